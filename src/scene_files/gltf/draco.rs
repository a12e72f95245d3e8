//! Decodes meshes that Draco has compressed (`KHR_draco_mesh_compression`). The decoded elements become further buffers, with
//! accessors of their own, so the code that reads meshes does not distinguish them from uncompressed ones.

use super::accessors::{Accessors, get};
use super::buffers::Content;
use super::damaged;
use super::document::DracoCompression as Compression;
use super::document::{Accessor, BufferView, Document, Primitive};
use super::unfolding::Unfolding;
use crate::Result;
use crate::base::panics::caught;
use crate::scene::notices::label;
use crate::scene_files::progress::Progress;
use draco_core::{
    DataType, DecodeLimits, DecoderBuffer, DracoError, ErrorKind, Mesh, MeshDecoder, PointAttribute,
};
use rayon::prelude::*;
use std::collections::HashMap;

/// The attributes that meshes read, besides the joints and weights of skins. Other attributes are not kept.
const READ: [&str; 6] = [
    "POSITION",
    "NORMAL",
    "TANGENT",
    "TEXCOORD_0",
    "TEXCOORD_1",
    "COLOR_0",
];

/// The memory that one value of an attribute takes after decoding, in bytes: four floats, the largest value that meshes use.
const VALUE_BYTES: u64 = 16;

/// The number of attributes that a compressed mesh may have beside those that its primitive states, such as joints and
/// weights. More are damage, because nothing has checked the memory for them.
const MORE_ATTRIBUTES: u64 = 6;

/// The number of vertices that a compressed mesh may have for each vertex that its accessors state. Encoders split vertices, and
/// some programs do not correct the accessors. More are damage, because a few bytes can stand for any number of vertices.
const VERTEX_RATIO: u64 = 2;

/// A compressed mesh to decode. Primitives with equal compressed data and accessors share one.
struct Job<'a> {
    /// The first primitive that shows the mesh, for messages.
    what: String,
    primitive: &'a Primitive,
    compression: &'a Compression,
    bytes: &'a [u8],
    /// The maximum number of vertices after decoding.
    max_points: u64,
    limits: DecodeLimits,
}

/// The elements of a decoded mesh: for each list its attribute (`None` for the vertex indices), an accessor without a buffer
/// view, and the bytes of its elements.
type Lists = Vec<(Option<String>, Accessor, Vec<u8>)>;

/// Decodes the compressed meshes of `document`, and changes their primitives so that they refer to the decoded elements.
/// Returns the decoded elements: buffers that follow `buffers`, the buffers of the file. Primitives that are not shown, such
/// as points, are not decoded. Fails if a mesh is damaged, if it has more elements than its accessors state, or if there is too
/// little memory.
pub fn decode(
    document: &mut Document,
    buffers: &[Content<'_>],
    unfolding: &Unfolding,
    progress: &mut Progress<'_>,
) -> Result<Vec<Vec<u8>>> {
    let mut jobs = Vec::new();
    // For each compressed primitive: its mesh, its index in the mesh, and the index of its job.
    let mut uses = Vec::new();
    let mut known = HashMap::new();
    let accessors = Accessors {
        document,
        buffers,
        unfolding,
    };
    for (mesh_index, mesh) in document.meshes.iter().enumerate() {
        for (index, primitive) in mesh.primitives.iter().enumerate() {
            let Some(compression) = &primitive.extensions.draco else {
                continue;
            };
            let is_shown = matches!(primitive.mode, None | Some(4..=6));
            if !is_shown || !primitive.attributes.contains_key("POSITION") {
                continue;
            }
            let identity = (compression, &primitive.attributes, primitive.indices);
            let job = match known.get(&identity) {
                Some(job) => *job,
                None => {
                    let what = format!(
                        "{} primitive {index}",
                        label("mesh", mesh_index, &mesh.name)
                    );
                    jobs.push(Job::new(what, primitive, compression, &accessors)?);
                    jobs.len() - 1
                }
            };
            known.insert(identity, job);
            uses.push((mesh_index, index, job));
        }
    }
    progress.pause()?;
    let decoded: Vec<Lists> = (jobs.par_iter())
        .map(|job| job.decode(&document.accessors))
        .collect::<Result<_>>()?;
    progress.pause()?;
    Ok(attach(document, buffers.len(), &uses, decoded))
}

impl<'a> Job<'a> {
    /// Checks the size that the accessors of `primitive` state. Fails if an index is out of range, or if there is too little
    /// memory for that size.
    fn new(
        what: String,
        primitive: &'a Primitive,
        compression: &'a Compression,
        accessors: &Accessors<'a>,
    ) -> Result<Self> {
        let count = |index: Option<&u64>| {
            let accessor = index.and_then(|index| get(&accessors.document.accessors, *index));
            accessor.map(|accessor| accessor.count)
        };
        let points = count(primitive.attributes.get("POSITION")).unwrap_or(0);
        let corners = count(primitive.indices.as_ref()).unwrap_or(points);
        let attributes = compression.attributes.len() as u64 + MORE_ATTRIBUTES;
        let values = points.saturating_mul(attributes * VALUE_BYTES);
        accessors
            .unfolding
            .take(&what, u128::from(values) + u128::from(corners) * 4)?;
        Ok(Self {
            bytes: accessors.view(&what, compression.buffer_view)?,
            limits: DecodeLimits::default()
                // A strip has almost as many triangles as corners.
                .with_max_faces(corners)
                .with_max_decoded_bytes(values),
            max_points: points.saturating_mul(VERTEX_RATIO),
            what,
            primitive,
            compression,
        })
    }

    fn decode(&self, accessors: &[Accessor]) -> Result<Lists> {
        let what = &self.what;
        let too_many = || {
            damaged(format!(
                "{what}: its Draco data have more triangles or vertices than its accessors state"
            ))
        };
        let mesh = caught(|| self.decode_mesh())
            .unwrap_or_else(|| Err(DracoError::general("the data are damaged".to_owned())))
            .map_err(|cause| match cause.kind() {
                ErrorKind::LimitExceeded => too_many(),
                _ => {
                    let cause = cause.to_string().replace(char::is_control, " ");
                    damaged(format!("{what}: its Draco data cannot be decoded: {cause}"))
                }
            })?;
        let count = mesh.num_points();
        if count as u64 > self.max_points {
            return Err(too_many());
        }
        let mut lists = Lists::new();
        for (name, id) in &self.compression.attributes {
            let accessor = self.primitive.attributes.get(name);
            let accessor = accessor.filter(|_| {
                let of_skins = name.starts_with("JOINTS_") || name.starts_with("WEIGHTS_");
                of_skins || READ.contains(&name.as_str())
            });
            let Some(accessor) = accessor.and_then(|index| get(accessors, *index)) else {
                continue;
            };
            let Some(components) = components(&accessor.kind) else {
                continue;
            };
            let attribute = u32::try_from(*id).ok();
            let Some(attribute) = attribute.and_then(|id| mesh.attribute_by_unique_id(id)) else {
                return Err(damaged(format!(
                    "{what}: its Draco data have no attribute {id}, which should be its {name}"
                )));
            };
            let (component_type, bytes) = elements(attribute, count, components);
            let accessor = Accessor {
                component_type,
                normalized: accessor.normalized,
                count: count as u64,
                kind: accessor.kind.clone(),
                ..Accessor::default()
            };
            lists.push((Some(name.clone()), accessor, bytes));
        }
        let corners = mesh.faces().as_flattened();
        let indices = Accessor {
            component_type: 5125,
            count: corners.len() as u64,
            kind: "SCALAR".into(),
            ..Accessor::default()
        };
        let bytes = corners.iter().flat_map(|point| point.0.to_le_bytes());
        lists.push((None, indices, bytes.collect()));
        Ok(lists)
    }

    fn decode_mesh(&self) -> std::result::Result<Mesh, DracoError> {
        let mut mesh = Mesh::new();
        let mut buffer = DecoderBuffer::new(self.bytes).with_limits(self.limits);
        MeshDecoder::new().decode(&mut buffer, &mut mesh)?;
        Ok(mesh)
    }
}

/// The number of components of an element whose type has the name `kind`, such as 3 for `VEC3`; `None` for types that
/// attributes of a mesh do not have.
fn components(kind: &str) -> Option<usize> {
    ["SCALAR", "VEC2", "VEC3", "VEC4"]
        .into_iter()
        .position(|name| name == kind)
        .map(|index| index + 1)
}

/// The first `components` components of an attribute's values for all `count` vertices, as an accessor stores them: the
/// number of their component type in glTF, and their bytes. Components of a type that attributes in glTF do not have become
/// floats.
fn elements(attribute: &PointAttribute, count: usize, components: usize) -> (u64, Vec<u8>) {
    let values = attribute.read_f32s(count, components);
    let values = values.iter().copied();
    match attribute.data_type() {
        DataType::Int8 => (5120, values.flat_map(|v| (v as i8).to_le_bytes()).collect()),
        DataType::Uint8 => (5121, values.map(|v| v as u8).collect()),
        DataType::Int16 => (
            5122,
            values.flat_map(|v| (v as i16).to_le_bytes()).collect(),
        ),
        DataType::Uint16 => (
            5123,
            values.flat_map(|v| (v as u16).to_le_bytes()).collect(),
        ),
        _ => (5126, values.flat_map(f32::to_le_bytes).collect()),
    }
}

/// Adds an accessor and a buffer view for each decoded list to the document, and lets the primitives in `uses` refer to
/// them. The bytes of the lists are returned; they are buffers, the first of which has the index `first_buffer`.
fn attach(
    document: &mut Document,
    first_buffer: usize,
    uses: &[(usize, usize, usize)],
    decoded: Vec<Lists>,
) -> Vec<Vec<u8>> {
    let mut buffers = Vec::new();
    let mut indices_of_jobs = Vec::new();
    for lists in decoded {
        let mut indices = Vec::new();
        for (name, accessor, bytes) in lists {
            document.accessors.push(Accessor {
                buffer_view: Some(document.buffer_views.len() as u64),
                ..accessor
            });
            document.buffer_views.push(BufferView {
                buffer: (first_buffer + buffers.len()) as u64,
                byte_length: bytes.len() as u64,
                ..BufferView::default()
            });
            buffers.push(bytes);
            indices.push((name, document.accessors.len() as u64 - 1));
        }
        indices_of_jobs.push(indices);
    }
    for (mesh, primitive, job) in uses {
        let primitive = &mut document.meshes[*mesh].primitives[*primitive];
        primitive.mode = None;
        for (name, accessor) in &indices_of_jobs[*job] {
            match name {
                Some(name) => drop(primitive.attributes.insert(name.clone(), *accessor)),
                None => primitive.indices = Some(*accessor),
            }
        }
    }
    buffers
}

//! Reads meshes: merges the primitives of each mesh into one list of triangles, splits strips and fans into triangles, and
//! leaves out vertices that no triangle uses.

use super::accessors::{Accessors, Elements, Kind, get};
use super::damaged;
use super::deformations::Deforming;
use super::document::{Mesh as FileMesh, Primitive};
use crate::scene::notices::{Tally, label};
use crate::scene::{Material, Mesh, Part};
use crate::{Error, Result};
use glam::{Vec2, Vec3, Vec4};

/// The rule that selects the corners of each triangle from a primitive's list of corners: the `mode` in glTF.
#[derive(Clone, Copy)]
enum Topology {
    List,
    Strip,
    Fan,
}

impl Topology {
    fn triangle_count(self, corners: u64) -> u64 {
        match self {
            Self::List => corners / 3,
            Self::Strip | Self::Fan => corners.saturating_sub(2),
        }
    }

    /// The three corners of the triangle with the index `i` of a primitive, in counter-clockwise order. Each is an index
    /// into the primitive's list of corners.
    fn corners(self, i: u64) -> [u64; 3] {
        match self {
            Self::List => [3 * i, 3 * i + 1, 3 * i + 2],
            Self::Strip => [i, i + 1 + i % 2, i + 2 - i % 2],
            Self::Fan => [i + 1, i + 2, 0],
        }
    }
}

/// The reader of the meshes of a glTF file, which converts one mesh after another to a mesh of the scene. It
/// keeps its table of vertex indices (`indices_in_mesh`) between meshes, to reuse the memory.
pub struct Meshes<'a> {
    accessors: Accessors<'a>,
    /// One entry for each material of the file, with two entries, for the first and the second set of texture coordinates of
    /// the mesh: the number of the set in the file, and true if a texture of the material uses the set. Unused sets are not
    /// read.
    sets: Vec<[(u64, bool); 2]>,
    /// One entry for each material of the file: the set of texture coordinates, 0 or 1, whose u is the direction of the
    /// tangents that it needs, as [`Material::tangent_set`] says; `None` if it needs none. Tangents are read only for
    /// triangles with a material that needs them.
    tangent_sets: Vec<Option<usize>>,
    /// For the first and the second set of texture coordinates: true if a material of the mesh that is being read uses the
    /// set. The mesh then gets coordinates for all its vertices, 0 where the file has none.
    needed: [bool; 2],
    /// The index in the scene of the material for primitives that state none: glTF's default, a white metal of roughness 1.
    /// It comes after all materials of the file.
    default_material: u32,
    /// True if some primitive states no material. The default material must then be appended to the scene's materials.
    pub default_material_used: bool,
    /// For each vertex of the primitive that is being read, its index in the mesh; `u32::MAX` if no triangle has used the
    /// vertex so far.
    indices_in_mesh: Vec<u32>,
}

impl<'a> Meshes<'a> {
    /// Makes a reader for the meshes of the document in `accessors`. `materials` are the scene's materials,
    /// one for each material of the file, in the order of the file. Their textures decide which texture
    /// coordinates and tangents are read. `sets` are the sets of texture coordinates of each material
    /// ([`Textures::coordinate_sets`](super::textures::Textures::coordinate_sets)).
    pub fn new(accessors: Accessors<'a>, materials: &[Material], sets: Vec<[u64; 2]>) -> Self {
        let used = |(material, sets): (&Material, [u64; 2])| {
            let uses = |set| material.textures().any(|(_, texture)| texture.set == set);
            [(sets[0], uses(0)), (sets[1], uses(1))]
        };
        Self {
            sets: materials.iter().zip(sets).map(used).collect(),
            tangent_sets: (materials.iter())
                .map(|material| material.tangent_set().map(|set| set as usize))
                .collect(),
            needed: [false; 2],
            default_material: accessors.document.materials.len() as u32,
            default_material_used: false,
            indices_in_mesh: Vec::new(),
            accessors,
        }
    }

    /// Reads the mesh `source`, which has the index `index` in the file. The result may have no triangles. Primitives that
    /// are not supported, such as lines, are skipped with a notice in `tally`. `deforming` collects what deforms its vertices;
    /// without it, skins and morph targets have no effect. Fails if an index, a type or a value is
    /// wrong.
    pub fn read(
        &mut self,
        index: usize,
        source: &FileMesh,
        mut deforming: Option<&mut Deforming>,
        tally: &mut Tally,
    ) -> Result<Mesh> {
        let mut mesh = Mesh {
            name: source.name.clone(),
            ..Mesh::default()
        };
        for (i, primitive) in source.primitives.iter().enumerate() {
            let what = format!("{} primitive {i}", label("mesh", index, &source.name));
            self.append(&what, primitive, &mut mesh, deforming.as_deref_mut(), tally)?;
        }
        if !mesh.normals.is_empty() {
            // Normals of zero length are missing ones: validation makes them geometric.
            mesh.normals.resize(mesh.positions.len(), Vec3::ZERO);
        }
        if !mesh.tangents.is_empty() {
            // Those of zero length are missing ones: validation makes them.
            mesh.tangents.resize(mesh.positions.len(), Vec4::ZERO);
        }
        if !mesh.colors.is_empty() {
            mesh.colors.resize(mesh.positions.len(), Vec4::ONE);
        }
        for (uvs, needed) in mesh.uvs.iter_mut().zip(&mut self.needed) {
            if std::mem::take(needed) {
                uvs.resize(mesh.positions.len(), Vec2::ZERO);
            }
        }
        Ok(mesh)
    }

    fn append(
        &mut self,
        what: &str,
        primitive: &Primitive,
        mesh: &mut Mesh,
        deforming: Option<&mut Deforming>,
        tally: &mut Tally,
    ) -> Result<()> {
        let topology = match primitive.mode {
            None | Some(4) => Topology::List,
            Some(5) => Topology::Strip,
            Some(6) => Topology::Fan,
            Some(0..=3) => {
                tally.add("points and lines are skipped", || what.into());
                return Ok(());
            }
            Some(mode) => {
                return Err(damaged(format!("{what}: mode {mode} is not one of 0 to 6")));
            }
        };
        let Some(&positions) = primitive.attributes.get("POSITION") else {
            tally.add("primitives without positions are skipped", || what.into());
            return Ok(());
        };
        let positions =
            self.accessors
                .attribute(positions, &format!("POSITION of {what}"), &[Kind::Vec3])?;
        let attribute = |accessors: &Accessors<'a>, name: &str, kinds: &[Kind]| {
            let Some(&accessor) = primitive.attributes.get(name) else {
                return Ok(None);
            };
            let used_as = format!("{name} of {what}");
            let found = accessors.vertex_attribute(accessor, &used_as, kinds, positions.count)?;
            Ok(Some(found))
        };
        let normals = attribute(&self.accessors, "NORMAL", &[Kind::Vec3])?;
        let colors = attribute(&self.accessors, "COLOR_0", &[Kind::Vec3, Kind::Vec4])?;
        let indices = match primitive.indices {
            Some(indices) => Some(
                self.accessors
                    .indices(indices, &format!("indices of {what}"))?,
            ),
            None => None,
        };
        let material = self.material(what, primitive)?;
        let sets = (self.sets.get(material as usize).copied()).unwrap_or_default();
        let tangent_set = (self.tangent_sets.get(material as usize).copied()).flatten();
        let tangents = match tangent_set {
            // Without normals of the file's own, its tangents are not followed either (glTF 2.0, 3.7.2.1).
            Some(_) if normals.is_some() => attribute(&self.accessors, "TANGENT", &[Kind::Vec4])?,
            _ => None,
        };
        let mut uvs = [None, None];
        for (set, (number, is_used)) in sets.into_iter().enumerate() {
            // Tangents that the file lacks are made from texture coordinates.
            if !is_used && (tangents.is_some() || tangent_set != Some(set)) {
                continue;
            }
            let name = format!("TEXCOORD_{number}");
            uvs[set] = attribute(&self.accessors, &name, &[Kind::Vec2])?;
            if uvs[set].is_none() {
                tally.add("texture coordinates are missing, 0 is used", || {
                    format!("{name} of {what}")
                });
            }
            self.needed[set] = true;
        }
        let corners = indices.as_ref().map_or(positions.count, |i| i.count);
        let count = topology.triangle_count(corners);
        if matches!(topology, Topology::List) && corners % 3 != 0 {
            tally.add("corners that make no whole triangle are ignored", || {
                what.into()
            });
        }
        self.reserve(what, &positions, corners, count)?;
        let first_triangle = index_of(what, mesh.triangles.len())?;
        let source = Source {
            what,
            positions,
            normals,
            tangents,
            colors,
            uvs,
            indices,
        };
        let used = self.copy(&source, topology, count, mesh)?;
        if let Some(deforming) = deforming {
            deforming.append(&self.accessors, what, primitive, &used, tally)?;
        }
        mesh.parts.push(Part {
            first_triangle,
            triangle_count: index_of(what, mesh.triangles.len())? - first_triangle,
            material,
        });
        Ok(())
    }

    fn material(&mut self, what: &str, primitive: &Primitive) -> Result<u32> {
        let Some(material) = primitive.material else {
            self.default_material_used = true;
            return Ok(self.default_material);
        };
        let materials = &self.accessors.document.materials;
        match get(materials, material) {
            Some(_) => Ok(material as u32),
            None => Err(damaged(format!(
                "{what}: material {material} is out of range, there are {}",
                materials.len()
            ))),
        }
    }

    /// Subtracts the memory that a primitive with `count` triangles and `corners` corners will take from the memory that the
    /// scene may still take ([`super::unfolding`]). Also enlarges `indices_in_mesh` to at least one entry for each of the
    /// primitive's `positions`. Fails if too little memory is left.
    fn reserve(
        &mut self,
        what: &str,
        positions: &Elements,
        corners: u64,
        count: u64,
    ) -> Result<()> {
        let table = positions
            .count
            .saturating_sub(self.indices_in_mesh.len() as u64);
        let needed = u128::from(count) * 12
            + u128::from(corners.min(positions.count)) * 56
            + u128::from(table) * 4;
        self.accessors.unfolding.take(what, needed)?;
        self.indices_in_mesh
            .resize(self.indices_in_mesh.len() + table as usize, u32::MAX);
        Ok(())
    }

    /// Copies the `count` triangles of a primitive to the mesh, with the vertices that they use, in the order in which
    /// triangles first use them. Returns the indices of these vertices in the primitive. Fails if a vertex index is out of range, or if a value is not finite.
    fn copy(
        &mut self,
        source: &Source,
        topology: Topology,
        count: u64,
        mesh: &mut Mesh,
    ) -> Result<Vec<u64>> {
        let what = source.what;
        let mut used = Vec::new();
        mesh.triangles.reserve(count as usize);
        for i in 0..count {
            let mut triangle = [0; 3];
            for (corner, at) in triangle.iter_mut().zip(topology.corners(i)) {
                let vertex = source.indices.as_ref().map_or(at, |i| i.index(at));
                if vertex >= source.positions.count {
                    return Err(damaged(format!(
                        "{what}: index {at} is {vertex}, but there are {} positions",
                        source.positions.count
                    )));
                }
                let index = &mut self.indices_in_mesh[vertex as usize];
                if *index == u32::MAX {
                    *index = index_of(what, mesh.positions.len())?;
                    used.push(vertex);
                    source.copy_vertex(vertex, mesh)?;
                }
                *corner = *index;
            }
            mesh.triangles.push(triangle);
        }
        for vertex in &used {
            self.indices_in_mesh[*vertex as usize] = u32::MAX;
        }
        Ok(used)
    }
}

struct Source<'a> {
    what: &'a str,
    positions: Elements<'a>,
    normals: Option<Elements<'a>>,
    tangents: Option<Elements<'a>>,
    colors: Option<Elements<'a>>,
    uvs: [Option<Elements<'a>>; 2],
    indices: Option<Elements<'a>>,
}

impl Source<'_> {
    fn copy_vertex(&self, vertex: u64, mesh: &mut Mesh) -> Result<()> {
        let wrong = |kind: &str, value: &dyn std::fmt::Display| {
            Error::input(format!(
                "{}: {kind} {vertex} is {value}; it must be finite",
                self.what
            ))
        };
        let finite = |kind: &str, value: Vec3| match value.is_finite() {
            true => Ok(value),
            false => Err(wrong(kind, &value)),
        };
        for (to, uvs) in mesh.uvs.iter_mut().zip(&self.uvs) {
            if let Some(uvs) = uvs {
                let uv = uvs.pair(vertex);
                if !uv.is_finite() {
                    return Err(wrong("texture coordinate", &uv));
                }
                to.resize(mesh.positions.len(), Vec2::ZERO);
                to.push(uv);
            }
        }
        if let Some(colors) = &self.colors {
            let color = colors.color(vertex);
            if !color.is_finite() {
                return Err(wrong("colour", &color));
            }
            mesh.colors.resize(mesh.positions.len(), Vec4::ONE);
            mesh.colors.push(color);
        }
        if let Some(tangents) = &self.tangents {
            let tangent = tangents.quadruple(vertex);
            if !tangent.is_finite() {
                return Err(wrong("tangent", &tangent));
            }
            mesh.tangents.resize(mesh.positions.len(), Vec4::ZERO);
            mesh.tangents.push(tangent);
        }
        if let Some(normals) = &self.normals {
            mesh.normals.resize(mesh.positions.len(), Vec3::ZERO);
            mesh.normals.push(finite("normal", normals.vector(vertex))?);
        }
        mesh.positions
            .push(finite("position", self.positions.vector(vertex))?);
        Ok(())
    }
}

fn index_of(what: &str, count: usize) -> Result<u32> {
    // u32::MAX itself marks the absence of an index.
    match u32::try_from(count) {
        Ok(index) if index < u32::MAX => Ok(index),
        _ => Err(Error::input(format!(
            "{what}: the mesh has more than 2³² vertices or triangles; split it"
        ))),
    }
}

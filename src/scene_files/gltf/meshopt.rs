//! Decodes buffer views that meshoptimizer has compressed: `EXT_meshopt_compression`, and `KHR_meshopt_compression`, which
//! has the same members, a further version of the codec and a further filter. The decoded bytes become further buffers, so
//! the code that reads accessors does not distinguish them from uncompressed ones.

use super::accessors::{Accessors, get};
use super::buffers::Content;
use super::damaged;
use super::document::Document;
use super::document::MeshoptCompression as Compression;
use super::unfolding::Unfolding;
use crate::Result;
use crate::base::panics::caught;
use crate::scene::notices::quoted;
use crate::scene_files::progress::Progress;
use meshoptimizer_rs::{Error as CodecError, Limits, Workspace, codec};
use rayon::prelude::*;

/// A compressed buffer view to decode.
struct Job<'a> {
    /// The index of the view in the document.
    view: usize,
    /// The name of the view in messages.
    what: String,
    compression: &'a Compression,
    bytes: &'a [u8],
}

/// The decoded bytes of a view. An error is the message that the file of its buffer is missing.
pub type Decoded = std::result::Result<Vec<u8>, String>;

/// Decodes the compressed buffer views of `document`, and changes them so that they refer to the decoded bytes. Returns the
/// decoded bytes: buffers that follow `buffers`, the buffers of the file. Fails if a view is damaged, or if there is too
/// little memory. A missing buffer is an error only when the bytes of the view are used.
pub fn decode(
    document: &mut Document,
    buffers: &[Content<'_>],
    unfolding: &Unfolding,
    progress: &mut Progress<'_>,
) -> Result<Vec<Decoded>> {
    let accessors = Accessors {
        document,
        buffers,
        unfolding,
    };
    let mut jobs = Vec::new();
    let mut missing = Vec::new();
    for (view, found) in document.buffer_views.iter().enumerate() {
        let extensions = &found.extensions;
        let Some(compression) = extensions.khr.as_ref().or(extensions.ext.as_ref()) else {
            continue;
        };
        if let Some(Err(fault)) = get(buffers, compression.buffer) {
            missing.push((view, Err((*fault).to_owned())));
            continue;
        }
        let what = format!("bufferView {view} (compressed)");
        let size = u128::from(compression.count) * u128::from(compression.byte_stride);
        unfolding.take(&what, size)?;
        let range = (compression.byte_offset, compression.byte_length);
        jobs.push(Job {
            view,
            bytes: accessors.bytes(&what, compression.buffer, range)?,
            what,
            compression,
        });
    }
    progress.pause()?;
    let decoded: Vec<(usize, Decoded)> = (jobs.par_iter())
        .map(|job| Ok((job.view, Ok(job.decode()?))))
        .collect::<Result<_>>()?;
    progress.pause()?;
    let attach = |(index, (view, bytes)): (usize, (usize, Decoded))| {
        let view = &mut document.buffer_views[view];
        view.buffer = (buffers.len() + index) as u64;
        view.byte_offset = 0;
        view.byte_length = bytes.as_ref().map_or(0, Vec::len) as u64;
        bytes
    };
    let all = decoded.into_iter().chain(missing).enumerate();
    Ok(all.map(attach).collect())
}

impl Job<'_> {
    /// The bytes of the view without compression. Fails if the compressed bytes are damaged, or if the mode or the filter is
    /// unknown.
    fn decode(&self) -> Result<Vec<u8>> {
        let what = &self.what;
        // The sizes fit: the memory for them has been checked.
        let (count, stride) = (
            self.compression.count as usize,
            self.compression.byte_stride as usize,
        );
        let unknown = |kind: &str, name: &str| {
            damaged(format!("{what} has the unknown {kind} {}", quoted(name)))
        };
        let decode = match self.compression.mode.as_str() {
            "ATTRIBUTES" => codec::decode_vertex_buffer,
            "TRIANGLES" => codec::decode_index_buffer,
            "INDICES" => codec::decode_index_sequence,
            other => return Err(unknown("mode", other)),
        };
        let filter = match self.compression.filter.as_deref() {
            None | Some("NONE") => None,
            Some("OCTAHEDRAL") => Some(codec::decode_filter_oct as Filter),
            Some("QUATERNION") => Some(codec::decode_filter_quat as Filter),
            Some("EXPONENTIAL") => Some(codec::decode_filter_exp as Filter),
            Some("COLOR") => Some(codec::decode_filter_color as Filter),
            Some(other) => return Err(unknown("filter", other)),
        };
        // The limits of the file have been checked already.
        let workspace = &mut Workspace::new(Limits {
            max_bytes: usize::MAX,
            max_work: u64::MAX,
        });
        let work = || {
            let mut decoded = decode(count, stride, self.bytes, workspace)?;
            if let Some(filter) = filter {
                filter(&mut decoded, count, stride, workspace)?;
            }
            Ok::<_, CodecError>(decoded)
        };
        match caught(work) {
            Some(Ok(decoded)) => Ok(decoded),
            Some(Err(cause)) => Err(damaged(format!("{what} cannot be decoded: {cause}"))),
            None => Err(damaged(format!("{what} cannot be decoded"))),
        }
    }
}

/// A function that converts `count` elements of `stride` bytes in place.
type Filter = fn(
    data: &mut [u8],
    count: usize,
    stride: usize,
    workspace: &mut Workspace,
) -> std::result::Result<(), CodecError>;

//! Reads the bytes of a glTF file: the two chunks of a GLB file (JSON and binary), buffers in other files, and data URIs.

use super::damaged;
use super::document::Document;
use crate::scene::notices::{Tally, quoted};
use crate::scene_files::progress::{Progress, read_file};
use crate::scene_files::scene_folder::SceneFolder;
use crate::{Error, Result};
use base64::Engine;
use base64::alphabet;
use base64::engine::general_purpose::{GeneralPurpose, PAD_INDIFFERENT};
use gltf::binary::{Error as GlbError, Glb};
use percent_encoding::percent_decode_str;
use std::borrow::Cow;
use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::path::PathBuf;

/// The decoder of the base64 text in data URIs (standard alphabet), from which buffers and images are read.
/// Like browsers, it accepts text without padding, and ignores bits at the end that do not fill a byte.
const BASE64: GeneralPurpose = GeneralPurpose::new(
    &alphabet::STANDARD,
    PAD_INDIFFERENT.with_decode_allow_trailing_bits(true),
);

/// The two parts of a glTF file: the bytes of its JSON, and the bytes of its binary chunk (buffer 0), or
/// `None` if the file has no such chunk. Both are borrowed from the bytes of the file.
type Chunks<'a> = (Cow<'a, [u8]>, Option<Cow<'a, [u8]>>);

/// Splits the bytes of a glTF file into its chunks. If they do not begin with the header of a GLB file, all bytes are JSON
/// (`.gltf`). Fails if the GLB file is damaged, or if its version is not 2.
pub fn split(bytes: &[u8]) -> Result<Chunks<'_>> {
    if !bytes.starts_with(b"glTF") {
        return Ok((bytes.into(), None));
    }
    let Some(length) = word(bytes, 8) else {
        return Err(damaged("the GLB header is cut off"));
    };
    // The crate panics if the length is less than that of the header, and reads past the length.
    if length < 12 || length > bytes.len() {
        return Err(damaged(format!(
            "the GLB header gives a length of {length} bytes, but the file has {}",
            bytes.len()
        )));
    }
    let fault = match Glb::from_slice(&bytes[..length]) {
        Ok(glb) => return Ok((glb.json, glb.bin)),
        Err(gltf::Error::Binary(GlbError::Version(version))) => {
            return Err(Error::input(format!(
                "GLB version {version} is not supported; export it as glTF 2.0"
            )));
        }
        Err(gltf::Error::Binary(GlbError::UnknownChunkType(_) | GlbError::ChunkType(_))) => {
            // Where there is no binary chunk, an extension's may follow the JSON, which the crate
            // refuses.
            match json_chunk(bytes) {
                Some(json) => return Ok((json.into(), None)),
                None => "chunk 0 is not JSON".to_owned(),
            }
        }
        Err(gltf::Error::Binary(GlbError::Io(_))) => "a chunk's header is cut off".to_owned(),
        Err(other) => other.to_string(),
    };
    Err(damaged(format!("its GLB chunks cannot be read: {fault}")))
}

/// The content of the first chunk of a GLB file; `None` if the chunk is not JSON or is cut off, so that the file is refused.
/// It is used if the `gltf` crate refuses one of the other chunks.
fn json_chunk(bytes: &[u8]) -> Option<&[u8]> {
    let is_json = bytes.get(16..20)? == b"JSON";
    bytes[20..].get(..word(bytes, 12)?).filter(|_| is_json)
}

/// The unsigned number, such as the length of a chunk, in the four bytes from byte `at`, in little-endian order; `None` if
/// the file ends before the fourth byte.
fn word(bytes: &[u8], at: usize) -> Option<usize> {
    let word = bytes.get(at..)?.first_chunk()?;
    Some(u32::from_le_bytes(*word) as usize)
}

/// The bytes of all buffers of a glTF file, from which accessors and images are read. Bytes from other files and from data
/// URIs are copied; the binary chunk is only borrowed. A file that several buffers name is read once.
pub struct Buffers<'a> {
    copies: Vec<Vec<u8>>,
    binary: &'a [u8],
    /// One entry per buffer, in the order of the document. The length of a buffer that is only a fallback is 0.
    sources: Vec<Source>,
}

/// The index of a buffer's bytes in [`Buffers::copies`] (`None` if they are in the binary chunk), and the length of the buffer
/// in bytes. An error is the message that the buffer's file is missing.
type Source = std::result::Result<(Option<usize>, usize), String>;

/// The bytes of a buffer. An error is the message that its file is missing; whoever needs the bytes decides whether the scene
/// can do without them.
pub type Content<'a> = std::result::Result<&'a [u8], &'a str>;

impl<'a> Buffers<'a> {
    /// Reads all buffers of a document. Their bytes are in the binary chunk (`binary`), in data URIs, or in files in
    /// `folder`. If the user permits missing files, a missing buffer is an error only when its bytes are used. Fails if the
    /// bytes of a buffer are missing without this permission, damaged, or fewer than the document states, or if `progress`
    /// ends the loading.
    pub fn load(
        document: &Document,
        binary: Option<&'a [u8]>,
        folder: &SceneFolder<'_>,
        progress: &mut Progress<'_>,
        tally: &mut Tally,
    ) -> Result<Self> {
        // A file is read as far as the longest of the buffers that it may be.
        let files = document
            .buffers
            .iter()
            .filter(|buffer| buffer.file().is_some() && !buffer.extensions.is_fallback());
        let longest = files.map(|buffer| buffer.byte_length).max();
        let mut buffers = Self {
            copies: Vec::new(),
            binary: binary.unwrap_or_default(),
            sources: Vec::new(),
        };
        let mut known: HashMap<(u64, u64), usize> = HashMap::new();
        for (index, buffer) in document.buffers.iter().enumerate() {
            if buffer.extensions.is_fallback() {
                buffers.sources.push(Ok((None, 0)));
                continue;
            }
            let what = format!("buffer {index}");
            let source = match (&buffer.uri, binary) {
                (None, Some(_)) if index == 0 => None,
                (None, _) => {
                    return Err(damaged(format!(
                        "{what} has no uri, and there is no binary chunk for it"
                    )));
                }
                (Some(uri), _) => Some(match uri.strip_prefix("data:") {
                    Some(data) => {
                        let decoded = decode_data_uri(data);
                        buffers.add(decoded.ok_or_else(|| {
                            damaged(format!("{what}: its data URI is not base64"))
                        })?)
                    }
                    None => {
                        let name = file_name(&what, uri)?;
                        let path = PathBuf::from(&*name);
                        let paths = std::slice::from_ref(&path);
                        let Some(file) = folder.open(&what, paths, tally)? else {
                            let fault = format!(
                                "{what}: there is no file {} where the scene expects it{}; put it there",
                                quoted(&name),
                                folder.hint(&path)
                            );
                            if !folder.options.allow_missing {
                                return Err(Error::input(fault));
                            }
                            buffers.sources.push(Err(fault));
                            continue;
                        };
                        match known.entry(file.id) {
                            Entry::Occupied(copy) => *copy.get(),
                            Entry::Vacant(copy) => {
                                let most = longest.unwrap_or_default();
                                let bytes = read_file(&what, file, most, progress)?;
                                *copy.insert(buffers.add(bytes))
                            }
                        }
                    }
                }),
            };
            let there = buffers.bytes(source).len();
            if (there as u64) < buffer.byte_length {
                let file =
                    (buffer.file()).map_or(String::new(), |uri| format!(" in {}", quoted(uri)));
                return Err(damaged(format!(
                    "{what} should have {} bytes, there are {there}{file}",
                    buffer.byte_length
                )));
            }
            let length = buffer.byte_length as usize;
            buffers.sources.push(Ok((source, length)));
        }
        Ok(buffers)
    }

    fn add(&mut self, bytes: Vec<u8>) -> usize {
        self.copies.push(bytes);
        self.copies.len() - 1
    }

    fn bytes(&self, source: Option<usize>) -> &[u8] {
        source.map_or(self.binary, |copy| &self.copies[copy])
    }

    /// The content of each buffer, in the order of the document; accessors read from it. Further bytes of the file or chunk,
    /// beyond the length of the buffer in the document, are left out.
    pub fn contents(&self) -> Vec<Content<'_>> {
        (self.sources.iter())
            .map(|source| match source {
                Ok((copy, length)) => Ok(&self.bytes(*copy)[..*length]),
                Err(fault) => Err(fault.as_str()),
            })
            .collect()
    }

    /// The total size of the binary chunk and of all copied buffers, in bytes. The limit on the memory that the scene may
    /// take is computed from it ([`super::unfolding`]).
    pub fn total(&self) -> u64 {
        let copies = self.copies.iter().map(Vec::len).sum::<usize>();
        (self.binary.len() + copies) as u64
    }
}

/// The path of the file that a URI names, with its percent codes decoded; the caller opens this file. The
/// path is relative to the scene's folder, or absolute for `file://`. `what` is the element with the URI, for
/// messages. Fails if the URI names a file on another machine, or if a percent code is wrong.
pub fn file_name<'a>(what: &str, uri: &'a str) -> Result<Cow<'a, str>> {
    // A file of another machine cannot be opened.
    let local = (uri.strip_prefix("file://localhost")).or_else(|| uri.strip_prefix("file://"));
    let uri = local.filter(|path| path.starts_with('/')).unwrap_or(uri);
    if uri.contains("://") {
        return Err(Error::input(format!(
            "{what}: the uri {} is not a file beside the scene; download it and name it there",
            quoted(uri)
        )));
    }
    decode_percent(uri).ok_or_else(|| {
        damaged(format!(
            "{what}: the uri {} is not percent-encoded UTF-8",
            quoted(uri)
        ))
    })
}

/// The bytes that a data URI contains: the content of a buffer or an encoded image. `data` is the text of the
/// URI after `data:`, such as `[type];base64,…`. Line breaks and blanks in the base64 text are ignored. `None` if the text is
/// not valid base64.
pub fn decode_data_uri(data: &str) -> Option<Vec<u8>> {
    let (kind, content) = data.split_once(',')?;
    kind.trim_end().ends_with(";base64").then_some(())?;
    let mut content = decode_percent(content)?;
    if content.contains(|c: char| c.is_ascii_whitespace()) {
        content.to_mut().retain(|c| !c.is_ascii_whitespace());
    }
    BASE64.decode(&*content).ok()
}

/// Decodes the percent codes of a text, such as `%20`. `None` if a percent sign is not followed by two hexadecimal digits,
/// or if the decoded bytes are not UTF-8.
fn decode_percent(text: &str) -> Option<Cow<'_, str>> {
    // The crate lets a `%` without its two digits stand: here that is damage.
    let is_code = |rest: &str| {
        let digits = rest.as_bytes().first_chunk::<2>();
        digits.is_some_and(|digits| digits.iter().all(u8::is_ascii_hexdigit))
    };
    if !text.split('%').skip(1).all(is_code) {
        return None;
    }
    percent_decode_str(text).decode_utf8().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base64_with_and_without_padding() {
        for (text, bytes) in [
            ("", &b""[..]),
            ("Zg==", b"f"),
            ("Zg", b"f"),
            ("Zh", b"f"),
            ("Zm8=", b"fo"),
            ("Zm9v", b"foo"),
            ("Zm9vYmE", b"fooba"),
            ("/+8A", &[0xff, 0xef, 0]),
        ] {
            assert_eq!(BASE64.decode(text).as_deref(), Ok(bytes), "{text}");
        }
        for wrong in ["Z", "Zm9vZ", "Zm9*", "Zg===", "Zg==Zg==", "é"] {
            assert!(BASE64.decode(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn data_uris_name_their_encoding() {
        let decoded = decode_data_uri("application/octet-stream;base64,Zm9v");
        assert_eq!(decoded.as_deref(), Some(&b"foo"[..]));
        assert_eq!(
            decode_data_uri(";base64,Zg%3D%3D").as_deref(),
            Some(&b"f"[..])
        );
        for spaced in ["Zm 9v", "Zm9v\n", "\r\nZm\t9v", "Zm%0D%0A9v"] {
            let decoded = decode_data_uri(&format!(";base64,{spaced}"));
            assert_eq!(decoded.as_deref(), Some(&b"foo"[..]), "{spaced:?}");
        }
        for wrong in ["text/plain,foo", ";base64", "", ",", ";base64,%"] {
            assert_eq!(decode_data_uri(wrong), None, "{wrong}");
        }
    }

    #[test]
    fn percent_signs_are_decoded() {
        assert_eq!(decode_percent("a%20b%C3%A4").as_deref(), Some("a bä"));
        for wrong in ["%", "%2", "%é", "%zz", "%+1", "%%41", "%ff"] {
            assert_eq!(decode_percent(wrong), None, "{wrong}");
        }
    }
}

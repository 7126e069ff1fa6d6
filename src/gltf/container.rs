//! From a file to JSON and buffers: the GLB container, files beside it, data URIs.

use std::borrow::Cow;
use std::path::{Path, PathBuf};

use base64::Engine as _;
use base64::alphabet::STANDARD;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};
use gltf::json::Root;
use percent_encoding::percent_decode_str;

use super::error::GltfError;

const JSON_CHUNK: u32 = u32::from_le_bytes(*b"JSON");
const BIN_CHUNK: u32 = u32::from_le_bytes(*b"BIN\0");
const GLB_HEADER: usize = 12;
const CHUNK_HEADER: usize = 8;

/// Exporters differ in whether they pad and in the bits left over at the end.
const BASE64: GeneralPurpose = GeneralPurpose::new(
    &STANDARD,
    GeneralPurposeConfig::new()
        .with_decode_padding_mode(DecodePaddingMode::Indifferent)
        .with_decode_allow_trailing_bits(true),
);

/// The parts of a glTF file.
#[derive(Debug)]
pub(super) struct Parts<'a> {
    /// The JSON text.
    pub(super) json: &'a [u8],
    /// The binary chunk of a `.glb`.
    pub(super) bin: Option<&'a [u8]>,
}

/// Splits a file into JSON and binary chunk. What it is, is decided by its first bytes.
pub(super) fn split(bytes: &[u8]) -> Result<Parts<'_>, String> {
    if bytes.starts_with(b"glTF") {
        return split_glb(bytes);
    }
    if bytes.is_empty() {
        return Err("the file is empty".to_owned());
    }
    // Some text editors put a byte order mark first, which JSON does not know.
    let json = bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes);
    Ok(Parts { json, bin: None })
}

fn split_glb(bytes: &[u8]) -> Result<Parts<'_>, String> {
    let (Some(version), Some(length)) = (u32_at(bytes, 4), u32_at(bytes, 8)) else {
        return Err(cut_short("its header"));
    };
    if version != 2 {
        return Err(format!(
            "the container's version is {version}, only 2 is supported"
        ));
    }
    let length = usize::try_from(length).map_err(|_| cut_short("the container"))?;
    let mut rest = bytes
        .get(GLB_HEADER..length)
        .ok_or_else(|| cut_short(&format!("its header says {length} bytes")))?;
    let (kind, json) = take_chunk(&mut rest)?;
    if kind != JSON_CHUNK {
        return Err("the first chunk is not JSON".to_owned());
    }
    let mut bin = None;
    // Chunks of other kinds are to be ignored; the binary one can only be the second.
    if !rest.is_empty() {
        let (kind, data) = take_chunk(&mut rest)?;
        bin = (kind == BIN_CHUNK).then_some(data);
    }
    Ok(Parts { json, bin })
}

fn take_chunk<'a>(rest: &mut &'a [u8]) -> Result<(u32, &'a [u8]), String> {
    let (Some(length), Some(kind)) = (u32_at(rest, 0), u32_at(rest, 4)) else {
        return Err(cut_short("a chunk's header"));
    };
    let end = usize::try_from(length)
        .ok()
        .and_then(|length| length.checked_add(CHUNK_HEADER));
    let data = end.and_then(|end| rest.get(CHUNK_HEADER..end));
    let data = data.ok_or_else(|| cut_short(&format!("a chunk of {length} bytes")))?;
    *rest = &rest[CHUNK_HEADER + data.len()..];
    Ok((kind, data))
}

fn u32_at(bytes: &[u8], at: usize) -> Option<u32> {
    let word = bytes.get(at..at.checked_add(4)?)?;
    Some(u32::from_le_bytes(word.try_into().ok()?))
}

fn cut_short(what: &str) -> String {
    format!("the file is cut short ({what}): copy or export it again")
}

/// The bytes of all buffers of the document, each at least as long as it says.
pub(super) fn load_buffers(
    path: &Path,
    root: &Root,
    bin: Option<&[u8]>,
) -> Result<Vec<Vec<u8>>, GltfError> {
    let mut buffers = Vec::with_capacity(root.buffers.len());
    for (index, buffer) in root.buffers.iter().enumerate() {
        let invalid = |reason: String| GltfError::Invalid {
            path: path.to_owned(),
            reason: format!("buffers[{index}] {reason}"),
        };
        let data = match &buffer.uri {
            None if index == 0 && bin.is_some() => bin.unwrap_or_default().to_vec(),
            None => {
                return Err(invalid(
                    "has no uri and the file has no binary chunk for it".to_owned(),
                ));
            }
            Some(uri) => fetch(path, uri).map_err(|error| match error {
                FetchError::Uri(reason) => invalid(reason),
                FetchError::File(path, source) => GltfError::Read { path, source },
            })?,
        };
        let expected = buffer.byte_length.0;
        if (data.len() as u64) < expected {
            let place = match &buffer.uri {
                Some(uri) if !is_data(uri) => format!("(file {uri}) "),
                _ => String::new(),
            };
            return Err(invalid(format!(
                "{place}has {} bytes where byteLength says {expected}: copy or export it again",
                data.len()
            )));
        }
        buffers.push(data);
    }
    Ok(buffers)
}

/// Why the bytes behind a URI could not be had.
#[derive(Debug)]
pub(super) enum FetchError {
    /// The URI itself is no good.
    Uri(String),
    /// The file it names could not be read.
    File(PathBuf, std::io::Error),
}

impl std::fmt::Display for FetchError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Uri(reason) => f.write_str(reason),
            Self::File(path, source) => write!(f, "cannot read {}: {source}", path.display()),
        }
    }
}

/// Whether a URI carries its data itself.
pub(super) fn is_data(uri: &str) -> bool {
    uri.get(..5)
        .is_some_and(|scheme| scheme.eq_ignore_ascii_case("data:"))
}

/// The bytes behind a URI of the glTF file at `document`.
pub(super) fn fetch(document: &Path, uri: &str) -> Result<Vec<u8>, FetchError> {
    if is_data(uri) {
        return decode_data(&uri[5..]).map_err(FetchError::Uri);
    }
    if has_scheme(uri) {
        return Err(FetchError::Uri(format!(
            "refers to {uri}, but only files beside the document are read: put a copy there"
        )));
    }
    let folder = document.parent().unwrap_or(Path::new(""));
    let decoded = percent_decode_str(uri).decode_utf8_lossy();
    let file = folder.join(decoded.as_ref());
    match read_file(&file) {
        Ok(bytes) => Ok(bytes),
        // Some exporters do not encode: then a percent sign is one.
        Err(error) => read_file(&folder.join(uri)).map_err(|_| FetchError::File(file, error)),
    }
}

/// Reads files only: a document may name a device, which would never end.
fn read_file(path: &Path) -> std::io::Result<Vec<u8>> {
    if std::fs::metadata(path)?.is_file() {
        std::fs::read(path)
    } else {
        Err(std::io::Error::other("it is no file"))
    }
}

/// `http:` and the like; one letter is a drive.
fn has_scheme(uri: &str) -> bool {
    let Some((scheme, _)) = uri.split_once(':') else {
        return false;
    };
    scheme.len() > 1
        && scheme.starts_with(|c: char| c.is_ascii_alphabetic())
        && scheme
            .chars()
            .all(|c| c.is_ascii_alphanumeric() || "+-.".contains(c))
}

/// Decodes a data URI, given without `data:`.
fn decode_data(rest: &str) -> Result<Vec<u8>, String> {
    let Some((kind, data)) = rest.split_once(',') else {
        return Err("has a data URI without a comma".to_owned());
    };
    let data: Cow<'_, [u8]> = percent_decode_str(data).into();
    if !kind.to_ascii_lowercase().ends_with(";base64") {
        return Ok(data.into_owned());
    }
    let clean = if data.iter().any(u8::is_ascii_whitespace) {
        let clean = data.iter().copied().filter(|b| !b.is_ascii_whitespace());
        Cow::Owned(clean.collect())
    } else {
        data
    };
    BASE64
        .decode(clean.as_ref())
        .map_err(|error| format!("has a data URI that is not base64: {error}"))
}

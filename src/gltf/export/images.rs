//! Takes image files into the binary chunk, so that the output stands alone.

use std::{
    collections::HashMap,
    fs, io,
    path::{Path, PathBuf},
};

use serde_json::Value;

use super::glb::Glb;

/// Embeds every image that is a file of its own; one that cannot be keeps its URI and gets a note.
pub(super) fn embed_images(glb: &mut Glb) {
    let count = glb.json["images"].as_array().map_or(0, Vec::len);
    let mut embedded = HashMap::new();
    for index in 0..count {
        let Some(uri) = glb.json["images"][index]["uri"].as_str() else {
            continue;
        };
        // Data URIs are part of the file already.
        if uri.starts_with("data:") {
            continue;
        }
        let uri = uri.to_owned();
        match embed(glb, &uri, &mut embedded) {
            Ok((view, mime)) => point_at_view(&mut glb.json["images"][index], view, mime),
            Err(reason) => glb.notes.push(format!(
                "image {index} stays a file of its own, {uri}: {reason}"
            )),
        }
    }
}

/// Appends an image file, once however many images use it.
fn embed(
    glb: &mut Glb,
    uri: &str,
    embedded: &mut HashMap<PathBuf, (usize, &'static str)>,
) -> Result<(usize, &'static str), String> {
    let relative = file_of(uri)?;
    let path = glb.path.parent().unwrap_or(Path::new("")).join(relative);
    if let Some(&known) = embedded.get(&path) {
        return Ok(known);
    }
    let bytes = read_file(&path).map_err(|error| error.to_string())?;
    let mime = mime_type(&bytes).ok_or("it is not an image of a known kind")?;
    let result = (glb.push_view(&bytes, None), mime);
    embedded.insert(path, result);
    Ok(result)
}

fn read_file(path: &Path) -> io::Result<Vec<u8>> {
    // Devices and pipes may have no end.
    if !fs::metadata(path)?.is_file() {
        return Err(io::Error::other("it is not a file"));
    }
    fs::read(path)
}

fn point_at_view(image: &mut Value, view: usize, mime: &str) {
    if let Some(image) = image.as_object_mut() {
        image.shift_remove("uri");
        image.insert("bufferView".into(), view.into());
        image.insert("mimeType".into(), mime.into());
    }
}

/// The file a relative URI means; `%20` and the like are decoded.
fn file_of(uri: &str) -> Result<PathBuf, String> {
    let scheme = uri.split_once(':').map_or("", |(scheme, _)| scheme);
    if !scheme.is_empty() && !scheme.contains(['/', '%']) {
        return Err("only files next to the scene are embedded".to_owned());
    }
    let mut bytes = Vec::new();
    let mut rest = uri.as_bytes();
    while let [first, tail @ ..] = rest {
        rest = tail;
        let code = tail
            .get(..2)
            .and_then(|code| std::str::from_utf8(code).ok());
        match code.and_then(|code| u8::from_str_radix(code, 16).ok()) {
            Some(byte) if *first == b'%' => {
                bytes.push(byte);
                rest = &tail[2..];
            }
            _ => bytes.push(*first),
        }
    }
    let name = String::from_utf8(bytes).map_err(|_| "its name is not UTF-8".to_owned())?;
    Ok(PathBuf::from(name))
}

/// What the first bytes of an image file say it is.
fn mime_type(bytes: &[u8]) -> Option<&'static str> {
    let is = |magic: &[u8]| bytes.starts_with(magic);
    if is(b"\x89PNG\r\n\x1a\n") {
        Some("image/png")
    } else if is(b"\xff\xd8\xff") {
        Some("image/jpeg")
    } else if is(b"\xabKTX 20\xbb\r\n\x1a\n") {
        Some("image/ktx2")
    } else if is(b"DDS ") {
        Some("image/vnd-ms.dds")
    } else if is(b"RIFF") && bytes.get(8..12) == Some(b"WEBP") {
        Some("image/webp")
    } else if bytes.get(4..12) == Some(b"ftypavif") {
        Some("image/avif")
    } else {
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gltf_image_uris_are_decoded() {
        let file = |uri| file_of(uri).map(|path| path.to_str().unwrap().to_owned());
        assert_eq!(file("a%20b.png").unwrap(), "a b.png");
        assert_eq!(file("t/%C3%A4.png").unwrap(), "t/ä.png");
        assert_eq!(file("100%.png").unwrap(), "100%.png");
        assert_eq!(file("./a:b.png").unwrap(), "./a:b.png");
        assert!(file("https://example.org/a.png").is_err());
        assert!(file("%ff.png").is_err());
    }
}

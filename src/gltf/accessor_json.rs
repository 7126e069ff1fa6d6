//! Reads accessors straight from the JSON: all component types, strides, normalisation, sparse.

use serde_json::Value;

/// What one element of an accessor is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct ElementKind {
    name: &'static str,
    columns: usize,
    rows: usize,
}

impl ElementKind {
    pub(crate) const SCALAR: Self = Self::new("SCALAR", 1, 1);
    pub(crate) const VEC2: Self = Self::new("VEC2", 1, 2);
    pub(crate) const VEC3: Self = Self::new("VEC3", 1, 3);
    pub(crate) const VEC4: Self = Self::new("VEC4", 1, 4);
    const ALL: [Self; 7] = [
        Self::SCALAR,
        Self::VEC2,
        Self::VEC3,
        Self::VEC4,
        Self::new("MAT2", 2, 2),
        Self::new("MAT3", 3, 3),
        Self::new("MAT4", 4, 4),
    ];

    const fn new(name: &'static str, columns: usize, rows: usize) -> Self {
        Self {
            name,
            columns,
            rows,
        }
    }

    /// As glTF spells it.
    pub(crate) fn name(self) -> &'static str {
        self.name
    }

    /// Numbers an element.
    pub(crate) fn width(self) -> usize {
        self.columns * self.rows
    }
}

/// The values of an accessor. Every component type fits an `f64` exactly.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct AccessorData {
    /// What an element is.
    pub(crate) kind: ElementKind,
    /// `kind.width()` numbers an element; normalised integers are divided already.
    pub(crate) values: Vec<f64>,
}

impl AccessorData {
    /// The numbers of one element.
    pub(crate) fn element(&self, index: usize) -> &[f64] {
        let width = self.kind.width();
        &self.values[index * width..(index + 1) * width]
    }
}

/// How many elements accessor `index` has.
pub(crate) fn accessor_count(json: &Value, index: usize) -> Result<usize, String> {
    whole(accessor(json, index)?, "count")?.ok_or_else(|| format!("accessor {index} has no count"))
}

/// Reads accessor `index`; `buffers` has the bytes of each of the document's buffers.
pub(crate) fn read_accessor(
    json: &Value,
    buffers: &[&[u8]],
    index: usize,
) -> Result<AccessorData, String> {
    read(json, buffers, index).map_err(|reason| format!("accessor {index}: {reason}"))
}

fn read(json: &Value, buffers: &[&[u8]], index: usize) -> Result<AccessorData, String> {
    let accessor = accessor(json, index)?;
    let name = accessor["type"].as_str().unwrap_or_default();
    let kind = ElementKind::ALL
        .into_iter()
        .find(|kind| kind.name == name)
        .ok_or_else(|| format!("unknown type {name:?}"))?;
    let component = Component::of(accessor)?;
    let count = whole(accessor, "count")?.ok_or("no count")?;
    let mut values = match whole(accessor, "bufferView")? {
        Some(view) => {
            let offset = whole(accessor, "byteOffset")?.unwrap_or(0);
            let span = Span::of(json, buffers, view, offset)?;
            read_elements(span, component, kind, count)?
        }
        None => zeros(kind, count)?,
    };
    if let Some(sparse) = accessor.get("sparse") {
        overlay(json, buffers, sparse, component, kind, &mut values)
            .map_err(|reason| format!("sparse: {reason}"))?;
    }
    Ok(AccessorData { kind, values })
}

fn accessor(json: &Value, index: usize) -> Result<&Value, String> {
    json["accessors"]
        .get(index)
        .ok_or_else(|| format!("there is no accessor {index}"))
}

fn zeros(kind: ElementKind, count: usize) -> Result<Vec<f64>, String> {
    let len = count.checked_mul(kind.width()).ok_or("count too large")?;
    let mut values = Vec::new();
    values
        .try_reserve_exact(len)
        .map_err(|_| "count too large".to_owned())?;
    values.resize(len, 0.0);
    Ok(values)
}

/// Replaces the elements that a sparse accessor lists.
fn overlay(
    json: &Value,
    buffers: &[&[u8]],
    sparse: &Value,
    component: Component,
    kind: ElementKind,
    values: &mut [f64],
) -> Result<(), String> {
    let count = whole(sparse, "count")?.ok_or("no count")?;
    let part = |part: &Value| -> Result<Span<'_>, String> {
        let view = whole(part, "bufferView")?.ok_or("no bufferView")?;
        let offset = whole(part, "byteOffset")?.unwrap_or(0);
        let mut span = Span::of(json, buffers, view, offset)?;
        span.stride = None;
        Ok(span)
    };
    let index_component = Component::of(&sparse["indices"])?;
    let indices = part(&sparse["indices"])?;
    let indices = read_elements(indices, index_component, ElementKind::SCALAR, count)?;
    let replacements = read_elements(part(&sparse["values"])?, component, kind, count)?;
    let width = kind.width();
    for (index, replacement) in indices.iter().zip(replacements.chunks_exact(width)) {
        let start = *index as usize * width;
        values
            .get_mut(start..start + width)
            .ok_or("an index is beyond the accessor's count")?
            .copy_from_slice(replacement);
    }
    Ok(())
}

/// Bytes from an accessor's first element to the end of its buffer view.
struct Span<'a> {
    bytes: &'a [u8],
    stride: Option<usize>,
}

impl<'a> Span<'a> {
    fn of(json: &Value, buffers: &[&'a [u8]], view: usize, offset: usize) -> Result<Self, String> {
        let outside = || format!("bufferView {view} is too short");
        let json = json["bufferViews"]
            .get(view)
            .ok_or_else(|| format!("there is no bufferView {view}"))?;
        let buffer = whole(json, "buffer")?.ok_or("a bufferView has no buffer")?;
        let start = whole(json, "byteOffset")?.unwrap_or(0);
        let length = whole(json, "byteLength")?.ok_or("a bufferView has no byteLength")?;
        let bytes = buffers
            .get(buffer)
            .ok_or_else(|| format!("there is no buffer {buffer}"))?;
        let end = start.checked_add(length).ok_or_else(outside)?;
        let bytes = bytes.get(start..end).ok_or_else(outside)?;
        Ok(Self {
            bytes: bytes.get(offset..).ok_or_else(outside)?,
            stride: whole(json, "byteStride")?,
        })
    }
}

fn read_elements(
    span: Span<'_>,
    component: Component,
    kind: ElementKind,
    count: usize,
) -> Result<Vec<f64>, String> {
    let size = component.size();
    // Columns of matrices start at multiples of four bytes.
    let column = match kind.columns {
        1 => kind.rows * size,
        _ => (kind.rows * size).next_multiple_of(4),
    };
    let element = column * (kind.columns - 1) + kind.rows * size;
    let stride = span.stride.unwrap_or(column * kind.columns);
    if count == 0 {
        return Ok(Vec::new());
    }
    let end = (count - 1)
        .checked_mul(stride)
        .and_then(|start| start.checked_add(element));
    if end.is_none_or(|end| end > span.bytes.len()) {
        return Err("reaches beyond its bufferView".to_owned());
    }
    let mut values = zeros(kind, count)?;
    for (index, value) in values.iter_mut().enumerate() {
        let (item, number) = (index / kind.width(), index % kind.width());
        let at = item * stride + number / kind.rows * column + number % kind.rows * size;
        *value = component.read(&span.bytes[at..at + size]);
    }
    Ok(values)
}

/// How one number is stored.
#[derive(Clone, Copy)]
struct Component {
    code: u64,
    normalized: bool,
}

impl Component {
    fn of(json: &Value) -> Result<Self, String> {
        let code = json["componentType"].as_u64().unwrap_or_default();
        if !matches!(code, 5120..=5123 | 5125 | 5126) {
            return Err(format!("unknown componentType {code}"));
        }
        Ok(Self {
            code,
            normalized: json["normalized"].as_bool().unwrap_or(false),
        })
    }

    fn size(self) -> usize {
        match self.code {
            5120 | 5121 => 1,
            5122 | 5123 => 2,
            _ => 4,
        }
    }

    /// Reads `self.size()` bytes.
    fn read(self, bytes: &[u8]) -> f64 {
        let mut four = [0; 4];
        four[..bytes.len()].copy_from_slice(bytes);
        let [a, b, ..] = four;
        let (value, one) = match self.code {
            5120 => (f64::from(a as i8), 127.0),
            5121 => (f64::from(a), 255.0),
            5122 => (f64::from(i16::from_le_bytes([a, b])), 32_767.0),
            5123 => (f64::from(u16::from_le_bytes([a, b])), 65_535.0),
            5125 => (f64::from(u32::from_le_bytes(four)), 4_294_967_295.0),
            _ => return f64::from(f32::from_le_bytes(four)),
        };
        if self.normalized {
            (value / one).max(-1.0)
        } else {
            value
        }
    }
}

/// A whole number of a JSON object, if it is there.
pub(crate) fn whole(json: &Value, key: &str) -> Result<Option<usize>, String> {
    match json.get(key) {
        None => Ok(None),
        Some(value) => value
            .as_u64()
            .and_then(|number| usize::try_from(number).ok())
            .map(Some)
            .ok_or_else(|| format!("{key} is {value}, not an index or size")),
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    fn one(view: Value, accessor: Value, bytes: &[u8]) -> Result<AccessorData, String> {
        let json = json!({"bufferViews": [view], "accessors": [accessor]});
        read_accessor(&json, &[bytes], 0)
    }

    #[test]
    fn gltf_reads_every_component_type() {
        let cases = [
            (5120, false, vec![0xff, 2], vec![-1.0, 2.0]),
            (5120, true, vec![0x80, 127], vec![-1.0, 1.0]),
            (5121, true, vec![255, 0], vec![1.0, 0.0]),
            (5122, false, vec![0xff, 0xff, 3, 0], vec![-1.0, 3.0]),
            (5123, true, vec![0xff, 0xff, 0, 0], vec![1.0, 0.0]),
            (5125, false, vec![0xff; 4], vec![f64::from(u32::MAX)]),
            (5126, false, 1.5f32.to_le_bytes().to_vec(), vec![1.5]),
        ];
        for (code, normalized, bytes, expected) in cases {
            let read = one(
                json!({"buffer": 0, "byteLength": bytes.len()}),
                json!({"bufferView": 0, "componentType": code, "normalized": normalized,
                       "count": expected.len(), "type": "SCALAR"}),
                &bytes,
            );
            assert_eq!(read.unwrap().values, expected, "{code}");
        }
    }

    #[test]
    fn gltf_reads_strides_offsets_and_padded_matrices() {
        let bytes = [9, 9, 1, 2, 9, 9, 3, 4];
        let read = one(
            json!({"buffer": 0, "byteOffset": 1, "byteLength": 7, "byteStride": 4}),
            json!({"bufferView": 0, "byteOffset": 1, "componentType": 5121, "count": 2,
                   "type": "VEC2"}),
            &bytes,
        );
        assert_eq!(read.unwrap().values, [1.0, 2.0, 3.0, 4.0]);
        let read = one(
            json!({"buffer": 0, "byteLength": 6}),
            json!({"bufferView": 0, "componentType": 5121, "count": 1, "type": "MAT2"}),
            &[1, 2, 9, 9, 3, 4],
        );
        assert_eq!(read.unwrap().values, [1.0, 2.0, 3.0, 4.0]);
    }

    #[test]
    fn gltf_reads_sparse_accessors_without_a_base() {
        let mut bytes = vec![1, 0, 0, 0];
        bytes.extend(7f32.to_le_bytes());
        let json = json!({
            "bufferViews": [
                {"buffer": 0, "byteLength": 1},
                {"buffer": 0, "byteOffset": 4, "byteLength": 4},
            ],
            "accessors": [{"componentType": 5126, "count": 3, "type": "SCALAR", "sparse": {
                "count": 1,
                "indices": {"bufferView": 0, "componentType": 5121},
                "values": {"bufferView": 1},
            }}],
        });
        let read = read_accessor(&json, &[&bytes], 0).unwrap();
        assert_eq!(read.values, [0.0, 7.0, 0.0]);
        bytes[0] = 3;
        assert!(read_accessor(&json, &[&bytes], 0).is_err());
    }

    #[test]
    fn gltf_refuses_accessors_out_of_bounds() {
        let accessor = |count: u64| json!({"bufferView": 0, "componentType": 5126, "count": count, "type": "VEC3"});
        let view = json!({"buffer": 0, "byteLength": 12});
        assert!(one(view.clone(), accessor(1), &[0; 12]).is_ok());
        for count in [2, u64::MAX, u64::MAX / 12] {
            assert!(one(view.clone(), accessor(count), &[0; 12]).is_err());
        }
        assert!(one(view, accessor(1), &[0; 11]).is_err());
        let view = json!({"buffer": 0, "byteOffset": u64::MAX, "byteLength": 12});
        assert!(one(view, accessor(1), &[0; 12]).is_err());
        let huge = json!({"componentType": 5126, "count": u64::MAX / 64, "type": "VEC3"});
        assert!(one(json!({}), huge, &[]).is_err());
    }
}

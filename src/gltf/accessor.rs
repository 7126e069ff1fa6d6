//! Reads accessors with every bound checked: component types, strides, sparse values.

use gltf::json::Root;
use gltf::json::accessor::sparse::Sparse;
use gltf::json::accessor::{Accessor, ComponentType, Type};
use gltf::json::validation::Checked;

/// Most bytes of zeros that an accessor without a buffer view stands for. Nothing in the file
/// bounds them.
const MAX_ZEROS: u64 = 1 << 28;

/// The data of a document.
#[derive(Clone, Copy, Debug)]
pub(super) struct Accessors<'a> {
    root: &'a Root,
    buffers: &'a [Vec<u8>],
}

/// An accessor's elements, tightly packed.
struct Packed {
    bytes: Vec<u8>,
    component: ComponentType,
    width: usize,
    normalized: bool,
}

impl<'a> Accessors<'a> {
    /// `buffers` are the bytes of the document's buffers, of the lengths it says.
    pub(super) fn new(root: &'a Root, buffers: &'a [Vec<u8>]) -> Self {
        Self { root, buffers }
    }

    /// The bytes of a buffer view.
    pub(super) fn view(&self, index: usize) -> Result<&'a [u8], String> {
        let fault = || format!("bufferViews[{index}] reaches past its buffer");
        let view = self.root.buffer_views.get(index).ok_or_else(fault)?;
        let buffer = self.buffers.get(view.buffer.value()).ok_or_else(fault)?;
        let start = view.byte_offset.unwrap_or_default().0;
        let end = start.checked_add(view.byte_length.0).ok_or_else(fault)?;
        let start = usize::try_from(start).map_err(|_| fault())?;
        let end = usize::try_from(end).map_err(|_| fault())?;
        buffer.get(start..end).ok_or_else(fault)
    }

    /// Whether the document has no data for an accessor, which makes it all zeros.
    pub(super) fn is_empty(&self, index: usize) -> bool {
        let accessor = self.root.accessors.get(index);
        accessor.is_none_or(|a| a.buffer_view.is_none() && a.sparse.is_none())
    }

    /// The numbers of an accessor of one of `types`, and how many make an element. Integers are
    /// converted as `normalized` says.
    pub(super) fn floats(&self, index: usize, types: &[Type]) -> Result<(Vec<f32>, usize), String> {
        self.packed(index, types)
            .map(|packed| (packed.floats(), packed.width))
            .map_err(|reason| format!("accessors[{index}] {reason}"))
    }

    /// The unsigned integers of an accessor of type `ty`, and how many make an element.
    pub(super) fn integers(&self, index: usize, ty: Type) -> Result<(Vec<u32>, usize), String> {
        self.packed(index, &[ty])
            .and_then(|packed| Ok((packed.integers()?, packed.width)))
            .map_err(|reason| format!("accessors[{index}] {reason}"))
    }

    fn packed(&self, index: usize, types: &[Type]) -> Result<Packed, String> {
        let accessor = self.root.accessors.get(index).ok_or("does not exist")?;
        let Checked::Valid(component) = accessor.component_type else {
            return Err("has an unknown componentType".to_owned());
        };
        let width = match accessor.type_ {
            Checked::Valid(ty) if types.contains(&ty) => ty.multiplicity(),
            _ => return Err(format!("is not of type {}", type_names(types))),
        };
        let element = width * component.0.size();
        let mut bytes = self.base(accessor, element)?;
        if let Some(sparse) = &accessor.sparse {
            self.apply_sparse(sparse, &mut bytes, element)?;
        }
        Ok(Packed {
            bytes,
            component: component.0,
            width,
            normalized: accessor.normalized,
        })
    }

    /// The elements before sparse values: those of the buffer view, or zeros.
    fn base(&self, accessor: &Accessor, element: usize) -> Result<Vec<u8>, String> {
        let count = accessor.count.0;
        let Some(view) = accessor.buffer_view else {
            let total = count.checked_mul(element as u64);
            return match total.filter(|&total| total <= MAX_ZEROS) {
                Some(total) => Ok(vec![0; total as usize]),
                None => Err(format!("says {count} elements without saying where")),
            };
        };
        let stride = self.stride(view.value(), element)?;
        let view = self.view(view.value())?;
        let offset = accessor.byte_offset.unwrap_or_default().0;
        strided(view, offset, count, stride, element)
    }

    fn stride(&self, view: usize, element: usize) -> Result<usize, String> {
        let view = self.root.buffer_views.get(view);
        match view.and_then(|view| view.byte_stride) {
            None => Ok(element),
            Some(stride) if stride.0 >= element => Ok(stride.0),
            Some(stride) => Err(format!(
                "has elements of {element} bytes, but the byteStride of its buffer view is {}",
                stride.0
            )),
        }
    }

    fn apply_sparse(
        &self,
        sparse: &Sparse,
        bytes: &mut [u8],
        element: usize,
    ) -> Result<(), String> {
        let fault = |reason: String| format!("has sparse values: {reason}");
        let Checked::Valid(kind) = sparse.indices.component_type else {
            return Err(fault("unknown componentType of indices".to_owned()));
        };
        let size = kind.0.size();
        let read = |view: usize, offset: u64, element: usize| {
            strided(self.view(view)?, offset, sparse.count.0, element, element)
        };
        let at = &sparse.indices;
        let indices = read(at.buffer_view.value(), at.byte_offset.0, size).map_err(fault)?;
        let at = &sparse.values;
        let values = read(at.buffer_view.value(), at.byte_offset.0, element).map_err(fault)?;
        let count = bytes.len() / element;
        let mut next = 0;
        for (index, value) in indices.chunks_exact(size).zip(values.chunks_exact(element)) {
            let index = unsigned(index) as usize;
            if index >= count {
                return Err(fault(format!("index {index} of {count} elements")));
            }
            if index < next {
                return Err(fault("indices do not increase".to_owned()));
            }
            next = index + 1;
            bytes[index * element..next * element].copy_from_slice(value);
        }
        Ok(())
    }
}

/// Packs `count` elements that lie `stride` bytes apart. Allocates only what is there.
fn strided(
    view: &[u8],
    offset: u64,
    count: u64,
    stride: usize,
    element: usize,
) -> Result<Vec<u8>, String> {
    if count == 0 {
        return Ok(Vec::new());
    }
    let past = || {
        format!(
            "says {count} elements of {element} bytes from byte {offset}, but its buffer view has \
             {} bytes",
            view.len()
        )
    };
    let span = (count - 1)
        .checked_mul(stride as u64)
        .and_then(|span| span.checked_add(element as u64))
        .and_then(|span| usize::try_from(span).ok())
        .ok_or_else(past)?;
    let start = usize::try_from(offset).map_err(|_| past())?;
    let end = start.checked_add(span).ok_or_else(past)?;
    let data = view.get(start..end).ok_or_else(past)?;
    if stride == element {
        return Ok(data.to_vec());
    }
    let mut bytes = Vec::with_capacity(count as usize * element);
    for chunk in data.chunks(stride) {
        bytes.extend_from_slice(chunk.get(..element).ok_or_else(past)?);
    }
    Ok(bytes)
}

/// A little endian unsigned integer of 1, 2 or 4 bytes.
fn unsigned(bytes: &[u8]) -> u32 {
    let digits = bytes.iter().rev();
    digits.fold(0, |value, &byte| value << 8 | u32::from(byte))
}

fn type_names(types: &[Type]) -> String {
    let names: Vec<_> = types.iter().map(|ty| format!("{ty:?}")).collect();
    names.join(" or ").to_uppercase()
}

impl Packed {
    fn floats(&self) -> Vec<f32> {
        let scale = match (self.normalized, self.component) {
            (true, ComponentType::I8) => 127.0,
            (true, ComponentType::U8) => 255.0,
            (true, ComponentType::I16) => 32767.0,
            (true, ComponentType::U16) => 65535.0,
            (true, ComponentType::U32) => u32::MAX as f32,
            _ => 1.0,
        };
        // The lowest signed integer would be a little below -1.
        let floor = if self.normalized { -1.0 } else { f32::MIN };
        let components = self.bytes.chunks_exact(self.component.size());
        let read = components.map(|bytes| {
            let raw = unsigned(bytes);
            match self.component {
                ComponentType::I8 => (f32::from(raw as u8 as i8) / scale).max(floor),
                ComponentType::I16 => (f32::from(raw as u16 as i16) / scale).max(floor),
                ComponentType::U8 | ComponentType::U16 | ComponentType::U32 => raw as f32 / scale,
                ComponentType::F32 => f32::from_bits(raw),
            }
        });
        read.collect()
    }

    fn integers(&self) -> Result<Vec<u32>, String> {
        match self.component {
            ComponentType::U8 | ComponentType::U16 | ComponentType::U32 => {
                let components = self.bytes.chunks_exact(self.component.size());
                Ok(components.map(unsigned).collect())
            }
            _ => Err("holds no unsigned integers".to_owned()),
        }
    }
}

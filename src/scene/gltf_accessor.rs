//! Which numbers are in a glTF file's buffers, when nothing in the file can be trusted?
//!
//! Every offset, stride and count is checked against the bytes there are.

use crate::error::{SceneError, one_line, shortened};
use base64::Engine;
use gltf::accessor::{DataType, Dimensions};
use std::borrow::Cow;
use std::path::Path;

/// Elements of an accessor without bytes of its own (all zero but for sparse ones).
const MAX_WITHOUT_BYTES: usize = 1 << 24;

/// Bytes of a file; a glTF binary's length has 32 bits.
const MAX_FILE: u64 = u32::MAX as u64;

/// The bytes of all buffers of a document.
pub struct Buffers {
    data: Vec<Vec<u8>>,
}

/// Returns the bytes that a URI of a document in `folder` stands for: base64 data or a file.
pub fn read_uri(folder: &Path, uri: &str) -> Result<Vec<u8>, String> {
    if let Some(data) = uri.strip_prefix("data:") {
        let Some((_, text)) = data.split_once(";base64,") else {
            return Err("its data: URI is not base64".into());
        };
        return base64::engine::general_purpose::STANDARD
            .decode(text)
            .map_err(|e| format!("its data: URI is not valid base64 ({e})"));
    }
    if uri.contains("://") {
        return Err(format!("{:?} is not a file beside the scene", shortened(uri, 100)));
    }
    let name = percent_encoding::percent_decode_str(uri)
        .decode_utf8()
        .map_err(|_| format!("{:?} is not UTF-8", shortened(uri, 100)))?;
    read_file(&folder.join(&*name))
        .map_err(|reason| format!("its file {:?} cannot be read ({reason})", shortened(&name, 100)))
}

/// Reads a file that is one: devices and pipes may have no end.
pub fn read_file(path: &Path) -> Result<Vec<u8>, String> {
    let about = std::fs::metadata(path).map_err(one_line)?;
    if about.is_dir() {
        return Err("it is a folder".into());
    }
    if !about.is_file() {
        return Err("it is a device or a pipe".into());
    }
    if about.len() > MAX_FILE {
        return Err(format!("its {} bytes are more than {MAX_FILE}", about.len()));
    }
    std::fs::read(path).map_err(one_line)
}

impl Buffers {
    /// Reads all buffers: the binary chunk, embedded data, files in `folder`.
    pub fn read(
        document: &gltf::Document,
        mut blob: Option<Vec<u8>>,
        path: &Path,
    ) -> Result<Self, SceneError> {
        let folder = path.parent().unwrap_or(Path::new(""));
        let mut data = vec![];
        for buffer in document.buffers() {
            let error = |reason: String| SceneError::Format {
                path: one_line(path.display()),
                reason: format!("buffer {}: {reason}", buffer.index()),
            };
            let bytes = match buffer.source() {
                gltf::buffer::Source::Uri(uri) => read_uri(folder, uri).map_err(error)?,
                gltf::buffer::Source::Bin => {
                    blob.take().ok_or_else(|| error("there is no binary chunk".into()))?
                }
            };
            if bytes.len() < buffer.length() {
                return Err(error(format!("{} bytes where it says {}", bytes.len(), buffer.length())));
            }
            data.push(bytes);
        }
        Ok(Self { data })
    }

    /// Returns a buffer view's bytes.
    pub fn view(&self, view: &gltf::buffer::View) -> Result<&[u8], String> {
        let end = view.offset().checked_add(view.length());
        end.and_then(|end| self.data.get(view.buffer().index())?.get(view.offset()..end))
            .ok_or_else(|| format!("buffer view {} reaches beyond its buffer", view.index()))
    }

    /// Returns `count` elements of `size` bytes from a view, tightly packed.
    fn packed(
        &self,
        view: &gltf::buffer::View,
        offset: usize,
        count: usize,
        size: usize,
    ) -> Result<Cow<'_, [u8]>, String> {
        let bytes = self.view(view)?;
        let stride = view.stride().unwrap_or(size);
        if stride < size {
            return Err(format!("buffer view {} has a stride of {stride} for {size} bytes", view.index()));
        }
        if count == 0 {
            return Ok(Cow::Borrowed(&[]));
        }
        let end = (count - 1).checked_mul(stride).and_then(|n| n.checked_add(size)?.checked_add(offset));
        let Some(range) = end.and_then(|end| bytes.get(offset..end)) else {
            return Err(format!("{count} elements reach beyond buffer view {}", view.index()));
        };
        if stride == size {
            return Ok(Cow::Borrowed(range));
        }
        Ok(Cow::Owned(range.chunks(stride).flat_map(|element| &element[..size]).copied().collect()))
    }

    /// Returns an accessor's elements, tightly packed, with sparse ones in place.
    fn elements(&self, accessor: &gltf::Accessor) -> Result<Cow<'_, [u8]>, String> {
        let (count, size) = (accessor.count(), accessor.size());
        let mut elements = match accessor.view() {
            Some(view) => self.packed(&view, accessor.offset(), count, size)?,
            None if count <= MAX_WITHOUT_BYTES => Cow::Owned(vec![0; count * size]),
            None => return Err(format!("{count} elements without a buffer view")),
        };
        if let Some(sparse) = accessor.sparse() {
            let (places, values) = (sparse.indices(), sparse.values());
            let width = places.index_type().size();
            let at = self.packed(&places.view(), places.offset(), sparse.count(), width)?;
            let new = self.packed(&values.view(), values.offset(), sparse.count(), size)?;
            let elements = elements.to_mut();
            for (place, value) in at.chunks_exact(width).zip(new.chunks_exact(size)) {
                let place = unsigned(place) as usize;
                let Some(target) = place.checked_mul(size).and_then(|n| elements.get_mut(n..n + size)) else {
                    return Err(format!("sparse index {place} is beyond {count} elements"));
                };
                target.copy_from_slice(value);
            }
        }
        Ok(elements)
    }

    /// Returns an accessor of N-vectors as f32; normalized integers are scaled to [0, 1] or [−1, 1].
    pub fn vectors<const N: usize>(&self, accessor: &gltf::Accessor) -> Result<Vec<[f32; N]>, String> {
        if accessor.dimensions().multiplicity() != N || matches!(accessor.dimensions(), Dimensions::Mat2) {
            return Err(format!("accessor {} does not hold vectors of {N}", accessor.index()));
        }
        let (kind, normalized) = (accessor.data_type(), accessor.normalized());
        let size = kind.size();
        let elements = self.elements(accessor)?;
        let number = |bytes: &[u8]| {
            let (value, scale) = match kind {
                DataType::F32 => return f32::from_bits(unsigned(bytes)),
                DataType::U8 => (unsigned(bytes) as f32, 255.0),
                DataType::U16 => (unsigned(bytes) as f32, 65535.0),
                DataType::U32 => (unsigned(bytes) as f32, u32::MAX as f32),
                DataType::I8 => (f32::from(unsigned(bytes) as u8 as i8), 127.0),
                DataType::I16 => (f32::from(unsigned(bytes) as u16 as i16), 32767.0),
            };
            if normalized { (value / scale).max(-1.0) } else { value }
        };
        let vector = |bytes: &[u8]| std::array::from_fn(|i| number(&bytes[i * size..(i + 1) * size]));
        Ok(elements.chunks_exact(N * size).map(vector).collect())
    }

    /// Returns an accessor of unsigned integers.
    pub fn indices(&self, accessor: &gltf::Accessor) -> Result<Vec<u32>, String> {
        let size = match (accessor.dimensions(), accessor.data_type()) {
            (Dimensions::Scalar, DataType::U8 | DataType::U16 | DataType::U32) => accessor.size(),
            _ => return Err(format!("accessor {} does not hold indices", accessor.index())),
        };
        Ok(self.elements(accessor)?.chunks_exact(size).map(unsigned).collect())
    }
}

/// Reads up to four bytes, the lowest first.
fn unsigned(bytes: &[u8]) -> u32 {
    bytes.iter().rev().fold(0, |value, &byte| value << 8 | u32::from(byte))
}

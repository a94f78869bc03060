//! Reads the buffers of a glTF file and the accessors in them.
//!
//! The crate's own readers trust counts, offsets and sparse indices, and panic if they are wrong.

use std::path::Path;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use gltf::accessor::sparse::IndexType;
use gltf::accessor::{Accessor, DataType};
use gltf::buffer::{Source, View};

use crate::files::named_below::{is_below, leads_out};
use crate::import::files::{MAX_BYTES, read_file};

/// The maximum number of values in one accessor. Our choice: bodies have 10 to 100 thousand
/// vertices.
const MAX_NUMBERS: usize = 16_000_000;

/// The bytes of all buffers.
pub(super) struct Buffers(Vec<Vec<u8>>);

impl Buffers {
    /// Loads the document's buffers: the binary chunk, `data:` URIs and files relative to `folder`.
    pub(super) fn load(
        document: &gltf::Document,
        mut blob: Option<Vec<u8>>,
        folder: &Path,
    ) -> Result<Self, String> {
        let mut total = 0;
        let mut all = Vec::new();
        for buffer in document.buffers() {
            let name = format!("buffer {}", buffer.index());
            let bytes = match buffer.source() {
                Source::Bin => blob
                    .take()
                    .ok_or_else(|| format!("{name}: the file has no binary chunk for it"))?,
                Source::Uri(uri) => from_uri(uri, folder).map_err(|e| format!("{name}: {e}"))?,
            };
            if bytes.len() < buffer.length() {
                return Err(format!(
                    "{name}: expected {} bytes, found {} (is the file truncated?)",
                    buffer.length(),
                    bytes.len()
                ));
            }
            total += bytes.len() as u64;
            if total > MAX_BYTES {
                return Err(format!(
                    "buffers of more than {} MB (leave out the textures)",
                    MAX_BYTES >> 20
                ));
            }
            all.push(bytes);
        }
        Ok(Self(all))
    }

    /// Returns the items of an accessor, `N` finite numbers each. Integers that the accessor states
    /// as normalised are shares of their range.
    pub(super) fn numbers<const N: usize>(
        &self,
        accessor: &Accessor,
    ) -> Result<Vec<[f64; N]>, String> {
        let kind = accessor.data_type();
        let is_share = accessor.normalized();
        let items = self.items(accessor, |bytes| component(bytes, kind, is_share))?;
        if let Some(at) = items
            .iter()
            .position(|item: &[f64; N]| item.iter().any(|value| !value.is_finite()))
        {
            return Err(format!(
                "accessor {}: item {at} is not finite",
                accessor.index()
            ));
        }
        Ok(items)
    }

    /// Returns the items of an accessor, `N` unsigned integers each.
    pub(super) fn integers<const N: usize>(
        &self,
        accessor: &Accessor,
    ) -> Result<Vec<[u32; N]>, String> {
        let kind = accessor.data_type();
        if !matches!(kind, DataType::U8 | DataType::U16 | DataType::U32) {
            return Err(format!(
                "accessor {}: expected unsigned integers, found {kind:?}",
                accessor.index()
            ));
        }
        self.items(accessor, unsigned)
    }

    fn items<T: Copy + Default, const N: usize>(
        &self,
        accessor: &Accessor,
        decode: impl Fn(&[u8]) -> T,
    ) -> Result<Vec<[T; N]>, String> {
        let fail = |problem: String| format!("accessor {}: {problem}", accessor.index());
        let (width, count) = (accessor.data_type().size(), accessor.count());
        if accessor.dimensions().multiplicity() != N {
            return Err(fail(format!(
                "expected {N} numbers an item, found {:?}",
                accessor.dimensions()
            )));
        }
        if count > MAX_NUMBERS / N {
            return Err(fail(format!(
                "expected at most {} items, found {count}",
                MAX_NUMBERS / N
            )));
        }
        let size = width * N;
        let item = |bytes: &[u8]| {
            let mut values = [T::default(); N];
            for (value, bytes) in values.iter_mut().zip(bytes.chunks_exact(width)) {
                *value = decode(bytes);
            }
            values
        };
        let mut items = match accessor.view() {
            Some(view) => {
                let strided = self.strided(&view, accessor.offset(), size, count);
                strided.map_err(fail)?.map(item).collect()
            }
            None => vec![[T::default(); N]; count],
        };
        if let Some(sparse) = accessor.sparse() {
            let (indices, values) = (sparse.indices(), sparse.values());
            let index_size = match indices.index_type() {
                IndexType::U8 => 1,
                IndexType::U16 => 2,
                IndexType::U32 => 4,
            };
            let count = sparse.count();
            let at = self.strided(&indices.view(), indices.offset(), index_size, count);
            let to = self.strided(&values.view(), values.offset(), size, count);
            for (index, value) in at.map_err(fail)?.zip(to.map_err(fail)?) {
                let index = unsigned(index);
                let target = usize::try_from(index)
                    .ok()
                    .and_then(|index| items.get_mut(index));
                *target.ok_or_else(|| fail(format!("sparse index {index} is out of range")))? =
                    item(value);
            }
        }
        Ok(items)
    }

    /// Returns `count` pieces of `size` bytes in a view, from `offset` on.
    fn strided<'a>(
        &'a self,
        view: &View,
        offset: usize,
        size: usize,
        count: usize,
    ) -> Result<impl Iterator<Item = &'a [u8]> + use<'a>, String> {
        let stride = view.stride().unwrap_or(size);
        if stride < size {
            return Err(format!(
                "expected a stride of at least {size} bytes, found {stride}"
            ));
        }
        let buffer = self.0.get(view.buffer().index());
        let needed = match count {
            0 => Some(0),
            _ => (count - 1)
                .checked_mul(stride)
                .and_then(|n| n.checked_add(size)),
        };
        let bytes = needed
            .filter(|needed| {
                offset
                    .checked_add(*needed)
                    .is_some_and(|end| end <= view.length())
            })
            .zip(view.offset().checked_add(offset))
            .and_then(|(needed, start)| {
                let end = start.checked_add(needed)?;
                buffer?.get(start..end)
            })
            .ok_or_else(|| {
                format!(
                    "{count} items of {size} bytes do not fit into buffer view {}",
                    view.index()
                )
            })?;
        Ok(bytes
            .chunks(stride)
            .take(count)
            .map(move |item| &item[..size]))
    }
}

/// Returns the bytes to which a buffer's URI refers.
fn from_uri(uri: &str, folder: &Path) -> Result<Vec<u8>, String> {
    if let Some(data) = uri.strip_prefix("data:") {
        let (_, text) = data
            .split_once(";base64,")
            .ok_or("expected a data URI in base64")?;
        return STANDARD
            .decode(text)
            .map_err(|error| format!("its base64 is broken: {error}"));
    }
    let shown: String = uri.chars().take(80).collect();
    let name = percent_decoded(uri).ok_or_else(|| format!("`{shown}` is not a file name"))?;
    let path = folder.join(&name);
    if !is_below(&name) || leads_out(folder, &path) {
        return Err(format!(
            "expected a file beside the .gltf, or in a folder there, found `{shown}`"
        ));
    }
    read_file(&path).map_err(|error| error.to_string())
}

fn percent_decoded(uri: &str) -> Option<String> {
    let mut pieces = uri.split('%');
    let mut bytes = pieces.next()?.as_bytes().to_vec();
    for piece in pieces {
        bytes.push(u8::from_str_radix(piece.get(..2)?, 16).ok()?);
        bytes.extend_from_slice(&piece.as_bytes()[2..]);
    }
    String::from_utf8(bytes).ok()
}

/// Decodes a little-endian unsigned integer of at most four bytes.
fn unsigned(bytes: &[u8]) -> u32 {
    bytes
        .iter()
        .rev()
        .fold(0, |value, byte| value << 8 | u32::from(*byte))
}

/// Decodes a number of an accessor (glTF 2.0, section 3.6.2.2 and, for shares, 3.11).
fn component(bytes: &[u8], kind: DataType, is_share: bool) -> f64 {
    let share = |value: f64, full: f64| match is_share {
        true => (value / full).max(-1.0),
        false => value,
    };
    match (kind, bytes) {
        (DataType::I8, &[a]) => share(i8::from_le_bytes([a]).into(), 127.0),
        (DataType::I16, &[a, b]) => share(i16::from_le_bytes([a, b]).into(), 32_767.0),
        (DataType::F32, &[a, b, c, d]) => f32::from_le_bytes([a, b, c, d]).into(),
        (DataType::U8, bytes) => share(unsigned(bytes).into(), 255.0),
        (DataType::U16, bytes) => share(unsigned(bytes).into(), 65_535.0),
        (_, bytes) => unsigned(bytes).into(),
    }
}

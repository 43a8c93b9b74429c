//! Tensor files: named arrays of numbers, as photometers of materials write them.
//!
//! Little endian: `tensor_file` and a zero byte, version 1.0 (two u8), the number of fields (u32); of each field the length of its name (u16), the name,
//! its dimensions (u16), type (u8), the byte at which its numbers begin (u64) and its size along each dimension (u64 each).
//!
//! Source: the description of the data files of [Dupuy, Jakob 2018].

use crate::mesh::FileError;
use std::collections::BTreeMap;

const MAGIC: &[u8; 12] = b"tensor_file\0";
/// Types by their number, with the bytes of one number.
const TYPES: [(&str, usize); 11] = [
    ("uint8", 1),
    ("int8", 1),
    ("uint16", 2),
    ("int16", 2),
    ("uint32", 4),
    ("int32", 4),
    ("uint64", 8),
    ("int64", 8),
    ("float16", 2),
    ("float32", 4),
    ("float64", 8),
];
const UINT8: usize = 0;
const FLOAT32: usize = 9;

/// A field: its size, and its numbers as bytes.
#[derive(Clone, Debug)]
struct Field<'a> {
    shape: Vec<usize>,
    kind: usize,
    bytes: &'a [u8],
    at: usize,
}

/// The fields of a file.
#[derive(Clone, Debug)]
pub(crate) struct Tensors<'a>(BTreeMap<&'a str, Field<'a>>);

/// Bytes from the front of a file.
struct Cursor<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl<'a> Cursor<'a> {
    fn take(&mut self, n: usize, what: &str) -> Result<&'a [u8], FileError> {
        let found = self.bytes.get(self.at..).and_then(|rest| rest.get(..n));
        let bytes = found.ok_or_else(|| FileError::byte(self.bytes.len(), format!("the file ends within {what}")))?;
        self.at += n;
        Ok(bytes)
    }

    fn number(&mut self, n: usize, what: &str) -> Result<u64, FileError> {
        Ok(self.take(n, what)?.iter().rev().fold(0, |x, b| x << 8 | u64::from(*b)))
    }
}

impl<'a> Tensors<'a> {
    /// The fields, each of which is there in full.
    pub fn read(bytes: &'a [u8]) -> Result<Self, FileError> {
        if !bytes.starts_with(MAGIC) {
            return Err(FileError::file("the file does not begin with `tensor_file`: it is no file of a measured material"));
        }
        let mut c = Cursor { bytes, at: MAGIC.len() };
        let version = c.take(2, "its head")?;
        if version != [1, 0] {
            return Err(FileError::byte(c.at - 2, format!("version {}.{} is not known, expected 1.0", version[0], version[1])));
        }
        let count = c.number(4, "its head")?;
        let mut fields = BTreeMap::new();
        for _ in 0..count {
            let start = c.at;
            let length = c.number(2, "the name of a field")? as usize;
            let name = std::str::from_utf8(c.take(length, "the name of a field")?)
                .map_err(|_| FileError::byte(start + 2, "the name of this field is no text"))?;
            let what = format!("the head of `{name}`");
            let dimensions = c.number(2, &what)?;
            let kind = c.number(1, &what)? as usize;
            let Some((_, size)) = kind.checked_sub(1).and_then(|i| TYPES.get(i)) else {
                return Err(FileError::byte(c.at - 1, format!("the type of `{name}` has the number {kind}, expected 1 to 11")));
            };
            let at = c.number(8, &what)?;
            let (mut shape, mut total) = (Vec::new(), *size as u128);
            for _ in 0..dimensions {
                let n = c.number(8, &what)?;
                // No more than any file has, so that the product stays in range.
                total = total.saturating_mul(u128::from(n));
                shape.push(usize::try_from(n).unwrap_or(usize::MAX));
            }
            let rest = usize::try_from(at).ok().and_then(|at| bytes.get(at..));
            let data = rest.filter(|rest| rest.len() as u128 >= total).ok_or_else(|| {
                FileError::byte(
                    start,
                    format!("`{name}` has {total} bytes from byte {at} on, and the file ends at {}", bytes.len()),
                )
            })?;
            fields.insert(name, Field { shape, kind: kind - 1, bytes: &data[..total as usize], at: at as usize });
        }
        Ok(Self(fields))
    }

    /// Whether there is such a field.
    pub fn has(&self, name: &str) -> bool {
        self.0.contains_key(name)
    }

    fn field(&self, name: &str, dimensions: usize, kind: usize) -> Result<&Field<'a>, FileError> {
        let Some(field) = self.0.get(name) else {
            let names = self.0.keys().copied().collect::<Vec<_>>().join(", ");
            return Err(FileError::file(format!("there is no field `{name}`; the file has: {names}")));
        };
        let (found, wanted) = (TYPES[field.kind].0, TYPES[kind].0);
        if field.kind != kind {
            return Err(FileError::byte(field.at, format!("`{name}` holds numbers of type {found}, expected {wanted}")));
        }
        if field.shape.len() != dimensions {
            let text = format!("`{name}` has {} dimensions, expected {dimensions}", field.shape.len());
            return Err(FileError::byte(field.at, text));
        }
        Ok(field)
    }

    /// The size of a field of so many dimensions, and its numbers, all finite.
    pub fn floats<const N: usize>(&self, name: &str) -> Result<([usize; N], Vec<f32>), FileError> {
        let field = self.field(name, N, FLOAT32)?;
        let values: Vec<f32> = field.bytes.as_chunks().0.iter().map(|b| f32::from_le_bytes(*b)).collect();
        if let Some(i) = values.iter().position(|x| !x.is_finite()) {
            return Err(FileError::byte(field.at + 4 * i, format!("`{name}` holds a number that is not finite: {}", values[i])));
        }
        Ok((std::array::from_fn(|i| field.shape[i]), values))
    }

    /// A field of bytes.
    pub fn bytes(&self, name: &str) -> Result<&'a [u8], FileError> {
        Ok(self.field(name, 1, UINT8)?.bytes)
    }
}

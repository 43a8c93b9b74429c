//! The numbers of a PLY file, one after the other.

use super::header::{Encoding, Scalar};
use crate::mesh::FileError;
use std::ops::Range;

/// Reads numbers of the types that the header names.
pub(super) trait Numbers {
    /// The next number as a coordinate or attribute.
    fn float(&mut self, scalar: Scalar) -> Result<f32, FileError>;
    /// The next number as a count or an index.
    fn integer(&mut self, scalar: Scalar) -> Result<i64, FileError>;
    /// A mistake at the number that was read last.
    fn mistake(&self, message: String) -> FileError;
    /// A mistake of what comes next as a whole.
    fn mistake_ahead(&self, message: String) -> FileError;
    /// The byte that is read next.
    fn at(&self) -> usize;
    /// Bytes that have not been read.
    fn rest(&self) -> usize;
    /// Leaves out bytes.
    fn skip(&mut self, bytes: usize);
    /// Bytes that have not been read and are not blank.
    fn left_over(&self) -> usize;
}

/// Numbers in binary.
pub(super) struct Binary<'b> {
    pub bytes: &'b [u8],
    pub at: usize,
    pub last: usize,
    pub big: bool,
}

impl Binary<'_> {
    #[inline]
    fn take<const N: usize>(&mut self) -> Result<[u8; N], FileError> {
        self.last = self.at;
        match self.bytes.get(self.at..).and_then(|rest| rest.first_chunk::<N>()) {
            Some(&chunk) => {
                self.at += N;
                let mut chunk = chunk;
                if self.big {
                    chunk.reverse();
                }
                Ok(chunk)
            }
            None => Err(FileError::byte(self.bytes.len(), "the file ends too early")),
        }
    }
}

impl Numbers for Binary<'_> {
    #[inline]
    fn float(&mut self, scalar: Scalar) -> Result<f32, FileError> {
        Ok(match scalar {
            Scalar::F32 => f32::from_le_bytes(self.take()?),
            Scalar::F64 => f64::from_le_bytes(self.take()?) as f32,
            _ => self.integer(scalar)? as f32,
        })
    }

    #[inline]
    fn integer(&mut self, scalar: Scalar) -> Result<i64, FileError> {
        Ok(match scalar {
            Scalar::I8 => i64::from(i8::from_le_bytes(self.take()?)),
            Scalar::U8 => i64::from(u8::from_le_bytes(self.take()?)),
            Scalar::I16 => i64::from(i16::from_le_bytes(self.take()?)),
            Scalar::U16 => i64::from(u16::from_le_bytes(self.take()?)),
            Scalar::I32 => i64::from(i32::from_le_bytes(self.take()?)),
            Scalar::U32 => i64::from(u32::from_le_bytes(self.take()?)),
            Scalar::I64 => i64::from_le_bytes(self.take()?),
            Scalar::U64 => i64::try_from(u64::from_le_bytes(self.take()?)).unwrap_or(i64::MAX),
            Scalar::F32 => f32::from_le_bytes(self.take()?) as i64,
            Scalar::F64 => f64::from_le_bytes(self.take()?) as i64,
        })
    }

    fn mistake(&self, message: String) -> FileError {
        FileError::byte(self.last, message)
    }

    fn mistake_ahead(&self, message: String) -> FileError {
        FileError::byte(self.at, message)
    }

    fn at(&self) -> usize {
        self.at
    }

    fn rest(&self) -> usize {
        self.bytes.len().saturating_sub(self.at)
    }

    fn skip(&mut self, bytes: usize) {
        self.at += bytes;
    }

    fn left_over(&self) -> usize {
        self.rest()
    }
}

/// Numbers as text, between blanks.
pub(super) struct Ascii<'b> {
    pub bytes: &'b [u8],
    pub at: usize,
    pub last: Range<usize>,
}

impl Ascii<'_> {
    /// Moves to the next word; an error at the end of the file.
    #[inline]
    fn next(&mut self) -> Result<(), FileError> {
        while matches!(self.bytes.get(self.at), Some(b' ' | b'\n' | b'\r' | b'\t')) {
            self.at += 1;
        }
        self.last = self.at..self.at;
        if self.at < self.bytes.len() { Ok(()) } else { Err(FileError::byte(self.at, "the file ends too early")) }
    }

    /// Takes a number of `digits` bytes, which must be a whole word.
    #[inline]
    fn end(&mut self, digits: usize, what: &str) -> Result<(), FileError> {
        let end = self.at + digits;
        if digits > 0 && matches!(self.bytes.get(end), None | Some(b' ' | b'\n' | b'\r' | b'\t')) {
            self.last = self.at..end;
            self.at = end;
            return Ok(());
        }
        let rest = &self.bytes[self.at..];
        let length = rest.iter().position(u8::is_ascii_whitespace).unwrap_or(rest.len());
        let word = String::from_utf8_lossy(&rest[..length.min(40)]).into_owned();
        Err(FileError::text(self.bytes, self.at..self.at + length, format!("`{word}` is no {what}")))
    }
}

impl Numbers for Ascii<'_> {
    #[inline]
    fn float(&mut self, _: Scalar) -> Result<f32, FileError> {
        self.next()?;
        let (value, digits) = fast_float2::parse_partial::<f32, _>(&self.bytes[self.at..]).unwrap_or((0.0, 0));
        self.end(digits, "number")?;
        Ok(value)
    }

    #[inline]
    fn integer(&mut self, _: Scalar) -> Result<i64, FileError> {
        self.next()?;
        let rest = &self.bytes[self.at..];
        let negative = rest.first() == Some(&b'-');
        let start = usize::from(negative || rest.first() == Some(&b'+'));
        let mut value: i64 = 0;
        let mut digits = start;
        while let Some(digit @ b'0'..=b'9') = rest.get(digits) {
            value = value.saturating_mul(10).saturating_add(i64::from(digit - b'0'));
            digits += 1;
        }
        self.end(if digits == start { 0 } else { digits }, "whole number")?;
        Ok(if negative { -value } else { value })
    }

    fn mistake(&self, message: String) -> FileError {
        FileError::text(self.bytes, self.last.clone(), message)
    }

    fn mistake_ahead(&self, message: String) -> FileError {
        FileError::file(message)
    }

    fn at(&self) -> usize {
        self.at
    }

    fn rest(&self) -> usize {
        self.bytes.len().saturating_sub(self.at)
    }

    fn skip(&mut self, bytes: usize) {
        self.at += bytes;
    }

    fn left_over(&self) -> usize {
        let rest = &self.bytes[self.at.min(self.bytes.len())..];
        if rest.iter().all(u8::is_ascii_whitespace) { 0 } else { rest.len() }
    }
}

/// The column of a property in a table of equal rows: `f32`s as they are, everything else converted.
pub(super) fn column(rows: &[u8], stride: usize, offset: usize, scalar: Scalar, encoding: Encoding) -> Vec<f32> {
    let big = encoding == Encoding::BigEndian;
    let cells = rows.chunks_exact(stride.max(1)).map(|row| &row[offset..]);
    match scalar {
        Scalar::F32 if !big => cells.map(|cell| f32::from_le_bytes([cell[0], cell[1], cell[2], cell[3]])).collect(),
        Scalar::F32 => cells.map(|cell| f32::from_be_bytes([cell[0], cell[1], cell[2], cell[3]])).collect(),
        // The cell is there, so that reading it cannot fail.
        _ => cells.map(|cell| Binary { bytes: cell, at: 0, last: 0, big }.float(scalar).unwrap_or(0.0)).collect(),
    }
}

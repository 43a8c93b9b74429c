//! Mitsuba's `.vol`: a regular grid of numbers.
//!
//! Little endian: `VOL`, version 3 (u8), encoding 1 = f32 (i32), cells along x, y, z (i32 each), channels (i32), the box as
//! x, y, z of its lower and of its upper corner (f32 each), then the numbers, channel fastest, then x, y, z.
//!
//! Source: Mitsuba documentation, "Grid-based volume data source".

use super::FileError;
use etendue_description::GridData;
use etendue_numerics::Bounds3;
use glam::Vec3;

const HEADER: usize = 48;

/// Reads a grid; its path is empty.
pub fn read(bytes: &[u8]) -> Result<GridData, Vec<FileError>> {
    one(bytes).map_err(|error| vec![error])
}

fn one(bytes: &[u8]) -> Result<GridData, FileError> {
    if !bytes.starts_with(b"VOL") {
        return Err(FileError::file("the file does not begin with `VOL`"));
    }
    if bytes.len() < HEADER {
        return Err(FileError::byte(bytes.len(), format!("the file ends within its header of {HEADER} bytes")));
    }
    if bytes[3] != 3 {
        return Err(FileError::byte(3, format!("version {} is not known, expected 3", bytes[3])));
    }
    let word = |at: usize| [bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]];
    let integer = |at: usize| i32::from_le_bytes(word(at));
    let float = |at: usize| f32::from_le_bytes(word(at));
    if integer(4) != 1 {
        return Err(FileError::byte(4, format!("encoding {} is not read, expected 1 (32-bit floats)", integer(4))));
    }
    let mut size = [0; 3];
    for (axis, cells) in size.iter_mut().enumerate() {
        let at = 8 + 4 * axis;
        let written = integer(at);
        *cells = usize::try_from(written).ok().filter(|&n| n > 0).ok_or_else(|| {
            FileError::byte(at, format!("the grid has {written} cells along {}, expected at least 1", ["x", "y", "z"][axis]))
        })?;
    }
    let channels = integer(20);
    let channels = usize::try_from(channels)
        .ok()
        .filter(|n| matches!(n, 1 | 3 | 6))
        .ok_or_else(|| FileError::byte(20, format!("the grid has {channels} channels, expected 1, 3 or 6")))?;

    let wanted = size.iter().map(|&n| n as u128).product::<u128>() * channels as u128 * 4;
    let data = &bytes[HEADER..];
    if wanted > data.len() as u128 {
        let [x, y, z] = size;
        let text = format!("{x} x {y} x {z} cells of {channels} channels take {wanted} bytes, and {} bytes follow", data.len());
        return Err(FileError::byte(HEADER, text));
    }
    let data: Vec<f32> = data[..wanted as usize].as_chunks().0.iter().map(|&b| f32::from_le_bytes(b)).collect();
    if let Some(i) = data.iter().position(|x| !x.is_finite()) {
        return Err(FileError::byte(HEADER + 4 * i, format!("the grid holds a number that is not finite: {}", data[i])));
    }
    let corner = |at: usize| Vec3::new(float(at), float(at + 4), float(at + 8));
    let (min, max) = (corner(24), corner(36));
    if !min.is_finite() || !max.is_finite() || min.cmpgt(max).any() {
        return Err(FileError::byte(24, format!("the grid's box from {min} to {max} is none")));
    }
    Ok(GridData { size, channels, bounds: Bounds3 { min, max }, data, ..GridData::default() })
}

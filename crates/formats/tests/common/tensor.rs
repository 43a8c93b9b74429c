//! Writes tensor files.
#![allow(dead_code)]

/// A field: name, number of its type, size, numbers as bytes.
pub type Field = (String, u8, Vec<u64>, Vec<u8>);

/// Of f32.
pub fn floats(name: &str, shape: &[usize], values: &[f32]) -> Field {
    let bytes = values.iter().flat_map(|x| x.to_le_bytes()).collect();
    (name.to_owned(), 10, shape.iter().map(|n| *n as u64).collect(), bytes)
}

/// Of bytes.
pub fn bytes(name: &str, values: &[u8]) -> Field {
    (name.to_owned(), 1, vec![values.len() as u64], values.to_vec())
}

/// A file of these fields.
pub fn file(fields: &[Field]) -> Vec<u8> {
    let head: usize = fields.iter().map(|(name, _, shape, _)| 2 + name.len() + 2 + 1 + 8 + 8 * shape.len()).sum();
    let mut out = b"tensor_file\0\x01\x00".to_vec();
    out.extend((fields.len() as u32).to_le_bytes());
    let mut at = 18 + head;
    for (name, kind, shape, bytes) in fields {
        out.extend((name.len() as u16).to_le_bytes());
        out.extend(name.bytes());
        out.extend((shape.len() as u16).to_le_bytes());
        out.push(*kind);
        out.extend((at as u64).to_le_bytes());
        shape.iter().for_each(|n| out.extend(n.to_le_bytes()));
        at += bytes.len();
    }
    fields.iter().for_each(|(.., bytes)| out.extend(bytes));
    out
}

/// The smallest of measured materials: one azimuth, two elevations, tables of 2 × 2, in `channels`: wavelengths, or none for red, green and blue.
pub fn material(wavelengths: &[f32]) -> Vec<Field> {
    let channels = if wavelengths.is_empty() { 3 } else { wavelengths.len() };
    let mut fields = vec![
        bytes("description", b"even"),
        floats("phi_i", &[1], &[0.0]),
        floats("theta_i", &[2], &[0.0, 1.5]),
        floats("ndf", &[2, 2], &[0.3; 4]),
        floats("sigma", &[2, 2], &[0.5; 4]),
        floats("vndf", &[1, 2, 2, 2], &[0.0, 1.0, 0.0, 1.0, 0.0, 2.0, 0.0, 1.0]),
        floats("luminance", &[1, 2, 2, 2], &[1.0; 8]),
        floats(if wavelengths.is_empty() { "rgb" } else { "spectra" }, &[1, 2, channels, 2, 2], &vec![0.5; 8 * channels]),
        bytes("jacobian", &[1]),
    ];
    if !wavelengths.is_empty() {
        fields.push(floats("wavelengths", &[channels], wavelengths));
    }
    fields
}

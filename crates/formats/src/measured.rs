//! `.bsdf`: a measured material, as the data base of [Dupuy, Jakob 2018] has them. A tensor file with the fields
//!
//! | field | size | |
//! | --- | --- | --- |
//! | `phi_i`, `theta_i` | p; t | azimuths and elevations of one direction, rising |
//! | `ndf`, `sigma` | any | density of normals, and the area that they show |
//! | `vndf` | p × t × any | density of the normals that each of these directions sees |
//! | `luminance` | p × t × n × n | what they reflect |
//! | `spectra`, `wavelengths`; or `rgb` | p × t × w × n × n; w | by wavelength in nm, rising; or as red, green and blue |
//! | `jacobian` | 1 | whether `ndf` and `sigma` are still to be multiplied with |

use crate::mesh::FileError;
use crate::tensor::Tensors;
use etendue_description::{MeasuredData, TableData};

/// Reads a material; its path is empty.
pub fn read(bytes: &[u8]) -> Result<MeasuredData, Vec<FileError>> {
    one(bytes).map_err(|error| vec![error])
}

fn one(bytes: &[u8]) -> Result<MeasuredData, FileError> {
    let file = Tensors::read(bytes)?;
    let phi = axis(&file, "phi_i")?;
    let theta = axis(&file, "theta_i")?;
    let spectral = file.has("wavelengths");
    let wavelengths = if spectral { axis(&file, "wavelengths")? } else { Vec::new() };
    let channels = if spectral { wavelengths.len() } else { 3 };

    let given = [("azimuths", phi.len()), ("elevations", theta.len()), ("channels", channels)];
    let table = |name: &str| -> Result<TableData, FileError> {
        let ([rows, columns], values) = file.floats::<2>(name)?;
        sized(name, [columns, rows], values)
    };
    let tables = |name: &str| -> Result<TableData, FileError> {
        let ([p, t, rows, columns], values) = file.floats::<4>(name)?;
        agree(name, &[p, t], &given)?;
        sized(name, [columns, rows], values)
    };
    let name = if spectral || !file.has("rgb") { "spectra" } else { "rgb" };
    let ([p, t, w, rows, columns], values) = file.floats::<5>(name)?;
    agree(name, &[p, t, w], &given)?;
    let spectra = sized(name, [columns, rows], values)?;

    let jacobian = file.bytes("jacobian")?.first().is_some_and(|b| *b != 0);
    Ok(MeasuredData {
        ndf: table("ndf")?,
        sigma: table("sigma")?,
        vndf: tables("vndf")?,
        luminance: tables("luminance")?,
        spectra,
        phi,
        theta,
        wavelengths,
        jacobian,
        ..MeasuredData::default()
    })
}

/// Rising numbers.
fn axis(file: &Tensors, name: &str) -> Result<Vec<f32>, FileError> {
    let ([_], values) = file.floats::<1>(name)?;
    if values.is_empty() {
        return Err(FileError::file(format!("`{name}` is empty")));
    }
    match values.windows(2).find(|w| w[0] >= w[1]) {
        Some(w) => Err(FileError::file(format!("`{name}` must rise: {} follows {}", w[1], w[0]))),
        None => Ok(values),
    }
}

/// A table of two or more columns and rows.
fn sized(name: &str, size: [usize; 2], values: Vec<f32>) -> Result<TableData, FileError> {
    if size.iter().any(|n| *n < 2) {
        return Err(FileError::file(format!("`{name}` has {} x {} nodes, expected at least 2 x 2", size[0], size[1])));
    }
    Ok(TableData { size, values })
}

/// Whether a field has as many tables as there are directions, and channels.
fn agree(name: &str, found: &[usize], given: &[(&str, usize)]) -> Result<(), FileError> {
    match found.iter().zip(given).find(|(n, (_, wanted))| *n != wanted) {
        Some((n, (what, wanted))) => Err(FileError::file(format!("`{name}` is for {n} {what}, and the file names {wanted}"))),
        None => Ok(()),
    }
}

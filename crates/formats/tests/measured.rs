//! Measured materials: what stands in the file, and what is said of one that is broken.

#[path = "common/tensor.rs"]
mod tensor;

use etendue_formats::measured;
use etendue_formats::mesh::Place;
use tensor::{Field, bytes, file, floats, material};

fn said(bytes: &[u8]) -> String {
    let error = measured::read(bytes).expect_err("a mistake").remove(0);
    match error.place {
        Place::Byte(at) => format!("byte {at}: {}", error.message),
        _ => error.message,
    }
}

/// The file with one field in place of that of its name, or one more.
fn with(field: Field) -> Vec<u8> {
    let mut fields = material(&[400.0, 700.0]);
    match fields.iter_mut().find(|f| f.0 == field.0) {
        Some(old) => *old = field,
        None => fields.push(field),
    }
    file(&fields)
}

#[test]
fn tables_by_wavelength_or_as_colours() {
    let spectral = measured::read(&file(&material(&[400.0, 500.0, 700.0]))).expect("a material");
    assert_eq!((spectral.phi, spectral.theta, spectral.wavelengths), (vec![0.0], vec![0.0, 1.5], vec![400.0, 500.0, 700.0]));
    assert_eq!((spectral.spectra.size, spectral.spectra.values.len(), spectral.jacobian), ([2, 2], 24, true));
    assert_eq!(spectral.vndf.values, [0.0, 1.0, 0.0, 1.0, 0.0, 2.0, 0.0, 1.0]);
    let colours = measured::read(&file(&material(&[]))).expect("a material");
    assert_eq!((colours.wavelengths.len(), colours.spectra.values.len()), (0, 24));
}

#[test]
fn broken_files_are_told() {
    let good = file(&material(&[400.0, 700.0]));
    assert_eq!(said(b"ply\n"), "the file does not begin with `tensor_file`: it is no file of a measured material");
    assert_eq!(said(b"tensor_file\0\x02\x00"), "byte 12: version 2.0 is not known, expected 1.0");
    assert_eq!(said(&good[..20]), "byte 20: the file ends within the name of a field");
    assert_eq!(said(&good[..40]), "byte 40: the file ends within the head of `description`");
    assert!(said(&good[..good.len() - 1]).starts_with("byte "), "{}", said(&good[..good.len() - 1]));
    // Nothing that a head promises is believed.
    let mut large = floats("ndf", &[2, 2], &[0.3; 4]);
    large.2 = vec![u64::MAX, u64::MAX];
    assert!(said(&with(large)).contains("`ndf` has 340282366920938463463374607431768211455 bytes from byte "));

    let without: Vec<Field> = material(&[400.0, 700.0]).into_iter().filter(|f| f.0 != "vndf").collect();
    let names = "description, jacobian, luminance, ndf, phi_i, sigma, spectra, theta_i, wavelengths";
    assert_eq!(said(&file(&without)), format!("there is no field `vndf`; the file has: {names}"));
    let mut double = floats("theta_i", &[2], &[0.0, 1.5]);
    (double.1, double.2) = (11, vec![1]);
    assert!(said(&with(double)).ends_with("`theta_i` holds numbers of type float64, expected float32"));
    let mut unknown = floats("theta_i", &[2], &[0.0, 1.5]);
    unknown.1 = 12;
    assert!(said(&with(unknown)).ends_with("the type of `theta_i` has the number 12, expected 1 to 11"));

    assert_eq!(said(&with(floats("theta_i", &[2], &[0.5, 0.5]))), "`theta_i` must rise: 0.5 follows 0.5");
    assert_eq!(said(&with(floats("theta_i", &[0], &[]))), "`theta_i` is empty");
    assert_eq!(said(&with(floats("theta_i", &[3], &[0.0, 1.0, 1.5]))), "`spectra` is for 2 elevations, and the file names 3");
    assert_eq!(said(&with(floats("wavelengths", &[1], &[500.0]))), "`spectra` is for 2 channels, and the file names 1");
    assert_eq!(said(&with(floats("ndf", &[1, 4], &[0.3; 4]))), "`ndf` has 4 x 1 nodes, expected at least 2 x 2");
    assert!(said(&with(floats("ndf", &[4], &[0.3; 4]))).ends_with("`ndf` has 1 dimensions, expected 2"));
    assert!(
        said(&with(floats("ndf", &[2, 2], &[0.3, f32::NAN, 0.3, 0.3]))).ends_with("`ndf` holds a number that is not finite: NaN")
    );
    assert!(said(&with(bytes("phi_i", &[0]))).ends_with("`phi_i` holds numbers of type uint8, expected float32"));
}

//! Writes gold as a photometer would have seen it, to try `measured` without any data from elsewhere:
//! `cargo run --release -p etendue-scene --example tabulated_metal -- OUT.bsdf [ALPHA [--rgb]]`
#![allow(clippy::print_stderr)]

#[path = "../../bsdf/tests/battery/tabulated.rs"]
mod tabulated;
#[path = "../../formats/tests/common/tensor.rs"]
mod tensor;

use tabulated::Resolution;

fn main() -> std::io::Result<()> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let Some(out) = args.first() else {
        eprintln!("tabulated_metal OUT.bsdf [ALPHA [--rgb]]");
        return Ok(());
    };
    let alpha = args.get(1).and_then(|a| a.parse().ok()).unwrap_or(0.3);
    let r = Resolution { normals: 128, square: 32, theta: 32, phi: 1, part: 1.0 };
    let p = tabulated::params([alpha, alpha], &r, [0.0, 1.0, 2.0]);
    let (t, n, m) = (p.theta.len(), r.normals, r.square);
    let rgb = args.iter().any(|a| a == "--rgb");
    // Gold by wavelength: blue, green and red where these are seen most.
    let order = if rgb { [0, 1, 2] } else { [2, 1, 0] };
    let tables: Vec<f32> = p
        .spectra
        .values
        .chunks_exact(3 * m * m)
        .flat_map(|c| order.map(|k| c[k * m * m..(k + 1) * m * m].to_vec()))
        .flatten()
        .collect();
    let mut fields = vec![
        tensor::bytes("description", b"gold, GGX, computed"),
        tensor::floats("phi_i", &[1], &p.phi),
        tensor::floats("theta_i", &[t], &p.theta),
        tensor::floats("ndf", &[n, n], &p.ndf.values),
        tensor::floats("sigma", &[n, n], &p.sigma.values),
        tensor::floats("vndf", &[1, t, n, n], &p.vndf.values),
        tensor::floats("luminance", &[1, t, m, m], &p.luminance.values),
        tensor::floats(if rgb { "rgb" } else { "spectra" }, &[1, t, 3, m, m], &tables),
        tensor::bytes("jacobian", &[1]),
    ];
    if !rgb {
        fields.push(tensor::floats("wavelengths", &[3], &[450.0, 550.0, 630.0]));
    }
    std::fs::write(out, tensor::file(&fields))
}

//! Makes the table of smooth spectra: `cargo run --release -p etendue-numerics --example smooth_table`, from the project's root.

use std::io;

fn main() -> io::Result<()> {
    std::fs::write("crates/numerics/src/spectrum/data/smooth.bin", etendue_numerics::spectrum::upsample::table())
}

//! Voxel grids: no bytes make the reader panic.
#![no_main]

use etendue_formats::mesh::vol;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let _ = vol::read(bytes);
});

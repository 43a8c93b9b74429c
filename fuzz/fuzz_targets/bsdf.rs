//! Measured materials: no bytes make the reader panic.
#![no_main]

use etendue_formats::measured;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let _ = measured::read(bytes);
});

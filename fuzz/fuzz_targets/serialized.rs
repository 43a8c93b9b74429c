//! Serialized meshes: no bytes make the reader panic.
#![no_main]

use etendue_formats::mesh::serialized;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    for index in 0..3 {
        let _ = serialized::read(bytes, index);
    }
});

//! OBJ meshes: no bytes make the reader panic.
#![no_main]

use etendue_formats::mesh::obj;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let _ = obj::read(bytes, true);
});

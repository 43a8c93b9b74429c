//! pbrt scenes: no text makes the reader or the messages panic.
#![no_main]

use etendue_formats::{ReadOptions, read_str};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|text: &str| {
    let (description, diagnostics) = read_str("no-folder/fuzz.pbrt", text, &ReadOptions::default());
    let _ = diagnostics.render(&description.sources);
});

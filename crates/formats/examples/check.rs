//! Reads scene files and prints what should be said about them: `cargo run -p etendue-formats --example check -- SCENE.xml ...`
#![allow(clippy::print_stdout)]

use etendue_formats::{ReadOptions, read};
use std::path::Path;
use std::time::Instant;

fn main() {
    for name in std::env::args().skip(1) {
        let start = Instant::now();
        let (description, diagnostics) = read(Path::new(&name), &ReadOptions::default());
        let triangles: usize = description.assets.meshes.iter().map(|m| m.indices.len()).sum();
        let (nodes, meshes) = (description.nodes.len(), description.assets.meshes.len());
        let state = if diagnostics.has_errors() { "errors" } else { "ok" };
        println!(
            "{name}: {state}, {nodes} objects, {meshes} meshes, {triangles} triangles, {:.3} s",
            start.elapsed().as_secs_f64()
        );
        print!("{}", diagnostics.render(&description.sources));
    }
}

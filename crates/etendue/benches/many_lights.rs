//! What ten thousand lamps cost beside ten: `cargo bench -p etendue --bench many_lights [-- SAMPLES ROUNDS]`.
//!
//! The hall of `many-lights` is rendered with its own lamps, and with ten triangles of the same total power that hang in two rows in their place. Both
//! are rendered on one thread in turns, each round with a seed of its own. Noise is measured between the rounds, so no reference is needed:
//!
//! ```text
//! noise = mean over pixels and channels of  s² / (m² + 0.01 M²)        m, s² mean and variance over rounds, M mean of m
//! cost  = seconds × noise,    ratio = cost of ten thousand / cost of ten        seconds: the median
//! ```

#![allow(clippy::print_stdout, reason = "what it measured is all that it has to say")]

mod seeds;

use etendue::{LoadOptions, Loaded, RenderOptions, Stop, builtin, load};
use seeds::{Runs, noise};
use std::fmt::Write as _;

const SIZE: [u32; 2] = [150, 112];
/// Area of a lamp that stands for a thousand, m²: 1000 times the mean area of the small ones.
const AREA: f32 = 0.1387;

fn main() {
    let mut numbers = std::env::args().skip(1).filter_map(|a| a.parse::<u32>().ok());
    let (samples, rounds) = (numbers.next().unwrap_or(32), numbers.next().unwrap_or(6).max(2));
    let folder = tempfile::tempdir().expect("a temporary folder");
    let halls = [open("many-lights"), open(&ten_lamps(folder.path()))];
    let mut runs = [Runs::default(), Runs::default()];
    for seed in 0..rounds {
        for (hall, runs) in halls.iter().zip(&mut runs) {
            let stop = Some(Stop::Samples(samples));
            runs.add(hall, &RenderOptions { stop, seed: Some(seed.into()), threads: Some(1), ..RenderOptions::default() });
        }
    }
    let costs = ["ten thousand", "ten"].iter().zip(&runs).map(|(name, runs)| {
        let means = runs.means();
        let (seconds, noise) = (runs.seconds(), noise(runs, &means));
        println!("{name:>12} lamps: {seconds:.3} s, noise {noise:.5}, mean {:.4}", means.iter().sum::<f64>() / means.len() as f64);
        [seconds, noise]
    });
    if let [many, ten] = costs.collect::<Vec<_>>()[..] {
        let [time, noise] = [many[0] / ten[0], many[1] / ten[1]];
        println!("ratio: {:.3} = time {time:.3} x noise {noise:.3}", time * noise);
    }
}

fn open(scene: &str) -> Loaded {
    let size = LoadOptions { width: Some(SIZE[0]), height: Some(SIZE[1]), ..LoadOptions::default() };
    load(scene, &size).unwrap_or_else(|e| panic!("{scene}: {e}"))
}

/// Writes the hall with two lamps in place of each mesh of two thousand; returns where.
fn ten_lamps(folder: &std::path::Path) -> String {
    let mut text = builtin::find("many-lights").expect("built in").text.to_owned();
    std::fs::create_dir(folder.join("meshes")).expect("a folder");
    let r = (0.5 * AREA).sqrt();
    for colour in 0..5 {
        let mut ply = "ply\nformat ascii 1.0\nelement vertex 6\nproperty float x\nproperty float y\nproperty float z\n".to_owned();
        ply += "element face 2\nproperty list uchar uint vertex_indices\nend_header\n";
        for [x, z] in [[2 * colour - 4, -2], [4 - 2 * colour, 3]].map(|p| p.map(|i: i32| i as f32)) {
            let (y, far, near) = (2.75, z - r, z + r);
            writeln!(ply, "{} {y} {far}\n{} {y} {far}\n{x} {y} {near}", x - r, x + r).expect("a string");
        }
        std::fs::write(folder.join(format!("meshes/lamps-{colour}.ply")), ply + "3 0 1 2\n3 3 4 5\n").expect("a mesh");
    }
    text = text.replace("ten thousand small lamps", "ten lamps");
    let path = folder.join("ten-lights.xml");
    std::fs::write(&path, text).expect("a scene");
    path.to_string_lossy().into_owned()
}

//! How well rows close in rooms with something in the way: `cargo bench -p etendue-radiosity --bench rooms`.
//!
//! Rooms of 4 x 5 x 3 m, in patches near 0.9 m; by each method the CPU seconds of all threads and the largest |1 - Σ_j F_ij|, before any repair and after.
//!
//! | argument after `--` | |
//! | --- | --- |
//! | ROOM | that one alone |
//! | `obj` ROOM | its patches as an OBJ, a face each, fronts counter-clockwise: for other programs |
//!
//! pyviewfactor reads that file by `benches/rooms_pyviewfactor.py`.

#![allow(clippy::print_stdout, reason = "what it measured is all that it has to say")]

mod common;

use common::{compile, usage};
use etendue_radiosity::form_factor::{Hemisphere, Method, Open, Pairs};
use etendue_radiosity::{Cutting, PatchSize, Patches, Sides};

/// Rooms by name: cubes of edge 2 in them, by their transforms.
const ROOMS: [(&str, &[&str]); 4] = [
    ("hovering", &[r#"<scale x="0.7" y="0.7" z="0.6"/><translate x="2" y="2.4" z="1.2"/>"#]),
    ("standing", &[r#"<scale x="0.7" y="0.7" z="0.6"/><rotate z="1" angle="20"/><translate x="2" y="2.4" z="0.6"/>"#]),
    ("table", &[r#"<scale x="1" y="0.6" z="0.03"/><rotate z="1" angle="20"/><translate x="2" y="2.4" z="0.8"/>"#]),
    (
        "two",
        &[
            r#"<scale x="0.4" y="0.4" z="0.7"/><rotate x="1" angle="35"/><translate x="1.2" y="1.5" z="1.5"/>"#,
            r#"<scale x="0.5" y="0.4" z="0.4"/><rotate z="1" angle="30"/><translate x="2.8" y="3.4" z="0.4"/>"#,
        ],
    ),
];

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).filter(|a| !a.starts_with("--")).collect();
    let room = |name: &str| ROOMS.iter().find(|r| r.0 == name).expect("a room: hovering, standing, table, two");
    match &arguments[..] {
        [] => ROOMS.iter().for_each(|r| table(r.0, r.1)),
        [word, name] if word == "obj" => obj(room(name).1),
        [name, ..] => table(room(name).0, room(name).1),
    }
}

fn text(boxes: &[&str]) -> String {
    let cube =
        |place: &str, more: &str| format!(r#"<shape type="cube">{more}<transform name="to_world">{place}</transform></shape>"#);
    let walls = cube(
        r#"<scale x="2" y="2.5" z="1.5"/><translate x="2" y="2.5" z="1.5"/>"#,
        r#"<boolean name="flip_normals" value="true"/>"#,
    );
    format!(r#"<scene version="3.0.0">{walls}{}</scene>"#, boxes.iter().map(|place| cube(place, "")).collect::<String>())
}

fn cutting() -> Cutting {
    Cutting { size: PatchSize::Metres(0.9), sides: Sides::Front, ..Cutting::default() }
}

fn table(name: &str, boxes: &[&str]) {
    let scene = compile(&text(boxes));
    let patches = Patches::cut(&scene, &cutting()).expect("few patches");
    let areas: Vec<f64> = patches.patches.iter().map(|p| p.area).collect();
    let hemisphere = Hemisphere { rays: 1 << 16, ..Hemisphere::default() };
    for method in [Method::Hemisphere(hemisphere), Method::Analytic(Pairs::default()), Method::Area] {
        let [before, _] = usage();
        let mut f = method.run(&scene, &patches, &|_, _| true).expect("not cancelled");
        let [after, _] = usage();
        let sums: Vec<f64> = (0..f.len()).map(|i| f.row_sum(i)).collect();
        let (low, high) = sums.iter().fold((f64::INFINITY, 0.0f64), |(low, high), s| (low.min(*s), high.max(*s)));
        let told = f.repair(&areas, Open::Reciprocal);
        println!(
            "{name}: {} patches, `{}`, {:.1} CPU s, rows {low:.6} to {high:.6}, pairs {:.1e} off; after repair rows {:.0e}",
            patches.len(),
            method.name(),
            after - before,
            told.reciprocity_before,
            told.closure_after
        );
    }
}

fn obj(boxes: &[&str]) {
    let scene = compile(&text(boxes));
    let patches = Patches::cut(&scene, &cutting()).expect("few patches");
    let mut n = 0;
    for i in 0..patches.len() as u32 {
        let corners = patches.polygon(i).expect("flat patches");
        corners.iter().for_each(|p| println!("v {} {} {}", p.x, p.y, p.z));
        let face: Vec<String> = (1..=corners.len()).map(|k| (n + k).to_string()).collect();
        println!("f {}", face.join(" "));
        n += corners.len();
    }
}

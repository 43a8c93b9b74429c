//! The same bits: at any number of threads, from files and from within the program, killed and resumed.

use crate::Bench;
use std::time::{Duration, Instant};

const BOX: [&str; 5] = ["render", "cornell-box", "--width", "24", "-o"];

fn render(bench: &Bench, file: &str, more: &[&str]) -> Vec<u32> {
    bench.good(&[&BOX, &[file] as &[&str], more].concat());
    bench.bits(file)
}

#[test]
fn any_number_of_threads() {
    let bench = Bench::new();
    let one = render(&bench, "1.exr", &["--spp", "5", "--threads", "1"]);
    for threads in ["2", "5"] {
        let name = format!("{threads}.exr");
        assert_eq!(render(&bench, &name, &["--spp", "5", "--threads", threads]), one, "{threads} threads");
        // Down to the file: nothing in it depends on the machine or the clock.
        assert_eq!(bench.read(&name), bench.read("1.exr"));
    }
    assert_ne!(render(&bench, "seed.exr", &["--spp", "5", "--seed", "1"]), one);
}

#[test]
fn exported_scenes_are_the_built_in_ones() {
    let bench = Bench::new();
    let names = bench.good(&["scenes", "--export", "files"]).out;
    for name in names.lines().filter_map(|l| l.split_whitespace().next()) {
        let size = ["--width", "12", "--height", "12", "--spp", "2"];
        bench.good(&[&["render", name, "-o", "in.exr"], &size as &[&str]].concat());
        bench.good(&[&["render", &format!("files/{name}.xml"), "-o", "out.exr"], &size as &[&str]].concat());
        assert_eq!(bench.bits("in.exr"), bench.bits("out.exr"), "{name}");
    }
}

/// Killed without warning in the middle, a render goes on from its checkpoint to the bits of an undisturbed one.
#[test]
fn killed_and_resumed() {
    let bench = Bench::new();
    // More samples than are taken before the kill on any machine; each pass makes a checkpoint.
    let spp = ["--spp", "3000"];
    let checkpoints = ["--checkpoint", "c.ckpt", "--checkpoint-every", "0.001"];
    let mut child = bench.start(&[&BOX, &["killed.exr"] as &[&str], &spp, &checkpoints].concat());
    let patience = Instant::now();
    while !bench.has("c.ckpt") && patience.elapsed() < Duration::from_secs(60) {
        std::thread::sleep(Duration::from_millis(5));
    }
    child.kill().expect("it can be killed");
    child.wait().expect("it ends");
    assert!(bench.has("c.ckpt") && !bench.has("killed.exr"));

    let undisturbed = render(&bench, "whole.exr", &spp);
    let resumed =
        render(&bench, "resumed.exr", &[&spp as &[&str], &["--resume", "c.ckpt", "--threads", "3", "--stats", "s.json"]].concat());
    assert!(undisturbed == resumed, "the resumed picture differs");
    assert_eq!(bench.read("whole.exr"), bench.read("resumed.exr"));
    // It did resume: fewer paths than the whole picture has.
    assert!(bench.json("s.json")["paths"].as_u64().is_some_and(|n| n < 24 * 24 * 3000));

    // Anything else than the same render is refused.
    let resume = ["--resume", "c.ckpt"];
    let refused = |more: &[&str], words: &[&str]| {
        let said = bench.bad(1, &[&BOX, &["other.exr"] as &[&str], &resume, more].concat());
        said.says(&["cannot resume"]).says(words);
        assert!(!bench.has("other.exr"));
    };
    refused(&["--spp", "3000", "--seed", "1"], &["seed"]);
    refused(&["--spp", "10"], &["3000"]);
    refused(&["--spp", "3000", "--solver", "path"], &["path-mis"]);
    refused(&["--spp", "3000", "--max-depth", "3"], &["settings"]);
    refused(&["--spp", "3000", "--sampler", "independent"], &["settings"]);
    refused(&["--spp", "3000", "--spectral"], &["settings"]);
    let said = bench.bad(1, &["render", "furnace", "--width", "24", "--spp", "3000", "--resume", "c.ckpt", "-o", "other.exr"]);
    said.says(&["cannot resume", "scene"]);
    bench.write("broken.ckpt", &bench.read("c.ckpt")[..99]);
    bench.bad(1, &["render", "--resume", "broken.ckpt"]).says(&["broken.ckpt", "checkpoint"]);
    bench.write("broken.ckpt", "something else");
    bench.bad(1, &["render", "--resume", "broken.ckpt"]).says(&["checkpoint"]);
}

/// A mesh that has changed is another scene, though the text that names it has not.
#[test]
fn a_changed_mesh_is_not_resumed() {
    let bench = Bench::new();
    let scene = r#"<scene version="3.0.0"><emitter type="constant"/>
        <shape type="obj"><string name="filename" value="mesh.obj"/></shape></scene>"#;
    bench.write("scene.xml", scene);
    let render = ["render", "scene.xml", "--width", "16", "--spp", "2", "-o", "a.exr"];
    bench.write("mesh.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    bench.good(&[&render as &[&str], &["--checkpoint", "c.ckpt"]].concat());
    bench.good(&[&render as &[&str], &["--resume", "c.ckpt"]].concat());
    bench.write("mesh.obj", "v 0 0 0\nv 1 0 0\nv 0 2 0\nf 1 2 3\n");
    bench.bad(1, &[&render as &[&str], &["--resume", "c.ckpt"]].concat()).says(&["scene or its settings have changed"]);
}

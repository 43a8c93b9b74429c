//! The commands beside `render`, and wrong usage.

use crate::{Bench, scenes};

#[test]
fn scenes_are_listed_exported_and_described() {
    let bench = Bench::new();
    let said = bench.good(&["scenes", "--export", "files"]);
    let names: Vec<&str> = said.out.lines().filter_map(|l| l.split_whitespace().next()).collect();
    assert_eq!(names.len(), 8);
    for name in &names {
        let (built_in, file) = (bench.good(&["info", name]), bench.good(&["info", &format!("files/{name}.xml")]));
        assert!(built_in.err.is_empty(), "{name}: {}", built_in.err);
        for row in ["view", "solver", "shapes", "materials", "emitters", "bounds"] {
            let line = |out: &str| out.lines().find(|l| l.starts_with(row)).map(str::to_owned);
            assert!(line(&built_in.out).is_some(), "{name}: {}", built_in.out);
            assert_eq!(line(&built_in.out), line(&file.out), "{name}");
        }
        // What is embedded is what lies in the repository.
        let exported = bench.read(&format!("files/{name}.xml"));
        assert_eq!(exported, std::fs::read(scenes().join(format!("{name}.xml"))).expect("the scene is in the repository"));
    }
    bench.bad(1, &["scenes", "--export", "files"]).says(&["exists and is not overwritten"]);
}

#[test]
fn pictures_are_compared() {
    let bench = Bench::new();
    bench.good(&["render", "--width", "16", "--spp", "4", "-o", "a.exr"]);
    bench.good(&["render", "--width", "16", "--spp", "4", "--seed", "7", "-o", "b.exr"]);
    let same: serde_json::Value = serde_json::from_str(&bench.good(&["diff", "a.exr", "a.exr", "--json"]).out).expect("JSON");
    assert_eq!((same["mse"].as_f64(), same["flip"].as_f64()), (Some(0.0), Some(0.0)));
    let other: serde_json::Value = serde_json::from_str(&bench.good(&["diff", "a.exr", "b.exr", "--json"]).out).expect("JSON");
    for figure in ["mse", "rel_mse", "psnr", "flip"] {
        assert!(other[figure].as_f64().is_some_and(|x| x > 0.0), "{figure}: {other}");
    }
    assert!(bench.good(&["diff", "a.exr", "b.exr"]).out.contains("relMSE"));
    bench.good(&["render", "furnace", "--width", "8", "--spp", "1", "-o", "small.exr"]);
    bench.bad(1, &["diff", "a.exr", "small.exr"]).says(&["16", "8"]);
    bench.bad(1, &["diff", "a.exr", "none.exr"]).says(&["none.exr"]);
}

/// Strategies (s, t) of two to four vertices: nine, weighted and not; the weighted ones are the picture, and each of one length shows its light.
#[test]
fn strategies_are_a_pyramid() {
    let bench = Bench::new();
    let small = ["cornell-box", "--width", "12", "--height", "12", "--spp", "64"];
    bench.good(&[&["strategies"], &small[..], &["--vertices", "4", "-o", "all", "-q"]].concat());
    let all = bench.picture("all/strategies.exr");
    assert_eq!(all.layers.len(), 18);
    let layer = |s: u32, t: u32, word: &str| all.layer(&format!("s{s}t{t}-{word}")).expect("a layer").data();
    let names = || (2..5).flat_map(|n| (0..n).map(move |s| (s, n - s)));
    for (i, whole) in all.image.data().iter().enumerate() {
        let sum: f32 = names().map(|(s, t)| layer(s, t, "weighted")[i]).sum();
        assert!((sum - whole).abs() <= 1e-4 * whole.abs().max(1e-3), "{i}: {sum} and {whole}");
    }
    let mean = |data: &[f32]| data.iter().map(|x| f64::from(*x)).sum::<f64>() / data.len() as f64;
    // The same seeds, so that this is no matter of chance; the noise of the means is 1 to 3 %.
    bench.good(&[&["render"], &small[..], &["--bounces", "0..2", "--solver", "path-mis", "-o", "whole.exr"]].concat());
    let whole = mean(bench.picture("whole.exr").image.data());
    assert!((mean(all.image.data()) / whole - 1.0).abs() < 0.1);
    let direct = mean(layer(1, 2, "unweighted"));
    assert!(direct > 0.1 * whole && (mean(layer(2, 1, "unweighted")) / direct - 1.0).abs() < 0.15);
    for pyramid in ["all/weighted.png", "all/unweighted.png"] {
        let shown = bench.picture(pyramid).image;
        assert_eq!((shown.width(), shown.height()), (4 * 16 - 4, 3 * 16 - 4));
    }
    bench.bad(2, &["strategies", "cornell-box", "--vertices", "1"]);
}

#[test]
fn pictures_are_tone_mapped() {
    let bench = Bench::new();
    bench.good(&["render", "furnace", "--width", "16", "--spp", "4", "-o", "a.exr"]);
    let mut brightness = Vec::new();
    for exposure in ["-3", "0"] {
        bench.good(&["tonemap", "a.exr", "a.png", "--exposure", exposure, "--curve", "reinhard"]);
        brightness.push(bench.picture("a.png").image.data()[0]);
    }
    assert!(brightness[0] < brightness[1], "{brightness:?}");
    bench.bad(2, &["tonemap", "a.exr", "a.png", "--curve", "filmic"]).says(&["srgb, reinhard, aces, agx"]);
    bench.write("bad.exr", "no picture at all");
    bench.bad(1, &["tonemap", "bad.exr", "b.png"]).says(&["bad.exr"]);
    assert!(!bench.has("b.png"));
}

#[test]
fn speed_is_measured() {
    let bench = Bench::new();
    let said = bench.good(&["bench", "furnace", "--width", "16", "--rounds", "1", "--threads", "2", "--json"]);
    let told: serde_json::Value = serde_json::from_str(&said.out).expect("JSON");
    assert_eq!((told["threads"].as_u64(), told["rounds"].as_u64(), told["width"].as_u64()), (Some(2), Some(1), Some(16)));
    let rays = told["rays"].as_array().expect("kinds of rays");
    assert_eq!(
        rays.iter().filter_map(|kind| kind["kind"].as_str()).collect::<Vec<_>>(),
        ["camera", "bounce", "occlusion", "shadow"]
    );
    let rates = rays.iter().flat_map(|kind| [&kind["single"], &kind["batch"], &kind["threads"]]);
    for rate in rates.chain([&told["paths_single"], &told["paths_threads"]]) {
        assert!(rate["median"].as_f64().is_some_and(|x| x > 0.0), "{told}");
    }
    bench.bad(1, &["bench", "furnace", "--solver", "path-miss"]).says(&["path-mis"]);
    bench.bad(1, &["bench", "furnace", "--view", "3"]).says(&["no view 3"]);
    bench.bad(2, &["bench", "furnace", "--rounds", "0"]).says(&["--rounds"]);
}

#[test]
fn the_machine_is_told() {
    let said = Bench::new().good(&["doctor"]);
    for row in ["version", "rays", "threads", "memory", "check"] {
        assert!(said.out.lines().any(|l| l.starts_with(row)), "{}", said.out);
    }
    assert!(said.out.contains("good"), "{}", said.out);
}

#[test]
fn wrong_usage_ends_with_2_and_the_rest_with_1() {
    let bench = Bench::new();
    for arguments in [
        &["rendr"] as &[&str],
        &["render", "--nonsense"],
        &["render", "--spp", "0"],
        &["render", "--spp", "4", "--time", "1"],
        &["render", "--time", "-1"],
        &["render", "--noise", "nan"],
        &["render", "--width", "0"],
        &["render", "--threads", "0"],
        &["render", "--bounces", "3..1"],
        &["render", "--max-depth", "-2"],
        &["render", "-o", "picture.tif"],
        &["render", "--aov", "colour"],
        &["render", "--checkpoint-every", "1"],
        &["diff", "one.exr"],
    ] {
        bench.bad(2, arguments);
    }
    bench.bad(2, &["render", "--solver", "pathmis"]).says(&["`pathmis`", "did you mean `path-mis`?"]);
    bench.bad(1, &["compare", "furnace", "--solvers", "path,auto"]).says(&["`auto` stands for one of the others"]);
    for command in ["compare", "verify"] {
        bench.bad(1, &[command, "furnace", "--solvers", "path,depth"]).says(&["`depth` shows no light", "render --solver depth"]);
    }
    bench.bad(1, &["render", "--spectral", "--solver", "radiosity"]).says(&["red, green and blue"]);
    bench.bad(2, &["render", "--spectral", "--rgb"]);
    bench.bad(1, &["render", "--view", "1"]).says(&["1 sensor"]);
    bench.bad(1, &["render", "--width", "2147483300"]).says(&["2147483300", "GiB"]);
    bench.bad(1, &["render", "-o", "nowhere/a.exr"]).says(&["nowhere", "does not exist"]);
    bench.bad(1, &["render", "--stats", "nowhere/a.json"]).says(&["nowhere", "does not exist"]);
    bench.bad(1, &["render", "--checkpoint", "nowhere/a.ckpt"]).says(&["nowhere", "does not exist"]);
    bench.bad(1, &["render", "--resume", "nothing.ckpt"]).says(&["nothing.ckpt"]);
    assert_eq!(bench.files(), Vec::<String>::new());
    for command in ["render", "scenes", "info", "diff", "tonemap", "doctor"] {
        assert!(bench.good(&[command, "--help"]).out.contains("Example"), "{command}");
    }
}

/// Whoever reads the first line only does no harm.
#[cfg(unix)]
#[test]
fn a_closed_pipe_is_no_error() {
    let bench = Bench::new();
    let mut child = bench.start(&["info", "cornell-box"]);
    drop(child.stdout.take());
    let output = child.wait_with_output().expect("the program ends");
    assert_eq!((output.status.code(), String::from_utf8_lossy(&output.stderr).as_ref()), (Some(0), ""));
}

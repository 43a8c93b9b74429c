//! The ways in which a render ends, and what is shown on the way.

use crate::Bench;

#[test]
fn a_clock_stops_it_after_a_whole_pass() {
    let bench = Bench::new();
    bench.good(&["render", "furnace", "--width", "16", "--time", "0.01", "-o", "a.exr", "--stats", "s.json"]);
    let stats = bench.json("s.json");
    assert!(stats["spp"].as_u64().is_some_and(|n| n >= 1) && stats["stopped"] == "time", "{stats}");
    assert!(bench.picture("a.exr").image.data().iter().all(|x| *x > 0.0), "every pixel was sampled");
}

#[test]
fn a_noise_target_is_reached_and_told() {
    let bench = Bench::new();
    let said = bench.good(&["render", "--width", "16", "--noise", "40", "-o", "a.exr", "--stats", "s.json"]);
    said.says(&["noise target 40 % reached", "95 % interval"]);
    let stats = bench.json("s.json");
    let spp = stats["spp"].as_u64().expect("a number");
    assert!(spp.is_multiple_of(16) && (spp / 16).is_power_of_two() && stats["stopped"] == "noise", "{stats}");
    let [value, low, high] = [0, 1, 2].map(|i| stats["noise_percent"][i].as_f64().expect("a number"));
    assert!(low <= value && value <= high && value <= 40.0, "{stats}");
}

/// More samples where there is noise, counted in a layer; asked of a solver that cannot, it is refused.
#[test]
fn samples_go_where_the_noise_is() {
    let bench = Bench::new();
    let render = ["render", "veach-mis", "--width", "24", "--noise", "8", "--aov", "samples", "-o", "a.exr", "--stats", "s.json"];
    bench.good(&render).says(&["samples a pixel", "more where there was noise"]);
    let (stats, picture) = (bench.json("s.json"), bench.picture("a.exr"));
    let counts = picture.layers.iter().find(|l| l.name == "samples").expect("the layer").image.data();
    let (least, most) = counts.iter().fold((f32::MAX, 0.0f32), |(l, m), n| (l.min(*n), m.max(*n)));
    assert_eq!((stats["samples"][0].as_f64(), stats["samples"][1].as_f64()), (Some(least.into()), Some(most.into())), "{stats}");
    assert!(most > 2.0 * least, "{least} to {most}");

    for even in [["--spread", "uniform"], ["--param", "block=4"]] {
        bench.good(&[&render[..], &even].concat());
        assert!(bench.json("s.json")["samples"].is_null(), "{even:?}");
    }
    let refused = bench
        .bad(1, &["render", "--width", "16", "--solver", "bidirectional", "--noise", "50", "--spread", "adaptive", "-o", "b.exr"]);
    refused.says(&["spreads its samples uniformly", "path-mis"]);
    let shared = ["--solver", "path-mis", "--param", "block=4", "--noise", "50", "--spread", "adaptive", "-o", "b.exr"];
    bench
        .bad(1, &[&["render", "--width", "16"], &shared[..]].concat())
        .says(&["`block` and an adaptive spread exclude each other", "block=1"]);
}

#[test]
fn events_are_json_lines() {
    let bench = Bench::new();
    let said = bench.good(&["render", "--width", "16", "--noise", "60", "-o", "a.exr", "--progress", "json", "--quiet"]);
    let events: Vec<serde_json::Value> = said.out.lines().map(|l| serde_json::from_str(l).expect("each line is JSON")).collect();
    assert!(said.err.is_empty() && events.len() >= 3, "{}", said.out);
    for event in &events {
        if let Some(fraction) = event["fraction"].as_f64() {
            assert!((0.0..1.0).contains(&fraction), "{event}");
        }
    }
    assert!(events.iter().any(|e| e["event"] == "noise" && e["passes"] == 16));
    let last = &events[events.len() - 1];
    assert_eq!((&last["event"], &last["files"][0]), (&"done".into(), &"a.exr".into()));
    assert_eq!(last["stats"]["stopped"], "noise");
}

/// Ctrl-C keeps what is done.
#[cfg(unix)]
#[test]
fn ctrl_c_keeps_the_picture() {
    use std::io::{BufRead, BufReader};
    let bench = Bench::new();
    let arguments =
        ["render", "cornell-box", "--width", "24", "--spp", "1000000000", "--progress", "json", "-o", "a.exr", "--stats", "s.json"];
    let mut child = bench.start(&arguments);
    // The second line of progress: passes are being made.
    let out = BufReader::new(child.stdout.take().expect("its standard output"));
    let mut lines = out.lines();
    assert!(lines.by_ref().take(2).all(|line| line.is_ok()));
    let status = std::process::Command::new("kill").args(["-INT", &child.id().to_string()]).status().expect("`kill` is there");
    assert!(status.success());
    let rest = lines.count();
    let output = child.wait_with_output().expect("it ends");
    let err = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(130), "{err}");
    assert!(rest > 0 && err.contains("stopping") && err.contains("stopped before the end") && err.contains("wrote a.exr"), "{err}");
    assert_eq!(bench.json("s.json")["stopped"], "cancelled");
    assert!(bench.picture("a.exr").image.data().iter().all(|x| x.is_finite()));
}

//! `radiosity` and `measure` from outside.

use super::Bench;

#[test]
fn a_solution_is_written_and_told() {
    let bench = Bench::new();
    let said = bench.good(&[
        "radiosity",
        "furnace",
        "--patches",
        "200",
        "--samples",
        "64",
        "--width",
        "8",
        "--spp",
        "1",
        "-o",
        "f.csv",
        "-o",
        "f.png",
        "--stats",
        "f.json",
        "--bounce-images",
        "--bounces",
        "2",
    ]);
    said.says(&["patches", "residual", "emitted", "wrote f.csv"]);
    for name in ["f.csv", "f.png", "f-bounce-0.png", "f-bounce-2.png", "f-up-to-2.png", "f-bounces.png"] {
        assert!(bench.has(name), "{name}");
    }
    let report: serde_json::Value = serde_json::from_slice(&bench.read("f.json")).expect("JSON");
    let of = |key: &str| report[key][0].as_f64().expect("a number");
    assert!((of("emitted") - of("absorbed") - of("escaped") - of("residual")).abs() < 1e-9 * of("emitted"));
    assert!(report["converged"] == true && report["closure_after"].as_f64().is_some_and(|x| x < 1e-12));
    // The same bits at any number of threads.
    let again = ["radiosity", "furnace", "--patches", "200", "--samples", "64", "--threads", "3", "-o", "g.csv", "-q"];
    bench.good(&again);
    assert_eq!(bench.read("f.csv"), bench.read("g.csv"));
}

#[test]
fn what_cannot_be_done_is_told() {
    let bench = Bench::new();
    bench.bad(2, &["radiosity", "-o", "x.tif"]).says(&[".glb"]);
    bench.bad(2, &["radiosity", "--patches", "10", "--patch-size", "1"]);
    bench.bad(1, &["radiosity", "--solve", "direct", "--patches", "20000"]).says(&["8192", "gauss-seidel"]);
    bench
        .bad(1, &["radiosity", "--method", "area", "--patches", "40000", "--samples", "16"])
        .says(&["million", "`hemisphere` and `hierarchical` fit, or 10000 patches fit"]);
    bench.bad(1, &["render", "--solver", "radiosity", "--param", "solve=direct", "--param", "patches=20000"]).says(&["8192"]);
    bench.bad(1, &["measure", "furnace"]).says(&["--grid"]);
    bench.bad(1, &["measure", "furnace", "--grid", "0,0,0", "1,0,0", "2,0,0"]).says(&["no plane"]);
    bench.bad(2, &["measure", "furnace", "--at", "0,0"]);
}

/// Rows of an open scene by what was asked, told in words and numbers.
#[test]
fn open_scenes_are_closed_as_asked() {
    let bench = Bench::new();
    let with = |scene: &str, open: &str| {
        let few = ["--patches", "200", "--even", "--samples", "64", "-o", "c.csv", "--stats", "s.json"];
        let said = bench.good(&[&["radiosity", scene, "--open", open][..], &few].concat());
        let report = bench.json("s.json");
        let red = |key: &str| report[key][0].as_f64().expect("a number");
        assert!(red("residual").abs() < 1e-3 * red("emitted"), "{report}");
        (said, report["rows"].as_str().map(str::to_owned), red("escaped") / red("emitted"))
    };
    let (said, rows, losses) = with("cornell-box", "losses");
    said.says(&["with what rays found lost"]);
    assert_eq!(rows.as_deref(), Some("losses"));
    let (said, rows, reciprocal) = with("cornell-box", "reciprocal");
    said.says(&["the scene is open, and what rows lack is lost"]);
    assert_eq!(rows.as_deref(), Some("reciprocal"));
    assert!((reciprocal - losses).abs() > 1e-3 && (0.2..0.4).contains(&reciprocal), "{reciprocal} and {losses}");
    assert_eq!(with("furnace", "reciprocal").1.as_deref(), Some("closed"));
    bench.bad(1, &["radiosity", "--open", "reciprocal", "--method", "hierarchical"]).says(&["needs a matrix"]);
    bench.bad(2, &["radiosity", "--open", "shut"]).says(&["losses", "reciprocal"]);
}

/// Ctrl-C between sweeps: the last whole one is written, and the report says that it was stopped.
#[cfg(unix)]
#[test]
fn ctrl_c_keeps_the_last_sweep() {
    use std::io::{BufRead, BufReader, Read};
    let bench = Bench::new();
    let arguments = [
        "radiosity",
        "cornell-box",
        "--patches",
        "3000",
        "--even",
        "--residual",
        "1e-300",
        "-o",
        "box.csv",
        "-o",
        "box.png",
        "--width",
        "16",
        "--stats",
        "s.json",
    ];
    let mut child = bench.start(&arguments);
    let mut told = BufReader::new(child.stderr.take().expect("its standard error"));
    let mut line = String::new();
    while !line.starts_with("sweep ") {
        line.clear();
        assert!(told.read_line(&mut line).expect("text") > 0, "it ended before a sweep was told");
    }
    let status = std::process::Command::new("kill").args(["-INT", &child.id().to_string()]).status().expect("`kill` is there");
    assert!(status.success());
    let mut rest = String::new();
    told.read_to_string(&mut rest).expect("text");
    assert_eq!(child.wait().expect("it ends").code(), Some(130), "{rest}");
    for words in ["stopping after this sweep", "stopped before the residual asked for", "wrote box.csv", "wrote box.png"] {
        assert!(rest.contains(words), "{rest}");
    }
    let report = bench.json("s.json");
    let residuals: Vec<f64> = report["residuals"].as_array().expect("a list").iter().filter_map(|r| r.as_f64()).collect();
    // Whole sweeps: each leaves less than the one before, and the books are closed but for what is left.
    assert!(report["converged"] == false && residuals.len() > 1 && residuals.len() < 1000, "{}", residuals.len());
    assert!(residuals.windows(2).all(|r| r[1] < r[0]), "{residuals:?}");
    let red = |key: &str| report[key][0].as_f64().expect("a number");
    let left = red("emitted") + red("arrived") - red("absorbed") - red("escaped") - red("residual");
    assert!(left.abs() < 1e-9 * red("emitted"), "{left}");
    let csv = String::from_utf8(bench.read("box.csv")).expect("text");
    assert_eq!(csv.lines().count() as u64, 1 + report["patches"].as_u64().expect("a number"));
}

/// What is wrong with a mesh is told with shape, place and facet, and is in the report.
#[test]
fn faults_of_meshes_are_told() {
    let bench = Bench::new();
    bench.write("lid.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 1 2\nf 1 2 4\nf 2 4 3\n");
    bench.write(
        "bad.xml",
        r#"<scene version="3.0.0"><sensor type="perspective"><film type="hdrfilm"><integer name="width" value="8"/><integer name="height" value="8"/></film></sensor>
<shape type="obj" id="lid"><string name="filename" value="lid.obj"/><boolean name="face_normals" value="true"/>
    <emitter type="area"><rgb name="radiance" value="1"/></emitter></shape></scene>"#,
    );
    let said = bench.good(&["radiosity", "bad.xml", "--patches", "30", "--samples", "64", "-o", "b.csv", "--stats", "s.json"]);
    said.says(&["1 of 4 triangles have no area and are left out: 1 (from 0", "`lid` facet 0", "bad.xml:2:1", "open along 3 edges"]);
    said.says(&["wound against each other", "each keeps its own front"]);
    let defects = bench.json("s.json")["defects"].clone();
    let kinds: Vec<&str> = defects.as_array().expect("a list").iter().filter_map(|d| d["kind"].as_str()).collect();
    assert_eq!(kinds, ["wound-against-each-other", "open"], "{defects}");
    assert_eq!((&defects[0]["shapes"], &defects[0]["facets"]), (&serde_json::json!(["lid", "lid"]), &serde_json::json!([0, 2])));
}

/// The built-in box: its blocks have no bottoms and stand on the floor, where they are not open; what is said is a line.
#[test]
fn a_box_on_a_floor_is_not_open() {
    let bench = Bench::new();
    let said = bench.good(&["radiosity", "cornell-box", "--patches", "100", "--samples", "16", "-o", "c.csv", "--stats", "s.json"]);
    let warnings: Vec<&str> = said.err.lines().filter(|l| l.starts_with("warning")).collect();
    assert!(matches!(warnings[..], [one] if one.contains("open along") && !one.contains("block")), "{warnings:?}");
    assert_eq!(bench.json("s.json")["defects"].as_array().map(Vec::len), Some(1));
}

#[test]
fn meters_print_numbers() {
    let bench = Bench::new();
    let arguments = ["measure", "furnace", "--at", "0,0,0", "--normal", "0,-1,0", "--by", "path", "--rays", "256", "--json", "-q"];
    let json: serde_json::Value = serde_json::from_str(&bench.good(&arguments).out).expect("JSON");
    let lux = json["points"][0]["path"]["illuminance"].as_f64().expect("a number");
    assert!(json["luminous_efficacy_lm_per_W"] == 683.002 && lux > 0.0, "{json}");
}

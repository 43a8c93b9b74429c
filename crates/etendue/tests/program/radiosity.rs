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
    bench.bad(1, &["radiosity", "--method", "area", "--patches", "40000"]).says(&["million", "`hemisphere` fits"]);
    bench.bad(1, &["render", "--solver", "radiosity", "--param", "solve=direct", "--param", "patches=20000"]).says(&["8192"]);
    bench.bad(1, &["measure", "furnace"]).says(&["--grid"]);
    bench.bad(1, &["measure", "furnace", "--grid", "0,0,0", "1,0,0", "2,0,0"]).says(&["no plane"]);
    bench.bad(2, &["measure", "furnace", "--at", "0,0"]);
}

#[test]
fn meters_print_numbers() {
    let bench = Bench::new();
    let arguments = ["measure", "furnace", "--at", "0,0,0", "--normal", "0,-1,0", "--by", "path", "--rays", "256", "--json", "-q"];
    let json: serde_json::Value = serde_json::from_str(&bench.good(&arguments).out).expect("JSON");
    let lux = json["points"][0]["path"]["illuminance"].as_f64().expect("a number");
    assert!(json["luminous_efficacy_lm_per_W"] == 683.002 && lux > 0.0, "{json}");
}

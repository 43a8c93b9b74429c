//! `verify` and `compare` from outside: verdicts with their exit status, and a page that stands alone.
//!
//! Pictures are tiny and sample counts fixed, so that nothing here depends on the clock.

use std::path::Path;
use std::process::{Command, Output};

const PROGRAM: &str = env!("CARGO_BIN_EXE_etendue");

fn etendue(folder: &Path, arguments: &[&str]) -> Output {
    run_program(Path::new(PROGRAM), folder, arguments)
}

fn run_program(program: &Path, folder: &Path, arguments: &[&str]) -> Output {
    Command::new(program).args(arguments).current_dir(folder).output().expect("the program starts")
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).expect("the program speaks UTF-8")
}

fn json(path: std::path::PathBuf) -> serde_json::Value {
    serde_json::from_slice(&std::fs::read(&path).expect("the file is there")).expect("it is JSON")
}

#[test]
fn right_solvers_pass_with_figures() {
    let folder = tempfile::tempdir().expect("a folder");
    let arguments = [
        "verify",
        "furnace",
        "--solvers",
        "path,path-mis,direct",
        "--spp",
        "16",
        "--size",
        "16",
        "--bound",
        "5",
        "--block-bound",
        "60",
        "--json",
        "verdict.json",
    ];
    let first = etendue(folder.path(), &arguments);
    let report = text(&first.stdout);
    assert_eq!(first.status.code(), Some(0), "{report}\n{}", text(&first.stderr));
    assert!(report.lines().last().is_some_and(|l| l.starts_with("PASS: ") && l.contains("would have been seen")), "{report}");
    let v = json(folder.path().join("verdict.json"));
    assert_eq!(v["verdict"], "PASS");
    // Emitters by all three, scattered light by path and path-mis, one bounce by direct and the better of them; five depths of each, four of direct.
    assert_eq!((v["pairs"].as_array().map(Vec::len), v["furnace"].as_array().map(Vec::len)), (Some(5), Some(14)));
    assert_eq!(v["tests"], 19 * 3 * 17);
    assert_eq!((&v["scene"], &v["pairs"][3]["bounces"]["least"]), (&"furnace".into(), &1.into()));
    assert!(v["pairs"][3]["visible_picture"].as_f64().is_some_and(|x| x > 0.0 && x < 0.05));
    // The same seed says the same, but for the times.
    let second = etendue(folder.path(), &arguments);
    let figures = |o: &Output| text(&o.stdout).lines().filter(|l| l.contains("PASS")).map(str::to_owned).collect::<Vec<_>>();
    assert_eq!(figures(&first), figures(&second));
}

/// Acceptance goes on from what it kept: once all targets are reached nothing more is rendered, and other seeds are refused.
#[test]
fn acceptance_is_kept() {
    let folder = tempfile::tempdir().expect("a folder");
    let accept = |seed: &str| {
        let scene = ["verify", "furnace", "--accept", "--solvers", "path,path-mis", "--size", "8", "--blocks", "2"];
        etendue(
            folder.path(),
            &[&scene[..], &["--time", "30", "--keep", "kept", "--seed", seed, "--json", "accepted.json"]].concat(),
        )
    };
    let solvers = || json(folder.path().join("accepted.json"))["solvers"].clone();
    let first = accept("0");
    let (report, told) = (text(&first.stdout), text(&first.stderr));
    assert_eq!(first.status.code(), Some(0), "{report}\n{told}");
    assert!(report.lines().last().is_some_and(|l| l == "PASS: each solver agrees with path-mis in every block"), "{report}");
    assert!(told.contains("path-mis: ") && told.contains("the reference is path-mis"), "{told}");
    let rendered = solvers();
    assert!(rendered[1]["visible"].as_f64().is_some_and(|x| x > 0.0 && x < 1.0));

    assert_eq!(accept("0").status.code(), Some(0));
    assert_eq!(solvers(), rendered, "to the bit, the times included");
    let other = accept("1");
    assert_eq!(other.status.code(), Some(1));
    assert!(text(&other.stderr).contains("scene, size, blocks, seed or version"), "{}", text(&other.stderr));

    // One solver alone is rendered for what is kept, and another build of the program goes on from nothing.
    let path = |program: &Path, folder_name: &str| {
        let alone = ["verify", "furnace", "--accept", "--solvers", "path", "--size", "8", "--blocks", "2", "--time", "30"];
        run_program(program, folder.path(), &[&alone[..], &["--keep", folder_name]].concat())
    };
    let this = Path::new(PROGRAM);
    let alone = path(this, "other");
    assert_eq!(alone.status.code(), Some(1), "nothing is accepted");
    assert!(text(&alone.stdout).contains("its target is reached") && text(&alone.stdout).contains("is kept"));
    let without = ["verify", "furnace", "--accept", "--solvers", "path", "--size", "8"];
    assert!(text(&etendue(folder.path(), &without).stderr).contains("fewer than two solvers"));
    if cfg!(target_os = "linux") {
        let built_anew = folder.path().join("etendue-anew");
        // By another process: a program that some thread of this one holds open for writing cannot be started.
        let copied = Command::new("sh").args(["-c", r#"cp "$0" "$1" && printf x >> "$1""#]).args([this, &built_anew]).status();
        assert!(copied.is_ok_and(|s| s.success()));
        let refused = path(&built_anew, "kept");
        assert_eq!(refused.status.code(), Some(1));
        assert!(text(&refused.stderr).contains("another build of the program"), "{}", text(&refused.stderr));
    }
    std::fs::write(folder.path().join("kept/furnace.path.json"), "{").expect("written");
    assert!(text(&accept("0").stderr).contains("damaged"));
}

#[test]
fn what_noise_hides_is_no_pass() {
    let folder = tempfile::tempdir().expect("a folder");
    let run = etendue(folder.path(), &["verify", "cornell-box", "--solvers", "path,path-nee", "--spp", "1", "--size", "16", "-q"]);
    let report = text(&run.stdout);
    assert_eq!(run.status.code(), Some(1), "{report}");
    assert!(report.lines().last().is_some_and(|l| l.starts_with("INCONCLUSIVE: ")), "{report}");
}

#[test]
fn nothing_to_compare_with_is_no_pass_and_unknown_names_are_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let alone = etendue(folder.path(), &["verify", "furnace", "--solvers", "path-mis", "--spp", "1", "--size", "8", "-q"]);
    assert_eq!(alone.status.code(), Some(1));
    assert!(text(&alone.stdout).contains("INCONCLUSIVE: nothing to compare with"));
    let unknown = etendue(folder.path(), &["verify", "--solvers", "path-miss"]);
    assert_eq!(unknown.status.code(), Some(1));
    assert!(text(&unknown.stderr).contains("did you mean `path-mis`?"));
    let wrong = etendue(folder.path(), &["compare", "cornell-box"]);
    assert_eq!(wrong.status.code(), Some(2), "solvers are required");
}

#[test]
fn compare_writes_one_page_with_all_in_it() {
    let folder = tempfile::tempdir().expect("a folder");
    let run = etendue(
        folder.path(),
        &["compare", "cornell-box", "--solvers", "path-nee,path-mis,direct", "--spp", "32", "--width", "16", "-o", "out", "-q"],
    );
    assert_eq!(run.status.code(), Some(0), "{}", text(&run.stderr));
    let out = folder.path().join("out");
    let page = text(&std::fs::read(out.join("index.html")).expect("the page"));
    // Nothing is fetched, no placeholder is left, and every map and picture is there.
    for foreign in ["http://", "https://", "src=\"/", "@import", "{{"] {
        let stray = page.replace("http://www.w3.org/2000/svg", "").contains(foreign);
        assert!(!stray, "`{foreign}` in the page");
    }
    assert_eq!(page.matches("data:image/png;base64,").count(), 3 + 1 + 3 + 3, "pictures, the reference, differences, errors");
    for part in ["<svg", "time, s", "relMSE", "id=\"flip\"", "id=\"ev\"", "class=\"blocks\"", "prefers-color-scheme"] {
        assert!(page.contains(part), "no {part}");
    }
    let balanced = |tag: &str| page.matches(&format!("<{tag}")).count() == page.matches(&format!("</{tag}>")).count();
    for tag in ["section", "figure", "table", "select", "script", "style", "svg", "main"] {
        assert!(balanced(tag), "<{tag}> is not closed");
    }

    let r = json(out.join("results.json"));
    let solvers = r["solvers"].as_array().expect("solvers");
    assert_eq!(solvers.len(), 3);
    let series: Vec<_> = solvers[1]["series"].as_array().expect("a series").iter().map(|p| p["passes"].as_u64()).collect();
    assert_eq!(series, [1, 2, 4, 8, 16, 32].map(Some));
    for s in &solvers[..2] {
        let (bias, half) = (s["bias"].as_f64().expect("bias"), s["bias_half_width"].as_f64().expect("interval"));
        // Four times 95 %: a bias beyond it has a probability below 1e-6 (Student, 15 degrees of freedom).
        assert!(bias.abs() < 4.0 * half && half > 0.0, "{}: {bias} ± {half}", s["solver"]);
        assert!(s["rel_mse"].as_f64().is_some_and(|x| x > 0.0 && x < 1.0));
    }
    // Direct light alone is a part of all light, and the test says so.
    assert_eq!(solvers[2]["agreement"]["verdict"], "FAIL");
    assert!(solvers[2]["bias"].as_f64().is_some_and(|b| b < -0.1));
    // The solver that made the reference is not tested against itself; the other is not refuted.
    let untested = solvers.iter().filter(|s| s["agreement"].is_null()).count();
    assert_eq!(untested, 1);
    assert!(solvers[..2].iter().all(|s| s["agreement"]["verdict"] != "FAIL"));

    // The pictures as EXR, with layers; one of them as a reference for another run.
    let picture = etendue_image::load_picture(&out.join("path-mis.exr")).expect("an EXR");
    assert!(picture.layer("error").is_some() && picture.layer("difference").is_some());
    let against_file = etendue(
        folder.path(),
        &[
            "compare",
            "cornell-box",
            "--solvers",
            "path-mis",
            "--reference",
            "out/reference.exr",
            "--spp",
            "16",
            "--width",
            "16",
            "-o",
            "two",
        ],
    );
    assert_eq!(against_file.status.code(), Some(0), "{}", text(&against_file.stderr));
    assert!(json(folder.path().join("two/results.json"))["reference"].as_str().is_some_and(|w| w.contains("reference.exr")));
    // A reference of another size is refused, in words.
    let other = etendue(
        folder.path(),
        &["compare", "cornell-box", "--solvers", "path-mis", "--reference", "out/reference.exr", "--spp", "1", "--width", "8"],
    );
    assert_eq!(other.status.code(), Some(1));
    assert!(text(&other.stderr).contains("--width and --height"), "{}", text(&other.stderr));
}

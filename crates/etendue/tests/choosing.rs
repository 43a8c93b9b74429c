//! `--solver auto`: the choice for each built-in scene, and that it is told.

use etendue::{LoadOptions, RenderOptions, advise, load};
use std::process::Command;

/// What is chosen for the built-in scenes. The trial draws the same numbers everywhere: this is no matter of chance.
#[test]
fn each_built_in_scene_gets_a_sensible_solver() {
    let auto = RenderOptions { solver: Some("auto".to_owned()), ..RenderOptions::default() };
    for (name, solver, word) in [
        ("cornell-box", "path-mis", "walks from the eye"),
        ("cornell-lens", "path-mis", "walks from the eye"),
        ("furnace", "path-mis", "walks from the eye"),
        ("veach-mis", "path-mis", "walks from the eye"),
        ("many-lights", "path-mis", "walks from the eye"),
        ("caustic", "bidirectional", "times the efficiency"),
        ("caustic-seen", "photon-map", "with a bias"),
        ("ajar", "bidirectional", "times the efficiency"),
    ] {
        let loaded = load(name, &LoadOptions { width: Some(64), ..LoadOptions::default() }).expect("a built-in scene");
        let advice = advise(&loaded, &auto).expect("a view").expect("auto");
        assert_eq!(advice.solver, solver, "{name}: {}", advice.reason);
        assert!(advice.reason.contains(word), "{name}: {}", advice.reason);
    }
    let named = RenderOptions { solver: Some("path".to_owned()), ..RenderOptions::default() };
    let loaded = load("furnace", &LoadOptions { width: Some(8), ..LoadOptions::default() }).expect("a built-in scene");
    assert_eq!(advise(&loaded, &named), Ok(None));
}

/// Rules, not names: direct light alone needs no walks from lights; a caustic by a point is nothing that the eye can find; no light is no reason for anything.
#[test]
fn the_choice_follows_scene_and_rules() {
    let folder = tempfile::tempdir().expect("a folder");
    let chosen = |lights: &str, max_depth: Option<u32>| {
        let glass = r#"<shape type="sphere"><point name="center" x="0" y="0.8" z="0"/><float name="radius" value="0.3"/><bsdf type="dielectric"/></shape>"#;
        let text = format!(
            r#"<scene version="3.0.0"><integrator type="path"/>
            <sensor type="perspective"><float name="fov" value="40"/>
                <transform name="to_world"><lookat origin="0, 0.45, 0.9" target="0, 0, 0" up="0, 1, 0"/></transform>
                <film type="hdrfilm"><integer name="width" value="32"/><integer name="height" value="32"/></film></sensor>
            <shape type="rectangle"><transform name="to_world"><rotate x="1" angle="-90"/></transform></shape>{glass}{lights}</scene>"#
        );
        let path = folder.path().join("scene.xml");
        std::fs::write(&path, text).expect("the folder is there");
        let loaded = load(path.to_str().expect("UTF-8"), &LoadOptions::default()).expect("a scene");
        let options = RenderOptions { solver: Some("auto".to_owned()), max_depth: max_depth.map(Some), ..RenderOptions::default() };
        let advice = advise(&loaded, &options).expect("a view").expect("auto");
        (advice.solver, advice.reason)
    };
    let point =
        r#"<emitter type="point"><point name="position" x="0.1" y="2.5" z="0"/><rgb name="intensity" value="3"/></emitter>"#;
    let (solver, reason) = chosen(point, None);
    assert!(solver != "path-mis" && reason.contains("would miss"), "{solver}: {reason}");
    assert_eq!(chosen(point, Some(2)).0, "path-mis");
    let (solver, reason) = chosen("", None);
    assert!(solver == "path-mis" && reason.contains("no light"), "{solver}: {reason}");
}

/// On standard error and among the numbers of the render.
#[test]
fn the_choice_and_its_reason_are_told() {
    let folder = tempfile::tempdir().expect("a folder");
    let run = Command::new(env!("CARGO_BIN_EXE_etendue"))
        .args(["render", "caustic", "--width", "16", "--spp", "1", "--solver", "auto", "-o", "x.exr", "--stats", "x.json"])
        .current_dir(folder.path())
        .output()
        .expect("the program starts");
    let said = String::from_utf8(run.stderr).expect("UTF-8");
    assert!(run.status.success() && said.contains("auto: bidirectional, because "), "{said}");
    let stats: serde_json::Value =
        serde_json::from_slice(&std::fs::read(folder.path().join("x.json")).expect("stats")).expect("JSON");
    assert_eq!(stats["solver"], "bidirectional");
    assert!(stats["because"].as_str().is_some_and(|because| said.contains(because)), "{stats}");
}

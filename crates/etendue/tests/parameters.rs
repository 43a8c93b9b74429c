//! Parameters of solvers, from words to the picture.

use etendue::{LoadOptions, Loaded, RenderOptions, Rendering, Stop, Watch, check, load, render};

fn furnace() -> Loaded {
    load("furnace", &LoadOptions { width: Some(8), ..Default::default() }).expect("a built-in scene")
}

fn options(solver: &str, parameters: &[(&str, &str)]) -> RenderOptions {
    RenderOptions {
        solver: Some(solver.to_owned()),
        parameters: parameters.iter().map(|(name, value)| ((*name).to_owned(), (*value).to_owned())).collect(),
        stop: Some(Stop::Samples(4)),
        ..Default::default()
    }
}

fn picture(options: &RenderOptions) -> Rendering {
    render(&furnace(), options, &Watch::default()).expect("a picture")
}

/// The furnace's walls reflect half: ambient light of 1 adds a half everywhere.
#[test]
fn ambient_light_arrives() {
    let without = picture(&options("whitted", &[])).mean();
    let with = picture(&options("whitted", &[("ambient", "1,0,2")])).mean();
    for (c, ambient) in [0.5, 0.0, 1.0].into_iter().enumerate() {
        assert!((with[c] - without[c] - ambient).abs() < 1e-5, "{with:?} {without:?}");
    }
}

#[test]
fn refusals_help() {
    let words = |solver: &str, name: &str, value: &str| {
        check(&furnace(), &options(solver, &[(name, value)])).expect_err("refused").to_string()
    };
    assert!(words("whitted", "ambiant", "1").contains("did you mean `ambient`?"));
    assert!(words("path", "ambient", "1").contains("it has none"));
    assert!(words("distribution", "shadow_samples", "-1").contains("a whole number from 0 to 4096, not `-1`"));
    assert!(words("depth", "ambient", "1").contains("no parameters"));
}

//! One surface, described by a piece of a file, and looked at from any side.
#![allow(dead_code, reason = "each test crate uses a part")]

use etendue_description::{Diagnostics, Severity};
use etendue_formats::{ReadOptions, read_str};
use etendue_numerics::{Frame, Vec2, Vec3};
use etendue_scene::{CompileOptions, Interaction, NO_INSTANCE, Scene, SurfaceId, compile};

fn file(inner: &str) -> String {
    format!(
        r#"<scene version="3.0.0"><shape type="rectangle">{inner}</shape><emitter type="constant"/><sensor type="perspective"/></scene>"#
    )
}

/// A scene of one rectangle that holds `inner`; it must compile without a word.
pub fn compiled(inner: &str) -> Scene {
    compiled_scene(&file(inner))
}

/// A scene from a whole file; it must compile without a word.
pub fn compiled_scene(text: &str) -> Scene {
    let (description, mut diagnostics) = read_str("test.xml", text, &ReadOptions::default());
    let scene = compile(&description, &CompileOptions::default(), &mut diagnostics);
    assert!(diagnostics.is_empty(), "{text}\n{}", diagnostics.render(&description.sources));
    scene.expect("a scene without errors")
}

/// The messages about `inner`: the text that each points at, and its words with the help.
pub fn messages(inner: &str) -> Vec<(Severity, String, String)> {
    let (description, mut diagnostics) = read_str("test.xml", &file(inner), &ReadOptions::default());
    assert!(!diagnostics.has_errors(), "{}", diagnostics.render(&description.sources));
    let mut found = Diagnostics::default();
    let scene = compile(&description, &CompileOptions::default(), &mut found);
    assert_eq!(scene.is_none(), found.has_errors());
    diagnostics.append(found);
    let place = |d: &etendue_description::Diagnostic| match d.span {
        Some(s) => description.sources.text(s.source)[s.start as usize..s.end as usize].to_owned(),
        None => String::new(),
    };
    diagnostics.iter().map(|d| (d.severity, place(d), format!("{} {}", d.message, d.help.join(" ")))).collect()
}

/// The errors about `inner`.
pub fn mistakes(inner: &str) -> Vec<(String, String)> {
    let errors = messages(inner).into_iter().filter(|m| m.0 == Severity::Error);
    errors.map(|(_, place, words)| (place, words)).collect()
}

/// A point of a surface in the plane z = 0, ∂p/∂u = (2, 0, 0), ∂p/∂v = (0, 2, 0).
pub fn seen_at(surface: SurfaceId, wo: Vec3, uv: Vec2) -> Interaction {
    Interaction {
        p: Vec3::new(2.0 * uv.x - 1.0, 2.0 * uv.y - 1.0, 0.0),
        p_error: Vec3::ZERO,
        n: Vec3::Z,
        shading: Frame::IDENTITY,
        uv,
        dp_du: Vec3::X * 2.0,
        dp_dv: Vec3::Y * 2.0,
        wo,
        t: 1.0,
        time: 0.0,
        surface,
        primitive: 0,
        bary: Vec2::new(0.25, 0.5),
        instance: NO_INSTANCE,
    }
}

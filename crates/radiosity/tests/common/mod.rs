//! Scenes for tests, from texts.
#![allow(dead_code)] // each test takes what it needs

use etendue_formats::ReadOptions;
use etendue_radiosity::{Cutting, PatchSize, Patches, Sides};
use etendue_scene::{CompileOptions, Scene};

/// The scene with these shapes in it.
pub fn scene(inside: &str) -> Scene {
    let text = format!(r#"<scene version="3.0.0">{inside}</scene>"#);
    let (description, mut diagnostics) = etendue_formats::read_str("test.xml", &text, &ReadOptions::default());
    let scene = etendue_scene::compile(&description, &CompileOptions::default(), &mut diagnostics);
    scene.unwrap_or_else(|| panic!("{}", diagnostics.render(&description.sources)))
}

/// A shape with a transform (as XML) and more in it.
pub fn shape(model: &str, transform: &str, inside: &str) -> String {
    format!(r#"<shape type="{model}"><transform name="to_world">{transform}</transform>{inside}</shape>"#)
}

/// A shape whose normals are turned.
pub const FLIPPED: &str = r#"<boolean name="flip_normals" value="true"/>"#;

/// Patches of a size, with sides by material.
pub fn cut(scene: &Scene, size: PatchSize) -> Patches {
    sided(scene, size, Sides::ByMaterial)
}

/// Patches of a size.
pub fn sided(scene: &Scene, size: PatchSize, sides: Sides) -> Patches {
    Patches::cut(scene, &Cutting { size, sides, ..Cutting::default() }).expect("few enough patches")
}

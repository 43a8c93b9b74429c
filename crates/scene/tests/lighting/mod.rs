//! Scenes from texts, and light measured in them from either end.
#![allow(dead_code)]

use etendue_check::{Moments, Rng};
use etendue_formats::{ReadOptions, read_str};
use etendue_numerics::{Ray, Vec2, Vec3, Wavelengths};
use etendue_scene::{CompileOptions, Interaction, LightReference, Scene, compile};
use std::path::Path;

pub const WL: Wavelengths = Wavelengths::Rgb;

/// Reads and compiles the inside of a `<scene>`; the messages as text beside it.
pub fn try_scene_in(folder: &Path, inside: &str) -> (Option<Scene>, String) {
    let text = format!("<scene version=\"3.0.0\">{inside}</scene>");
    let name = folder.join("scene.xml");
    let (description, mut diagnostics) = read_str(&name.to_string_lossy(), &text, &ReadOptions::default());
    let scene = if diagnostics.has_errors() { None } else { compile(&description, &CompileOptions::default(), &mut diagnostics) };
    let messages = diagnostics.iter().map(|d| {
        let at = d.span.map_or("", |s| &description.sources.text(s.source)[s.start as usize..s.end as usize]);
        format!("{:?} at `{at}`: {} {}\n", d.severity, d.message, d.help.join(" "))
    });
    (scene, messages.collect())
}

pub fn try_scene(inside: &str) -> (Option<Scene>, String) {
    try_scene_in(Path::new(""), inside)
}

/// A scene that must compile.
pub fn scene_in(folder: &Path, inside: &str) -> Scene {
    let (scene, messages) = try_scene_in(folder, inside);
    scene.unwrap_or_else(|| panic!("{inside}\n{messages}"))
}

pub fn scene(inside: &str) -> Scene {
    scene_in(Path::new(""), inside)
}

/// Mean of the three channels.
pub fn grey(s: etendue_numerics::Spectrum) -> f64 {
    s.to_rgb().into_iter().map(f64::from).sum::<f64>() / 3.0
}

/// The surface that is seen from `o` in the direction `d`.
pub fn look(scene: &Scene, o: Vec3, d: Vec3) -> Option<Interaction> {
    let ray = Ray::new(o, d.normalize());
    scene.intersect(&ray).map(|hit| scene.interaction(&ray, &hit))
}

/// Irradiance on the side of `n` at a place in empty space, W/m², by light sampling: ∫ L max(cosθ, 0) dw, occlusion included.
pub fn irradiance(scene: &Scene, p: Vec3, n: Vec3, samples: usize, rng: &mut Rng) -> Moments {
    let from = LightReference { p, n, one_sided: true, shared: false };
    let mut moments = Moments::default();
    for _ in 0..samples {
        let sample = scene.sample_light(&from, rng.u1(), rng.u2(), &WL);
        moments.add(sample.map_or(0.0, |s| {
            let ray = Ray::new(p, s.wi).until(s.distance.min(1e6) * 0.9999);
            let lit = scene.transmittance(&ray, 0, &WL).is_some();
            let cos = f64::from(n.dot(s.wi).max(0.0));
            if lit { grey(s.le) * cos / f64::from(s.pdf.value()) } else { 0.0 }
        }));
    }
    moments
}

/// Uniform over the square [-1, 1]² scaled by `half`.
pub fn on_square(u: Vec2, half: f32) -> Vec2 {
    (2.0 * u - Vec2::ONE) * half
}

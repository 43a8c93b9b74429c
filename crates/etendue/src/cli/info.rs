//! `etendue info`: what a scene holds.

use super::scene::{SceneArguments, SizeArguments, scene};
use super::{Done, output};
use clap::Args;
use etendue::memory;
use etendue::render::filter_words;
use std::collections::BTreeMap;
use std::process::ExitCode;

/// Tells what a scene holds.
#[derive(Debug, Args)]
#[command(after_help = "Example: etendue info cornell-box")]
pub struct InfoArguments {
    /// A scene file, or the name of a built-in scene.
    scene: String,
    #[command(flatten)]
    common: SceneArguments,
}

pub fn run(arguments: &InfoArguments) -> Done {
    let loaded = scene(&arguments.scene, &arguments.common.options(SizeArguments::default()), false)?;
    let scene = &loaded.scene;
    let row = |name: &str, words: String| output::result(&format!("{name:<12}{words}"));
    row("scene", loaded.name.clone());
    for view in &scene.views {
        let film = &view.film;
        let [w, h] = film.crop_size;
        let crop = if film.crop_size == film.size {
            String::new()
        } else {
            format!(", a crop of {} x {} at {:?}", film.size[0], film.size[1], film.crop_offset)
        };
        row(
            "view",
            format!(
                "{}, {w} x {h} pixels{crop}, {} samples per pixel, filter: {}",
                view.sensor.name().to_lowercase(),
                view.sampler.count,
                filter_words(&film.filter)
            ),
        );
        row("film", format!("{} while rendering", memory::human(memory::Need::least(film.crop_size).bytes())));
    }
    let depth = scene.integrator.max_depth.map_or("unbounded".to_owned(), |d| d.to_string());
    row("solver", format!("{}, max depth {depth}", scene.integrator.solver));
    if !scene.integrator.aovs.is_empty() {
        let layers: Vec<_> = scene.integrator.aovs.iter().map(|(name, quantity)| format!("{name} ({quantity})")).collect();
        row("layers", layers.join(", "));
    }
    row("light", if scene.spectral { "wavelengths, four a walk" } else { "red, green and blue" }.to_owned());
    row("shapes", format!("{} surfaces, {} triangles, {} instances", scene.surfaces.len(), scene.triangles, scene.instances.len()));
    let bytes = scene.accel.stats().bytes as u64;
    row("tree", format!("{} for casting rays", memory::human(bytes)));
    row("materials", tally(scene.materials.iter().map(|m| m.name())));
    row("textures", tally(scene.textures.iter().map(|t| t.name())));
    row("emitters", tally(scene.emitters.iter().map(|e| e.model.name())));
    let (b, size) = (scene.bounds, scene.bounds.size());
    row("bounds", format!("{} to {} ({:.4} x {:.4} x {:.4} m)", b.min, b.max, size.x, size.y, size.z));
    row("loading", format!("{:.3} s reading, {:.3} s building", loaded.read_time.as_secs_f64(), loaded.build_time.as_secs_f64()));
    for words in scene.diagnose() {
        output::message(&format!("warning: {words}"));
    }
    Ok(ExitCode::SUCCESS)
}

/// `3 diffuse, 1 dielectric`.
fn tally<'a>(names: impl Iterator<Item = &'a str>) -> String {
    let mut counts = BTreeMap::new();
    for name in names {
        *counts.entry(name.to_lowercase()).or_insert(0usize) += 1;
    }
    let words: Vec<_> = counts.iter().map(|(name, n)| format!("{n} {name}")).collect();
    if words.is_empty() { "none".to_owned() } else { words.join(", ") }
}

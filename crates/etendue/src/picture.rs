//! A finished picture and the words of its header.

use crate::load::Loaded;
use crate::render::RenderError;
use etendue_image::{Image, Layer, Picture};
use etendue_numerics::kernel::Kernel;
use etendue_scene::View;
use etendue_solvers::Run;

/// Name and version, as pictures and reports carry them.
pub fn software() -> String {
    concat!("etendue ", env!("CARGO_PKG_VERSION")).to_owned()
}

/// The words for a picture's header: all that decides its pixels, and nothing that does not, so that equal renders are equal files.
pub(crate) fn words(loaded: &Loaded, solver: &str, passes: u32, run: &Run<'_>, view: &View) -> Vec<(String, String)> {
    let most = |n: u32| if n == u32::MAX { "unbounded".to_owned() } else { n.to_string() };
    let mut words = vec![
        ("software", software()),
        ("scene", loaded.name.clone()),
        ("solver", solver.to_owned()),
        ("samples-per-pixel", passes.to_string()),
        ("seed", run.seed.to_string()),
        ("sampler", format!("{:?}", run.sequence).to_lowercase()),
        ("filter", filter_words(&view.film.filter)),
        ("max-depth", most(run.rules.max_edges)),
    ];
    if loaded.scene.spectral {
        words.push(("light", "wavelengths".to_owned()));
    }
    if run.rules.min_edges > 1 {
        words.push(("min-depth", run.rules.min_edges.to_string()));
    }
    if view.film.crop_size != view.film.size {
        let ([w, h], [x, y]) = (view.film.size, view.film.crop_offset);
        words.push(("crop", format!("from ({x}, {y}) of {w} x {h}")));
    }
    words.into_iter().map(|(name, word)| (name.to_owned(), word)).collect()
}

/// A reconstruction filter and its parameter in words.
pub fn filter_words(kernel: &Kernel) -> String {
    match kernel {
        Kernel::Box { radius } => format!("box, radius {radius}"),
        Kernel::Tent { radius } => format!("tent, radius {radius}"),
        Kernel::Gaussian { stddev } => format!("gaussian, stddev {stddev}"),
        Kernel::Mitchell { b, c } => format!("mitchell, B {b}, C {c}"),
        Kernel::CatmullRom => "catmullrom".to_owned(),
        Kernel::Lanczos { lobes } => format!("lanczos, {lobes} lobes"),
    }
}

/// Three channels, or luminance alone.
pub(crate) fn picture(
    pixels: Vec<[f32; 3]>,
    channels: u32,
    size: [u32; 2],
    layers: Vec<Layer>,
    attributes: Vec<(String, String)>,
) -> Result<Picture, RenderError> {
    let [width, height] = size.map(|n| n as usize);
    let image = if channels == 1 {
        let y = pixels.iter().map(|[r, g, b]| 0.2126 * r + 0.7152 * g + 0.0722 * b).collect();
        Image::from_data(width, height, &["Y"], y)
    } else {
        Image::rgb(width, height, pixels.into_flattened())
    };
    Ok(Picture { image: image.map_err(|e| RenderError(e.to_string()))?, layers, attributes })
}

pub(crate) fn mean(pixels: &[[f32; 3]]) -> [f64; 3] {
    let n = pixels.len().max(1) as f64;
    std::array::from_fn(|c| pixels.iter().map(|p| f64::from(p[c])).sum::<f64>() / n)
}

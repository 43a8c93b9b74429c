//! What all commands that load a scene share: values for its parameters, threads, the size of its film.

use super::{output, parse};
use clap::Args;
use etendue::{LoadOptions, Loaded, load};

/// How a scene is loaded.
#[derive(Debug, Args)]
pub struct SceneArguments {
    /// Set a `<default>` parameter of the scene file.
    #[arg(short = 'D', value_name = "NAME=VALUE", value_parser = parse::define)]
    pub define: Vec<(String, String)>,
    /// Threads; all cores otherwise. The result is the same for any number.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
    /// Walks carry wavelengths instead of red, green and blue.
    #[arg(long)]
    spectral: bool,
    /// Walks carry red, green and blue, also where the scene's format asks for wavelengths (pbrt).
    #[arg(long, conflicts_with = "spectral")]
    rgb: bool,
}

/// The size of the film.
#[derive(Clone, Copy, Debug, Default, Args)]
pub struct SizeArguments {
    /// Width of the picture in pixels; the height follows in proportion unless it is given too.
    #[arg(long, value_name = "W", value_parser = clap::value_parser!(u32).range(1..))]
    pub width: Option<u32>,
    /// Height of the picture in pixels.
    #[arg(long, value_name = "H", value_parser = clap::value_parser!(u32).range(1..))]
    pub height: Option<u32>,
}

/// Where a scene is seen from, and in what size.
#[derive(Debug, Args)]
pub struct ViewArguments {
    #[command(flatten)]
    pub size: SizeArguments,
    /// Which of the scene's sensors, counted from 0.
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub view: usize,
}

impl SceneArguments {
    /// Threads, where they were told.
    pub fn threads(&self) -> Option<usize> {
        self.threads.map(usize::from)
    }

    /// Whether walks carry wavelengths, where that was told.
    pub fn spectral(&self) -> Option<bool> {
        (self.spectral || self.rgb).then_some(self.spectral)
    }

    /// Refuses wavelengths where there are only red, green and blue.
    pub fn no_wavelengths(&self) -> Result<(), String> {
        if self.spectral {
            Err("patches carry red, green and blue, and no wavelengths: leave --spectral out".to_owned())
        } else {
            Ok(())
        }
    }

    /// As the library takes them.
    pub fn options(&self, size: SizeArguments) -> LoadOptions {
        let SizeArguments { width, height } = size;
        LoadOptions {
            defines: self.define.clone(),
            width,
            height,
            threads: self.threads(),
            spectral: self.spectral(),
            ..LoadOptions::default()
        }
    }
}

/// Loads a scene; what should be said of it is said, unless `quiet`.
pub fn scene(name: &str, options: &LoadOptions, quiet: bool) -> Result<Loaded, String> {
    let loaded = load(name, options).map_err(|e| output::load_error(&e))?;
    if !quiet {
        output::diagnostics(&loaded.diagnostics, &loaded.description);
    }
    Ok(loaded)
}

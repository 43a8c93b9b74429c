//! `etendue tonemap`: linear light to a picture for a display.

use super::{Done, output};
use clap::Args;
use etendue_image::{Curve, Picture, SaveOptions, ToneMap, load_picture, save};
use std::path::PathBuf;
use std::process::ExitCode;

/// Turns a picture of linear light into one for a display.
#[derive(Debug, Args)]
#[command(after_help = "Example: etendue tonemap cornell-box.exr bright.png --exposure 1 --curve agx")]
pub struct TonemapArguments {
    /// EXR, HDR or PFM.
    input: PathBuf,
    /// PNG or JPEG.
    output: PathBuf,
    #[command(flatten)]
    tone: ToneArguments,
}

/// Exposure and tone curve.
#[derive(Clone, Copy, Debug, Args)]
pub struct ToneArguments {
    /// Exposure in EV: one more doubles the light.
    #[arg(long, value_name = "EV", default_value_t = 0.0, allow_negative_numbers = true, value_parser = exposure)]
    exposure: f32,
    /// Tone curve: srgb, reinhard, aces, agx.
    #[arg(long, value_name = "NAME", default_value_t = Curve::Srgb)]
    curve: Curve,
}

fn exposure(text: &str) -> Result<f32, String> {
    let ev: f32 = text.parse().map_err(|_| format!("`{text}` is not a number"))?;
    if ev.abs() <= 64.0 { Ok(ev) } else { Err(format!("{ev} EV is out of range, expected -64 to 64")) }
}

impl ToneArguments {
    /// As the picture crate takes it.
    pub fn map(self) -> ToneMap {
        ToneMap { exposure: self.exposure, curve: self.curve }
    }
}

pub fn run(arguments: &TonemapArguments) -> Done {
    let picture = load_picture(&arguments.input).map_err(|e| e.to_string())?;
    let shown = Picture { image: arguments.tone.map().image(&picture.image), layers: Vec::new(), attributes: picture.attributes };
    save(&arguments.output, &shown, &SaveOptions::default()).map_err(|e| e.to_string())?;
    output::message(&format!("wrote {}", arguments.output.display()));
    Ok(ExitCode::SUCCESS)
}

//! `etendue diff`: how far a picture is from a reference.

use super::{Done, output};
use clap::Args;
use etendue_image::{Comparison, compare, load};
use std::path::PathBuf;
use std::process::ExitCode;

/// Measures how far a picture is from a reference of the same size.
#[derive(Debug, Args)]
#[command(after_help = "Example: etendue diff picture.exr reference.exr --json")]
pub struct DiffArguments {
    /// The picture.
    picture: PathBuf,
    /// The reference.
    reference: PathBuf,
    /// Print one JSON object.
    #[arg(long)]
    json: bool,
}

pub fn run(arguments: &DiffArguments) -> Done {
    let read = |path: &PathBuf| load(path).map_err(|e| e.to_string());
    let (picture, reference) = (read(&arguments.picture)?, read(&arguments.reference)?);
    let c = compare(&picture, &reference).map_err(|e| e.to_string())?;
    output::result(&if arguments.json { json(&c) } else { table(&c) });
    Ok(ExitCode::SUCCESS)
}

fn json(c: &Comparison) -> String {
    let value = serde_json::json!({
        "mse": c.mse, "rel_mse": c.rel_mse, "psnr": c.psnr, "bias": c.bias, "bias_luminance": c.bias_luminance,
        "flip": c.flip, "hdr_flip": c.hdr_flip, "mean": c.mean, "mean_reference": c.mean_reference,
        "nonfinite": c.nonfinite, "nonfinite_reference": c.nonfinite_reference,
    });
    value.to_string()
}

fn table(c: &Comparison) -> String {
    let percent = |x: f64| format!("{:+.3} %", 100.0 * x);
    let [r, g, b] = c.bias.map(percent);
    let mut lines = vec![
        format!("MSE       {:.6e}", c.mse),
        format!("relMSE    {:.6e}", c.rel_mse),
        format!("PSNR      {:.2} dB (of the sRGB pictures)", c.psnr),
        format!("bias      {} (R {r}, G {g}, B {b})", percent(c.bias_luminance)),
        format!("FLIP      {:.5} (HDR-FLIP {:.5})", c.flip, c.hdr_flip),
    ];
    if c.nonfinite + c.nonfinite_reference > 0 {
        lines.push(format!(
            "left out  {} pixels of the picture and {} of the reference: not finite",
            c.nonfinite, c.nonfinite_reference
        ));
    }
    lines.join("\n")
}

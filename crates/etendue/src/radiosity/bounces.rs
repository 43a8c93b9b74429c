//! The light of exactly 0, 1, 2, … bounces, its running sum, and a contact sheet of both.

use super::sheet::{Canvas, LETTER};
use super::{View, look};
use crate::load::Loaded;
use crate::render::RenderError;
use etendue_image::{Image, Picture, ToneMap};
use etendue_radiosity::Solved;
use etendue_solvers::{CancelToken, PathRules};

/// A picture of some bounces.
#[derive(Clone, Debug)]
pub struct BouncePicture {
    /// Which, in words for a file's name: `bounce-2`, `up-to-2`.
    pub name: String,
    /// The picture.
    pub picture: Picture,
}

/// Pictures of exactly k bounces and of up to k, for k from 0 to `most`, each sum that of the pictures; and the sheet, a display picture.
pub fn bounce_pictures(
    loaded: &Loaded,
    solved: &Solved,
    how: &View,
    most: u32,
    tone: ToneMap,
    threads: Option<usize>,
    cancel: &CancelToken,
) -> Result<(Vec<BouncePicture>, Image), RenderError> {
    let mut pictures: Vec<BouncePicture> = Vec::new();
    let mut sum: Option<Image> = None;
    let mut rows: Vec<[Image; 2]> = Vec::new();
    for k in 0..=most {
        let rules = PathRules { hide_emitters: how.rules.hide_emitters, ..how.rules.with_bounces(k..=k) };
        let picture = look(loaded, solved, &View { rules, ..*how }, threads, cancel)?;
        let mut up_to = picture.clone();
        if let Some(sum) = &sum {
            up_to.image.data_mut().iter_mut().zip(sum.data()).for_each(|(x, y)| *x += *y);
        }
        sum = Some(up_to.image.clone());
        rows.push([&picture, &up_to].map(|p| tone.image(&p.image.to_rgb())));
        pictures.push(BouncePicture { name: format!("bounce-{k}"), picture });
        pictures.push(BouncePicture { name: format!("up-to-{k}"), picture: up_to });
        if cancel.is_cancelled() {
            break;
        }
    }
    let sheet = sheet(&rows).map_err(|e| RenderError(e.to_string()))?;
    Ok((pictures, sheet))
}

/// Exactly k bounces above, their running sum below, with captions.
fn sheet(columns: &[[Image; 2]]) -> Result<Image, etendue_image::ImageError> {
    let [width, height] = columns.first().map_or([1, 1], |c| [c[0].width(), c[0].height()]);
    let scale = (width / 160).max(1);
    let (gap, line) = (LETTER * scale / 2, LETTER * scale * 2);
    let mut canvas = Canvas::new(columns.len() * (width + gap) + gap, 2 * (height + line) + gap, 0.08);
    for (k, column) in columns.iter().enumerate() {
        let left = gap + k * (width + gap);
        let plural = if k == 1 { "" } else { "s" };
        for (row, (image, words)) in column.iter().zip([format!("{k} bounce{plural}"), format!("up to {k}")]).enumerate() {
            let top = row * (height + line);
            canvas.write(&words, left, top + line / 4, scale, [0.95; 3]);
            canvas.paste(image, left, top + line);
        }
    }
    canvas.into_image()
}

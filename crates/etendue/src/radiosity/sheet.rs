//! Pictures with letters: contact sheets with captions, and legends.

use etendue_image::Image;
use font8x8::{BASIC_FONTS, LATIN_FONTS, UnicodeFonts};

/// Width and height of a letter, pixels.
pub(crate) const LETTER: usize = 8;

/// A display picture to be drawn on: sRGB in [0, 1].
pub(crate) struct Canvas {
    pub width: usize,
    pub height: usize,
    pixels: Vec<f32>,
}

impl Canvas {
    /// All of one grey.
    pub fn new(width: usize, height: usize, grey: f32) -> Self {
        Self { width, height, pixels: vec![grey; width * height * 3] }
    }

    /// Sets a pixel, if there is one.
    pub fn set(&mut self, x: usize, y: usize, colour: [f32; 3]) {
        if x < self.width && y < self.height {
            let at = (y * self.width + x) * 3;
            self.pixels[at..at + 3].copy_from_slice(&colour);
        }
    }

    /// Copies a display picture of three channels.
    pub fn paste(&mut self, image: &Image, left: usize, top: usize) {
        for y in 0..image.height() {
            for x in 0..image.width() {
                let at = (y * image.width() + x) * 3;
                self.set(left + x, top + y, [image.data()[at], image.data()[at + 1], image.data()[at + 2]]);
            }
        }
    }

    /// Writes words, each dot `scale` pixels wide.
    pub fn write(&mut self, words: &str, left: usize, top: usize, scale: usize, colour: [f32; 3]) {
        for (k, letter) in words.chars().enumerate() {
            let rows = BASIC_FONTS.get(letter).or_else(|| LATIN_FONTS.get(letter)).unwrap_or_default();
            for (y, row) in rows.iter().enumerate() {
                for x in (0..LETTER).filter(|x| row >> x & 1 == 1) {
                    for dot in 0..scale * scale {
                        let at = (left + (k * LETTER + x) * scale + dot % scale, top + y * scale + dot / scale);
                        self.set(at.0, at.1, colour);
                    }
                }
            }
        }
    }

    /// The picture.
    pub fn into_image(self) -> Result<Image, etendue_image::ImageError> {
        let image = Image::rgb(self.width, self.height, self.pixels)?;
        Ok(image.with_encoding(etendue_image::Encoding::SRGB))
    }
}

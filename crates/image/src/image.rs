//! A raster of named channels, and a picture of several such layers.

use crate::colour::{Encoding, Primaries, Transfer, apply};
use crate::error::{ErrorKind, ImageError};
use crate::limits;

/// width x height pixels of named f32 channels, interleaved, the top row first.
///
/// The names are those of OpenEXR: `R` `G` `B` colour, `Y` grey, `A` alpha; layers of other quantities name theirs as
/// they like (`X` `Y` `Z` of a normal, `Z` of a depth).
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    width: usize,
    height: usize,
    channels: Vec<String>,
    data: Vec<f32>,
    encoding: Encoding,
}

impl Image {
    /// A picture of zeros, linear Rec.709. Refused where a side is 0 or the size exceeds [`limits`].
    pub fn new(width: usize, height: usize, channels: &[&str]) -> Result<Self, ImageError> {
        let data = limits::zeros(width, height, channels.len())?;
        Image::from_data(width, height, channels, data)
    }

    /// A picture of `width * height * channels.len()` given numbers, linear Rec.709 until
    /// [`with_encoding`](Image::with_encoding) says otherwise.
    pub fn from_data(width: usize, height: usize, channels: &[&str], data: Vec<f32>) -> Result<Self, ImageError> {
        let samples = limits::samples(width as u64, height as u64, channels.len() as u64)?;
        if data.len() != samples {
            let names = channels.join(", ");
            let text = format!("{width} x {height} pixels of channels {names} are {samples} numbers, not {}", data.len());
            return Err(ErrorKind::Mismatch(text).into());
        }
        let channels: Vec<String> = channels.iter().map(|&c| c.to_owned()).collect();
        if let Some(twice) = channels.iter().enumerate().find(|(i, c)| channels[..*i].contains(c)) {
            return Err(ErrorKind::Mismatch(format!("the channel {} is named twice", twice.1)).into());
        }
        Ok(Image { width, height, channels, data, encoding: Encoding::LINEAR })
    }

    /// A picture of channels `R`, `G`, `B` in linear Rec.709: what a film develops to.
    pub fn rgb(width: usize, height: usize, data: Vec<f32>) -> Result<Self, ImageError> {
        Image::from_data(width, height, &["R", "G", "B"], data)
    }

    /// The same numbers, meaning something else.
    #[must_use]
    pub fn with_encoding(mut self, encoding: Encoding) -> Self {
        self.encoding = encoding;
        self
    }

    /// Columns.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Rows.
    pub fn height(&self) -> usize {
        self.height
    }

    /// The names of the channels, in the order in which a pixel holds them.
    pub fn channels(&self) -> &[String] {
        &self.channels
    }

    /// Numbers a pixel.
    pub fn channel_count(&self) -> usize {
        self.channels.len()
    }

    /// What the numbers mean.
    pub fn encoding(&self) -> Encoding {
        self.encoding
    }

    /// All numbers.
    pub fn data(&self) -> &[f32] {
        &self.data
    }

    /// All numbers, to be changed.
    pub fn data_mut(&mut self) -> &mut [f32] {
        &mut self.data
    }

    /// All numbers, without the rest.
    pub fn into_data(self) -> Vec<f32> {
        self.data
    }

    /// The pixels, each a slice of its channels.
    pub fn pixels(&self) -> std::slice::ChunksExact<'_, f32> {
        self.data.chunks_exact(self.channels.len())
    }

    /// The numbers of the pixel in column `x`, row `y`.
    ///
    /// # Panics
    /// Where (x, y) lies outside of the picture.
    #[inline]
    pub fn pixel(&self, x: usize, y: usize) -> &[f32] {
        assert!(x < self.width && y < self.height, "pixel ({x}, {y}) of {} x {}", self.width, self.height);
        let n = self.channels.len();
        &self.data[(y * self.width + x) * n..][..n]
    }

    /// Where a channel stands in a pixel.
    pub fn channel(&self, name: &str) -> Option<usize> {
        self.channels.iter().position(|c| c == name)
    }

    /// Whether the channels are, in this order, those named.
    pub fn has_exactly(&self, names: &[&str]) -> bool {
        self.channels.iter().map(String::as_str).eq(names.iter().copied())
    }

    /// The channels at these places, under these names, in this order.
    pub(crate) fn pick(&self, places: &[(usize, &str)]) -> Image {
        let data = self.pixels().flat_map(|p| places.iter().map(|&(i, _)| p[i])).collect();
        let names: Vec<&str> = places.iter().map(|p| p.1).collect();
        self.with_channels(&names, data)
    }

    /// Other numbers for the same pixels: `channels.len()` each.
    pub(crate) fn with_channels(&self, channels: &[&str], data: Vec<f32>) -> Image {
        debug_assert_eq!(data.len(), self.width * self.height * channels.len());
        Image { channels: channels.iter().map(|&c| c.to_owned()).collect(), data, ..*self }
    }

    /// The three colour channels: `R` `G` `B`, or a grey three times, or the first channel three times where none has
    /// such a name. Alpha and others are left out, the numbers stay as they are.
    #[must_use]
    pub fn to_rgb(&self) -> Image {
        if self.has_exactly(&["R", "G", "B"]) {
            return self.clone();
        }
        let places = match (self.channel("R"), self.channel("G"), self.channel("B")) {
            (Some(r), Some(g), Some(b)) => [r, g, b],
            _ => [self.channel("Y").unwrap_or(0); 3],
        };
        self.pick(&[(places[0], "R"), (places[1], "G"), (places[2], "B")])
    }

    /// The picture in linear Rec.709: the transfer function undone on every channel but alpha, and colours brought from
    /// other primaries. The depth still tells what the file held.
    #[must_use]
    pub fn to_linear(&self) -> Image {
        self.clone().into_linear()
    }

    /// [`to_linear`](Image::to_linear), in place.
    #[must_use]
    pub fn into_linear(mut self) -> Image {
        let n = self.channels.len();
        let alpha = self.channel("A");
        if self.encoding.transfer != Transfer::Linear {
            let transfer = self.encoding.transfer;
            // Eight bits know 256 lights only; other numbers that found their way in are computed.
            let table: Vec<f32> = (0..=255).map(|i| transfer.decode(i as f32 / 255.0)).collect();
            let decode = |v: f32| {
                let i = (v * 255.0).round().clamp(0.0, 255.0);
                if i / 255.0 == v { table[i as usize] } else { transfer.decode(v) }
            };
            for pixel in self.data.chunks_exact_mut(n) {
                for (c, v) in pixel.iter_mut().enumerate() {
                    if Some(c) != alpha {
                        *v = decode(*v);
                    }
                }
            }
            self.encoding.transfer = Transfer::Linear;
        }
        let rgb = (self.channel("R"), self.channel("G"), self.channel("B"));
        if let (Some(r), Some(g), Some(b)) = rgb
            && !self.encoding.primaries.same_as(&Primaries::REC709)
            && let Some(m) = self.encoding.primaries.to_rec709()
        {
            for p in self.data.chunks_exact_mut(n) {
                let rgb = apply(&m, [r, g, b].map(|i| f64::from(p[i])));
                [p[r], p[g], p[b]] = rgb.map(|x| x as f32);
            }
        }
        self.encoding.primaries = Primaries::REC709;
        self
    }
}

/// A named layer beside the picture itself: `albedo`, `normal`, `depth`.
#[derive(Clone, Debug, PartialEq)]
pub struct Layer {
    /// The name, which EXR writes in front of the channels': `albedo.R`.
    pub name: String,
    /// The pixels.
    pub image: Image,
}

/// A picture as a file holds it: the image, layers of the same size, words about it.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// The picture itself.
    pub image: Image,
    /// Further quantities. Only EXR keeps them.
    pub layers: Vec<Layer>,
    /// Names and words: render settings, the software. EXR keeps them as string attributes, PNG as text chunks.
    pub attributes: Vec<(String, String)>,
}

impl From<Image> for Picture {
    fn from(image: Image) -> Self {
        Picture { image, layers: Vec::new(), attributes: Vec::new() }
    }
}

impl Picture {
    /// The layer of a name.
    pub fn layer(&self, name: &str) -> Option<&Image> {
        self.layers.iter().find(|l| l.name == name).map(|l| &l.image)
    }

    /// The words of an attribute.
    pub fn attribute(&self, name: &str) -> Option<&str> {
        self.attributes.iter().find(|a| a.0 == name).map(|a| a.1.as_str())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn channels_are_found_and_converted() {
        let image = Image::from_data(1, 1, &["A", "B", "G", "R"], vec![0.5, 0.1, 0.2, 1.0]).unwrap();
        assert_eq!(image.to_rgb().data(), [1.0, 0.2, 0.1]);
        let linear = image.with_encoding(Encoding::SRGB).into_linear();
        assert_eq!(linear.pixel(0, 0)[0], 0.5, "alpha stays");
        assert_eq!(linear.pixel(0, 0)[2], crate::srgb_to_linear(0.2));
        let grey = Image::from_data(1, 1, &["Y", "A"], vec![0.25, 1.0]).unwrap();
        assert_eq!(grey.to_rgb().data(), [0.25; 3]);
    }

    #[test]
    fn wrong_lengths_and_names_are_refused() {
        assert!(Image::rgb(2, 2, vec![0.0; 11]).is_err());
        assert!(Image::from_data(1, 1, &["R", "R"], vec![0.0; 2]).is_err());
        assert!(Image::new(0, 1, &["Y"]).is_err() && Image::new(1 << 20, 1, &["Y"]).is_err());
    }
}

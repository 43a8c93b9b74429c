//! The numbers of a picture in memory: as small as they can be without loss.
//!
//! | stored as | when | bytes a number |
//! | --- | --- | --- |
//! | code values of eight bits and a table of 256 lights | the file has eight bits and Rec.709 primaries | 1 |
//! | half precision | every decoded value is one exactly | 2 |
//! | f32 | else | 4 |
//!
//! One number a texel for grey pictures, three for coloured ones; alpha is left out. Decoded values are linear Rec.709, or the code values
//! themselves divided by their maximum where a picture is `raw`.

use etendue_image::{Depth, Encoding, Image, Primaries, Transfer};
use etendue_numerics::{Spectrum, wide};

/// K texels for each of N lanes, \[which]\[channel]\[lane].
pub(crate) type TexelLanes<const K: usize, const N: usize> = [[[f32; N]; 3]; K];

/// Texels, row by row from the top.
#[derive(Clone, Debug)]
pub struct Texels {
    width: usize,
    height: usize,
    grey: bool,
    decoded: bool,
    /// Numbers that were not finite and are zero now.
    pub(crate) mended: usize,
    data: Data,
}

#[derive(Clone, Debug)]
enum Data {
    /// Code values and the light of each.
    Bytes(Vec<u8>, Box<[f32; 256]>),
    /// Bits of binary16.
    Halves(Vec<u16>),
    Floats(Vec<f32>),
}

impl Texels {
    /// The texels of a picture, decoded to linear Rec.709, by `transfer` in place of the file's own where it is given: numbers taken as they are
    /// (`Linear`) are no colours of any primaries. `None` where its channels are neither grey nor a colour.
    pub fn new(image: Image, transfer: Option<Transfer>) -> Option<Self> {
        let places: Vec<usize> = match (image.channel("R"), image.channel("G"), image.channel("B")) {
            (Some(r), Some(g), Some(b)) => vec![r, g, b],
            _ => vec![image.channel("Y").or((image.channel_count() == 1).then_some(0))?],
        };
        let (width, height, encoding) = (image.width(), image.height(), image.encoding());
        let grey = places.len() == 1;
        let raw = transfer == Some(Transfer::Linear);
        let transfer = transfer.unwrap_or(encoding.transfer);
        let rec709 = encoding.primaries.same_as(&Primaries::REC709);
        let mut mended = 0;
        let data = if encoding.depth == Depth::Unorm8 && (raw || grey || rec709) {
            let bytes = pick(&image, &places).map(|v| (v * 255.0).round() as u8).collect();
            Data::Bytes(bytes, Box::new(std::array::from_fn(|i| transfer.decode(i as f32 / 255.0))))
        } else {
            let image = if raw { image } else { image.with_encoding(Encoding { transfer, ..encoding }).into_linear() };
            let finite = |v: f32| if v.is_finite() { v } else { 0.0 };
            mended = pick(&image, &places).filter(|v| !v.is_finite()).count();
            match pick(&image, &places).map(|v| to_half(finite(v))).collect() {
                Some(halves) => Data::Halves(halves),
                None => Data::Floats(pick(&image, &places).map(finite).collect()),
            }
        };
        let decoded = transfer != Transfer::Linear;
        Some(Self { width, height, grey, decoded, mended, data })
    }

    /// Columns.
    #[inline]
    pub fn width(&self) -> usize {
        self.width
    }

    /// Rows.
    #[inline]
    pub fn height(&self) -> usize {
        self.height
    }

    /// Whether there is one number a texel.
    pub fn is_grey(&self) -> bool {
        self.grey
    }

    /// Whether code values went through a curve to become light.
    pub fn is_decoded(&self) -> bool {
        self.decoded
    }

    /// Bytes of the texels in memory.
    pub fn bytes(&self) -> usize {
        match &self.data {
            Data::Bytes(d, _) => d.len() + 1024,
            Data::Halves(d) => 2 * d.len(),
            Data::Floats(d) => 4 * d.len(),
        }
    }

    /// The texel of column `x` and row `y`, both within the picture.
    #[inline]
    pub fn texel(&self, x: usize, y: usize) -> Spectrum {
        self.read([[x, y]])[0]
    }

    /// Texels at (column, row), all within the picture. One question for several, so that the storage is looked at once.
    #[inline]
    pub(super) fn read<const N: usize>(&self, at: [[usize; 2]; N]) -> [Spectrum; N] {
        let at = at.map(|[x, y]| y * self.width + x);
        match &self.data {
            Data::Bytes(d, light) => at.map(|i| self.decode(d, i, |v| light[usize::from(v)])),
            Data::Halves(d) => at.map(|i| self.decode(d, i, from_half)),
            Data::Floats(d) => at.map(|i| self.decode(d, i, |v| v)),
        }
    }

    /// K texels at (column, row) for each of the first `count` lanes, all within the picture: [`Texels::texel`] of each, decoded side by side.
    pub(crate) fn read_each<const K: usize, const N: usize>(
        &self,
        count: usize,
        at: impl Fn(usize) -> [[usize; 2]; K],
        to: &mut TexelLanes<K, N>,
    ) {
        match &self.data {
            Data::Bytes(d, light) => self.lift(d, count, at, |v| light[usize::from(v)], to),
            Data::Halves(d) => self.lift(d, count, at, from_half, to),
            Data::Floats(d) => self.lift(d, count, at, |v| v, to),
        }
    }

    #[inline(always)]
    fn lift<T: Copy + Default, const K: usize, const N: usize>(
        &self,
        data: &[T],
        count: usize,
        at: impl Fn(usize) -> [[usize; 2]; K],
        decode: impl Fn(T) -> f32,
        to: &mut TexelLanes<K, N>,
    ) {
        let (mut raw, count) = ([[[T::default(); N]; 3]; K], count.min(N));
        if self.grey {
            for lane in 0..count {
                for ([r, g, b], [x, y]) in raw.iter_mut().zip(at(lane)) {
                    let v = data[y * self.width + x];
                    (r[lane], g[lane], b[lane]) = (v, v, v);
                }
            }
        } else {
            for lane in 0..count {
                for ([r, g, b], [x, y]) in raw.iter_mut().zip(at(lane)) {
                    let rgb = &data[3 * (y * self.width + x)..][..3];
                    (r[lane], g[lane], b[lane]) = (rgb[0], rgb[1], rgb[2]);
                }
            }
        }
        wide::widest(Decode { raw: &raw, lanes: wide::padded::<N>(count), decode, to });
    }

    /// Asks for the memory of a texel within the picture.
    #[inline]
    pub(crate) fn fetch(&self, x: usize, y: usize) {
        let i = (y * self.width + x) * if self.grey { 1 } else { 3 };
        match &self.data {
            Data::Bytes(d, _) => wide::fetch(&d[i]),
            Data::Halves(d) => wide::fetch(&d[i]),
            Data::Floats(d) => wide::fetch(&d[i]),
        }
    }

    #[inline]
    fn decode<T: Copy>(&self, data: &[T], i: usize, decode: impl Fn(T) -> f32) -> Spectrum {
        if self.grey {
            let v = decode(data[i]);
            return Spectrum::rgb(v, v, v);
        }
        let rgb = &data[3 * i..][..3];
        Spectrum::rgb(decode(rgb[0]), decode(rgb[1]), decode(rgb[2]))
    }

    /// One number of a value looked up here: the luminance of a coloured one.
    #[inline]
    pub fn scalar(&self, value: Spectrum) -> f32 {
        if self.grey { value.0.x } else { value.luminance() }
    }

    /// The mean of all texels, summed in f64.
    pub fn mean(&self) -> Spectrum {
        let mut sum = [0f64; 3];
        for y in 0..self.height {
            for x in 0..self.width {
                for (s, v) in sum.iter_mut().zip(self.texel(x, y).to_rgb()) {
                    *s += f64::from(v);
                }
            }
        }
        let n = (self.width * self.height).max(1) as f64;
        let [r, g, b] = sum.map(|s| (s / n) as f32);
        Spectrum::rgb(r, g, b)
    }

    /// The largest number, where one exceeds 1.
    pub(crate) fn exceeds_one(&self) -> Option<f32> {
        let most = match &self.data {
            Data::Bytes(..) => return None,
            Data::Halves(d) => d.iter().map(|&h| from_half(h)).fold(0.0, f32::max),
            Data::Floats(d) => d.iter().copied().fold(0.0, f32::max),
        };
        (most > 1.0).then_some(most)
    }
}

/// Stored numbers to light, on lanes.
struct Decode<'a, T, F, const K: usize, const N: usize> {
    raw: &'a [[[T; N]; 3]; K],
    lanes: usize,
    decode: F,
    to: &'a mut TexelLanes<K, N>,
}

impl<T: Copy, F: Fn(T) -> f32, const K: usize, const N: usize> wide::Job for Decode<'_, T, F, K, N> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let lanes = self.lanes.min(N);
        for (from, to) in self.raw.as_flattened().iter().zip(self.to.as_flattened_mut()) {
            for i in 0..lanes {
                to[i] = (self.decode)(from[i]);
            }
        }
    }
}

fn pick<'a>(image: &'a Image, places: &'a [usize]) -> impl Iterator<Item = f32> + 'a {
    image.pixels().flat_map(move |p| places.iter().map(move |&i| p[i]))
}

/// 2¹¹², the ratio of the two formats' exponent biases.
const BIAS: f32 = f32::from_bits((127 + 112) << 23);

/// The number of a finite binary16.
#[inline(always)]
fn from_half(h: u16) -> f32 {
    let magnitude = f32::from_bits(u32::from(h & 0x7fff) << 13) * BIAS;
    f32::from_bits(magnitude.to_bits() | u32::from(h & 0x8000) << 16)
}

/// The binary16 that is exactly `v`, if there is one.
fn to_half(v: f32) -> Option<u16> {
    let magnitude = (v.abs() / BIAS).to_bits();
    let h = (magnitude >> 13) as u16 | ((v.to_bits() >> 16) as u16 & 0x8000);
    (magnitude >> 13 < 0x7c00 && from_half(h).to_bits() == v.to_bits()).then_some(h)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_finite_half_goes_there_and_back() {
        assert_eq!(from_half(0x3c00), 1.0);
        assert_eq!(from_half(0x0001), 2f32.powi(-24));
        assert_eq!(from_half(0x7bff), 65504.0);
        for h in (0..=u16::MAX).filter(|h| h & 0x7c00 != 0x7c00) {
            assert_eq!(to_half(from_half(h)), Some(h));
        }
        for v in [0.1, 65536.0, 1e-9, 1.0 + f32::EPSILON] {
            assert_eq!(to_half(v), None, "{v} is no half");
        }
    }

    #[test]
    fn storage_is_the_smallest_without_loss() {
        let bytes: Vec<f32> = (0..12).map(|i| (i * 20) as f32 / 255.0).collect();
        let names = ["R", "G", "B", "A"];
        let image = Image::from_data(3, 1, &names, bytes.clone()).unwrap().with_encoding(Encoding::SRGB);
        let (srgb, raw) = (Texels::new(image.clone(), None).unwrap(), Texels::new(image, Some(Transfer::Linear)).unwrap());
        assert_eq!(srgb.bytes(), 9 + 1024);
        for x in 0..3 {
            for c in 0..3 {
                assert_eq!(srgb.texel(x, 0)[c], etendue_image::srgb_to_linear(bytes[4 * x + c]));
                assert_eq!(raw.texel(x, 0)[c], bytes[4 * x + c]);
            }
        }
        let halves = Texels::new(Image::from_data(2, 1, &["Y"], vec![0.5, 1024.0]).unwrap(), None).unwrap();
        assert_eq!((halves.bytes(), halves.texel(1, 0).to_rgb(), halves.is_grey()), (4, [1024.0; 3], true));
        let floats = Texels::new(Image::from_data(2, 1, &["Y"], vec![0.5, 0.1]).unwrap(), None).unwrap();
        assert_eq!((floats.bytes(), floats.texel(1, 0).0.x, floats.mean().0.x), (8, 0.1, 0.3));
    }

    #[test]
    fn texels_that_are_no_numbers_are_mended_and_counted() {
        let data = vec![f32::NAN, 1.0, f32::INFINITY, 0.25];
        let t = Texels::new(Image::from_data(2, 2, &["Y"], data).unwrap(), None).unwrap();
        assert_eq!((t.mended, t.texel(0, 0).0.x, t.texel(1, 1).0.x, t.exceeds_one()), (2, 0.0, 0.25, None));
    }

    #[test]
    fn unknown_channels_are_no_texture() {
        assert!(Texels::new(Image::from_data(1, 1, &["depth", "id"], vec![0.0; 2]).unwrap(), None).is_none());
    }
}

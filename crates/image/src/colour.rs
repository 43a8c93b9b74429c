//! What the numbers of a picture mean: transfer function and primaries.
//!
//! sRGB [IEC 61966-2-1:1999], V the code value and L the light, both in \[0, 1\]:
//!
//! ```text
//! L = V / 12.92                       V ≤ 0.04045
//!     ((V + 0.055) / 1.055)^2.4       else
//! ```
//!
//! A change of primaries goes through XYZ, with the white points brought together by the Bradford transform
//! [Lindbloom 2017, chromatic adaptation]: white stays white.

use etendue_numerics::math;

/// The weights of linear Rec.709 R, G, B in the luminance Y, to the four digits of [ITU-R BT.709-6, item 3.2].
pub const LUMINANCE: [f32; 3] = [0.2126, 0.7152, 0.0722];

/// Y = 0.2126 R + 0.7152 G + 0.0722 B of a linear Rec.709 colour, in its unit.
#[inline]
pub fn luminance([r, g, b]: [f32; 3]) -> f32 {
    LUMINANCE[0] * r + LUMINANCE[1] * g + LUMINANCE[2] * b
}

/// The light of an sRGB code value. Below 0 the straight piece goes on.
#[inline]
pub fn srgb_to_linear(v: f32) -> f32 {
    if v <= 0.04045 { v / 12.92 } else { math::powf((v + 0.055) / 1.055, 2.4) }
}

/// The sRGB code value of a light, the inverse of [`srgb_to_linear`].
#[inline]
pub fn linear_to_srgb(l: f32) -> f32 {
    if l <= 0.003_130_8 { l * 12.92 } else { 1.055 * math::powf(l, 1.0 / 2.4) - 0.055 }
}

/// How a colour channel's number stands for light. Alpha is always proportional.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Transfer {
    /// The number is the light.
    Linear,
    /// The number is an sRGB code value.
    Srgb,
    /// The light is the number to this power.
    Gamma(f32),
}

impl Transfer {
    /// The light of a number.
    pub fn decode(self, v: f32) -> f32 {
        match self {
            Transfer::Linear => v,
            Transfer::Srgb => srgb_to_linear(v),
            Transfer::Gamma(g) => math::powf(v.max(0.0), g),
        }
    }
}

/// How the file kept its numbers. Integers are scaled so that the largest one is 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Depth {
    /// At most 8 bits.
    Unorm8,
    /// At most 16 bits.
    Unorm16,
    /// Integers of 32 bits, unscaled.
    Uint32,
    /// Floats of 16 bits.
    Half,
    /// Floats of 32 bits.
    Float,
    /// Three bytes with one exponent.
    Rgbe,
}

/// What the numbers of a picture mean.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Encoding {
    /// From number to light.
    pub transfer: Transfer,
    /// The colours that R, G and B stand for.
    pub primaries: Primaries,
    /// How the file kept them.
    pub depth: Depth,
}

impl Encoding {
    /// Linear Rec.709 in f32: what a render is.
    pub const LINEAR: Self = Encoding { transfer: Transfer::Linear, primaries: Primaries::REC709, depth: Depth::Float };
    /// sRGB of 8 bits: what a display takes.
    pub const SRGB: Self = Encoding { transfer: Transfer::Srgb, primaries: Primaries::REC709, depth: Depth::Unorm8 };
}

/// CIE 1931 chromaticities (x, y) of red, green, blue and white.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Primaries {
    /// Red.
    pub r: [f32; 2],
    /// Green.
    pub g: [f32; 2],
    /// Blue.
    pub b: [f32; 2],
    /// White: the colour of R = G = B.
    pub w: [f32; 2],
}

/// A row-major 3 x 3 matrix.
pub(crate) type Matrix = [[f64; 3]; 3];

impl Primaries {
    /// Rec.709 with its white D65, which sRGB shares [ITU-R BT.709-6, §1].
    pub const REC709: Self = Primaries { r: [0.64, 0.33], g: [0.30, 0.60], b: [0.15, 0.06], w: [0.3127, 0.3290] };

    /// Whether the two name the same colours, to the digits that files carry.
    pub fn same_as(&self, other: &Primaries) -> bool {
        let pairs = [(self.r, other.r), (self.g, other.g), (self.b, other.b), (self.w, other.w)];
        pairs.iter().all(|(p, q)| (p[0] - q[0]).abs() < 5e-4 && (p[1] - q[1]).abs() < 5e-4)
    }

    /// The matrix from these primaries to linear Rec.709. `None` where they span no colours.
    pub fn to_rec709(&self) -> Option<[[f64; 3]; 3]> {
        let to_xyz = self.to_xyz()?;
        let adapt = bradford(xyz(self.w)?, xyz(Self::REC709.w)?)?;
        let from_xyz = inverse(&Self::REC709.to_xyz()?)?;
        let m = product(&from_xyz, &product(&adapt, &to_xyz));
        m.iter().flatten().all(|x| x.is_finite()).then_some(m)
    }

    /// The weights of R, G, B in the luminance, of sum 1. `None` where the primaries span no colours.
    pub fn luminance_weights(&self) -> Option<[f64; 3]> {
        self.to_xyz().map(|m| m[1])
    }

    /// The matrix to XYZ with white at Y = 1: its columns are the primaries scaled to add up to white.
    fn to_xyz(self) -> Option<Matrix> {
        let (r, g, b, w) = (xyz(self.r)?, xyz(self.g)?, xyz(self.b)?, xyz(self.w)?);
        let columns = [[r[0], g[0], b[0]], [r[1], g[1], b[1]], [r[2], g[2], b[2]]];
        let s = apply(&inverse(&columns)?, w);
        Some(columns.map(|row| [row[0] * s[0], row[1] * s[1], row[2] * s[2]]))
    }
}

/// XYZ of a chromaticity, with Y = 1.
fn xyz([x, y]: [f32; 2]) -> Option<[f64; 3]> {
    let (x, y) = (f64::from(x), f64::from(y));
    (y.abs() > 1e-6 && x.is_finite() && y.is_finite()).then(|| [x / y, 1.0, (1.0 - x - y) / y])
}

/// The Bradford adaptation of XYZ from one white to another.
fn bradford(from: [f64; 3], to: [f64; 3]) -> Option<Matrix> {
    let cone = [[0.8951, 0.2664, -0.1614], [-0.7502, 1.7135, 0.0367], [0.0389, -0.0685, 1.0296]];
    let (a, b) = (apply(&cone, from), apply(&cone, to));
    let scaled = [0, 1, 2].map(|i| cone[i].map(|x| x * b[i] / a[i]));
    Some(product(&inverse(&cone)?, &scaled))
}

/// M v.
pub(crate) fn apply(m: &Matrix, v: [f64; 3]) -> [f64; 3] {
    m.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2])
}

/// A B.
fn product(a: &Matrix, b: &Matrix) -> Matrix {
    a.map(|row| [0, 1, 2].map(|j| row[0] * b[0][j] + row[1] * b[1][j] + row[2] * b[2][j]))
}

/// M⁻¹ by cofactors.
pub(crate) fn inverse(m: &Matrix) -> Option<Matrix> {
    let minor = |i: usize, j: usize| {
        let (i1, i2, j1, j2) = ((i + 1) % 3, (i + 2) % 3, (j + 1) % 3, (j + 2) % 3);
        m[i1][j1] * m[i2][j2] - m[i1][j2] * m[i2][j1]
    };
    let det = m[0][0] * minor(0, 0) + m[0][1] * minor(0, 1) + m[0][2] * minor(0, 2);
    (det.abs() > 1e-12).then(|| [0, 1, 2].map(|i| [0, 1, 2].map(|j| minor(j, i) / det)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn srgb_goes_there_and_back() {
        assert_eq!((srgb_to_linear(0.0), linear_to_srgb(0.0)), (0.0, 0.0));
        assert!((srgb_to_linear(1.0) - 1.0).abs() < 1e-6 && (linear_to_srgb(1.0) - 1.0).abs() < 1e-6);
        // 18 % grey is the code value 118 of 255.
        assert_eq!((linear_to_srgb(0.18) * 255.0).round(), 118.0);
        for i in 0..=65_535u32 {
            let v = i as f32 / 65_535.0;
            let back = linear_to_srgb(srgb_to_linear(v));
            assert!((back - v).abs() < 0.1 / 65_535.0, "{v} came back as {back}");
        }
    }

    #[test]
    fn primaries_keep_white_and_themselves() {
        let m = Primaries::REC709.to_rec709().unwrap();
        for (i, row) in m.iter().enumerate() {
            for (j, x) in row.iter().enumerate() {
                assert!((x - f64::from(u8::from(i == j))).abs() < 1e-12);
            }
        }
        // ACES 2065-1 has another white [SMPTE ST 2065-1, §4]; a grey must stay a grey.
        let aces = Primaries { r: [0.7347, 0.2653], g: [0.0, 1.0], b: [0.0001, -0.077], w: [0.32168, 0.33767] };
        for x in apply(&aces.to_rec709().unwrap(), [0.4, 0.4, 0.4]) {
            assert!((x - 0.4).abs() < 1e-6);
        }
        for (w, l) in Primaries::REC709.luminance_weights().unwrap().iter().zip(LUMINANCE) {
            assert!((w - f64::from(l)).abs() < 1e-4);
        }
        assert!(Primaries { g: Primaries::REC709.r, ..Primaries::REC709 }.to_rec709().is_none());
    }
}

//! Pictures as textures.
//!
//! ```text
//! t(u, v) = Σ w_i texel_i over the four texels around (u' W - 1/2, v' H - 1/2)        (u', v') = to_uv(u, v)
//! ```
//!
//! Texel (i, j) has its centre at u' = (i + 1/2)/W, v' = (j + 1/2)/H; j = 0 is the top row, so v' grows downwards. Outside [0, 1] the
//! picture repeats, is mirrored, or goes on with its border.
//!
//! Texels stay as small in memory as they can without loss: eight bits with a table of 256 values, or half precision, else f32.

use crate::scene::Scene;
use crate::texture::{Role, Texels, TextureContext, UvMap};
use etendue_numerics::{Spectrum, Vec2, Wavelengths};
use std::sync::Arc;

/// How a value between texel centres is made.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FilterMode {
    /// Linear between the four nearest centres.
    #[default]
    Bilinear,
    /// The texel that holds the point.
    Nearest,
}

/// What lies outside [0, 1].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum WrapMode {
    /// The picture again.
    #[default]
    Repeat,
    /// The picture mirrored, then again.
    Mirror,
    /// The border.
    Clamp,
    /// Nothing.
    Black,
}

/// A picture with the way of looking it up.
#[derive(Clone, Debug)]
pub struct Bitmap {
    /// The texels, shared by every texture that names the same file.
    pub texels: Arc<Texels>,
    /// Between texels.
    pub filter: FilterMode,
    /// Outside the picture.
    pub wrap: WrapMode,
    /// From (u, v) to (u', v').
    pub to_uv: UvMap,
    /// What its colours stand for.
    pub role: Role,
}

/// Two neighbouring texels along an axis, and how far the point lies from the first towards the second.
#[derive(Clone, Copy)]
struct Span {
    first: usize,
    second: usize,
    fraction: f32,
    /// d(position in texels)/d(u'): the size, negative in a mirrored tile, zero beyond a clamped border.
    slope: f32,
}

/// The four texels around a point: along x first.
#[inline]
fn corners(x: &Span, y: &Span) -> [[usize; 2]; 4] {
    [[x.first, y.first], [x.second, y.first], [x.first, y.second], [x.second, y.second]]
}

/// ⌊x⌋ without a call where the processor has no instruction for it.
#[inline]
fn floor(x: f32) -> f32 {
    // From 2²³ on every number is whole.
    if x.abs() < 8_388_608.0 {
        let t = x as i32 as f32;
        if t > x { t - 1.0 } else { t }
    } else {
        x
    }
}

impl WrapMode {
    /// u' brought into [0, 1], and the sign of its slope.
    #[inline]
    fn fold(self, u: f32) -> (f32, f32) {
        match self {
            Self::Repeat => (u - floor(u), 1.0),
            Self::Mirror => {
                let t = u - 2.0 * floor(0.5 * u);
                if t > 1.0 { (2.0 - t, -1.0) } else { (t, 1.0) }
            }
            Self::Clamp | Self::Black => (u.clamp(0.0, 1.0), if (0.0..=1.0).contains(&u) { 1.0 } else { 0.0 }),
        }
    }

    #[inline]
    fn span(self, u: f32, size: usize) -> Span {
        let (u, sign) = self.fold(u);
        // Within [-1/2, size - 1/2], and so is its floor within [-1, size - 1].
        let x = u * size as f32 - 0.5;
        let (last, i) = (size as i32 - 1, x as i32 - i32::from(x < 0.0));
        let (first, second) = match self {
            Self::Repeat => (if i < 0 { last } else { i.min(last) }, if i >= last { 0 } else { i + 1 }),
            Self::Mirror | Self::Clamp | Self::Black => (i.clamp(0, last), (i + 1).min(last)),
        };
        Span { first: first as usize, second: second as usize, fraction: x - i as f32, slope: sign * size as f32 }
    }

    #[inline]
    fn nearest(self, u: f32, size: usize) -> usize {
        let (u, _) = self.fold(u);
        ((u * size as f32) as usize).min(size - 1)
    }
}

impl Bitmap {
    /// The value, linear Rec.709; a grey picture has equal channels.
    #[inline]
    fn lookup(&self, uv: Vec2) -> Spectrum {
        let t = &*self.texels;
        let uv = self.finite(uv);
        if self.wrap == WrapMode::Black && uv.clamp(Vec2::ZERO, Vec2::ONE) != uv {
            return Spectrum::ZERO;
        }
        match self.filter {
            FilterMode::Nearest => t.texel(self.wrap.nearest(uv.x, t.width()), self.wrap.nearest(uv.y, t.height())),
            FilterMode::Bilinear => {
                let (x, y) = (self.wrap.span(uv.x, t.width()), self.wrap.span(uv.y, t.height()));
                let [f00, f10, f01, f11] = t.read(corners(&x, &y));
                Spectrum::lerp(y.fraction, Spectrum::lerp(x.fraction, f00, f10), Spectrum::lerp(x.fraction, f01, f11))
            }
        }
    }

    /// (u', v'); coordinates that are not numbers are taken as zero.
    #[inline]
    fn finite(&self, uv: Vec2) -> Vec2 {
        let uv = self.to_uv.apply(uv);
        if uv.is_finite() { uv } else { Vec2::ZERO }
    }

    /// The value at x.
    #[inline]
    pub fn eval(&self, x: &TextureContext, wl: &Wavelengths) -> Spectrum {
        self.role.spectrum(self.lookup(x.uv), wl)
    }

    /// The luminance at x.
    #[inline]
    pub fn eval_scalar(&self, x: &TextureContext) -> f32 {
        self.texels.scalar(self.lookup(x.uv))
    }

    /// (∂/∂u, ∂/∂v) of the luminance at x: zero where the nearest texel is taken.
    pub fn eval_gradient(&self, x: &TextureContext) -> Vec2 {
        self.gradient(x.uv)
    }

    fn gradient(&self, uv: Vec2) -> Vec2 {
        if self.filter == FilterMode::Nearest {
            return Vec2::ZERO;
        }
        let t = &*self.texels;
        let uv = self.finite(uv);
        let (x, y) = (self.wrap.span(uv.x, t.width()), self.wrap.span(uv.y, t.height()));
        let [f00, f10, f01, f11] = t.read(corners(&x, &y)).map(|v| t.scalar(v));
        let along_x = (1.0 - y.fraction) * (f10 - f00) + y.fraction * (f11 - f01);
        let along_y = (1.0 - x.fraction) * (f01 - f00) + x.fraction * (f11 - f10);
        self.to_uv.pull_back(Vec2::new(x.slope * along_x, y.slope * along_y))
    }

    /// The mean of all texels.
    pub fn mean(&self, _scene: &Scene) -> Spectrum {
        self.texels.mean()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use etendue_image::Image;
    use etendue_numerics::Transform;
    use glam::{DMat4, DVec3};

    const W: usize = 4;
    const H: usize = 3;

    fn data() -> Vec<f32> {
        (0..W * H).map(|i| ((i * 7 + 3) % 11) as f32 / 11.0).collect()
    }

    fn bitmap(filter: FilterMode, wrap: WrapMode, to_uv: UvMap) -> Bitmap {
        let image = Image::from_data(W, H, &["Y"], data()).unwrap();
        Bitmap { texels: Arc::new(Texels::new(image, None).unwrap()), filter, wrap, to_uv, role: Role::Reflectance }
    }

    /// The same by integer indices of an endless lattice.
    fn by_hand(u: f32, v: f32, wrap: WrapMode) -> f32 {
        let fold = |i: i64, n: i64| match wrap {
            WrapMode::Repeat => i.rem_euclid(n),
            WrapMode::Clamp | WrapMode::Black => i.clamp(0, n - 1),
            WrapMode::Mirror => {
                let m = i.rem_euclid(2 * n);
                if m < n { m } else { 2 * n - 1 - m }
            }
        };
        let at = |i: i64, j: i64| f64::from(data()[(fold(j, H as i64) * W as i64 + fold(i, W as i64)) as usize]);
        let (x, y) = (f64::from(u) * W as f64 - 0.5, f64::from(v) * H as f64 - 0.5);
        let (i, j) = (x.floor() as i64, y.floor() as i64);
        let (fx, fy) = (x - x.floor(), y - y.floor());
        let row = |j| (1.0 - fx) * at(i, j) + fx * at(i + 1, j);
        ((1.0 - fy) * row(j) + fy * row(j + 1)) as f32
    }

    fn grid() -> impl Iterator<Item = (f32, f32)> {
        (0..67).flat_map(|i| (0..61).map(move |j| (i as f32 * 0.0937 - 3.1, j as f32 * 0.1013 - 2.9)))
    }

    #[test]
    fn bilinear_values_follow_the_lattice_in_every_wrap_mode() {
        for wrap in [WrapMode::Repeat, WrapMode::Mirror, WrapMode::Clamp] {
            let t = bitmap(FilterMode::Bilinear, wrap, UvMap::default());
            for (u, v) in grid() {
                let (got, want) = (t.lookup(Vec2::new(u, v)).0.x, by_hand(u, v, wrap));
                assert!((got - want).abs() < 1e-5, "{wrap:?} ({u}, {v}): {got}, expected {want}");
            }
        }
    }

    #[test]
    fn texel_centres_give_the_texels_and_the_first_row_is_at_v_0() {
        for filter in [FilterMode::Bilinear, FilterMode::Nearest] {
            let t = bitmap(filter, WrapMode::Repeat, UvMap::default());
            for (i, want) in data().into_iter().enumerate() {
                let uv = Vec2::new((i % W) as f32 + 0.5, (i / W) as f32 + 0.5) / Vec2::new(W as f32, H as f32);
                assert!((t.lookup(uv).0.x - want).abs() < 1e-6);
            }
        }
    }

    #[test]
    fn gradients_are_those_of_the_values() {
        let m = DMat4::from_rotation_z(0.4) * DMat4::from_scale(DVec3::new(1.5, 0.7, 1.0));
        let to_uv = UvMap::from(&Transform::new(m).unwrap());
        for wrap in [WrapMode::Repeat, WrapMode::Mirror, WrapMode::Clamp] {
            let t = bitmap(FilterMode::Bilinear, wrap, to_uv);
            let h = 1.0 / 512.0;
            for (u, v) in grid() {
                let f = |u: f32, v: f32| t.lookup(Vec2::new(u, v)).0.x;
                let numeric = Vec2::new(f(u + h, v) - f(u - h, v), f(u, v + h) - f(u, v - h)) / (2.0 * h);
                // A texel border within the stencil makes the two differ: compare where none is.
                let smooth = (f(u + h, v) + f(u - h, v) - 2.0 * f(u, v)).abs() < 1e-6
                    && (f(u, v + h) + f(u, v - h) - 2.0 * f(u, v)).abs() < 1e-6;
                let got = t.gradient(Vec2::new(u, v));
                assert!(!smooth || (got - numeric).length() < 2e-3, "{wrap:?} ({u}, {v}): {got}, expected {numeric}");
            }
        }
    }

    #[test]
    fn wild_coordinates_give_finite_values() {
        for wrap in [WrapMode::Repeat, WrapMode::Mirror, WrapMode::Clamp] {
            for filter in [FilterMode::Bilinear, FilterMode::Nearest] {
                let t = bitmap(filter, wrap, UvMap::default());
                for x in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MAX, f32::MIN, -1e-30, 1e30, -0.0, 1.0, 2.0] {
                    assert!(t.lookup(Vec2::new(x, 0.3)).is_finite() && t.lookup(Vec2::new(0.3, x)).is_finite(), "{x} {wrap:?}");
                    assert!(t.gradient(Vec2::new(x, x)).is_finite());
                }
            }
        }
    }
}

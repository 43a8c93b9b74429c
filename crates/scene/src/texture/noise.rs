//! Noise over space, and what is made of it.
//!
//! ```text
//! noise(p)              gradients at the corners of p's cell of the integer lattice, blended by t³ (10 - 15 t + 6 t²)      [Perlin 2002]
//! fbm(p)                Σ_k ω^k noise(λ^k p),  k < octaves, λ = 1.99, ω = `roughness`
//! wrinkled              Σ_k ω^k |noise(λ^k p)|
//! windy                 |fbm(0.1 p; ω = 1/2, 3 octaves)| fbm(p; ω = 1/2, 6 octaves)
//! marble                a curve through colours at sin(y + `variation` fbm(`scale` p)) of q = `scale` p, made 3/2 as bright
//! dots                  `inside` in a disk of radius 0.35 in about half of the cells of the (u', v') lattice, else `outside`
//! ```
//!
//! Sources: [Perlin 2002, "Improving Noise"] for noise; [Peachey 1985] and [Pharr, Jakob, Humphreys 2016, §10.6] for the rest.

use super::combine::no_gradient;
use crate::scene::Scene;
use crate::texture::{ColorSlot, Mapping, Role, TextureContext};
use etendue_numerics::{Spectrum, Vec2, Vec3, Wavelengths};

/// The permutation of the bytes that [Perlin 2002] gives.
const PERMUTATION: [u8; 256] = [
    151, 160, 137, 91, 90, 15, 131, 13, 201, 95, 96, 53, 194, 233, 7, 225, 140, 36, 103, 30, 69, 142, 8, 99, 37, 240, 21, 10, 23,
    190, 6, 148, 247, 120, 234, 75, 0, 26, 197, 62, 94, 252, 219, 203, 117, 35, 11, 32, 57, 177, 33, 88, 237, 149, 56, 87, 174, 20,
    125, 136, 171, 168, 68, 175, 74, 165, 71, 134, 139, 48, 27, 166, 77, 146, 158, 231, 83, 111, 229, 122, 60, 211, 133, 230, 220,
    105, 92, 41, 55, 46, 245, 40, 244, 102, 143, 54, 65, 25, 63, 161, 1, 216, 80, 73, 209, 76, 132, 187, 208, 89, 18, 169, 200,
    196, 135, 130, 116, 188, 159, 86, 164, 100, 109, 198, 173, 186, 3, 64, 52, 217, 226, 250, 124, 123, 5, 202, 38, 147, 118, 126,
    255, 82, 85, 212, 207, 206, 59, 227, 47, 16, 58, 17, 182, 189, 28, 42, 223, 183, 170, 213, 119, 248, 152, 2, 44, 154, 163, 70,
    221, 153, 101, 155, 167, 43, 172, 9, 129, 22, 39, 253, 19, 98, 108, 110, 79, 113, 224, 232, 178, 185, 112, 104, 218, 246, 97,
    228, 251, 34, 242, 193, 238, 210, 144, 12, 191, 179, 162, 241, 81, 51, 145, 235, 249, 14, 239, 107, 49, 192, 214, 31, 181, 199,
    106, 157, 184, 84, 204, 176, 115, 121, 50, 45, 127, 4, 150, 254, 138, 236, 205, 93, 222, 114, 67, 29, 24, 72, 243, 141, 128,
    195, 78, 66, 215, 61, 156, 180,
];

/// How much finer each octave is.
const LACUNARITY: f32 = 1.99;

/// Noise in about [-1, 1]; zero on the integer lattice.
pub fn noise(p: Vec3) -> f32 {
    // Beyond this the lattice is coarser than f32.
    if !p.is_finite() || p.abs().max_element() > 1e6 {
        return 0.0;
    }
    let cell = p.floor();
    let d = p - cell;
    let [x, y, z] = cell.to_array().map(|c| (c as i32) & 255);
    let hash = |i: i32| PERMUTATION[(i & 255) as usize] as i32;
    let corner = |i: i32, j: i32, k: i32| {
        let h = hash(hash(hash(x + i) + y + j) + z + k) & 15;
        let d = d - Vec3::new(i as f32, j as f32, k as f32);
        let u = if h < 8 || h == 12 || h == 13 { d.x } else { d.y };
        let v = if h < 4 || h == 12 || h == 13 { d.y } else { d.z };
        (if h & 1 == 0 { u } else { -u }) + if h & 2 == 0 { v } else { -v }
    };
    let w = d * d * d * (d * (6.0 * d - 15.0) + 10.0);
    let lerp = |t: f32, a: f32, b: f32| a + t * (b - a);
    let along_x = |j, k| lerp(w.x, corner(0, j, k), corner(1, j, k));
    lerp(w.z, lerp(w.y, along_x(0, 0), along_x(1, 0)), lerp(w.y, along_x(0, 1), along_x(1, 1)))
}

/// Σ ω^k f(noise(λ^k p)).
fn octaves(p: Vec3, omega: f32, count: u32, f: impl Fn(f32) -> f32) -> f32 {
    let (mut sum, mut amplitude, mut scale) = (0.0, 1.0, 1.0);
    for _ in 0..count {
        sum += amplitude * f(noise(p * scale));
        scale *= LACUNARITY;
        amplitude *= omega;
    }
    sum
}

fn fbm(p: Vec3, omega: f32, count: u32) -> f32 {
    octaves(p, omega, count, |x| x)
}

/// Which sum of noise.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Turbulence {
    /// Σ ω^k noise.
    Fbm,
    /// Σ ω^k |noise|.
    Wrinkled,
    /// Waves on water.
    Windy,
}

/// A grey sum of noise.
#[derive(Clone, Copy, Debug)]
pub struct Noise {
    /// Which.
    pub kind: Turbulence,
    /// How many octaves.
    pub octaves: u32,
    /// ω.
    pub roughness: f32,
    /// Where it is looked up.
    pub mapping: Mapping,
}

impl Noise {
    /// The value at x as one number.
    pub fn eval_scalar(&self, x: &TextureContext) -> f32 {
        let p = self.mapping.point(x);
        match self.kind {
            Turbulence::Fbm => fbm(p, self.roughness, self.octaves),
            Turbulence::Wrinkled => octaves(p, self.roughness, self.octaves, f32::abs),
            Turbulence::Windy => fbm(0.1 * p, 0.5, 3).abs() * fbm(p, 0.5, 6),
        }
    }

    /// The same in each lane; below zero there is no colour.
    pub fn eval(&self, x: &TextureContext, _wl: &Wavelengths) -> Spectrum {
        Spectrum::splat(self.eval_scalar(x).max(0.0))
    }

    no_gradient!();

    /// About: noise is 1/4 in the mean of its magnitude.
    pub fn mean(&self, _scene: &Scene) -> Spectrum {
        let sum = (0..self.octaves).map(|k| self.roughness.powi(k as i32)).sum::<f32>();
        Spectrum::splat(0.25 * sum * if self.kind == Turbulence::Wrinkled { 1.0 } else { 0.5 })
    }
}

/// Veined stone.
#[derive(Clone, Copy, Debug)]
pub struct Marble {
    /// How many octaves.
    pub octaves: u32,
    /// ω.
    pub roughness: f32,
    /// A factor on the place.
    pub scale: f32,
    /// How far veins stray.
    pub variation: f32,
    /// What the colours stand for.
    pub role: Role,
    /// Where it is looked up.
    pub mapping: Mapping,
}

/// The colours along the curve, linear Rec.709.
const MARBLE: [Vec3; 9] = [
    Vec3::new(0.58, 0.58, 0.6),
    Vec3::new(0.58, 0.58, 0.6),
    Vec3::new(0.58, 0.58, 0.6),
    Vec3::new(0.5, 0.5, 0.5),
    Vec3::new(0.6, 0.59, 0.58),
    Vec3::new(0.58, 0.58, 0.6),
    Vec3::new(0.58, 0.58, 0.6),
    Vec3::new(0.2, 0.2, 0.33),
    Vec3::new(0.58, 0.58, 0.6),
];

impl Marble {
    fn rgb(&self, x: &TextureContext) -> Vec3 {
        let p = self.mapping.point(x) * self.scale;
        let marble = p.y + self.variation * fbm(p, self.roughness, self.octaves);
        let t = 0.5 + 0.5 * etendue_numerics::math::sin_cos(marble).0;
        // A cubic Bézier curve through each four colours.
        let segments = MARBLE.len() - 3;
        let first = ((t * segments as f32) as usize).min(segments - 1);
        let t = t * segments as f32 - first as f32;
        let c = &MARBLE[first..first + 4];
        let (s, w) = (1.0 - t, t);
        1.5 * (c[0] * (s * s * s) + c[1] * (3.0 * s * s * w) + c[2] * (3.0 * s * w * w) + c[3] * (w * w * w))
    }

    fn colour(&self, x: &TextureContext) -> Spectrum {
        let Vec3 { x: r, y: g, z: b } = self.rgb(x).min(Vec3::ONE);
        Spectrum::rgb(r, g, b)
    }

    /// The value at x.
    pub fn eval(&self, x: &TextureContext, wl: &Wavelengths) -> Spectrum {
        self.role.spectrum(self.colour(x), wl)
    }

    /// Its luminance.
    pub fn eval_scalar(&self, x: &TextureContext) -> f32 {
        self.colour(x).luminance()
    }

    no_gradient!();

    /// About.
    pub fn mean(&self, _scene: &Scene) -> Spectrum {
        Spectrum::rgb(0.81, 0.81, 0.83)
    }
}

/// Disks strewn over a plane.
#[derive(Clone, Debug)]
pub struct Dots {
    /// In the disks, and around them.
    pub parts: [ColorSlot; 2],
    /// Where it is looked up.
    pub mapping: Mapping,
}

impl Dots {
    fn part(&self, x: &TextureContext) -> &ColorSlot {
        const RADIUS: f32 = 0.35;
        let uv = self.mapping.uv(x);
        let cell = (uv + 0.5).floor();
        let at = |a: f32, b: f32| noise(Vec3::new(cell.x + a, cell.y + b, 0.5));
        let has_dot = at(0.5, 0.5) > 0.0;
        let center = cell + (0.5 - RADIUS) * Vec2::new(at(1.5, 2.8), at(4.5, 9.8));
        &self.parts[usize::from(!(has_dot && uv.distance_squared(center) < RADIUS * RADIUS))]
    }

    /// The value at x.
    pub fn eval(&self, x: &TextureContext, wl: &Wavelengths) -> Spectrum {
        self.part(x).eval(x, wl)
    }

    /// The value at x as one number.
    pub fn eval_scalar(&self, x: &TextureContext) -> f32 {
        self.part(x).eval_scalar(x)
    }

    no_gradient!();

    /// By the disks' share of the plane, half of the cells having one.
    pub fn mean(&self, scene: &Scene) -> Spectrum {
        Spectrum::lerp(0.192, self.parts[1].mean(scene), self.parts[0].mean(scene))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_vanishes_on_the_lattice_and_is_smooth() {
        let mut seen = std::collections::BTreeSet::from(PERMUTATION);
        assert_eq!(seen.len(), 256);
        seen.clear();
        let (mut low, mut high) = (0f32, 0f32);
        for i in 0..4000 {
            let p = Vec3::new(i as f32 * 0.37, i as f32 * 0.91 - 300.0, i as f32 * 0.113);
            assert_eq!(noise(p.floor()), 0.0);
            let n = noise(p);
            assert!((n - noise(p + Vec3::splat(1e-3))).abs() < 0.02, "{p}");
            (low, high) = (low.min(n), high.max(n));
        }
        assert!((-1.1..-0.6).contains(&low) && (0.6..1.1).contains(&high), "{low} {high}");
        assert_eq!(noise(Vec3::splat(f32::NAN)), 0.0);
    }

    /// A figure of Perlin's own program for improved noise.
    #[test]
    fn noise_is_perlins() {
        let got = noise(Vec3::new(157.0 / 50.0, 42.0, 7.0));
        assert!((got - 0.136_919_96).abs() < 2e-4, "{got}");
    }
}

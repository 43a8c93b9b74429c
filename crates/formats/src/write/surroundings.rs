//! Pictures of what is all around, from one unfolding of the sphere to another.
//!
//! ```text
//! polar         φ = atan2(x, -z), θ = arccos y;  columns even in φ, rows even in θ with the poles on the first and the last
//! equal area    the square of [Clarberg 2008], z in its middle; texels are even
//! ```
//!
//! Both are told in the picture's own coordinates, so that `to_world` stays as it is. A new texel is the mean over 4 × 4 points of it.

use super::pictures::Pixels;
use etendue_numerics::Vec2;
use etendue_numerics::warp::{equal_area_sphere_to_square, square_to_equal_area_sphere};
use glam::{DVec3, Vec3};
use std::f64::consts::{PI, TAU};

/// Points along each side of a texel.
const POINTS: usize = 4;

/// A square picture of about as many texels as the polar one.
pub(super) fn to_equal_area(polar: &Pixels) -> Pixels {
    let side = ((polar.width * polar.height) as f64).sqrt().ceil() as usize;
    averaged(side, side, |x, y| {
        let w = square_to_equal_area_sphere(Vec2::new((x / side as f64) as f32, (y / side as f64) as f32));
        Some(look_polar(polar, w.as_dvec3()))
    })
}

/// A polar picture twice as wide as the square is.
pub(super) fn to_polar(square: &Pixels) -> Pixels {
    let (width, height) = (2 * square.width, square.width.max(2));
    averaged(width, height, |x, y| {
        // A row is centred on its θ; half of the first and of the last would lie beyond the poles.
        let (phi, theta) = (TAU * x / width as f64, PI * (y - 0.5) / (height - 1) as f64);
        if !(0.0..=PI).contains(&theta) {
            return None;
        }
        let (sin, cos) = theta.sin_cos();
        let w = DVec3::new(phi.sin() * sin, cos, -phi.cos() * sin);
        let uv = equal_area_sphere_to_square(w.as_vec3());
        let n = square.width;
        let at = |u: f32| ((u * n as f32) as usize).min(n - 1);
        Some(square.texel(at(uv.x), at(uv.y)))
    })
}

/// The irradiance, by luminance, that the upper half (z > 0) of a square picture gives a plane.
pub(super) fn illuminance(square: &Pixels) -> f64 {
    let n = square.width;
    let cell = 2.0 * TAU / (n * n) as f64;
    let light = (0..n * n).map(|i| {
        let uv = Vec2::new((i % n) as f32 + 0.5, (i / n) as f32 + 0.5) / n as f32;
        let cos = f64::from(square_to_equal_area_sphere(uv).z).max(0.0);
        let t = square.texels[i].as_dvec3();
        (0.2126 * t.x + 0.7152 * t.y + 0.0722 * t.z) * cos * cell
    });
    light.sum()
}

/// A picture of means; points without a value do not count.
fn averaged(width: usize, height: usize, at: impl Fn(f64, f64) -> Option<Vec3>) -> Pixels {
    let within = |i: usize, k: usize| i as f64 + (k as f64 + 0.5) / POINTS as f64;
    Pixels::make(width, height, |x, y| {
        let (mut sum, mut n) = (Vec3::ZERO, 0.0);
        for k in 0..POINTS * POINTS {
            if let Some(t) = at(within(x, k % POINTS), within(y, k / POINTS)) {
                sum += t;
                n += 1.0;
            }
        }
        if n > 0.0 { sum / n } else { Vec3::ZERO }
    })
}

/// A polar picture between its texels, as `envmap` looks it up.
fn look_polar(p: &Pixels, w: DVec3) -> Vec3 {
    let phi = w.x.atan2(-w.z).rem_euclid(TAU);
    let theta = w.y.clamp(-1.0, 1.0).acos();
    let x = phi / TAU * p.width as f64 - 0.5;
    let y = theta / PI * (p.height - 1) as f64;
    let (x0, y0) = (x.floor(), y.floor().min(p.height.saturating_sub(2) as f64));
    let (s, t) = ((x - x0) as f32, (y - y0) as f32);
    let column = |i: f64| (i as i64).rem_euclid(p.width as i64) as usize;
    let row = |i: f64| (i as usize).min(p.height - 1);
    let texel = |dx: f64, dy: f64| p.texel(column(x0 + dx), row(y0 + dy));
    texel(0.0, 0.0).lerp(texel(1.0, 0.0), s).lerp(texel(0.0, 1.0).lerp(texel(1.0, 1.0), s), t)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A sky that is bright around one direction, with a slope all around.
    fn polar() -> Pixels {
        Pixels::make(128, 65, |x, y| {
            let (phi, theta) = (TAU * (x as f64 + 0.5) / 128.0, PI * y as f64 / 64.0);
            let w = DVec3::new(phi.sin() * theta.sin(), theta.cos(), -phi.cos() * theta.sin());
            let sun = (w.dot(DVec3::new(0.6, 0.48, 0.64)) * 8.0 - 8.0).exp();
            Vec3::new((1.0 + w.x) as f32, (1.0 + 0.5 * w.y) as f32, sun as f32)
        })
    }

    #[test]
    fn light_comes_from_the_same_directions_there_and_back() {
        let polar = polar();
        let square = to_equal_area(&polar);
        let back = to_polar(&square);
        for (w, _) in [(DVec3::X, 0), (DVec3::NEG_Y, 0), (DVec3::new(0.6, 0.48, 0.64), 0), (DVec3::new(-0.6, 0.0, -0.8), 0)] {
            let uv = equal_area_sphere_to_square(w.as_vec3()) * square.width as f32;
            let there = square.texel((uv.x as usize).min(square.width - 1), (uv.y as usize).min(square.width - 1));
            let (a, c) = (look_polar(&polar, w), look_polar(&back, w));
            assert!((a - there).abs().max_element() < 0.06 && (a - c).abs().max_element() < 0.06, "{w}: {a} {there} {c}");
        }
        // ∫ L dw: the mean of even texels.
        let mean = square.mean();
        assert!((mean.x - 1.0).abs() < 2e-3 && (mean.y - 1.0).abs() < 2e-3, "{mean}");
    }

    #[test]
    fn an_even_sky_gives_pi() {
        let square = Pixels::make(256, 256, |_, _| Vec3::ONE);
        assert!((illuminance(&square) - PI).abs() < 2e-3, "{}", illuminance(&square));
    }
}

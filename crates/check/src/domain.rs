//! The sets that samplers draw from, each laid out on the unit square so that one chi-square test serves all.
//!
//! A domain maps points to (s, t) in [0, 1]² and back; with the way back comes the factor |∂point/∂(s, t)| that turns a density in the
//! domain's own measure into one on the square.

use crate::quadrature::spherical;
use glam::{Vec2, Vec3};
use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::fmt::Debug;

/// A set with a measure, laid out on the unit square.
pub trait Domain {
    /// What samplers of this domain return.
    type Point: Copy + Debug;

    /// Where the point lies on the square; `None` outside the domain (or not a number).
    fn square_of(&self, p: Self::Point) -> Option<[f64; 2]>;

    /// The point at (s, t), and the measure per unit of the square there.
    fn point_at(&self, s: f64, t: f64) -> (Self::Point, f64);

    /// How many cells the square starts with, in s and in t.
    fn grid(&self) -> [usize; 2] {
        [12, 12]
    }

    /// How a cell with many points in it is divided: into four quarters, or into two halves in s.
    fn divide(&self, cell: &Rect) -> Vec<Rect> {
        cell.quarters().to_vec()
    }
}

fn within(s: f64, t: f64) -> Option<[f64; 2]> {
    ((0.0..=1.0).contains(&s) && (0.0..=1.0).contains(&t)).then_some([s, t])
}

/// [a, b] with the measure of length.
#[derive(Clone, Copy, Debug)]
pub struct Interval(pub f32, pub f32);

impl Domain for Interval {
    type Point = f32;

    fn square_of(&self, p: f32) -> Option<[f64; 2]> {
        let (a, b) = (f64::from(self.0), f64::from(self.1));
        within((f64::from(p) - a) / (b - a), 0.5)
    }

    fn point_at(&self, s: f64, _: f64) -> (f32, f64) {
        let (a, b) = (f64::from(self.0), f64::from(self.1));
        ((a + s * (b - a)) as f32, b - a)
    }

    fn grid(&self) -> [usize; 2] {
        [128, 1]
    }

    fn divide(&self, cell: &Rect) -> Vec<Rect> {
        cell.grid(2, 1).collect()
    }
}

/// The unit square with the measure of area.
#[derive(Clone, Copy, Debug)]
pub struct Square;

impl Domain for Square {
    type Point = Vec2;

    fn square_of(&self, p: Vec2) -> Option<[f64; 2]> {
        within(f64::from(p.x), f64::from(p.y))
    }

    fn point_at(&self, s: f64, t: f64) -> (Vec2, f64) {
        (Vec2::new(s as f32, t as f32), 1.0)
    }
}

/// The unit disk around the origin with the measure of area; s = r, t = φ/2π.
#[derive(Clone, Copy, Debug)]
pub struct Disk;

impl Domain for Disk {
    type Point = Vec2;

    fn square_of(&self, p: Vec2) -> Option<[f64; 2]> {
        let (x, y) = (f64::from(p.x), f64::from(p.y));
        let r = x.hypot(y);
        // The border belongs to the disk, and f32 rounds to either side of it.
        if r > 1.0 + 1e-6 {
            return None;
        }
        within(r.min(1.0), y.atan2(x).rem_euclid(TAU) / TAU)
    }

    fn point_at(&self, s: f64, t: f64) -> (Vec2, f64) {
        let (sin, cos) = (TAU * t).sin_cos();
        (Vec2::new((s * cos) as f32, (s * sin) as f32), s * TAU)
    }
}

/// Barycentric coordinates (b₀, b₁) ≥ 0, b₀ + b₁ ≤ 1, with the measure of area in that plane: the uniform density is 2.
#[derive(Clone, Copy, Debug)]
pub struct Triangle;

impl Domain for Triangle {
    type Point = Vec2;

    fn square_of(&self, p: Vec2) -> Option<[f64; 2]> {
        let (x, y) = (f64::from(p.x), f64::from(p.y));
        let sum = x + y;
        if x.is_nan() || y.is_nan() || x < 0.0 || y < 0.0 || sum > 1.0 + 1e-6 {
            return None;
        }
        within(sum.min(1.0), if sum > 0.0 { y / sum } else { 0.0 })
    }

    fn point_at(&self, s: f64, t: f64) -> (Vec2, f64) {
        (Vec2::new((s * (1.0 - t)) as f32, (s * t) as f32), s)
    }
}

/// Unit vectors with the measure of solid angle; s = θ/π, t = φ/2π. θ and not cosθ, so that lobes at the poles are resolved in f32.
#[derive(Clone, Copy, Debug)]
pub struct Sphere;

impl Domain for Sphere {
    type Point = Vec3;

    fn square_of(&self, w: Vec3) -> Option<[f64; 2]> {
        angles(w).and_then(|[theta, phi]| within(theta / PI, phi / TAU))
    }

    fn point_at(&self, s: f64, t: f64) -> (Vec3, f64) {
        let theta = PI * s;
        (spherical(theta, TAU * t).as_vec3(), theta.sin() * PI * TAU)
    }

    fn grid(&self) -> [usize; 2] {
        [12, 16]
    }
}

/// Unit vectors with z ≥ 0 and the measure of solid angle; s = 2θ/π, t = φ/2π.
#[derive(Clone, Copy, Debug)]
pub struct Hemisphere;

impl Domain for Hemisphere {
    type Point = Vec3;

    fn square_of(&self, w: Vec3) -> Option<[f64; 2]> {
        angles(w).and_then(|[theta, phi]| within(theta / FRAC_PI_2, phi / TAU))
    }

    fn point_at(&self, s: f64, t: f64) -> (Vec3, f64) {
        let theta = FRAC_PI_2 * s;
        (spherical(theta, TAU * t).as_vec3(), theta.sin() * FRAC_PI_2 * TAU)
    }
}

/// θ and φ of a direction; `None` unless it has unit length to 1e-3.
fn angles(w: Vec3) -> Option<[f64; 2]> {
    let w = w.as_dvec3();
    ((w.length_squared() - 1.0).abs() < 2e-3).then(|| [w.x.hypot(w.y).atan2(w.z), w.y.atan2(w.x).rem_euclid(TAU)])
}

/// A rectangle of the unit square.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rect {
    /// Smallest s and t.
    pub min: [f64; 2],
    /// Largest s and t.
    pub max: [f64; 2],
}

impl Rect {
    pub(crate) fn size(&self) -> [f64; 2] {
        [self.max[0] - self.min[0], self.max[1] - self.min[1]]
    }

    /// The middle.
    pub fn center(&self) -> [f64; 2] {
        [0.5 * (self.min[0] + self.max[0]), 0.5 * (self.min[1] + self.max[1])]
    }

    pub(crate) fn quarters(&self) -> [Self; 4] {
        let [cs, ct] = self.center();
        let ([s0, t0], [s1, t1]) = (self.min, self.max);
        [
            Self { min: [s0, t0], max: [cs, ct] },
            Self { min: [cs, t0], max: [s1, ct] },
            Self { min: [s0, ct], max: [cs, t1] },
            Self { min: [cs, ct], max: [s1, t1] },
        ]
    }

    /// `n` × `m` equal cells, s running fastest.
    pub(crate) fn grid(self, n: usize, m: usize) -> impl Iterator<Item = Self> {
        let [ds, dt] = self.size();
        let at = move |i: usize, j: usize| [self.min[0] + ds * i as f64 / n as f64, self.min[1] + dt * j as f64 / m as f64];
        (0..m).flat_map(move |j| (0..n).map(move |i| Self { min: at(i, j), max: at(i + 1, j + 1) }))
    }
}

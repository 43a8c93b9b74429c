//! What a point of primary sample space stands for: a length, a strategy, and the paths that this strategy finds with these numbers.
//!
//! ```text
//! h(u) = (n + 1) / P(n) · w_{s,t} C_{s,t},    s = ⌊ξ (n + 1)⌋ of 0 … n,  t = n + 1 - s        n edges, n + 1 vertices
//! ```
//!
//! C is in the measure of splats: light that falls on the film somewhere, of which each pixel gets its own. What a path of the eye (t ≥ 2) brings counts for
//! all pixels from which its place was drawn.

use super::lengths::{Length, lengths};
use crate::bidirectional::{Bidirectional, Paths, Strategies};
use crate::drivers::pixels::eye_walk;
use crate::run::Run;
use crate::transport::{PathRules, slot};
use etendue_film::Splat;
use etendue_numerics::{Dim, Numbers, Primary, Spectrum, Vec2};
use etendue_scene::Scene;
use serde::{Deserialize, Serialize};

/// A point of primary sample space, of a class of paths.
#[derive(Clone, Copy, Debug)]
pub struct Point<'a> {
    /// The class.
    pub length: Length,
    /// The numbers.
    pub u: Primary<'a>,
}

/// What was found at a point.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Measured {
    /// Where on the film in pixels from the crop's corner, and how much: linear Rec.709.
    pub light: Vec<([f32; 2], [f32; 3])>,
    /// f: the mean of the channels, of all light.
    pub f: f32,
}

impl Measured {
    fn clear(&mut self) {
        self.light.clear();
        self.f = 0.0;
    }
}

/// What evaluations keep for its memory.
#[derive(Clone, Debug, Default)]
pub struct Scratch<'a> {
    paths: Paths<'a>,
    /// Light that was not finite.
    pub broken: Vec<Splat>,
}

impl Scratch<'_> {
    /// Rays cast since the last time.
    pub fn take_rays(&mut self) -> u64 {
        std::mem::take(&mut self.paths.rays)
    }
}

/// Primary sample space over a scene.
pub struct Space<'a> {
    strategies: Strategies<'a>,
    view: usize,
    lengths: Vec<Length>,
    corner: Vec2,
    size: Vec2,
}

impl<'a> Space<'a> {
    /// That of the run's view, where `rules` say which paths count.
    pub fn new(scene: &'a Scene, run: &Run<'_>, rules: PathRules) -> Self {
        let mut strategies = Bidirectional::default().strategies(scene, run);
        strategies.c.rules = rules;
        let film = &strategies.view.film;
        let [corner, size] = [film.crop_offset, film.crop_size].map(|[x, y]| Vec2::new(x as f32, y as f32));
        Self { view: run.view, lengths: lengths(&rules, scene), corner, size, strategies }
    }

    /// The classes of paths, each with its number of vertices.
    pub fn lengths(&self) -> Vec<(Length, u32)> {
        self.lengths.iter().map(|l| (*l, l.vertices(self.strategies.c.scene))).collect()
    }

    /// h and f at a point.
    pub fn measure(&self, at: &Point<'_>, out: &mut Measured, scratch: &mut Scratch<'a>) {
        out.clear();
        let choice = at.u.u2(Dim::at(0, slot::STRATEGY));
        let (n, p) = at.length.choose(choice.x);
        if n > self.strategies.c.rules.max_edges {
            return;
        }
        let count = (n + 1) as f32;
        let s = ((choice.y * count) as u32).min(n);
        let scale = count / p;

        let place = (at.u.u2(Dim::at(0, slot::PIXEL)) * self.size).min(Vec2::new(self.size.x.next_down(), self.size.y.next_down()));
        let wl = self.strategies.c.scene.wavelengths(|| at.u.u1(Dim::at(0, slot::WAVELENGTHS)));
        let strategies = Strategies { wl, ..self.strategies };
        let eye = || eye_walk(&strategies.c, self.view, self.corner + place, &at.u);
        let pixels = self.size.x * self.size.y;
        let Scratch { paths, broken } = scratch;
        strategies.one((s, n + 1 - s), eye, &at.u, paths, &mut |found| {
            let value = wl.to_rgb(found.value * (found.weight * scale));
            let (position, value) = found.pixel.map_or((place, value * pixels), |p| (p - self.corner, value));
            let f = target(value);
            if !f.is_finite() {
                broken.push(Splat { position, value, particle: 0 });
            } else if f > 0.0 {
                out.light.push((position.into(), value.to_rgb()));
                out.f += f;
            }
        });
    }
}

/// f of a contribution.
#[inline]
fn target(value: Spectrum) -> f32 {
    value.to_rgb().iter().sum::<f32>() / 3.0
}

//! One strategy alone: only the walks that it needs, only as far as it needs them.
//!
//! ```text
//! Σ_{s,t} one(s, t; u) = sample(u)        for the same numbers u, where roulette is off
//! ```
//!
//! What passes a null or mask surface keeps its number of vertices: a strategy may then find several paths.

use super::{Found, LightPath, PathVertex, Paths, Strategies};
use crate::transport::PathState;
use etendue_numerics::Numbers;

impl<'a> Strategies<'a> {
    /// The paths of s vertices from a light and t from the eye, t ≥ 1; `found` is told each one that carries light. `eye` is asked for the camera's ray
    /// where one is needed; its wavelengths are those of the strategies.
    pub fn one(
        &self,
        (s, t): (u32, u32),
        eye: impl FnOnce() -> PathState,
        u: &impl Numbers,
        paths: &mut Paths<'a>,
        found: &mut impl FnMut(&Found<'_>),
    ) {
        let Paths { eye: vertices, light, rays } = paths;
        // The light sampler draws z_0 of s = 1 by itself.
        if s >= 2 || (s, t) == (1, 1) {
            light.trace_up_to(s, self, u, rays);
            if s >= 2 && light.vertices.last().is_none_or(|z| z.count != s) {
                return;
            }
        }
        if t == 1 {
            self.seen_by_lens(s, light, u, rays, found);
            return;
        }

        vertices.clear();
        let mut walk = self.walk_from(eye());
        while walk.count < t {
            let is_last = walk.count + 1 == t;
            let Some(x) = walk.meet(rays) else {
                if let Some(f) = self.escape(&walk).filter(|_| s == 0 && is_last) {
                    found(&f);
                }
                return;
            };
            if s == 0
                && is_last
                && let Some(f) = self.hit(&walk, &x)
            {
                found(&f);
            }
            let nothing_behind = s == 0 && is_last && !self.c.scene.has_transparent;
            if nothing_behind || self.c.ends(&walk.state) {
                return;
            }

            let place = vertices.len();
            vertices.push(walk.vertex(x));
            let y = &vertices[place];
            if is_last && s > 0 && y.vertex.is_smooth() {
                self.lit_by(s, y, light, u, rays, found);
            }
            let ends_here = is_last && !y.may_be_passed();
            if ends_here || !walk.turn(&mut vertices[place], place as u32, u) {
                return;
            }
        }
    }

    /// t = 1.
    fn seen_by_lens(&self, s: u32, light: &LightPath, u: &impl Numbers, rays: &mut u64, found: &mut impl FnMut(&Found<'_>)) {
        if s == 1
            && let Some(f) = self.emitter(light, u, rays)
        {
            found(&f);
        }
        for z in light.vertices.iter().filter(|z| z.count == s && z.vertex.is_smooth()) {
            if let Some(f) = self.lens(z, u, rays) {
                found(&f);
            }
        }
    }

    /// s ≥ 1, t ≥ 2: y looks for light.
    fn lit_by(
        &self,
        s: u32,
        y: &PathVertex,
        light: &LightPath,
        u: &impl Numbers,
        rays: &mut u64,
        found: &mut impl FnMut(&Found<'_>),
    ) {
        if s == 1 {
            self.next_event(y, u, rays, found);
            return;
        }
        for z in light.vertices.iter().filter(|z| z.count == s && z.vertex.is_smooth()) {
            if let Some(f) = self.inner(y, z, u, rays) {
                found(&f);
            }
        }
    }
}

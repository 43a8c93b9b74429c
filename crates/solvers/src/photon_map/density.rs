//! Density estimation: the light that photons bring to a point, from those that landed around it.
//!
//! ```text
//! L(x, wo) ≈ 1/N Σ_p f(wi_p, x, wo) |wi·ns|/|wi·n| Φ_p K(|x_p - x|) A(x, x_p) / P(x)
//! K(d)     = 2/(π r²) (1 - d²/r²)                                          [Epanechnikov 1969]
//! P(x)     = ∫ K(|y - x|) A(x, y) dA(y)
//! ```
//!
//! A is 1 where the surface at y is a piece of that at x: it faces the same way, lies in the same plane but for r/8, and is in sight of x from r/8 above.
//! Photons on the far side of a corner or of a wall do not count. Where the surface ends within r, at corners and beside whatever stands on it, P < 1
//! makes up for what is missing: irradiance that is constant is found as it is, however large r. On large smooth surfaces P = 1.
//!
//! 1/P is the mean number of trials until one succeeds, each of which draws a y in proportion to K and looks whether A = 1 there, the way in which
//! [Qin et al. 2015] found reciprocals. To test sight for every photon would cost as many rays; one is picked in proportion to what it brings, and what it
//! stands for is taken off if it is out of sight: S - (1 - V_p) s_p / P(p) has the mean Σ V_p s_p.

use super::PhotonMap;
use super::photons::{Photon, Photons};
use crate::transport::{Context, PathState, Vertex, slot};
use etendue_numerics::math::PI;
use etendue_numerics::sequence::{mix, unit};
use etendue_numerics::warp::square_to_disk;
use etendue_numerics::{Frame, Ray, Sampler, Spectrum, Vec2, Vec3};
use etendue_scene::Interaction;

/// cos of the angle between normals of one surface, at least: 45°.
const ALIKE: f32 = 0.7;
/// How far from the tangent plane the surface may be, and from what height it is looked at, over r.
const HEIGHT: f32 = 0.125;
/// Trials at most: what is left of a surface of which one in so many succeeds is too small to be seen.
const TRIALS: u32 = 64;

/// The surface around a point.
#[derive(Clone, Copy)]
pub(super) struct Around<'a> {
    c: &'a Context<'a>,
    x: &'a Interaction,
    /// Unit geometric normal on the side that the eye sees.
    pub(super) n: Vec3,
    r: f32,
}

impl<'a> Around<'a> {
    /// The surface within r of x.
    #[inline]
    pub(super) fn new(c: &'a Context<'a>, x: &'a Interaction, r: f32) -> Self {
        Self { c, x, n: if x.n.dot(x.wo) < 0.0 { -x.n } else { x.n }, r }
    }

    /// Whether y with the normal `n` is a piece of this surface, as far as can be told without a ray.
    #[inline]
    pub(super) fn continues_at(&self, y: Vec3, n: Vec3) -> bool {
        self.x.n.dot(n) > ALIKE && self.n.dot(y - self.x.p).abs() <= HEIGHT * self.r
    }

    /// Whether y is in sight, both seen from above the surface.
    pub(super) fn sees(&self, y: Vec3) -> bool {
        let rise = self.n * (HEIGHT * self.r);
        let d = y - self.x.p;
        let distance = d.length();
        // Within the roundings of a point nothing can be in between.
        if distance <= 1e-3 * self.r {
            return true;
        }
        let ray = Ray { time: self.x.time, ..Ray::new(self.x.p + rise, d / distance).until(distance) };
        !self.c.scene.accel.occluded(&ray, &self.c.scene.surfaces)
    }

    /// Whether the surface is there, in sight, in the direction `q` of the tangent plane.
    pub(super) fn is_there(&self, q: Vec3, rays: &mut u64) -> bool {
        let rise = HEIGHT * self.r;
        let down = Ray { time: self.x.time, ..Ray::new(self.x.p + q + self.n * rise, -self.n).until(2.0 * rise) };
        *rays += 1;
        let Some(hit) = self.c.scene.intersect(&down) else { return false };
        let y = self.c.scene.interaction(&down, &hit);
        if !self.continues_at(y.p, y.n) {
            return false;
        }
        *rays += 1;
        self.sees(y.p)
    }

    /// Trials until one succeeds: 1/P on average.
    fn trials(&self, u: Vec2, rays: &mut u64) -> u32 {
        let frame = Frame::from_normal(self.n);
        let key = u64::from(u.x.to_bits()) << 32 | u64::from(u.y.to_bits());
        let trial = |i: u32| {
            let bits = mix(key ^ mix(u64::from(i)));
            let u = if i == 1 { u } else { Vec2::new(unit(bits as u32), unit((bits >> 32) as u32)) };
            // Uniform over the disc, then inwards: the distance has the density K.
            let d = square_to_disk(u);
            let s = d.length_squared();
            let inwards = ((1.0 - (1.0 - s).max(0.0).sqrt()) / s.max(1e-12)).sqrt();
            (frame.s * d.x + frame.t * d.y) * (self.r * inwards)
        };
        (1..TRIALS).find(|i| self.is_there(trial(*i), rays)).unwrap_or(TRIALS)
    }
}

/// One of several, picked in proportion to their weights, with a single number.
struct Pick {
    u: f64,
    total: f64,
    /// Place, value and weight.
    picked: Option<(usize, Spectrum, f64)>,
}

impl Pick {
    fn offer(&mut self, place: usize, value: Spectrum) {
        let weight = f64::from(value.max_lane());
        self.total += weight;
        let share = weight / self.total;
        // What is left of the number is stretched: it decides again.
        if self.u < share {
            self.u /= share;
            self.picked = Some((place, value, weight));
        } else {
            self.u = (self.u - share) / (1.0 - share).max(1e-300);
        }
    }
}

impl PhotonMap {
    /// What the photons around `vertex` bring along the last edge of a walk from the eye.
    pub(super) fn gather(
        &self,
        c: &Context<'_>,
        map: &Photons,
        state: &PathState,
        vertex: &Vertex,
        u: &Sampler,
        rays: &mut u64,
    ) -> Spectrum {
        let (x, r) = (&vertex.x, map.index.radius());
        let around = Around::new(c, x, r);
        let mut pick = Pick { u: f64::from(u.u1(state.dim(slot::PHOTON))), total: 0.0, picked: None };
        let mut sum = Spectrum::ZERO;
        map.index.near(x.p, |place, d2| {
            let photon = &map.photons[place];
            if !around.continues_at(map.index.point(place), photon.n) || !c.rules.counts(state.edges + photon.edges) {
                return;
            }
            // Where both go on with one wavelength each has made up for the others: once is enough.
            let once = if photon.is_alone && state.wl.is_alone() { 0.25 } else { 1.0 };
            let value = self.brings(vertex, photon) * (once * (1.0 - d2 / (r * r)));
            if !value.is_zero() {
                sum += value;
                pick.offer(place, value);
            }
        });
        let Some((place, value, weight)) = pick.picked else { return Spectrum::ZERO };
        *rays += 1;
        if !around.sees(map.index.point(place)) {
            sum += value * -((pick.total / weight) as f32);
        }
        let trials = around.trials(u.u2(state.dim(slot::PROBE)), rays);
        sum * (trials as f32 * 2.0 / (PI * r * r * map.shot as f32))
    }

    /// f |wi·ns| / |wi·n| Φ: nothing along directions that the eye's walk takes itself.
    #[inline]
    pub(super) fn brings(&self, vertex: &Vertex, photon: &Photon) -> Spectrum {
        let cos = vertex.x.n.dot(photon.wi).abs();
        let (f_cos, pdf) = vertex.eval(photon.wi);
        if f_cos.is_zero() || cos == 0.0 || pdf >= self.gloss && !photon.unseen {
            return Spectrum::ZERO;
        }
        photon.flux * f_cos / cos
    }
}

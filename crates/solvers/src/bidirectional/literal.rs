//! The weights word for word: all densities of all vertices of a whole path, one strategy after the other, in f64.
//!
//! ```text
//! w_s = (n_s p_s)^β / Σ_i (n_i p_i)^β,    p_s = Π_{i<s} p⃗(z_i) · Π_{i≥s} p⃖(z_i)
//! ```
//!
//! It knows nothing of how the path was found: slow, and the judge of [`super::weights`].

use super::connect::{Found, Joint, Strategies};
use super::light_path::{Finders, LightPath, Origin, Place, emitting_point, surroundings_density};
use super::path_vertex::PathVertex;
use crate::transport::{Heuristic, Vertex};
use etendue_bsdf::Scatter;
use etendue_numerics::{Pdf, Vec3, Wavelengths};
use etendue_scene::{EmitterId, Interaction};

/// z_0.
#[derive(Clone, Copy, Debug)]
enum Source {
    /// A point of an emitting surface.
    Surface(Interaction, Finders),
    /// A point.
    Point(EmitterId, Vec3),
    /// A single direction in which light travels.
    Direction(EmitterId, Vec3),
    /// A direction in which light of the surroundings travels.
    Surroundings(Vec3),
}

/// A path from a light to the lens.
#[derive(Clone, Debug)]
pub struct Whole {
    source: Source,
    /// z_1 … z_{k-1}, each with whether it scatters into a discrete direction.
    points: Vec<(Interaction, bool)>,
    /// The camera's unit direction towards the last of them.
    from_lens: Vec3,
}

/// A walk's vertices up to one that is joined to the other's, from its start.
fn chain(walk: &[PathVertex], last: Option<u32>, end: Option<&PathVertex>) -> Vec<(Interaction, bool)> {
    let mut points: Vec<_> = end.map(|v| (v.vertex.x, false)).into_iter().collect();
    let mut next = end.map_or(last, |v| v.parent);
    while let Some(v) = next.and_then(|i| walk.get(i as usize)) {
        // The last vertex of an eye path that hit a light has turned already.
        points.push((v.vertex.x, v.is_dirac));
        next = v.parent;
    }
    points.reverse();
    points
}

impl Source {
    fn of(origin: &Origin) -> Self {
        match &origin.place {
            Place::Surface(x, finders) => Self::Surface(*x, *finders),
            Place::Point => Self::Point(origin.emitter, origin.ray.o),
            Place::Direction => Self::Direction(origin.emitter, origin.ray.d),
            Place::Surroundings => Self::Surroundings(origin.ray.d),
        }
    }

    /// Where its light comes from, as seen from `p`.
    fn seen_from(&self, p: Vec3) -> Vec3 {
        match self {
            Self::Surface(x, _) => (x.p - p).normalize(),
            Self::Point(_, q) => (*q - p).normalize(),
            Self::Direction(_, w) | Self::Surroundings(w) => -*w,
        }
    }
}

impl Whole {
    /// The path that a strategy found, with the two walks that it is made of. `None` where they do not belong together.
    pub fn of(all: &Strategies<'_>, found: &Found<'_>, light: &LightPath, eye: &[PathVertex]) -> Option<Self> {
        let origin = || light.origin.as_ref().map(Source::of);
        let (source, from_light, mut from_eye, lens) = match found.joint {
            Joint::Hit(last, x) => (Source::Surface(*x, Finders::SamplesAndHits), vec![], chain(eye, last, None), -x.wo),
            Joint::Escape(last, w) => (Source::Surroundings(-w), vec![], chain(eye, last, None), w),
            Joint::Light(y, sample) => {
                let at = emitting_point(all.c.scene, sample.emitter, sample.primitive, sample.p, sample.n, -sample.wi);
                let source = match (at, sample.pdf) {
                    (Some(x), _) => Source::Surface(x, Finders::of(all.c.scene, &x)),
                    (None, Pdf::SolidAngle(_)) => Source::Surroundings(-sample.wi),
                    (None, Pdf::Delta(_)) if sample.distance.is_finite() => Source::Point(sample.emitter, sample.p),
                    (None, Pdf::Delta(_)) => Source::Direction(sample.emitter, -sample.wi),
                };
                (source, vec![], chain(eye, None, Some(y)), Vec3::ZERO)
            }
            Joint::Inner(y, z) => (origin()?, chain(&light.vertices, None, Some(z)), chain(eye, None, Some(y)), Vec3::ZERO),
            Joint::Lens(z, w) => (origin()?, chain(&light.vertices, None, Some(z)), vec![], -w),
            Joint::Emitter(origin, w) => (Source::of(origin), vec![], vec![], -w),
        };
        let from_lens = from_eye.first().map_or(lens, |(y, _)| -y.wo);
        from_eye.reverse();
        Some(Self { source, points: [from_light, from_eye].concat(), from_lens })
    }

    /// w_s for all s, from 0 to the number of vertices less one.
    pub fn weights(&self, all: &Strategies<'_>) -> Vec<f64> {
        let k = self.points.len() + 1;
        let from_light: Vec<f64> = (0..k).map(|i| self.light_density(all, i)).collect();
        let from_eye: Vec<f64> = (0..k).map(|i| self.eye_density(all, i)).collect();
        let beta = if all.heuristic == Heuristic::Balance { 1.0 } else { 2.0 };
        let logs: Vec<f64> = (0..=k)
            .map(|s| {
                let mut density: f64 = from_light[..s].iter().map(|p| p.ln()).sum::<f64>();
                density += from_eye[s..].iter().map(|p| p.ln()).sum::<f64>();
                if s == 1 && k > 1 {
                    density += self.next_event(all).ln() - from_light[0].ln();
                }
                if s == k {
                    density += f64::from(all.eye.rho).ln();
                }
                if self.can_join(s) { beta * density } else { f64::NEG_INFINITY }
            })
            .collect();
        let most = logs.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let shares: Vec<f64> = logs.iter().map(|l| (l - most).exp()).collect();
        let sum: f64 = shares.iter().sum();
        shares.iter().map(|x| x / sum).collect()
    }

    /// Whether s vertices from the light's side and the rest from the eye's make this path.
    fn can_join(&self, s: usize) -> bool {
        let k = self.points.len() + 1;
        let dirac = |i: usize| i >= 1 && i < k && self.points[i - 1].1;
        let single = matches!(self.source, Source::Surface(_, Finders::Nobody));
        match s {
            0 => matches!(self.source, Source::Surface(_, Finders::SamplesAndHits) | Source::Surroundings(_)),
            // The eye sees lamps by itself.
            1 if k == 1 => false,
            1 => !single && !dirac(1),
            _ => !dirac(s - 1) && !dirac(s),
        }
    }

    fn point(&self, i: usize) -> &Interaction {
        &self.points[i - 1].0
    }

    /// Unit direction from z_i towards the eye.
    fn eyewards(&self, i: usize) -> Vec3 {
        if i + 1 > self.points.len() { -self.from_lens } else { (self.point(i + 1).p - self.point(i).p).normalize() }
    }

    /// Unit direction from z_i towards the light.
    fn lightwards(&self, i: usize) -> Vec3 {
        if i == 1 { self.source.seen_from(self.point(1).p) } else { (self.point(i - 1).p - self.point(i).p).normalize() }
    }

    /// |cosθ| at z_i over the distance squared of z_j, for directions along `w`; no distance to what is infinitely far away.
    fn geometry(&self, i: usize, j: usize, w: Vec3) -> f64 {
        let place = |i: usize| match (i, &self.source) {
            (0, Source::Surface(x, _)) => Some((x.p, x.n)),
            (0, Source::Point(_, p)) => Some((*p, Vec3::ZERO)),
            (0, _) => None,
            _ => Some((self.point(i).p, self.point(i).n)),
        };
        match (place(i), place(j)) {
            (Some((a, n)), Some((b, _))) => f64::from(n.dot(w).abs()) / f64::from(a.distance_squared(b)),
            (Some((_, n)), None) => f64::from(n.dot(w).abs()),
            (None, _) => 1.0,
        }
    }

    /// The density with which a walk that came along `from` leaves z_i along `to`, both unit vectors that leave z_i.
    fn turn(&self, all: &Strategies<'_>, i: usize, from: Vec3, to: Vec3) -> f64 {
        let (x, is_dirac) = &self.points[i - 1];
        if *is_dirac {
            return f64::from(x.shading.n.dot(to).abs());
        }
        let vertex = Vertex::new(all.c.scene, Interaction { wo: from, ..*x }, &Wavelengths::Rgb);
        f64::from(vertex.bsdf.pdf(vertex.wo, x.shading.to_local(to)))
    }

    /// p⃖(z_i).
    fn eye_density(&self, all: &Strategies<'_>, i: usize) -> f64 {
        let last = self.points.len();
        let seen = |x: &Interaction| f64::from(all.eye.density(x.p, x.n, self.from_lens));
        if i == last {
            return match (&self.source, last) {
                (_, 1..) => seen(self.point(i)),
                (Source::Surface(x, _), 0) => seen(x),
                // The surroundings are found by the eye alone.
                _ => 1.0,
            };
        }
        let w = self.lightwards(i + 1);
        self.turn(all, i + 1, self.eyewards(i + 1), w) * self.geometry(i, i + 1, w)
    }

    /// p⃗(z_i), of light that was emitted.
    fn light_density(&self, all: &Strategies<'_>, i: usize) -> f64 {
        let scene = all.c.scene;
        if i >= 2 {
            let w = self.eyewards(i - 1);
            return self.turn(all, i - 1, self.lightwards(i - 1), w) * self.geometry(i, i - 1, w);
        }
        let w = if self.points.is_empty() { -self.from_lens } else { -self.lightwards(1) };
        let (position, direction) = match &self.source {
            Source::Surface(x, _) => {
                let pdf = scene.lights.pdf_emission(scene, &Interaction { wo: w, ..*x });
                (pdf.position.value(), pdf.direction.value())
            }
            Source::Point(emitter, _) | Source::Direction(emitter, _) => {
                let pdf = scene.lights.pdf_emission_discrete(scene, *emitter, w);
                (pdf.position.value(), pdf.direction.value())
            }
            Source::Surroundings(_) => (surroundings_density(scene, -w), 1.0),
        };
        if i == 0 { f64::from(position) } else { f64::from(direction) * self.geometry(1, 0, w) }
    }

    /// p_N(z_0), by the light sampler at z_1.
    fn next_event(&self, all: &Strategies<'_>) -> f64 {
        let scene = all.c.scene;
        let from = Vertex::new(scene, Interaction { wo: self.eyewards(1), ..*self.point(1) }, &Wavelengths::Rgb).light_reference();
        f64::from(match &self.source {
            Source::Surface(x, _) => scene.pdf_light(&from, x) * self.geometry(0, 1, self.lightwards(1)) as f32,
            Source::Point(emitter, _) | Source::Direction(emitter, _) => scene.lights.probability(&from, *emitter),
            Source::Surroundings(w) => scene.pdf_light_escaped(&from, -*w),
        })
    }
}

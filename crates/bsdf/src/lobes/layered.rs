//! A ground under a scattering layer with a dielectric boundary, by random walks [Guo, Hašan, Zhao 2018; Pharr, Jakob, Humphreys 2023, §14.3].
//!
//! ```text
//! f(wo, wi) = f_boundary(wo, wi) + E[walks that enter along wo, meet ground and layer, and leave along wi]/η²
//! ```
//!
//! `eval` is an unbiased estimate, the same for the same bits of `wo` and `wi`: they seed the walk. At each event on the ground or in the layer the walk is
//! joined to a direction that light from `wi` takes behind the boundary; where the boundary is rough, also along the direction that the event
//! sends it to, weighed by the power heuristic [Veach 1997, §9.2.4]. A walk has `max_depth` events at the most.
//!
//! `pdf` is exact for what `sample` does, which does not walk: it reflects at the boundary, at a proxy of the ground (its facets, tilted as
//! refraction shows them), or by the cosine.
//!
//! | symbol | identifier |
//! | --- | --- |
//! | a direction of travel within the layer, z > 0 upwards | `d` |
//! | what a walk still carries | `beta` |
//! | the height above the ground, in optical thickness | `z` |

use super::rough_conductor::{half_vector, reflected_pdf};
use super::rough_dielectric::Facet;
use crate::{
    BsdfSample, Event, Microfacets, Ndf, Scatter,
    fresnel::{self, reflect, reflect_z, refract},
    local::{clean, clean_eta, clean_f32, cosine_pdf, cosine_sample, dirac, smooth, whole_dirac},
};
use etendue_numerics::{
    Spectrum, Vec2, Vec3,
    math::{FRAC_1_PI, PI, TAU, exp, ln, safe_sqrt, sin_cos, sqr},
    sequence::{mix, unit},
};

/// What lies under the layer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Ground {
    /// Lambert's, of this reflectance.
    Diffuse(Spectrum),
    /// A metal: η, k and the roughness of its facets along x and y, or a mirror.
    Metal(Spectrum, Spectrum, Option<[f32; 2]>),
}

/// What a [`Layered`] is made of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LayeredParams {
    /// The ground; default diffuse 0.5.
    pub ground: Ground,
    /// η, the layer's index over the outside's; default 1.5.
    pub eta: f32,
    /// Roughness of the boundary along x and y, in [1e-4, 1]; `None`, the default, is smooth.
    pub alpha: Option<[f32; 2]>,
    /// Optical thickness of the layer; default 0.01.
    pub thickness: f32,
    /// The share of light that the layer's particles scatter; default 0.
    pub albedo: Spectrum,
    /// Henyey and Greenstein's g of the particles; default 0.
    pub g: f32,
    /// Events of a walk at the most; default 10.
    pub max_depth: u32,
    /// Walks of an estimate; default 1.
    pub samples: u32,
}

impl Default for LayeredParams {
    fn default() -> Self {
        Self {
            ground: Ground::Diffuse(Spectrum::splat(0.5)),
            eta: 1.5,
            alpha: None,
            thickness: 0.01,
            albedo: Spectrum::ZERO,
            g: 0.0,
            max_depth: 10,
            samples: 1,
        }
    }
}

/// The ground as walks meet it.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Base {
    Diffuse(Spectrum),
    Mirror(Spectrum, Spectrum),
    Metal(Spectrum, Spectrum, Microfacets),
}

/// Lacquered metal, hazy varnish.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Layered {
    base: Base,
    facets: Option<Microfacets>,
    /// The ground's facets as they look from outside.
    proxy: Option<Microfacets>,
    eta: f32,
    thickness: f32,
    albedo: Spectrum,
    g: f32,
    max_depth: u32,
    samples: u32,
}

/// Numbers that follow from bits.
struct Numbers(u64);

impl Numbers {
    fn of(wo: Vec3, wi: Vec3) -> Self {
        let bits = [wo.x, wo.y, wo.z, wi.x, wi.y, wi.z].map(|x| u64::from(x.to_bits()));
        Self(bits.into_iter().fold(0x243f_6a88_85a3_08d3, |seed, x| mix(seed.rotate_left(17) ^ x)))
    }

    fn u1(&mut self) -> f32 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        unit((mix(self.0) >> 32) as u32)
    }

    fn u2(&mut self) -> Vec2 {
        Vec2::new(self.u1(), self.u1())
    }
}

/// Light from outside behind the boundary.
struct Entry {
    /// The direction of travel, downwards.
    d: Vec3,
    /// How much of it there is.
    weight: f32,
    /// The density of `d`, 1/sr; none behind a smooth boundary.
    pdf: Option<f32>,
}

/// w(a, b) of the power heuristic.
fn power(a: f32, b: f32) -> f32 {
    let (a, b) = (a * a, b * b);
    if a + b > 0.0 { a / (a + b) } else { 0.0 }
}

impl Layered {
    /// The lobe of these parameters.
    pub fn new(p: LayeredParams) -> Self {
        let eta = clean_eta(p.eta);
        let eta = if (eta - 1.0).abs() < 1e-4 { 1.0001 } else { eta };
        let rough = |[u, v]: [f32; 2]| Microfacets::new(Ndf::GgxCorrelated, u, v, true);
        let base = match p.ground {
            Ground::Diffuse(rho) => Base::Diffuse(clean(rho).clamp(0.0, 1.0)),
            Ground::Metal(n, k, None) => Base::Mirror(clean(n), clean(k)),
            Ground::Metal(n, k, Some(alpha)) => Base::Metal(clean(n), clean(k), rough(alpha)),
        };
        // A tilt δ of the ground looks like ηδ from outside; a rough boundary blurs twice by (η - 1) of its own tilt.
        let proxy = match p.ground {
            Ground::Diffuse(_) => None,
            Ground::Metal(_, _, alpha) => {
                let [bu, bv] = p.alpha.unwrap_or([0.0; 2]);
                let blur =
                    |ground: f32, boundary: f32| (sqr(eta * ground) + 2.0 * sqr((eta - 1.0) * boundary)).sqrt().clamp(0.01, 1.0);
                let [gu, gv] = alpha.unwrap_or([0.0; 2]);
                Some(rough([blur(gu, bu), blur(gv, bv)]))
            }
        };
        Self {
            base,
            facets: p.alpha.map(rough),
            proxy,
            eta,
            thickness: clean_f32(p.thickness, 1e-6, 1e3, 0.01),
            albedo: clean(p.albedo).clamp(0.0, 1.0),
            g: clean_f32(p.g, -0.99, 0.99, 0.0),
            max_depth: p.max_depth.clamp(1, 1000),
            samples: p.samples.clamp(1, 1000),
        }
    }

    // ---- the boundary

    /// Light along `w`, outside, enters.
    fn enter(&self, w: Vec3, u: Vec2) -> Option<Entry> {
        let m = self.facets.map_or(Vec3::Z, |facets| facets.sample(w, u));
        let x = fresnel::dielectric(w.dot(m), self.eta);
        let d = refract(w, m, &x);
        if d.z >= 0.0 || x.f >= 1.0 {
            return None;
        }
        let Some(facets) = self.facets else { return Some(Entry { d, weight: 1.0 - x.f, pdf: None }) };
        let facet = Facet::of(m, w, d, self.eta, false, x.f)?;
        let pdf = facets.pdf(w, m) * facet.jacobian;
        let weight = (1.0 - x.f) * facets.unshadowed(w, d, m);
        (pdf > 0.0).then_some(Entry { d, weight, pdf: Some(pdf) })
    }

    /// f of a rough boundary for light that enters along `w` and goes on along `d`, without the cosine, and the density with which
    /// [`Layered::enter`] finds it.
    fn entering(&self, w: Vec3, d: Vec3) -> (f32, f32) {
        let (Some(facets), Some(x)) = (self.facets, Facet::between(w, d, self.eta)) else { return (0.0, 0.0) };
        let f = (1.0 - x.f) * facets.dg(w, d, x.m) * x.cos_o * x.jacobian;
        (f, facets.pdf(w, x.m) * x.jacobian)
    }

    /// Light that travels up along `d` is sent back: its direction, and how much of it there is.
    fn send_back(&self, d: Vec3, u: Vec2) -> Option<(Vec3, f32)> {
        // Seen from within: z turned round, the index upside down.
        let up = Vec3::new(-d.x, -d.y, d.z);
        let m = self.facets.map_or(Vec3::Z, |facets| facets.sample(up, u));
        let f = fresnel::dielectric(up.dot(m), 1.0 / self.eta).f;
        let r = reflect(up, m);
        let left = self.facets.map_or(1.0, |facets| facets.unshadowed(up, r, m));
        (r.z > 0.0).then_some((Vec3::new(r.x, r.y, -r.z), f * left))
    }

    // ---- the ground

    /// f of the ground without the cosine, and the density with which [`Layered::bounce`] finds the direction; both directions leave it.
    fn ground(&self, wo: Vec3, wi: Vec3) -> (Spectrum, f32) {
        match self.base {
            Base::Diffuse(rho) if wo.z > 0.0 && wi.z > 0.0 => (rho * FRAC_1_PI, cosine_pdf(wi)),
            Base::Metal(n, k, facets) => half_vector(wo, wi).map_or((Spectrum::ZERO, 0.0), |m| {
                let f = fresnel::conductor(wo.dot(m).clamp(0.0, 1.0), n, k) * (0.25 * facets.dg(wo, wi, m));
                (f, reflected_pdf(&facets, wo, m))
            }),
            _ => (Spectrum::ZERO, 0.0),
        }
    }

    /// A direction off the ground, f cosθ / p, and p; none of a mirror.
    fn bounce(&self, wo: Vec3, u: Vec2) -> Option<(Vec3, Spectrum, Option<f32>)> {
        match self.base {
            Base::Diffuse(rho) => cosine_sample(u).map(|wi| (wi, rho, Some(cosine_pdf(wi)))),
            Base::Mirror(n, k) => Some((reflect_z(wo), fresnel::conductor(wo.z, n, k), None)),
            Base::Metal(n, k, facets) => {
                let m = facets.sample(wo, u);
                let wi = reflect(wo, m);
                if wi.z <= 0.0 {
                    return None;
                }
                let weight = fresnel::conductor(wo.dot(m).clamp(0.0, 1.0), n, k) * facets.unshadowed(wo, wi, m);
                Some((wi, weight, Some(reflected_pdf(&facets, wo, m)))).filter(|s| s.2.is_some_and(|p| p > 0.0))
            }
        }
    }

    // ---- the layer

    fn through(&self, dz: f32, d: Vec3) -> f32 {
        exp(-(dz / d.z).abs())
    }

    /// Henyey and Greenstein's phase function for light that goes on along `next`, 1/sr [Henyey, Greenstein 1941].
    fn phase(&self, d: Vec3, next: Vec3) -> f32 {
        let g = self.g;
        let denominator = (1.0 + g * g - 2.0 * g * d.dot(next)).max(1e-6);
        (1.0 - g * g) / (4.0 * PI * denominator * denominator.sqrt())
    }

    fn scatter(&self, d: Vec3, u: Vec2) -> Vec3 {
        let g = self.g;
        let cos = if g.abs() < 1e-3 {
            1.0 - 2.0 * u.x
        } else {
            (1.0 + g * g - sqr((1.0 - g * g) / (1.0 + g - 2.0 * g * u.x))) / (2.0 * g)
        };
        let cos = cos.clamp(-1.0, 1.0);
        let (sin_phi, cos_phi) = sin_cos(TAU * u.y);
        let sin = safe_sqrt(1.0 - cos * cos);
        etendue_numerics::Frame::from_normal(d).to_world(Vec3::new(sin * cos_phi, sin * sin_phi, cos)).normalize()
    }

    // ---- walks

    /// One walk's estimate of what enters along `wo` and leaves along `wi`, without 1/η².
    fn walk(&self, wo: Vec3, wi: Vec3, u: &mut Numbers) -> Option<Spectrum> {
        let exit = self.enter(wi, u.u2())?;
        let entry = self.enter(wo, u.u2())?;
        let mut sum = Spectrum::ZERO;
        let (mut d, mut beta, mut z) = (entry.d, Spectrum::splat(entry.weight), self.thickness);
        let hazy = !self.albedo.is_zero();
        // Leaves along `exit`, backwards: light travels up along -exit.d.
        let leave = |z: f32| self.through(self.thickness - z, exit.d) * exit.weight;
        // Leaves along the direction that was drawn with density `p`.
        let follow = |d: Vec3, z: f32, p: Option<f32>| {
            let (f, pdf) = self.entering(wi, -d);
            let w = p.map_or(1.0, |p| power(p, pdf));
            self.through(self.thickness - z, d) * f * w
        };
        for depth in 0..self.max_depth {
            // A walk that carries little goes on by chance.
            if depth > 3 && beta.max_lane() < 0.25 {
                let q = beta.max_lane();
                if u.u1() >= q {
                    break;
                }
                beta *= 1.0 / q;
            }
            if hazy {
                let next = z - ln(1.0 - u.u1()) * d.z;
                if next > 0.0 && next < self.thickness {
                    z = next;
                    beta *= self.albedo;
                    let phase = self.phase(d, -exit.d);
                    let w = exit.pdf.map_or(1.0, |p| power(p, phase));
                    sum += beta * (phase * leave(z) * w);
                    let to = self.scatter(d, u.u2());
                    let p = self.phase(d, to);
                    d = to;
                    if d.z > 0.0 {
                        sum += beta * follow(d, z, Some(p));
                    }
                    if d.z == 0.0 {
                        break;
                    }
                    continue;
                }
            } else {
                beta *= self.through(self.thickness, d);
            }
            if d.z > 0.0 {
                let Some((back, weight)) = self.send_back(d, u.u2()) else { break };
                (d, z) = (back, self.thickness);
                beta *= weight;
            } else {
                z = 0.0;
                let (f, p) = self.ground(-d, -exit.d);
                let w = exit.pdf.map_or(1.0, |q| power(q, p));
                sum += beta * f * (leave(z) * w);
                let Some((to, weight, p)) = self.bounce(-d, u.u2()) else { break };
                d = to;
                beta *= weight;
                sum += beta * follow(d, z, p);
            }
            if beta.is_zero() {
                break;
            }
        }
        Some(sum)
    }

    /// What a smooth boundary over a mirror reflects: all bounces between both.
    fn mirrored(&self, wo: Vec3) -> Spectrum {
        let x = fresnel::dielectric(wo.z, self.eta);
        let d = refract(wo, Vec3::Z, &x);
        let Base::Mirror(n, k) = self.base else { return Spectrum::splat(x.f) };
        let mut sum = Spectrum::splat(x.f);
        let way = self.through(self.thickness, d);
        let round = fresnel::conductor(-d.z, n, k) * (way * way);
        let mut carried = round * sqr(1.0 - x.f);
        for _ in 0..self.max_depth.div_ceil(2) {
            sum += carried;
            carried *= round * x.f;
        }
        sum
    }

    /// How often `sample` takes the boundary, and the proxy of the ground.
    fn shares(&self, cos: f32) -> [f32; 2] {
        let f = fresnel::dielectric(cos, self.eta).f;
        match self.base {
            Base::Mirror(..) if self.facets.is_none() => [if self.albedo.is_zero() { 1.0 } else { 0.7 }, 0.0],
            Base::Diffuse(rho) => [f / (f + (1.0 - f) * rho.max_lane().max(0.05)), 0.0],
            _ => [0.8 * f.max(0.1), 0.8 * (1.0 - f.max(0.1))],
        }
    }

    fn is_mirror(&self) -> bool {
        self.facets.is_none() && matches!(self.base, Base::Mirror(..)) && self.albedo.is_zero()
    }
}

impl Scatter for Layered {
    fn eval(&self, wo: Vec3, wi: Vec3) -> Spectrum {
        let Some(m) = half_vector(wo, wi) else { return Spectrum::ZERO };
        if self.is_mirror() {
            return Spectrum::ZERO;
        }
        let boundary = self.facets.map_or(0.0, |facets| 0.25 * fresnel::dielectric(wo.dot(m), self.eta).f * facets.dg(wo, wi, m));
        let mut numbers = Numbers::of(wo, wi);
        let walks: Spectrum = (0..self.samples).filter_map(|_| self.walk(wo, wi, &mut numbers)).sum();
        let f = Spectrum::splat(boundary) + walks * (1.0 / (sqr(self.eta) * self.samples as f32));
        if f.is_finite() { f } else { Spectrum::splat(boundary) }
    }

    fn pdf(&self, wo: Vec3, wi: Vec3) -> f32 {
        let Some(m) = half_vector(wo, wi) else { return 0.0 };
        let [boundary, ground] = self.shares(wo.z);
        let reflected = |facets: Option<Microfacets>| facets.map_or(0.0, |facets| reflected_pdf(&facets, wo, m));
        boundary * reflected(self.facets) + ground * reflected(self.proxy) + (1.0 - boundary - ground).max(0.0) * cosine_pdf(wi)
    }

    fn sample(&self, wo: Vec3, u1: f32, u2: Vec2) -> Option<BsdfSample> {
        if wo.z <= 0.0 {
            return None;
        }
        let [boundary, ground] = self.shares(wo.z);
        let (facets, event) = if u1 < boundary {
            (self.facets, Event::GLOSSY)
        } else if u1 < boundary + ground {
            (self.proxy, Event::GLOSSY)
        } else {
            (None, Event::DIFFUSE)
        };
        let wi = match (facets, event) {
            (Some(facets), _) => reflect(wo, facets.sample(wo, u2)),
            (None, Event::DIFFUSE) => cosine_sample(u2)?,
            (None, _) => return dirac(reflect_z(wo), self.mirrored(wo) / boundary, boundary, 1.0, Event::REFLECT),
        };
        let pdf = self.pdf(wo, wi);
        smooth(wi, self.eval(wo, wi), pdf, 1.0, Event::REFLECT | event)
    }

    fn diracs(&self, wo: Vec3, found: &mut dyn FnMut(BsdfSample)) {
        if self.facets.is_none() && wo.z > 0.0 {
            whole_dirac(reflect_z(wo), self.mirrored(wo), 1.0, Event::REFLECT, found);
        }
    }

    fn events(&self) -> Event {
        let boundary = if self.facets.is_some() { Event::GLOSSY } else { Event::DELTA };
        let rest = if self.is_mirror() { Event::NONE } else { Event::DIFFUSE.with(Event::GLOSSY) };
        Event::REFLECT | rest | boundary
    }

    fn albedo(&self, wo: Vec3) -> Spectrum {
        let f = fresnel::dielectric(wo.z, self.eta).f;
        Spectrum::lerp(f, self.base_reflectance(), Spectrum::ONE)
    }

    fn diffuse_reflectance(&self) -> Spectrum {
        if let Base::Diffuse(rho) = self.base { rho } else { Spectrum::ZERO }
    }

    fn roughness(&self) -> f32 {
        let base = match self.base {
            Base::Diffuse(_) => 1.0,
            Base::Mirror(..) => 0.0,
            Base::Metal(_, _, facets) => facets.min_alpha(),
        };
        self.facets.map_or(0.0, |facets| facets.min_alpha()).min(base)
    }

    fn importance(&self) -> f32 {
        self.base_reflectance().max_lane().max(0.1)
    }
}

impl Layered {
    fn base_reflectance(&self) -> Spectrum {
        match self.base {
            Base::Diffuse(rho) => rho,
            Base::Mirror(n, k) | Base::Metal(n, k, _) => fresnel::conductor(1.0, n, k),
        }
    }
}

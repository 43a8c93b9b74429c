//! Walks of neighbouring pixels that share what they find [Bekaert, Sbert, Halton 2002; here with one density for all].
//!
//! The pixels of a small block look at places x_i near each other, and each sends a ray on, with density p_i. What the ray of one of them meets,
//! y, the others could have met as well: so y is looked at as a sample of all their densities together, and each takes what comes from there, for a shadow ray.
//!
//! ```text
//! a_k = p_k(x_k → y) |cosθ_y| / |x_k - y|² V(x_k, y)        the density per area with which k meets y
//! L_i += f_i |cosθ_i| |cosθ_y| / |x_i - y|² V(x_i, y) · L(y → x_i) / (q Σ_k a_k)      [balance heuristic: Veach 1997, eq. 9.8]
//!      = ρ_i · a_i / Σ_k a_k · L(y) / q                     where both are Lambert's: L is parted among the block
//! ```
//!
//! Each y is now worth as much as several, so that not all are followed: with probability q = min(1, κ / √n), n = (Σ a)² / Σ a² the number of
//! neighbours to whom it is of use, guessed without V. The cost of what lies beyond y falls with q, its variance rises with 1/q and falls with n. Directions of rays that escape are
//! shared alike, with p_k in place of a_k, and each keeps its own weight against its light samples.
//!
//! Guided walks ([`crate::path_guided`]) send their rays with p_k = a p_b + (1 - a) p_g, each by the leaf that x_k lies in, and so these are the densities a_k: what the guide of one
//! knows, all have. q asks for the BSDF's alone. Whether x_k shares depends on x_k and never on the direction drawn there: a walk that its guide sends into the surface finds nothing, but takes
//! its part of what others find.
//!
//! Who shares is decided by the surface at x_i, and by that at y: both have to reflect diffusely, at least in good part ([`shares`]), for what is reflected is
//! estimated for one direction and taken to others. At y the light sample and the ray that goes on stay as they are, f is taken anew for each neighbour, and so are both
//! exact for any of them. What y itself emits is left to the walk that met it. Nothing is shared in scenes with null or mask surfaces, nor by walks of wavelengths.
//!
//! The errors of a block's pixels are therefore alike. Blocks are mingled, four to a square of twice their edge, so that they are not seen; they are those of the whole film, so that a
//! crop shows the same.

mod meet;
mod sight;

pub(crate) use meet::{FOLLOWED, How, meet};

use crate::lanes::{lambert, reflectance};
use crate::transport::{Context, PathState, ShadowQuery, Step, Throughput, Vertex};
use etendue_accel::Hit;
use etendue_bsdf::{Bsdf, Scatter};
use etendue_numerics::{Ray, Spectrum, Vec3};
use etendue_scene::{Interaction, LightReference};

/// Surfaces share that reflect at least as much diffusely, in some lane.
const DIFFUSE: f32 = 0.1;

/// Their highlights are no narrower: a direction drawn for one neighbour must not be far too rare for another.
const ROUGH: f32 = 0.03;

/// The first vertex of a walk.
#[derive(Clone, Copy, Debug)]
pub(crate) struct First {
    pub p: Vec3,
    pub p_error: Vec3,
    /// Geometric normal on the side of the eye.
    pub n: Vec3,
    /// Shading normal on the side of the eye.
    pub ns: Vec3,
    /// β before it, times ρ where it is Lambert's; zero where it does not share. Whatever direction the walk takes from there.
    pub beta: Spectrum,
    /// Where it is not Lambert's: its number among the vertices.
    pub other: Option<u32>,
}

/// What a walk found at its second vertex y, to be parted.
struct Find {
    walk: u32,
    /// What the walk had collected before.
    before: Spectrum,
    /// The walks of its block.
    block: [u32; 2],
    /// Its first share.
    shares: usize,
    /// Where y is not Lambert's.
    other: Option<OtherFind>,
}

/// What is known of y where light is not reflected to all sides alike.
struct OtherFind {
    /// Its number among the vertices.
    vertex: u32,
    /// What the light sample brought from `wi_light`; the rest came from `wi`.
    by_light: Spectrum,
    wi_light: Vec3,
    wi: Vec3,
}

/// The memory of a crowd's sharing.
#[derive(Default)]
pub(crate) struct Neighbours<'a> {
    /// Whether walks share at all.
    active: bool,
    firsts: Vec<First>,
    /// Where walks are guided: the leaf of each first vertex.
    leaves: Vec<u32>,
    sights: sight::Places,
    vertices: Vec<Vertex<'a>>,
    finds: Vec<Find>,
    /// For each walk its find.
    find_of: Vec<Option<u32>>,
    /// Of each find and each walk of its block: a, and what the walk takes of L.
    densities: Vec<f32>,
    /// a of a block for a place that may not be followed.
    guessed: Vec<f32>,
    shares: Vec<Spectrum>,
    rays: Vec<Ray>,
    /// Whose share each ray decides.
    places: Vec<u32>,
}

impl First {
    const NONE: Self =
        Self { p: Vec3::ZERO, p_error: Vec3::ZERO, n: Vec3::ZERO, ns: Vec3::ZERO, beta: Spectrum::ZERO, other: None };

    /// On Lambert's surface, seen from `wo` by `walk`.
    #[expect(clippy::too_many_arguments, reason = "what lanes have apart")]
    #[inline(always)]
    pub fn lambert(p: Vec3, p_error: Vec3, n: Vec3, ns: Vec3, wo: Vec3, two_sided: bool, walk: &PathState, rho: Spectrum) -> Self {
        let cos = ns.dot(wo);
        let beta = if cos > 0.0 || (two_sided && cos < 0.0) { walk.beta.carry(rho) } else { Spectrum::ZERO };
        Self { p, p_error, n: toward(n, wo), ns: toward(ns, wo), beta, other: None }
    }

    fn shares(&self) -> bool {
        !self.beta.is_zero()
    }

    /// What its light samples know.
    fn from(&self) -> LightReference {
        LightReference { p: self.p, n: self.ns, one_sided: true, shared: true }
    }
}

/// The normal on the side of `wo`.
#[inline(always)]
fn toward(n: Vec3, wo: Vec3) -> Vec3 {
    if n.dot(wo) < 0.0 { -n } else { n }
}

/// Whether a surface shares that is not Lambert's.
fn shares(bsdf: &Bsdf<'_>) -> bool {
    let events = bsdf.events();
    let smooth = !(events.has_delta() || events.has_null() || events.transmits());
    smooth && bsdf.diffuse_reflectance().max_lane() >= DIFFUSE && bsdf.roughness() >= ROUGH
}

impl Context<'_> {
    /// Whether walks may share: all of them are of red, green and blue, nothing lets them pass for nothing, and none ended by chance at its first vertex.
    pub(crate) fn may_share(&self) -> bool {
        !(self.scene.has_transparent || self.scene.spectral || self.rules.rr_depth.is_some_and(|first| first < 2))
    }
}

impl<'a> Neighbours<'a> {
    /// Begins with walks that all stand at the eye.
    pub fn begin(&mut self, active: bool, walks: usize) {
        self.active = active;
        self.firsts.clear();
        self.vertices.clear();
        if active {
            self.firsts.resize(walks, First::NONE);
            self.sights.reset(walks);
        }
    }

    /// Whether what walks do at this vertex is to be noted.
    #[inline]
    pub fn watches(&self, vertex: u32) -> bool {
        self.active && vertex <= 2
    }

    /// Notes what walk i did at `hit`.
    pub fn note(&mut self, c: &Context<'a>, i: u32, before: &PathState, hit: Option<&Hit>, step: &Step, after: &PathState) {
        let Some(hit) = hit.filter(|_| !c.ends(before)) else { return };
        if before.vertex == 2 {
            return self.note_second(i, step.shadow.as_ref(), after);
        }
        let x = c.scene.interaction(&before.ray, hit);
        if let Some((rho, two_sided)) = lambert(c, before, hit) {
            let rho = reflectance(rho, &before.wl, || c.scene.texture_context(&x));
            self.first(i, First::lambert(x.p, x.p_error, x.n, x.shading.n, x.wo, two_sided, before, rho));
        } else {
            self.note_first(i, before.beta, &Vertex::new(c.scene, x, &before.wl));
        }
    }

    /// Notes what walk i did at a vertex that is not Lambert's, β before it.
    pub fn note_other(
        &mut self,
        i: u32,
        vertex: u32,
        beta: Throughput,
        y: &Vertex<'a>,
        shadow: Option<&ShadowQuery>,
        after: &PathState,
    ) {
        match vertex {
            1 => self.note_first(i, beta, y),
            _ => self.note_second(i, shadow, after),
        }
    }

    /// Notes the first vertex of walk i that is not Lambert's, if it shares.
    fn note_first(&mut self, i: u32, beta: Throughput, y: &Vertex<'a>) {
        if shares(&y.bsdf) {
            let (beta, other) = (beta.carry(Spectrum::ONE), Some(self.vertices.len() as u32));
            self.vertices.push(*y);
            let Interaction { p, p_error, n, shading, wo, .. } = y.x;
            self.first(i, First { p, p_error, n: toward(n, wo), ns: toward(shading.n, wo), beta, other });
        }
    }

    /// Notes where the light came from to walk i's second vertex.
    fn note_second(&mut self, i: u32, shadow: Option<&ShadowQuery>, after: &PathState) {
        if let Some(k) = self.find_of[i as usize]
            && let Some(other) = &mut self.finds[k as usize].other
        {
            (other.wi_light, other.wi) = (shadow.map_or(Vec3::ZERO, |query| query.ray.d), after.ray.d);
        }
    }

    /// Notes the first vertex of walk i.
    #[inline(always)] // as a value that moves it would go through memory
    pub fn first(&mut self, i: u32, First { p, p_error, n, ns, beta, other }: First) {
        self.sights.set(i as usize, p, p_error, n, ns);
        let to = &mut self.firsts[i as usize];
        (to.p, to.p_error, to.n, to.ns) = (p, p_error, n, ns);
        (to.beta, to.other) = (beta, other);
    }

    /// Evaluates the material at x and keeps the vertex, if it shares.
    fn keep(&mut self, c: &Context<'a>, x: &Interaction, walk: &PathState) -> bool {
        self.vertices.push(Vertex::at(*x));
        if let Some(vertex) = self.vertices.last_mut() {
            vertex.evaluate(c.scene, &walk.wl);
            if shares(&vertex.bsdf) {
                return true;
            }
        }
        self.vertices.pop();
        false
    }

    /// Light samples at the second vertices have arrived: what they brought is kept apart where it is reflected otherwise than the rest.
    pub fn connected(&mut self, walks: &mut [PathState]) {
        for find in &mut self.finds {
            if let Some(other) = &mut find.other {
                other.by_light = std::mem::take(&mut walks[find.walk as usize].l);
            }
        }
    }

    /// Parts what was found. Finds come in the order of walks, so that sums do not depend on company.
    pub fn part(&mut self, walks: &mut [PathState]) {
        let found: Vec<Spectrum> =
            self.finds.iter().map(|find| std::mem::replace(&mut walks[find.walk as usize].l, find.before)).collect();
        for (find, l) in self.finds.iter().zip(found) {
            let block = find.block[0]..find.block[1];
            let shares = self.shares[find.shares..].iter().zip(block).filter(|(share, _)| !share.is_zero());
            let Some(other) = &find.other else {
                shares.for_each(|(share, i)| walks[i as usize].l += *share * l);
                continue;
            };
            if l.is_zero() && other.by_light.is_zero() {
                continue;
            }
            // L from both sides before y reflected it.
            let mut y = self.vertices[other.vertex as usize];
            let (by_light, by_walk) = (per(other.by_light, y.eval(other.wi_light).0), per(l, y.eval(other.wi).0));
            for (share, i) in shares {
                let seen = if i == find.walk {
                    other.by_light + l
                } else {
                    y.wo = y.x.shading.to_local((self.firsts[i as usize].p - y.x.p).normalize());
                    let light = |l: Spectrum, wi: Vec3| if l.is_zero() { l } else { l * y.eval(wi).0 };
                    light(by_light, other.wi_light) + light(by_walk, other.wi)
                };
                walks[i as usize].l += *share * seen;
            }
        }
        self.finds.clear();
        self.shares.clear();
        self.densities.clear();
    }
}

/// a/b, and nothing where b is nothing.
fn per(a: Spectrum, b: Spectrum) -> Spectrum {
    let lane = |i: usize| if b[i] > 0.0 { a[i] / b[i] } else { 0.0 };
    Spectrum([lane(0), lane(1), lane(2), lane(3)].into())
}

//! What the rays of a block's walks meet beyond their first vertices, and who takes how much of it.

use super::sight::{Aim, Cosines, Densities, LANES, Second};
use super::{Find, First, Neighbours, OtherFind};
use crate::lanes::lambert;
use crate::path_guided::field::Field;
use crate::transport::{Context, Crowd, Heuristic, PathState, Throughput, mis_weight, slot};
use etendue_accel::Hit;
use etendue_numerics::ray::offset_origin;
use etendue_numerics::{Dim, Ray, Spectrum, Vec3, wide};
use etendue_scene::{Escape, Seen, SurfaceId};

/// κ where nobody asks for another. By measurement: more cost time, fewer bring noise; this is as fast as walks alone where all surfaces are Lambert's.
pub(crate) const FOLLOWED: f32 = 1.05;

/// κ of directions that escape, which cost nothing but the neighbours' shadow rays.
const ESCAPED: f32 = 2.0;

/// How walks share.
pub(crate) struct How<'a> {
    pub heuristic: Heuristic,
    /// κ.
    pub follow: f32,
    /// κ of roulette.
    pub hope: f32,
    /// What guides them.
    pub guide: Option<&'a Field>,
}

/// What all walks of a block could have met.
enum Met<'a> {
    Surface(&'a Second),
    /// A direction with what shines from there.
    Sky(Vec3),
}

/// Lets the walks of each block share what they met at their second vertices. Returns how many rays that took.
pub(crate) fn meet<'a>(how: &How<'_>, c: &Context<'a>, crowd: &mut Crowd<'a>) -> u64 {
    let mut all = std::mem::take(&mut crowd.neighbours);
    all.leaves.clear();
    if let Some(field) = how.guide {
        all.leaves.extend(all.firsts.iter().map(|x| if x.shares() { field.find(x.p, x.n) } else { 0 }));
    }
    let mut hit_of = vec![None; crowd.walks.len()];
    for (k, i) in crowd.going.iter().enumerate() {
        hit_of[*i as usize] = Some(k);
    }
    all.find_of.clear();
    all.find_of.resize(crowd.walks.len(), None);
    // Through a portal the same direction shows light from one place and none from another.
    let portals = c.scene.has_portals();
    let skies = if portals { Vec::new() } else { all.skies(c, crowd) };
    let mut ended = vec![false; crowd.going.len()];
    let mut begin = 0;
    for end in &crowd.blocks {
        let block = [begin, *end];
        begin = *end;
        let walks = block[0]..block[1];
        if walks.clone().filter(|i| all.firsts[*i as usize].shares()).count() < 2 {
            continue;
        }
        for i in walks {
            let Some(k) = hit_of[i as usize] else { continue };
            if !all.firsts[i as usize].shares() {
                continue;
            }
            let (walk, u) = (&mut crowd.walks[i as usize], &crowd.samplers[i as usize]);
            let u = || u.u1(Dim::at(2, slot::SHARED));
            ended[k] = match &crowd.hits[k] {
                Some(hit) => all.surface(how, c, block, i, walk, hit, u),
                None => !portals && all.sky(how, c, block, i, walk, &skies[k], u),
            };
        }
    }
    let rays = all.look(c);
    crowd.neighbours = all;
    let mut keep = ended.iter();
    crowd.going.retain(|_| keep.next() == Some(&false));
    let mut keep = ended.iter();
    crowd.hits.retain(|_| keep.next() == Some(&false));
    rays
}

impl<'a> Neighbours<'a> {
    /// Shares what is reflected at `hit`, if it can be. Returns whether the walk ends there.
    #[expect(clippy::too_many_arguments, reason = "one half of a loop's body")]
    fn surface(
        &mut self,
        how: &How<'_>,
        c: &Context<'a>,
        block: [u32; 2],
        i: u32,
        walk: &mut PathState,
        hit: &Hit,
        u: impl Fn() -> f32,
    ) -> bool {
        if c.ends(walk) || c.scene.surface(SurfaceId(hit.geometry)).emitter.is_some() {
            return false;
        }
        let other = lambert(c, walk, hit).is_none().then_some(self.vertices.len());
        let y = if other.is_none() {
            Second::lambert(c, &walk.ray, hit)
        } else {
            let y = c.scene.interaction(&walk.ray, hit);
            if !self.keep(c, &y, walk) {
                return false;
            }
            Second::from(&y)
        };
        let q = self.guess(block, i, &Met::Surface(&y), how.follow);
        let Some((first, q)) = q.filter(|q| *q == 1.0 || u() < *q).map(|q| (self.follow(), q)) else {
            self.vertices.truncate(other.unwrap_or(self.vertices.len()));
            // Where it could not have gone there it goes on by itself.
            return q.is_some();
        };
        for (n, k) in (block[0]..block[1]).enumerate() {
            self.share(&Met::Surface(&y), first + n, k, |_| 1.0);
        }
        self.know(how, block, first, &Met::Surface(&y));
        self.aim(block, i, first, &y);
        let other =
            other.map(|vertex| OtherFind { vertex: vertex as u32, by_light: Spectrum::ZERO, wi_light: Vec3::ZERO, wi: Vec3::ZERO });
        self.find_of[i as usize] = Some(self.finds.len() as u32);
        self.finds.push(Find { walk: i, before: std::mem::take(&mut walk.l), block, shares: first, other });
        // From here on it is a walk of its own, from y.
        walk.beta = Throughput::ONE;
        walk.beta.divide(q);
        walk.roulette_scale = how.hope * q;
        false
    }

    /// What the walks that go on see of the surroundings where they meet nothing, with the density of light samples where that is the same from everywhere.
    fn skies(&self, c: &Context<'_>, crowd: &Crowd<'_>) -> Vec<Seen> {
        let first = |i: u32| &self.firsts[i as usize];
        let escaped: Vec<usize> =
            (0..crowd.going.len()).filter(|k| crowd.hits[*k].is_none() && first(crowd.going[*k]).shares()).collect();
        let from = crowd.going.first().filter(|_| c.scene.lights.is_alike(c.scene)).map(|i| first(*i).from());
        let escape = |k: &usize| {
            let walk = &crowd.walks[crowd.going[*k] as usize];
            Escape { ray: &walk.ray, from: from.as_ref(), wl: &walk.wl }
        };
        let (mut seen, mut skies) = (Vec::new(), vec![Seen::default(); crowd.going.len()]);
        c.scene.escaped_each(escaped.iter().map(escape), &mut seen);
        escaped.into_iter().zip(seen).for_each(|(k, seen)| skies[k] = seen);
        skies
    }

    /// Shares `sky`, which the walk's ray escapes to. Returns whether that was done: then the walk ends.
    #[expect(clippy::too_many_arguments, reason = "one half of a loop's body")]
    fn sky(
        &mut self,
        how: &How<'_>,
        c: &Context<'a>,
        block: [u32; 2],
        i: u32,
        walk: &mut PathState,
        sky: &Seen,
        u: impl Fn() -> f32,
    ) -> bool {
        let le = sky.le;
        if le.is_zero() || !c.rules.counts(walk.edges) {
            return false;
        }
        let d = walk.ray.d;
        let Some(q) = self.guess(block, i, &Met::Sky(d), ESCAPED) else { return false };
        if q < 1.0 && u() >= q {
            return true;
        }
        let first = self.follow();
        let alike = c.scene.lights.is_alike(c.scene).then_some(sky.pdf);
        for (n, k) in (block[0]..block[1]).enumerate() {
            let from = self.firsts[k as usize].from();
            let by_light = || alike.unwrap_or_else(|| c.scene.pdf_light_escaped(&from, d));
            let weight = |pdf: f32| mis_weight(how.heuristic, pdf, by_light());
            self.share(&Met::Sky(d), first + n, k, weight);
            if k != i && self.densities[first + n] > 0.0 {
                let x = &self.firsts[k as usize];
                self.rays.push(Ray::new(offset_origin(x.p, x.p_error, x.n, d), d));
                self.places.push((first + n) as u32);
            }
        }
        self.know(how, block, first, &Met::Sky(d));
        self.finds.push(Find { walk: i, before: std::mem::replace(&mut walk.l, le / q), block, shares: first, other: None });
        true
    }

    /// Guesses a for each walk of the block, as if all were Lambert's and saw y. Returns q; `None` where the walk i itself, by rounding, could not have gone there.
    fn guess(&mut self, block: [u32; 2], i: u32, met: &Met<'_>, kappa: f32) -> Option<f32> {
        let (begin, end) = (block[0] as usize, block[1] as usize);
        self.guessed.clear();
        let (mut sum, mut squares) = (0.0, 0.0);
        for first in (begin..end).step_by(LANES) {
            let (places, count) = (&self.sights, LANES.min(end - first));
            let found = match met {
                Met::Sky(w) => wide::widest(Cosines { places, first, count, w: *w }),
                Met::Surface(y) => wide::widest(Densities { places, first, count, y }),
            };
            self.guessed.extend_from_slice(&found.a[..count]);
            (sum, squares) = (sum + found.sum, squares + found.squares);
        }
        let could = self.guessed[i as usize - begin] > 0.0 && squares > 0.0 && sum.is_finite();
        could.then(|| (kappa * squares.sqrt() / sum).min(1.0))
    }

    /// Notes what was guessed. Returns its first place.
    fn follow(&mut self) -> usize {
        self.densities.extend_from_slice(&self.guessed);
        self.densities.len() - self.guessed.len()
    }

    /// What walk k takes, if nothing stands between; `weight` of its density, 1/sr, is its share against light samples from a sky.
    fn share(&mut self, met: &Met<'_>, place: usize, k: u32, weight: impl Fn(f32) -> f32) {
        let x = &self.firsts[k as usize];
        let a = &mut self.densities[place];
        let mut share = Spectrum::ZERO;
        if *a > 0.0 {
            share = match x.other {
                None => x.beta * (*a * weight(*a)),
                Some(vertex) => {
                    let (w, area) = met.from(x);
                    let (f_cos, pdf) = self.vertices[vertex as usize].eval(w);
                    *a = pdf * area;
                    x.beta * f_cos * (area * weight(pdf))
                }
            };
        }
        self.shares.push(share);
    }

    /// Where walks are guided: makes densities of the BSDFs those with which directions are drawn.
    fn know(&mut self, how: &How<'_>, block: [u32; 2], first: usize, met: &Met<'_>) {
        if let Some(field) = how.guide {
            let places = block[0] as usize..block[1] as usize;
            let (firsts, leaves) = (&self.firsts[places.clone()], &self.leaves[places]);
            wide::widest(Know { field, firsts, leaves, met, densities: &mut self.densities[first..] });
        }
    }

    /// Notes the rays between y and all others of the block that it is of use to.
    fn aim(&mut self, block: [u32; 2], i: u32, first: usize, y: &Second) {
        let (begin, end) = (block[0] as usize, block[1] as usize);
        for some in (begin..end).step_by(LANES) {
            let aimed = wide::widest(Aim { places: &self.sights, first: some, y });
            for (lane, k) in (some..end.min(some + LANES)).enumerate() {
                let place = first + k - begin;
                if k != i as usize && self.densities[place] > 0.0 && aimed.is_there(lane) {
                    self.rays.push(aimed.ray(lane, y.time));
                    self.places.push(place as u32);
                }
            }
        }
    }

    /// Asks who sees what, and divides by the sum of densities. Returns the rays cast.
    fn look(&mut self, c: &Context<'a>) -> u64 {
        let mut occluded = Vec::new();
        c.scene.occluded_each(&self.rays, &mut occluded);
        for (place, occluded) in self.places.iter().zip(&occluded) {
            if *occluded {
                (self.densities[*place as usize], self.shares[*place as usize]) = (0.0, Spectrum::ZERO);
            }
        }
        for find in &self.finds {
            let theirs = find.shares..find.shares + (find.block[1] - find.block[0]) as usize;
            let sum: f32 = self.densities[theirs.clone()].iter().sum();
            self.shares[theirs].iter_mut().filter(|share| !share.is_zero()).for_each(|share| *share /= sum);
        }
        let count = self.rays.len() as u64;
        self.rays.clear();
        self.places.clear();
        count
    }
}

/// What a guide makes of densities per area: those of the BSDF, p_b, become a p_b + (1 - a) p_g.
struct Know<'a> {
    field: &'a Field,
    firsts: &'a [First],
    leaves: &'a [u32],
    met: &'a Met<'a>,
    densities: &'a mut [f32],
}

impl wide::Job for Know<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        for ((x, leaf), a) in self.firsts.iter().zip(self.leaves).zip(self.densities).filter(|(_, a)| **a > 0.0) {
            let (w, area) = self.met.from(x);
            let leaf = self.field.leaf(*leaf);
            *a = leaf.fraction * *a + (1.0 - leaf.fraction) * leaf.guide.pdf(x.p, w) * area;
        }
    }
}

impl Met<'_> {
    /// The unit direction from x, and what makes a density per area of one per solid angle: |cosθ_y|/r², or 1 of a direction.
    #[inline(always)]
    fn from(&self, x: &First) -> (Vec3, f32) {
        match self {
            Self::Sky(w) => (*w, 1.0),
            Self::Surface(y) => {
                let d = y.p - x.p;
                let r2 = d.length_squared();
                let w = d / r2.sqrt();
                (w, y.n.dot(w).abs() / r2)
            }
        }
    }
}

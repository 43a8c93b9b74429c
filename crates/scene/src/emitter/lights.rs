//! How to choose among the lights of a scene.
//!
//! ```text
//! p(wi | x) = P(tree | x) P(light | x, tree) p_light(wi | x)          lights in the scene
//! p(wi | x) = Σ_k P(k | x) p_k(wi | x)                               surroundings, taken together
//! P(tree | x) = 1/2 · 1/(n + 1) + 1/2 · E_tree / (E_tree + Σ E_k)     n distant lights
//! ```
//!
//! E_k is the irradiance of distant light k, E_tree what the lights in the scene could give at x by their bounds. Half of the choice is even, for
//! what either can see is not known here: a sun is no use indoors. Several surroundings are one light of their summed radiance.
//!
//! For light that sets out, primitives are chosen with probability ∝ Φ.

mod sky;

use super::record::{EmissionPdf, EmissionSample, Escape, LightId, LightQuery, LightReference, LightSample, Seen};
use super::tree::{Descent, LightTree};
use super::{Extent, Light, LightBounds, Model, of, scalar};
use crate::ids::EmitterId;
use crate::interaction::Interaction;
use crate::scene::Scene;
use etendue_numerics::math::ONE_MINUS_EPSILON;
use etendue_numerics::sequence::{mix, unit};
use etendue_numerics::table::Table1D;
use etendue_numerics::{Pdf, Spectrum, Vec2, Vec3, Wavelengths};

/// A light at infinity.
#[derive(Clone, Copy, Debug)]
struct Distant {
    emitter: EmitterId,
    /// E on a surface that faces it, times the sampling weight, W/m².
    irradiance: f32,
    /// The part of it that counts beside a walk.
    excess: f32,
    /// The direction towards it, if it has only one.
    from: Option<Vec3>,
}

/// Lights that are chosen together: as many as their memory stays near by, and enough that none is waited for.
const TOGETHER: usize = 32;

/// The light sampler.
#[derive(Clone, Debug, Default)]
pub struct Lights {
    /// Surroundings, sampled or not.
    environments: Vec<EmitterId>,
    distant: Vec<Distant>,
    /// The primitives that the tree chooses among.
    primitives: Vec<LightId>,
    /// For each emitter its first primitive among them.
    first: Vec<Option<u32>>,
    tree: LightTree,
    /// The only light that can be sampled, where there is nothing to choose.
    alone: Option<LightId>,
    /// All primitives and distant lights, and the choice among them by flux.
    emitting: Vec<LightId>,
    by_flux: Option<Table1D>,
    first_emitting: Vec<u32>,
    power: Spectrum,
}

impl Lights {
    /// The sampler of all emitters of `scene`, whose own `lights` are not looked at.
    pub fn new(scene: &Scene) -> Self {
        let mut lights = Self::default();
        let (mut bounds, mut tints, mut flux): (Vec<LightBounds>, Vec<f32>, Vec<f32>) = (Vec::new(), Vec::new(), Vec::new());
        for (i, emitter) in scene.emitters.iter().enumerate() {
            let id = EmitterId(i as u32);
            lights.first_emitting.push(lights.emitting.len() as u32);
            lights.first.push(None);
            let own = flux.len();
            for primitive in 0..emitter.primitive_count(scene) {
                let light = LightId { emitter: id, primitive };
                lights.emitting.push(light);
                let power = emitter.model.power_of(scene, primitive);
                flux.push(scalar(power));
                match emitter.model.extent(scene, primitive) {
                    Extent::Bounded(b) => {
                        lights.first[i].get_or_insert(lights.primitives.len() as u32);
                        lights.primitives.push(light);
                        bounds.push(b.scaled(emitter.sampling_weight));
                        tints.push(tint(power));
                    }
                    Extent::Distant { irradiance, excess, from } => {
                        if from.is_none() {
                            lights.environments.push(id);
                        }
                        let [irradiance, excess] = [irradiance, excess].map(|e| e * emitter.sampling_weight);
                        if irradiance > 0.0 {
                            lights.distant.push(Distant { emitter: id, irradiance, excess, from });
                        }
                    }
                    Extent::Unseen => {}
                }
            }
            lights.power += emitter.power(scene);
            // The flux of textured primitives is known from a few points of each: none is left without its chance.
            let own = &mut flux[own..];
            let least = 0.02 * own.iter().sum::<f32>() / own.len().max(1) as f32;
            own.iter_mut().for_each(|f| *f = f.max(least));
        }
        lights.tree = LightTree::new(&bounds, &tints);
        lights.alone = match (&lights.primitives[..], &lights.distant[..], &lights.environments[..]) {
            ([only], [], _) if !lights.tree.is_empty() => Some(*only),
            ([], [only], [] | [_]) => Some(LightId { emitter: only.emitter, primitive: 0 }),
            _ => None,
        };
        lights.by_flux = (!flux.is_empty()).then(|| Table1D::new(&flux));
        lights
    }

    /// The emitters that surround the scene: what a ray that meets nothing sees.
    #[inline]
    pub fn environments(&self) -> &[EmitterId] {
        &self.environments
    }

    /// Whether no light can be sampled from a point.
    pub fn is_empty(&self) -> bool {
        self.distant.is_empty() && self.tree.is_empty()
    }

    /// Whether there is but one light: nothing to choose, and `u_light` is not looked at.
    #[inline]
    pub fn is_alone(&self) -> bool {
        self.alone.is_some()
    }

    /// Whether light samples find the emitter at all.
    pub fn is_sampled(&self, scene: &Scene, emitter: EmitterId) -> bool {
        let known = self.first[emitter.index()].is_some() || self.distant.iter().any(|d| d.emitter == emitter);
        known && scene.emitter(emitter).sampling_weight > 0.0
    }

    /// The only light, where there is nothing to choose.
    #[inline]
    pub(super) fn alone(&self) -> Option<LightId> {
        self.alone
    }

    /// Flux Φ of all emitters, W.
    pub fn power(&self) -> Spectrum {
        self.power
    }

    /// Density at `from`, 1/sr, with which [`Lights::sample`] chooses the emitting point `x`; zero where x does not emit.
    pub fn pdf(&self, scene: &Scene, from: &LightReference, x: &Interaction) -> f32 {
        let Some(id) = self.light_at(scene, x) else { return 0.0 };
        let Some(first) = self.first[id.emitter.index()] else { return 0.0 };
        if self.is_alone() {
            return scene.emitter(id.emitter).model.pdf(scene, from, id, x);
        }
        let chosen = self.tree.probability(from, (first + id.primitive) as usize);
        if chosen == 0.0 {
            return 0.0;
        }
        self.tree_share(from) * chosen * scene.emitter(id.emitter).model.pdf(scene, from, id, x)
    }

    /// Density at `from`, 1/sr, with which [`Lights::sample`] chooses the direction `wi` of the surroundings.
    pub fn pdf_escaped(&self, scene: &Scene, from: &LightReference, wi: Vec3) -> f32 {
        self.pdf_surroundings(from, |emitter| scene.emitter(emitter).model.pdf_escaped(from, wi))
    }

    /// The same, `of` telling the density of each of the surroundings.
    #[inline]
    fn pdf_surroundings(&self, from: &LightReference, of: impl Fn(EmitterId) -> f32) -> f32 {
        let surroundings = || self.distant.iter().filter(|d| d.from.is_none());
        let density: f32 = match &self.distant[..] {
            [only] => surroundings().map(|_| of(only.emitter)).sum(),
            _ => {
                let total = self.distant_irradiance(from);
                surroundings().map(|d| d.weight(from) / total * of(d.emitter)).sum()
            }
        };
        if density > 0.0 { density * (1.0 - self.tree_share(from)) } else { 0.0 }
    }

    /// What many rays that meet nothing see, and [`Lights::pdf_escaped`] where it is asked for; `found` hears of them in their order.
    pub fn escaped_each<'a>(&self, scene: &Scene, rays: impl Iterator<Item = Escape<'a>>, mut found: impl FnMut(Seen)) {
        if let [only] = self.environments[..] {
            scene.emitter(only).model.escaped_each(rays, |ray, seen| {
                found(Seen { pdf: ray.from.map_or(0.0, |from| self.pdf_surroundings(from, |_| seen.pdf)), ..seen });
            });
            return;
        }
        for ray in rays {
            let pdf = ray.from.map_or(0.0, |from| self.pdf_escaped(scene, from, ray.ray.d));
            found(Seen { le: scene.le_escaped(ray.ray, ray.wl), pdf });
        }
    }

    /// Whether [`Lights::pdf_escaped`] is the same from everywhere: whether the only light is a picture all around.
    #[inline]
    pub fn is_alike(&self, scene: &Scene) -> bool {
        self.alone.is_some_and(|only| matches!(scene.emitter(only.emitter).model, Model::Environment(_)))
    }

    /// The probability with which [`Lights::sample`] chooses at `from` the point or the single direction `emitter`.
    pub fn probability(&self, from: &LightReference, emitter: EmitterId) -> f32 {
        if let Some(only) = self.alone {
            return if only.emitter == emitter { 1.0 } else { 0.0 };
        }
        if let Some(first) = self.first[emitter.index()] {
            return self.tree_share(from) * self.tree.probability(from, first as usize);
        }
        let Some(distant) = self.distant.iter().find(|d| d.emitter == emitter) else { return 0.0 };
        let total = self.distant_irradiance(from);
        if total > 0.0 { (1.0 - self.tree_share(from)) * distant.weight(from) / total } else { 0.0 }
    }

    /// A point on a light for `from`: `u_light` chooses the light, `u` the point on it; `None` where no light can arrive.
    #[inline]
    pub fn sample(&self, scene: &Scene, from: &LightReference, u_light: f32, u: Vec2, wl: &Wavelengths) -> Option<LightSample> {
        match self.alone {
            Some(id) => scene.emitter(id.emitter).model.sample(scene, from, id, u, wl),
            None => self.sample_one_of(scene, from, u_light, u, wl),
        }
    }

    /// [`Lights::sample`] of many queries, each with its wavelengths (none where all are RGB); `found` hears of them in their order.
    pub fn sample_each(
        &self,
        scene: &Scene,
        queries: &[LightQuery],
        wl: &[Wavelengths],
        mut found: impl FnMut(usize, Option<LightSample>),
    ) {
        if let Some(id) = self.alone {
            return scene.emitter(id.emitter).model.sample_each(scene, id, queries, wl, found);
        }
        for (group, queries) in queries.chunks(TOGETHER).enumerate() {
            // Which light, then what it looks like: what each of them needs is asked for before the first is looked at.
            let mut choices: Vec<Descent<'_>> = queries.iter().map(|q| self.choice(&q.from, q.u_light, q.u)).collect();
            self.tree.descend(&mut choices);
            for stage in 0..2 {
                choices.iter().filter_map(Descent::light).for_each(|i| self.fetch(scene, i, stage));
            }
            let first = group * TOGETHER;
            let wl = wl.get(first..).unwrap_or(&[]);
            let skies = self.sample_sky(scene, &choices, queries, wl);
            for (i, (choice, query)) in choices.iter().zip(queries).enumerate() {
                let sky = skies.get(i).copied().flatten();
                found(first + i, sky.unwrap_or_else(|| self.chosen(scene, choice, query.u, of(wl, i))));
            }
        }
    }

    fn sample_one_of(&self, scene: &Scene, from: &LightReference, u_light: f32, u: Vec2, wl: &Wavelengths) -> Option<LightSample> {
        let mut choice = [self.choice(from, u_light, u)];
        self.tree.descend(&mut choice);
        self.chosen(scene, &choice[0], u, wl)
    }

    /// A choice about to be made: the tree, where one of its lights shall be chosen; else the probability of all others.
    fn choice<'a>(&self, from: &'a LightReference, u_light: f32, u: Vec2) -> Descent<'a> {
        // A tree of many lights asks for more digits than `u_light` has. The rest is scrambled out of `u`.
        let digits = unit(mix(u64::from(u.x.to_bits()) << 32 | u64::from(u.y.to_bits())) as u32);
        let u_light = f64::from(u_light) + f64::from(digits) * (0.5f64).powi(24);

        let tree_share = self.tree_share(from);
        if u_light < f64::from(tree_share) {
            // Between colours the place on the light decides, which for many small lights is the least of all matters.
            self.tree.descent(from, u_light / f64::from(tree_share), u.x, tree_share)
        } else {
            let share = 1.0 - tree_share;
            Descent::elsewhere(from, (u_light - f64::from(tree_share)) / f64::from(share), share)
        }
    }

    /// Asks for the memory of light i of the tree, what lies behind the first stage in the second.
    fn fetch(&self, scene: &Scene, i: usize, stage: u32) {
        let id = self.primitives[i];
        if let Model::Area(area) = &scene.emitter(id.emitter).model
            && let Some(mesh) = scene.surface(area.surface).shape.mesh()
        {
            mesh.fetch(id.primitive, stage);
        }
    }

    /// A point on the light that was chosen.
    fn chosen(&self, scene: &Scene, choice: &Descent<'_>, u: Vec2, wl: &Wavelengths) -> Option<LightSample> {
        if choice.is_elsewhere() {
            return self.sample_distant(scene, choice.from, choice.u, choice.probability, u, wl);
        }
        let id = self.primitives[choice.light()?];
        let u = Vec2::new(choice.tint, u.y);
        let sample = scene.emitter(id.emitter).model.sample(scene, choice.from, id, u, wl)?;
        Some(LightSample { pdf: times(sample.pdf, choice.probability), ..sample })
    }

    fn sample_distant(
        &self,
        scene: &Scene,
        from: &LightReference,
        u_light: f64,
        share: f32,
        u: Vec2,
        wl: &Wavelengths,
    ) -> Option<LightSample> {
        let (distant, probability) = self.choose_distant(from, u_light)?;
        let id = LightId { emitter: distant.emitter, primitive: 0 };
        let sample = scene.emitter(id.emitter).model.sample(scene, from, id, u, wl)?;
        if sample.pdf.is_delta() || self.distant.len() == 1 && self.environments.len() == 1 {
            return Some(LightSample { pdf: times(sample.pdf, share * probability), ..sample });
        }
        // Any of the surroundings could have given this direction, and all of them shine from it.
        let le: Spectrum = self.environments.iter().map(|e| scene.emitter(*e).le_escaped(from.p, sample.wi, wl)).sum();
        Some(LightSample { le, pdf: Pdf::SolidAngle(self.pdf_escaped(scene, from, sample.wi)), ..sample })
    }

    /// Which distant light, with its probability.
    fn choose_distant(&self, from: &LightReference, u_light: f64) -> Option<(&Distant, f32)> {
        let total = self.distant_irradiance(from);
        let mut rest = (u_light * f64::from(total)) as f32;
        let mut chosen = None;
        for d in &self.distant {
            let weight = d.weight(from);
            if weight > 0.0 {
                chosen = Some((d, weight / total));
                if rest < weight {
                    break;
                }
                rest -= weight;
            }
        }
        chosen
    }

    /// The densities with which [`Lights::sample_emission`] lets light leave `x` towards `x.wo`; the choice of the light is in the density by area.
    pub fn pdf_emission(&self, scene: &Scene, x: &Interaction) -> EmissionPdf {
        let Some(id) = self.light_at(scene, x) else { return EmissionPdf::ZERO };
        let pdf = scene.emitter(id.emitter).model.pdf_emission(scene, id, x);
        EmissionPdf { position: pdf.position.times(self.flux_share(id)), ..pdf }
    }

    /// The same for light of `emitter`, one of the surroundings, that comes from the direction `wi`.
    pub fn pdf_emission_escaped(&self, scene: &Scene, emitter: EmitterId, wi: Vec3) -> EmissionPdf {
        let pdf = scene.emitter(emitter).model.pdf_emission_escaped(scene, wi);
        EmissionPdf { position: pdf.position.times(self.flux_share(LightId { emitter, primitive: 0 })), ..pdf }
    }

    /// The same for light that travels towards `w` from the point or the single direction `emitter`.
    pub fn pdf_emission_discrete(&self, scene: &Scene, emitter: EmitterId, w: Vec3) -> EmissionPdf {
        let pdf = scene.emitter(emitter).model.pdf_emission_discrete(scene, w);
        EmissionPdf { position: pdf.position.times(self.flux_share(LightId { emitter, primitive: 0 })), ..pdf }
    }

    /// A ray that sets out from a light, chosen by `u_light` with probability ∝ Φ. The choice is in the density by area and in the weight.
    pub fn sample_emission(
        &self,
        scene: &Scene,
        u_light: f32,
        u_position: Vec2,
        u_direction: Vec2,
        wl: &Wavelengths,
    ) -> Option<EmissionSample> {
        let (i, chosen, _) = self.by_flux.as_ref()?.sample_discrete(u_light.min(ONE_MINUS_EPSILON));
        let id = *self.emitting.get(i)?;
        let sample = scene.emitter(id.emitter).model.sample_emission(scene, id, u_position, u_direction, wl)?;
        let pdf = EmissionPdf { position: sample.pdf.position.times(chosen), ..sample.pdf };
        Some(EmissionSample { pdf, weight: sample.weight / chosen, ..sample })
    }

    /// The light primitive at x, if x emits.
    fn light_at(&self, scene: &Scene, x: &Interaction) -> Option<LightId> {
        let emitter = scene.surface(x.surface).emitter?;
        // Lights of one piece may be more than one triangle.
        let count = scene.emitter(emitter).model.primitive_count(scene);
        Some(LightId { emitter, primitive: if count == 1 { 0 } else { x.primitive } })
    }

    fn flux_share(&self, id: LightId) -> f32 {
        let i = (self.first_emitting[id.emitter.index()] + id.primitive) as usize;
        self.by_flux.as_ref().map_or(0.0, |table| table.probability(i))
    }

    /// P(tree | x).
    fn tree_share(&self, from: &LightReference) -> f32 {
        if self.distant.is_empty() {
            return 1.0;
        }
        let tree = if self.tree.is_empty() { 0.0 } else { self.tree.irradiance(from) };
        if tree <= 0.0 {
            return 0.0;
        }
        let distant = self.distant_irradiance(from);
        if distant <= 0.0 {
            return 1.0;
        }
        0.5 / (self.distant.len() as f32 + 1.0) + 0.5 * tree / (tree + distant)
    }

    fn distant_irradiance(&self, from: &LightReference) -> f32 {
        self.distant.iter().map(|d| d.weight(from)).sum()
    }
}

impl Distant {
    /// How often it is chosen at `from`, relative to others: its irradiance there, not quite down to zero where it grazes the surface, for bumps may
    /// lean towards it.
    fn weight(&self, from: &LightReference) -> f32 {
        let cos = match self.from {
            Some(wi) if from.n != Vec3::ZERO => from.n.dot(wi),
            _ => 1.0,
        };
        let cos = if from.one_sided { cos } else { cos.abs() };
        let irradiance = if from.shared { self.excess } else { self.irradiance };
        if cos > 0.0 { irradiance * cos.max(0.05) } else { 0.0 }
    }
}

/// One number for a hue, from -1 (blue) to 1 (red).
fn tint(power: Spectrum) -> f32 {
    let [r, g, b] = power.to_rgb().map(f32::abs);
    if r + g + b > 0.0 { (r - b) / (r + g + b) } else { 0.0 }
}

fn times(pdf: Pdf, probability: f32) -> Pdf {
    match pdf {
        Pdf::SolidAngle(p) => Pdf::SolidAngle(p * probability),
        Pdf::Delta(p) => Pdf::Delta(p * probability),
    }
}

//! Light samples of the surroundings where other lights may be chosen as well: those that chose them go together.

use super::{Descent, Lights, times};
use crate::emitter::{Escape, Light, LightId, LightQuery, LightSample, of};
use crate::ids::EmitterId;
use crate::scene::Scene;
use etendue_numerics::{Pdf, Ray, Wavelengths};

/// The sample of each choice: `None` where it fell on another light.
pub(super) type OfSky = Vec<Option<Option<LightSample>>>;

impl Lights {
    /// Samples the surroundings where the choice fell on them, if there are only these; [`Lights::chosen`] of each.
    pub(super) fn sample_sky(&self, scene: &Scene, choices: &[Descent<'_>], queries: &[LightQuery], wl: &[Wavelengths]) -> OfSky {
        let [sky] = self.environments[..] else { return Vec::new() };
        let share = |i: usize| Some((i, self.share_of_sky(&choices[i], sky)?));
        let asked: Vec<(usize, f32)> = (0..choices.len()).filter_map(share).collect();
        let queries: Vec<LightQuery> = asked.iter().map(|(i, _)| queries[*i]).collect();
        let wl: Vec<Wavelengths> = asked.iter().filter_map(|(i, _)| wl.get(*i).copied()).collect();

        let (id, mut samples) = (LightId { emitter: sky, primitive: 0 }, Vec::with_capacity(asked.len()));
        scene.emitter(sky).model.sample_each(scene, id, &queries, &wl, |k, sample| {
            samples.push(sample.map(|s| LightSample { pdf: times(s.pdf, asked[k].1), ..s }));
        });
        if self.distant.len() > 1 {
            self.look_again(scene, &queries, &wl, &mut samples);
        }
        let mut all = vec![None; choices.len()];
        asked.iter().zip(samples).for_each(|((i, _), sample)| all[*i] = Some(sample));
        all
    }

    /// The probability of a choice that fell on `sky`.
    fn share_of_sky(&self, choice: &Descent<'_>, sky: EmitterId) -> Option<f32> {
        let (distant, probability) = if choice.is_elsewhere() { self.choose_distant(choice.from, choice.u)? } else { return None };
        (distant.emitter == sky).then_some(choice.probability * probability)
    }

    /// Among several distant lights Le and p are those that a ray sees.
    fn look_again(&self, scene: &Scene, queries: &[LightQuery], wl: &[Wavelengths], samples: &mut [Option<LightSample>]) {
        let ray = |k: usize| Some((k, Ray::new(queries[k].from.p, samples[k].as_ref()?.wi)));
        let rays: Vec<(usize, Ray)> = (0..samples.len()).filter_map(ray).collect();
        let escapes = rays.iter().map(|(k, ray)| Escape { ray, from: Some(&queries[*k].from), wl: of(wl, *k) });
        let mut places = rays.iter().map(|(k, _)| *k);
        self.escaped_each(scene, escapes, |seen| {
            if let Some(sample) = places.next().and_then(|k| samples[k].as_mut()) {
                (sample.le, sample.pdf) = (seen.le, Pdf::SolidAngle(seen.pdf));
            }
        });
    }
}

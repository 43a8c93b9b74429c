//! Light straight from lamps that are patches, by rays to them.
//!
//! ```text
//! D_i = 1/A_i ∫_i Σ_l Be_l ∫_l V cosθ cosθ / (π r²)  ≈  1/M Σ_k Be_l g / (P_l A_i)          P_l ∝ Σ_channels A_l Be_l
//! E_i ← E_i + s D_i - (F Be)_i                                                              s by channel: Σ A s D = Σ A F Be
//! ```
//!
//! F Be is D too, but of cosine-distributed rays that happened to meet a lamp: with a thousand rays a patch some tens, which leaves 15 % of noise in the brightest light
//! of the scene. The equation keeps its form: what F says of light straight from lamps is put right by E. Σ A E stays, and so do the books.
//!
//! Where lamps are more than a quarter of all surfaces rays meet them anyway.

use super::rgb;
use crate::form_factor::{Sight, by_points, by_solid_angle};
use crate::patch::Patches;
use etendue_numerics::sequence::{mix, unit};
use etendue_numerics::{Net4, Vec2};
use etendue_scene::Scene;
use glam::DVec3;
use rayon::prelude::*;

/// The part of all area that lamps may be.
const MOST: f64 = 0.25;

/// D of all patches, W/m², of so many `rays` each; `None` where there are no lamps, or too many.
pub fn irradiance(scene: &Scene, patches: &Patches, rays: impl Fn(u32) -> usize + Sync, seed: u64) -> Option<Vec<DVec3>> {
    let lamps: Vec<u32> = (0..patches.len() as u32).filter(|l| !patches.get(*l).be.is_zero()).collect();
    let power = |l: u32| rgb(patches.get(l).be).element_sum() * patches.get(l).area;
    let area: f64 = lamps.iter().map(|l| patches.get(*l).area).sum();
    if lamps.is_empty() || area > MOST * patches.patches.iter().map(|p| p.area).sum::<f64>() {
        return None;
    }
    let sums: Vec<f64> = lamps
        .iter()
        .scan(0.0, |sum, l| {
            *sum += power(*l);
            Some(*sum)
        })
        .collect();
    let all = sums[sums.len() - 1];
    let sight = Sight::new(scene, patches);
    let of_patch = |i: u32| {
        let shift = f64::from(unit(mix(mix(seed) ^ u64::from(i)) as u32));
        let (mut sum, mut weights) = (DVec3::ZERO, 0.0);
        for (k, [u, v, s, t]) in Net4::new(!seed, u64::from(i)).take(rays(i)).enumerate() {
            let x = patches.sample(i, Vec2::new(u, v));
            weights += x.weight;
            // Lamps in turns, each as often as it is bright.
            let turn = (k as f64 * 0.618_033_988_749_895 + shift).fract();
            let l = lamps[sums.partition_point(|sum| *sum < turn * all).min(lamps.len() - 1)];
            let (middle, radius) = patches.ball(l);
            let near = x.p.distance(middle) < 4.0 * radius;
            let drawn = match patches.polygon(l).filter(|_| near) {
                Some(polygon) => by_solid_angle(patches, &x, i, l, &polygon, Vec2::new(s, t)),
                None => by_points(patches, &x, i, l, Vec2::new(s, t)),
            };
            if let Some((y, g)) = drawn
                && sight.sees((i, &x), (l, &y))
            {
                sum += rgb(patches.get(l).be) * (g * all / power(l));
            }
        }
        if weights > 0.0 { sum / (weights * patches.get(i).area) } else { DVec3::ZERO }
    };
    Some((0..patches.len() as u32).into_par_iter().with_min_len(16).map(of_patch).collect())
}

/// Puts `d` in the place of `f_be` = F Be, by what is added to E, given the areas of the patches.
pub fn put_right(direct: &mut [DVec3], d: &[DVec3], f_be: &[DVec3], areas: &[f64]) {
    let sum = |x: &[DVec3]| x.iter().zip(areas).map(|(x, a)| *x * *a).sum::<DVec3>();
    let (all, found) = (sum(f_be), sum(d));
    let part = |a: f64, b: f64| if b > 0.0 { a / b } else { 1.0 };
    let s = DVec3::new(part(all.x, found.x), part(all.y, found.y), part(all.z, found.z));
    direct.iter_mut().zip(d).zip(f_be).for_each(|((e, d), f)| *e += s * *d - *f);
}

//! Parts of patches that something stands on: no light leaves them or arrives.
//!
//! ```text
//! a point is covered        where another patch lies on it, or every ray from it meets what absorbs: the inside of a solid
//! open_i                    the part of patch i that is not covered
//! A_i ← A_i open_i,   absorbed_i ← absorbed_i - (1 - open_i),   row i divided by what is left of it
//! ```
//!
//! Patches are cut without regard to what stands on them. Without this the foot of a box would be seen as a dark rim on the floor around it,
//! half a patch wide, and the floor would give the box too little light.

use crate::form_factor::FormFactors;
use crate::patch::Patches;
use etendue_numerics::warp::square_to_cosine_hemisphere;
use etendue_numerics::{Frame, Net4, Ray, Vec2};
use etendue_scene::Scene;
use rayon::prelude::*;

/// Points looked at on a patch.
pub const POINTS: u32 = 64;

/// Rays of a point, of which the first that gets away decides.
const RAYS: u64 = 6;

/// What is left of a patch that is covered as a whole, so that nothing is divided by zero.
const LEAST: f64 = 1e-6;

/// The open part of each patch, by so many `points` of it.
pub fn open(scene: &Scene, patches: &Patches, points: impl Fn(u32) -> u32 + Sync, seed: u64) -> Vec<f64> {
    let of = |i: usize| {
        let points = points(i as u32) as usize;
        let covered = Net4::new(seed, i as u64).take(points).enumerate();
        let covered = covered.filter(|(k, u)| is_covered(scene, patches, i as u32, *k as u64, *u)).count();
        1.0 - covered as f64 / points as f64
    };
    (0..patches.len()).into_par_iter().with_min_len(64).map(of).collect()
}

fn is_covered(scene: &Scene, patches: &Patches, i: u32, k: u64, [a, b, c, d]: [f32; 4]) -> bool {
    let x = patches.sample(i, Vec2::new(a, b));
    if patches.touching_at(i, x.p).is_some() {
        return true;
    }
    let frame = Frame::from_normal(x.n.as_vec3());
    let absorbed = |u: Vec2| {
        let ray = patches.spawn(i, &x, frame.to_world(square_to_cosine_hemisphere(u)));
        meets_what_absorbs(scene, patches, &ray)
    };
    absorbed(Vec2::new(c, d)) && Net4::new(k, u64::from(i)).take(RAYS as usize).all(|[u, v, ..]| absorbed(Vec2::new(u, v)))
}

fn meets_what_absorbs(scene: &Scene, patches: &Patches, ray: &Ray) -> bool {
    let Some(hit) = scene.intersect(ray) else { return false };
    match patches.locate(ray, &hit) {
        Some(place) => place.patch.is_none(),
        None => !patches.objects[patches.object_of(&hit) as usize].is_clear,
    }
}

/// Takes covered parts out of the areas of patches.
pub fn shrink(patches: &mut Patches, open: &[f64]) {
    patches.patches.iter_mut().zip(open).for_each(|(patch, open)| patch.area *= open.max(LEAST));
}

/// Takes covered parts out of factors, which are not repaired yet.
pub fn uncover(factors: &mut FormFactors, patches: &Patches, open: &[f64]) {
    for (i, open) in open.iter().enumerate().filter(|(_, open)| **open < 1.0) {
        let range = factors.matrix.rows.indptr().outer_inds_sz(i);
        for j in patches.touching(i as u32) {
            if let Ok(k) = factors.matrix.rows.indices()[range.clone()].binary_search(&j) {
                factors.matrix.rows.data_mut()[range.start + k] = 0.0;
            }
        }
        if *open == 0.0 {
            factors.absorbed[i] = 1.0 - factors.escaped[i];
            continue;
        }
        // What is absorbed beyond the covered part stays; the rest is what the open part sends, and closes to one.
        let row = factors.matrix.rows.data()[range.clone()].iter().map(|f| f64::from(*f)).sum::<f64>();
        let absorbed = (factors.absorbed[i] - 1.0 + open).max(0.0);
        let all = if factors.losses_are_measured { row + factors.escaped[i] + absorbed } else { *open };
        if all > 0.0 {
            factors.matrix.rows.data_mut()[range].iter_mut().for_each(|f| *f = (f64::from(*f) / all) as f32);
            (factors.escaped[i], factors.absorbed[i]) = (factors.escaped[i] / all, absorbed / all);
        }
    }
}

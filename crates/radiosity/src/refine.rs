//! Patches cut finer where the light changes: a coarse solution tells where.
//!
//! ```text
//! error of a constant B on patch i  ≈  A_i ρ_i (max H - min H)  over H of the patch and of its corners
//! ```
//!
//! Half of the patches that were asked for are even; the other half come of cutting into four, in [`ROUNDS`] rounds, the patches with the largest error.
//! Edges of shadows, corners and the feet of objects are found so, and a patch that is partly covered by something standing on it.

use crate::patch::Patches;
use crate::solve::rgb;
use etendue_scene::Scene;
use glam::DVec3;

/// Rounds of cutting.
pub const ROUNDS: usize = 3;

/// Patches where `h` is the irradiance of `patches`, with at most `most` in all.
pub fn finer(scene: &Scene, patches: &Patches, h: &[DVec3], most: usize) -> Patches {
    let vertices = patches.vertices(scene);
    let at = vertices.average(patches, h);
    let error = |i: usize| {
        let corners = vertices.corners[i].iter().filter(|v| **v != u32::MAX).map(|v| at[*v as usize]);
        let (low, high) = corners.fold((h[i], h[i]), |(low, high), x| (low.min(x), high.max(x)));
        let patch = &patches.patches[i];
        (rgb(patch.rho) * (high - low)).element_sum() * patch.area
    };
    let mut order: Vec<(f64, usize)> = (0..patches.len()).map(|i| (error(i), i)).collect();
    order.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    // A cell has up to two patches, and each becomes four.
    let mut room = most.saturating_sub(patches.len());
    let mut marked = vec![false; patches.len()];
    let mut cells = std::collections::HashSet::new();
    for (error, i) in order {
        let cell = patches.patches[i].cell;
        let sides = patches.cells[cell as usize].sides();
        if error <= 0.0 || room < 3 * sides {
            break;
        }
        if cells.insert(cell) {
            room -= 3 * sides;
        }
        marked[i] = true;
    }
    patches.subdivided(scene, |i| marked[i as usize])
}

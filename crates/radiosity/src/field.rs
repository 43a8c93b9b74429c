//! A field over the surfaces from one value a patch: continuous where surfaces go on smoothly, broken where they meet at an angle.
//!
//! ```text
//! f(x) = Σ_v w_v(x) f_v        mean of f over patch i ≈ f_i
//! ```
//!
//! Weights are bilinear in quadrilaterals and linear in triangles. Vertex values start as means of the patches around. That alone would flatten the field
//! at the rims of surfaces, where there are patches on one side only; so what the means of f still lack is added to the vertices,
//! [`ROUNDS`] times, and what comes out is kept near the range of the patches around a vertex, and never below zero.

use crate::patch::{Patches, Vertices};
use glam::{DVec2, DVec3};

/// Corrections of the vertices.
pub const ROUNDS: usize = 2;

/// Values at the vertices of patches.
#[derive(Clone, Debug, Default)]
pub struct Field {
    at: Vec<DVec3>,
}

impl Field {
    /// The field whose means over the patches are near `values`.
    pub fn new(patches: &Patches, vertices: &Vertices, values: &[DVec3]) -> Self {
        let mut at = vertices.average(patches, values);
        let (low, high) = range(vertices, values);
        for _ in 0..ROUNDS {
            let lacking: Vec<DVec3> = (0..values.len()).map(|i| values[i] - mean(vertices, i, &at)).collect();
            let correction = vertices.average(patches, &lacking);
            for (v, c) in correction.iter().enumerate() {
                let reach = high[v] - low[v];
                at[v] = (at[v] + *c).clamp((low[v] - 0.5 * reach).max(DVec3::ZERO), high[v] + 0.5 * reach);
            }
            vertices.settle(&mut at);
        }
        Self { at }
    }

    /// The value at a place within patch i.
    #[inline]
    pub fn value(&self, vertices: &Vertices, i: u32, local: DVec2) -> DVec3 {
        vertices.weights(i, local).into_iter().map(|(v, w)| self.at[v as usize] * w).sum()
    }

    /// The values at the vertices.
    pub fn at_vertices(&self) -> &[DVec3] {
        &self.at
    }
}

/// The mean over patch i: that of its corners, exact for parallelograms and triangles.
fn mean(vertices: &Vertices, i: usize, at: &[DVec3]) -> DVec3 {
    let corners = vertices.corners[i];
    let n = if corners[3] == u32::MAX { 3 } else { 4 };
    corners[..n].iter().map(|v| at[*v as usize]).sum::<DVec3>() / n as f64
}

/// The least and the largest of the patches around each vertex and of those next to them.
fn range(vertices: &Vertices, values: &[DVec3]) -> (Vec<DVec3>, Vec<DVec3>) {
    let widen = |of: &[(DVec3, DVec3)]| {
        let mut at = vec![(DVec3::INFINITY, DVec3::NEG_INFINITY); vertices.points.len()];
        for (corners, (low, high)) in vertices.corners.iter().zip(of) {
            for v in corners.iter().filter(|v| **v != u32::MAX) {
                let range = &mut at[*v as usize];
                *range = (range.0.min(*low), range.1.max(*high));
            }
        }
        at
    };
    let around = widen(&values.iter().map(|v| (*v, *v)).collect::<Vec<_>>());
    let of_patch = |corners: &[u32; 4]| {
        let known = corners.iter().filter(|v| **v != u32::MAX).map(|v| around[*v as usize]);
        known.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |a, b| (a.0.min(b.0), a.1.max(b.1)))
    };
    widen(&vertices.corners.iter().map(of_patch).collect::<Vec<_>>()).into_iter().unzip()
}

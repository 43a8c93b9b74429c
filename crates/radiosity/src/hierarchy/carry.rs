//! F b by links: up the tree, across, and down again.
//!
//! ```text
//! pull      q_S = Σ_{j in S} A_j x_j b_j              the light of each cluster, all sizes at once
//! gather    h_R = Σ_links k q_S                        each cluster from those it is linked with
//! push      (F b)_i = x_i Σ_{R holding i} h_R           to each patch what came at its own size and at all above
//! ```
//!
//! Links between what emits light and what does not are carried likewise, with y in place of x. [`super::closure`] tells which they are.
//!
//! One pass goes through all levels: it is the V-cycle of [Hanrahan, Salzman, Aupperle 1991, fig. 8]. F_ij = x_i k A_j x_j with one k both ways, so
//! A_i F_ij = A_j F_ji to the last bit but of rounding: what one loses the other gets. The x_i close the rows ([`super::closure`]).

use super::Link;
use super::tree::Tree;
use glam::DVec3;
use rayon::prelude::*;
use std::ops::{Add, Mul};

/// Links in rows, one for each cluster.
#[derive(Clone, Debug, Default)]
pub struct Rows {
    begins: Vec<usize>,
    sources: Vec<u32>,
    kernels: Vec<f32>,
}

impl Rows {
    /// Both ways of all links that carry light, in their order.
    pub fn new(nodes: usize, links: &[Link]) -> Self {
        let mut begins = vec![0usize; nodes + 1];
        let ways = |link: &Link| {
            let [r, s] = link.ends;
            [(r, s, link.k), (s, r, link.k)].into_iter().take(if r == s { 1 } else { 2 }).filter(|way| way.2 > 0.0)
        };
        links.iter().flat_map(ways).for_each(|(r, ..)| begins[r as usize + 1] += 1);
        (0..nodes).for_each(|k| begins[k + 1] += begins[k]);
        let mut next = begins.clone();
        let (mut sources, mut kernels) = (vec![0; begins[nodes]], vec![0.0; begins[nodes]]);
        for (r, s, k) in links.iter().flat_map(ways) {
            let place = &mut next[r as usize];
            (sources[*place], kernels[*place]) = (s, k);
            *place += 1;
        }
        Self { begins, sources, kernels }
    }

    /// Bytes that they take.
    pub fn bytes(&self) -> usize {
        8 * (self.begins.len() + self.sources.len())
    }

    /// h of all clusters.
    fn gather<T: Carried>(&self, q: &[T]) -> Vec<T> {
        let row = |k: usize| {
            let range = self.begins[k]..self.begins[k + 1];
            let links = self.sources[range.clone()].iter().zip(&self.kernels[range]);
            links.fold(T::default(), |sum, (s, k)| sum + q[*s as usize] * f64::from(*k))
        };
        (0..self.begins.len() - 1).into_par_iter().with_min_len(256).map(row).collect()
    }
}

/// One number a patch, or three.
pub trait Carried: Copy + Default + Send + Sync + Add<Output = Self> + Mul<f64, Output = Self> {}
impl Carried for f64 {}
impl Carried for DVec3 {}

/// x_i Σ k A_j x_j b_j; zero at patches that are not in the tree.
pub fn carry<T: Carried>(tree: &Tree, rows: &Rows, areas: &[f64], x: &[f64], b: &[T]) -> Vec<T> {
    let q = tree.sums(|i| b[i as usize] * (areas[i as usize] * x[i as usize]), T::default());
    let mut out = vec![T::default(); b.len()];
    tree.hand_down(rows.gather(&q), |i, h| out[i as usize] = h * x[i as usize]);
    out
}

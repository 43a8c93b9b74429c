//! Form factors: F_ij is the part of the light that leaves patch i diffusely and arrives at patch j.
//!
//! ```text
//! F_ij = 1/A_i ∫_i ∫_j V(x, y) cosθx cosθy / (π r²) dA dA        Σ_j F_ij = 1 in a closed scene        A_i F_ij = A_j F_ji
//! ```
//!
//! | method | | good for |
//! | --- | --- | --- |
//! | [`hemisphere()`] | rays from each patch | any scene, hundreds of thousands of patches |
//! | [`analytic()`] | closed forms, less what is blocked | polygons, thousands of patches |
//! | [`by_area()`] | quadrature of the double integral | a check of the other two |
//!
//! The matrix is kept as F_ij = l_i M_ij r_j: M sparse, in single precision, and two diagonals in double precision. As estimated, l = r = 1 and M
//! is F itself. After a repair M is symmetric, l_i = x_i / A_i and r_j = x_j: reciprocity holds exactly whatever the rounding of M, and the x_i
//! close the rows as far as double precision goes.

mod area;
mod blocked;
mod hemisphere;
mod method;
mod pairs;
pub mod polygon;
mod repair;
mod tally;
mod visible;

pub(crate) use blocked::{by_points, by_solid_angle};
pub use hemisphere::{Hemisphere, Share, hemisphere};
pub(crate) use hemisphere::{Landing, land};
pub use method::{Method, TooLarge};
pub use pairs::{Pairs, analytic, by_area};
pub(crate) use repair::balance;
pub use repair::{CLOSED, Open, Repair};
pub use tally::REPLICATES;
pub(crate) use visible::Sight;

use glam::DVec3;
use rayon::prelude::*;
use sprs::CsMatI;

/// A sparse matrix in rows: 4 bytes for a column, 4 for a value.
pub type Rows = CsMatI<f32, u32, usize>;

/// Rows with the standard errors of their entries.
#[derive(Clone, Debug)]
pub struct Matrix {
    /// The numbers.
    pub rows: Rows,
    /// The standard error of each, in the order of `rows.data()`; empty where they were not asked for.
    pub errors: Vec<f32>,
}

/// Hears how many of how many rows are done; `false` stops the work.
pub type Watch<'a> = dyn Fn(usize, usize) -> bool + Sync + 'a;

/// The watch stopped the work.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Cancelled;

/// The form factors between all patches.
#[derive(Clone, Debug)]
pub struct FormFactors {
    /// M.
    pub matrix: Matrix,
    /// l.
    pub left: Vec<f64>,
    /// r.
    pub right: Vec<f64>,
    /// The part of the light of each patch that meets no surface.
    pub escaped: Vec<f64>,
    /// The part of the light of each patch that meets what is no patch: backs that absorb, obstacles.
    pub absorbed: Vec<f64>,
    /// The rays N_i of each row, where entries without a standard error have the variance F_ij / N_i at most; empty where none were cast.
    pub rays: Vec<f64>,
    /// Whether these two were measured, and are not just what rows lack.
    pub losses_are_measured: bool,
    /// From patches to objects, before any repair; the last two columns are what is absorbed and what escapes. Where the method counts them apart:
    /// the standard error of a sum is not the sum of its parts' errors.
    pub to_objects: Option<Matrix>,
}

impl FormFactors {
    /// From rows that hold F itself, without losses.
    pub fn new(matrix: Matrix) -> Self {
        let n = matrix.rows.rows();
        let none = vec![0.0; n];
        Self {
            matrix,
            left: vec![1.0; n],
            right: vec![1.0; n],
            escaped: none.clone(),
            absorbed: none,
            rays: Vec::new(),
            losses_are_measured: true,
            to_objects: None,
        }
    }

    /// The number of patches.
    pub fn len(&self) -> usize {
        self.left.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.left.is_empty()
    }

    /// The entries (j, F_ij) of row i, by j.
    #[inline]
    pub fn row(&self, i: usize) -> impl Iterator<Item = (usize, f64)> + '_ {
        let (left, range) = (self.left[i], self.matrix.rows.indptr().outer_inds_sz(i));
        let (columns, values) = (&self.matrix.rows.indices()[range.clone()], &self.matrix.rows.data()[range]);
        columns.iter().zip(values).map(move |(j, m)| (*j as usize, left * f64::from(*m) * self.right[*j as usize]))
    }

    /// F_ij.
    pub fn get(&self, i: usize, j: usize) -> f64 {
        self.matrix.rows.get(i, j).map_or(0.0, |m| self.left[i] * f64::from(*m) * self.right[j])
    }

    /// The standard error of F_ij; zero where it was not asked for.
    pub fn error(&self, i: usize, j: usize) -> f64 {
        match self.matrix.rows.nnz_index(i, j) {
            Some(k) if !self.matrix.errors.is_empty() => self.left[i] * f64::from(self.matrix.errors[k.0]) * self.right[j],
            _ => 0.0,
        }
    }

    /// (F b)_i of row i: the light that arrives from all patches, for radiosities b.
    #[inline]
    pub fn gather(&self, i: usize, b: &[DVec3]) -> DVec3 {
        self.row(i).map(|(j, f)| b[j] * f).sum()
    }

    /// F b. Rows are shared among the caller's threads; each is summed in the order of its columns.
    pub fn multiply(&self, b: &[DVec3]) -> Vec<DVec3> {
        (0..self.len()).into_par_iter().with_min_len(16).map(|i| self.gather(i, b)).collect()
    }

    /// Σ_j F_ij.
    pub fn row_sum(&self, i: usize) -> f64 {
        self.row(i).map(|(_, f)| f).sum()
    }

    /// Bytes of the matrix.
    pub fn bytes(&self) -> usize {
        self.matrix.rows.nnz() * 8 + self.matrix.errors.len() * 4 + self.len() * (5 * 8)
    }
}

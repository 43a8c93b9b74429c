//! What carries light between the patches of a solution: a matrix, or links.

use crate::form_factor::FormFactors;
use crate::hierarchy::Hierarchy;
use crate::solve::Exchange;
use glam::DVec3;

/// F, one way or the other.
#[derive(Clone, Debug)]
pub enum Carrier {
    /// A sparse matrix.
    Matrix(Box<FormFactors>),
    /// Links between clusters.
    Links(Box<Hierarchy>),
}

impl Carrier {
    /// Numbers that are kept: factors above zero, or links.
    pub fn entries(&self) -> usize {
        match self {
            Self::Matrix(f) => f.matrix.rows.nnz(),
            Self::Links(h) => h.links,
        }
    }

    /// Bytes that they take.
    pub fn bytes(&self) -> usize {
        match self {
            Self::Matrix(f) => f.bytes(),
            Self::Links(h) => h.bytes(),
        }
    }

    /// The links, if it is made of them.
    pub fn links(&self) -> Option<&Hierarchy> {
        match self {
            Self::Matrix(_) => None,
            Self::Links(h) => Some(h),
        }
    }
}

impl Exchange for Carrier {
    fn multiply(&self, b: &[DVec3]) -> Vec<DVec3> {
        match self {
            Self::Matrix(f) => f.multiply(b),
            Self::Links(h) => h.multiply(b),
        }
    }

    fn lost(&self, i: usize) -> [f64; 2] {
        match self {
            Self::Matrix(f) => f.lost(i),
            Self::Links(h) => h.lost(i),
        }
    }
}

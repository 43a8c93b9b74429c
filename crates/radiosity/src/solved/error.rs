//! Why there is no solution, in words.

use super::{Factors, Method};
use crate::form_factor::Cancelled;
use crate::patch::TooMany;
use crate::solve::direct::TooLarge;
use std::fmt;

/// What fits where something does not.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Fit {
    /// Ways to find the form factors.
    pub methods: Vec<Factors>,
    /// So many rays a patch, fewer than were asked for.
    pub rays: Option<u32>,
    /// So many patches, in the way that was asked for.
    pub patches: usize,
}

impl fmt::Display for Fit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let names: Vec<String> = self.methods.iter().map(|m| format!("`{}`", m.name())).collect();
        let mut ways = match &names[..] {
            [] => Vec::new(),
            [one] => vec![format!("{one} fits")],
            [first @ .., last] => vec![format!("{} and {last} fit", first.join(", "))],
        };
        ways.extend(self.rays.map(|rays| format!("`hemisphere` of {rays} rays a patch fits")));
        ways.push(format!("{} patches fit", self.patches));
        f.write_str(&ways.join(", or "))
    }
}

/// Why there is no solution.
#[derive(Clone, Debug, PartialEq)]
pub enum Error {
    /// More patches than can be numbered.
    TooMany(TooMany),
    /// The method does not fit.
    TooLarge(TooLarge),
    /// There are too many pairs for a method that goes through all.
    Pairs {
        /// Patches.
        patches: usize,
        /// The method.
        factors: Factors,
        /// What fits.
        fit: Fit,
    },
    /// The factors would not fit into memory.
    Memory {
        /// Patches.
        patches: usize,
        /// Bytes that the factors would take, at most.
        bytes: u64,
        /// What fits.
        fit: Fit,
    },
    /// The method of solving needs rows of a matrix, and there are links.
    NoRows {
        /// The method.
        method: Method,
    },
    /// Rows of links are closed with losses, and reciprocity alone was asked for.
    LossesOnly,
    /// It was stopped before there was anything to show.
    Cancelled,
}

impl From<Cancelled> for Error {
    fn from(Cancelled: Cancelled) -> Self {
        Self::Cancelled
    }
}

impl From<TooLarge> for Error {
    fn from(e: TooLarge) -> Self {
        Self::TooLarge(e)
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::TooMany(TooMany { patches, most, size: Some(size) }) => {
                write!(f, "there would be {patches} patches, and {most} are the most; patches of {size:.4} m fit")
            }
            Self::TooMany(TooMany { patches, most, size: None }) => {
                write!(f, "the scene has {patches} pieces before any is cut, and {most} patches are the most")
            }
            Self::TooLarge(e) => e.fmt(f),
            Self::Pairs { patches, factors, fit } => write!(
                f,
                "`{}` goes through all pairs, {:.0} million of {patches} patches, and takes {} patches at most; {fit}",
                factors.name(),
                (*patches as f64).powi(2) / 2e6,
                factors.most()
            ),
            Self::Memory { patches, bytes, fit } => write!(
                f,
                "form factors of {patches} patches would take up to {:.1} GiB, which cannot be had; {fit}",
                *bytes as f64 / f64::from(1 << 30),
            ),
            Self::NoRows { method } => write!(
                f,
                "`{}` needs form factors between all patches, and `hierarchical` has links between clusters; `neumann` fits",
                method.name()
            ),
            Self::LossesOnly => f.write_str(
                "`hierarchical` closes rows together with what its rays found lost; to make an open scene reciprocal only needs a matrix: `hemisphere`, `analytic` or `area`",
            ),
            Self::Cancelled => f.write_str("stopped before there was a solution"),
        }
    }
}

impl std::error::Error for Error {}

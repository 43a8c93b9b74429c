//! What to do: how form factors are found and the equation is solved.

use crate::form_factor::FormFactors;
use crate::hierarchy::Hierarchical;
use crate::patch::PatchSize;
use crate::solve::direct::TooLarge;
use crate::solve::{Equation, Solution, Until, direct, gauss_seidel, neumann, shooting};

/// How form factors are found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Factors {
    /// By rays.
    #[default]
    Hemisphere,
    /// Closed forms, less what rays find blocked.
    Analytic,
    /// Quadrature of the double integral.
    Area,
    /// None between patches: links between clusters ([`crate::hierarchy`]).
    Hierarchical,
}

impl Factors {
    /// All, as users write them, in the order of the variants.
    pub const NAMES: &'static [&'static str] = &["hemisphere", "analytic", "area", "hierarchical"];

    /// The one of a place in [`Factors::NAMES`].
    pub fn nth(i: usize) -> Self {
        [Self::Hemisphere, Self::Analytic, Self::Area, Self::Hierarchical][i.min(3)]
    }

    /// As users write it.
    pub fn name(self) -> &'static str {
        Self::NAMES[self as usize]
    }

    /// The most patches that it is of use for: beyond, a matrix of all pairs takes hours and more memory than there is.
    pub fn most(self) -> usize {
        if matches!(self, Self::Hemisphere | Self::Hierarchical) { usize::MAX } else { 16_384 }
    }
}

/// How the equation is solved.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Method {
    /// Bounce by bounce.
    #[default]
    Neumann,
    /// Gathering from what is newest.
    GaussSeidel,
    /// The brightest shoots first.
    Shooting,
    /// A dense factorisation.
    Direct,
}

impl Method {
    /// All, as users write them, in the order of the variants.
    pub const NAMES: &'static [&'static str] = &["neumann", "gauss-seidel", "shooting", "direct"];

    /// The method of a place in [`Method::NAMES`].
    pub fn nth(i: usize) -> Self {
        [Self::Neumann, Self::GaussSeidel, Self::Shooting, Self::Direct][i.min(3)]
    }

    /// As users write it.
    pub fn name(self) -> &'static str {
        Self::NAMES[self as usize]
    }

    /// Solves `equation`.
    pub fn solve(self, equation: &Equation<'_, FormFactors>, until: &Until<'_>) -> Result<Solution, TooLarge> {
        match self {
            Self::Neumann => Ok(neumann::solve(equation, until)),
            Self::GaussSeidel => Ok(gauss_seidel::solve(equation, until)),
            Self::Shooting => Ok(shooting::solve(equation, until)),
            Self::Direct => direct::solve(equation),
        }
    }
}

/// What to do.
#[derive(Clone, Copy, Debug)]
pub struct Settings {
    /// The size of patches.
    pub size: PatchSize,
    /// Whether patches that go by number are cut finer where the light changes.
    pub adaptive: bool,
    /// How form factors are found.
    pub factors: Factors,
    /// Form-factor rays a patch.
    pub rays: u32,
    /// Of `hierarchical`: the bound on its error, in parts of all reflected light.
    pub error: f64,
    /// How the equation is solved.
    pub method: Method,
    /// The relative residual at which it is.
    pub residual: f64,
    /// Sweeps at most.
    pub sweeps: usize,
    /// Of the rays.
    pub seed: u64,
    /// Bytes that form factors may take.
    pub memory: u64,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            size: PatchSize::Count(12_000),
            adaptive: true,
            factors: Factors::default(),
            rays: 1024,
            error: Hierarchical::default().error,
            method: Method::default(),
            residual: 1e-4,
            sweeps: 1000,
            seed: 0,
            memory: u64::MAX,
        }
    }
}

impl Settings {
    /// The most that F takes among so many patches, bytes: a row has an entry a ray at most, the symmetric matrix twice as many, and three are held at
    /// one time. By links: what they can do without is theirs, this is the tree and some sweeps.
    pub(super) fn bytes(&self, patches: usize) -> u64 {
        /// Bytes a patch of the tree, and of what goes up and down in it.
        const TREE: u64 = 1000;
        let n = patches as u64;
        if self.factors == Factors::Hierarchical {
            return n * TREE;
        }
        let (row, symmetric) = (n.min(u64::from(self.rays)), n.min(2 * u64::from(self.rays)));
        n * 8 * (2 * row + symmetric)
    }
}

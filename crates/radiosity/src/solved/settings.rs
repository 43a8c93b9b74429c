//! What to do: how form factors are found and the equation is solved.

use crate::choices::choices;
use crate::form_factor::{CLOSED, FormFactors, Open, Share};
use crate::hierarchy::Hierarchical;
use crate::patch::{PatchSize, Patches};
use crate::solve::direct::TooLarge;
use crate::solve::{Equation, Solution, Until, direct, gauss_seidel, neumann, shooting};

choices! {
    /// How form factors are found.
    Factors {
        #[default]
        Hemisphere = "hemisphere", "Cosine-distributed rays from each patch.";
        Analytic = "analytic", "Closed forms between polygons, less what rays find blocked; for some thousands of patches.";
        Area = "area", "Quadrature of the double integral; for some thousands of patches.";
        Hierarchical = "hierarchical", "Links between clusters of patches, as coarse as the stated error allows; for up to millions of patches.";
    }
}

choices! {
    /// How the equation is solved.
    Method {
        #[default]
        Neumann = "neumann", "Bounce by bounce.";
        GaussSeidel = "gauss-seidel", "Gathering from what is newest.";
        Shooting = "shooting", "The patch with most unshot light shoots first.";
        Direct = "direct", "A dense factorisation, for small scenes.";
    }
}

impl Factors {
    /// The most patches that it is of use for: beyond, a matrix of all pairs takes hours and more memory than there is.
    pub fn most(self) -> usize {
        if matches!(self, Self::Hemisphere | Self::Hierarchical) { usize::MAX } else { 16_384 }
    }
}

impl Method {
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
    /// What an open scene's rows are brought to.
    pub open: Open,
    /// The relative residual at which it is.
    pub residual: f64,
    /// Sweeps at most.
    pub sweeps: usize,
    /// How near to one the rows of F are brought.
    pub closure: f64,
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
            open: Open::default(),
            residual: 1e-4,
            sweeps: 1000,
            closure: CLOSED,
            seed: 0,
            memory: u64::MAX,
        }
    }
}

impl Settings {
    /// How patches have part in the rays: alike, unless there are more than twice as many as were asked for.
    pub(super) fn share(&self, patches: &Patches) -> Share {
        match self.size {
            PatchSize::Count(n) if patches.len() / 2 > n => {
                Share::ByArea { whole: patches.patches.iter().map(|p| p.area).sum::<f64>() / n.max(1) as f64 }
            }
            _ => Share::Even,
        }
    }

    /// The rays of a patch in the mean.
    pub(super) fn mean_rays(&self, patches: &Patches) -> u32 {
        let share = self.share(patches);
        let sum: u64 = patches.patches.iter().map(|p| u64::from(share.of(self.rays, p.area))).sum();
        sum.div_ceil(patches.len().max(1) as u64) as u32
    }

    /// The ways to find form factors of so many patches that fit.
    pub(super) fn fitting(&self, patches: usize) -> Vec<Factors> {
        let fits = |f: &Factors| patches <= f.most() && Self { factors: *f, ..*self }.bytes(patches) <= self.memory;
        Factors::ALL.iter().copied().filter(fits).collect()
    }

    /// The most rays, of a power of two, with which form factors of so many patches by rays fit.
    pub(super) fn fitting_rays(&self, patches: usize) -> Option<u32> {
        let fits = |rays: &u32| Self { factors: Factors::Hemisphere, rays: *rays, ..*self }.bytes(patches) <= self.memory;
        (4..self.rays.ilog2()).rev().map(|k| 1 << k).find(fits)
    }

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

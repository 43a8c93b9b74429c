//! A scene's radiosity from beginning to end: patches, light from elsewhere, form factors, their repair, the solution.
//!
//! ```text
//! scene → patches → E, F → F repaired → B, H = E + F B
//! ```
//!
//! | parameter | meaning | default |
//! | --- | --- | --- |
//! | `size` | of the patches | 12,000 in all |
//! | `adaptive` | where patches go by number, cut finer where the light changes ([`crate::refine`]) | true |
//! | `factors` | how they are found; patches that are yet to be cut finer have theirs by `hemisphere` | `hemisphere` |
//! | `rays` | form-factor rays a patch; of `analytic`, which shares them among the patches that may be hidden, 65,536 at least | 1024 |
//! | `method` | of solving | `neumann` |
//! | `residual` | relative, at which the solution is done | 1e-4 |
//! | `sweeps` | at most | 1000 |
//! | `seed` | of the rays | 0 |

use crate::form_factor::{Cancelled, FormFactors, Hemisphere, Pairs, Repair, Watch, analytic, by_area, hemisphere};
use crate::patch::{Cutting, PatchSize, Patches, Sides, TooMany};
use crate::solve::direct::{MOST, TooLarge};
use crate::solve::{Equation, Solution, Until, direct, gauss_seidel, lights, neumann, shooting};
use crate::{cover, refine};
use etendue_scene::Scene;
use glam::DVec3;
use std::fmt;

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
}

impl Factors {
    /// All, as users write them, in the order of the variants.
    pub const NAMES: &'static [&'static str] = &["hemisphere", "analytic", "area"];

    /// The one of a place in [`Factors::NAMES`].
    pub fn nth(i: usize) -> Self {
        [Self::Hemisphere, Self::Analytic, Self::Area][i.min(2)]
    }

    /// As users write it.
    pub fn name(self) -> &'static str {
        Self::NAMES[self as usize]
    }

    /// The most patches that it is of use for: beyond, a matrix of all pairs takes hours and more memory than there is.
    pub fn most(self) -> usize {
        if self == Self::Hemisphere { usize::MAX } else { 16_384 }
    }

    fn find(self, scene: &Scene, patches: &Patches, rays: u32, seed: u64, watch: &Watch<'_>) -> Result<FormFactors, Cancelled> {
        match self {
            Self::Hemisphere => hemisphere(scene, patches, &Hemisphere { rays, errors: false, seed }, watch),
            Self::Analytic => analytic(scene, patches, &Pairs { samples: rays.max(1 << 16), seed }, watch),
            Self::Area => by_area(scene, patches, watch),
        }
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
            method: Method::default(),
            residual: 1e-4,
            sweeps: 1000,
            seed: 0,
            memory: u64::MAX,
        }
    }
}

/// What has been reached.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Stage {
    /// So many patches.
    Patches(usize),
    /// So many rows of so many.
    Rows(usize, usize),
    /// The factors obey physics.
    Repaired,
    /// A sweep, and the residual after it.
    Sweep(usize, f64),
}

/// Why there is no solution.
#[derive(Clone, Copy, Debug, PartialEq)]
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
    },
    /// The factors would not fit into memory.
    Memory {
        /// Patches.
        patches: usize,
        /// Bytes that the factors would take, at most.
        bytes: u64,
        /// How many patches would fit.
        fit: usize,
    },
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
            Self::Pairs { patches, factors } => write!(
                f,
                "`{}` goes through all pairs, {:.0} million of {patches} patches, and takes {} patches at most; `hemisphere` fits",
                factors.name(),
                (*patches as f64).powi(2) / 2e6,
                factors.most()
            ),
            Self::Memory { patches, bytes, fit } => write!(
                f,
                "form factors of {patches} patches would take up to {:.1} GiB, which cannot be had; {fit} patches fit",
                *bytes as f64 / f64::from(1 << 30)
            ),
            Self::Cancelled => f.write_str("stopped before there was a solution"),
        }
    }
}

impl std::error::Error for Error {}

/// A scene with its solution.
#[derive(Clone, Debug)]
pub struct Solved {
    /// The patches.
    pub patches: Patches,
    /// F, repaired.
    pub factors: FormFactors,
    /// What the repair found.
    pub repair: Repair,
    /// E, W/m².
    pub direct: Vec<DVec3>,
    /// B, with the residuals on the way.
    pub solution: Solution,
}

impl Solved {
    /// Solves a scene. `watch` hears of stages; its `false` stops the factors for good, and the solution after the sweep.
    pub fn new(scene: &Scene, settings: &Settings, watch: &(dyn Fn(Stage) -> bool + Sync)) -> Result<Self, Error> {
        let mut patches = Self::patches(scene, settings)?;
        if let (PatchSize::Count(n), true) = (settings.size, settings.adaptive) {
            let coarse = Settings {
                factors: Factors::Hemisphere,
                rays: (settings.rays / 4).max(64),
                method: Method::Neumann,
                residual: 0.01,
                ..*settings
            };
            for round in 1..=refine::ROUNDS {
                let most = n / 2 + n / 2 * round / refine::ROUNDS;
                if patches.len() + 3 > most {
                    continue;
                }
                let solved = Self::of(scene, patches, &coarse, watch)?;
                let h = solved.equation().irradiance(&solved.solution.b);
                patches = refine::finer(scene, &solved.patches, &h, most);
            }
        }
        Self::of(scene, patches, settings, watch)
    }

    /// Solves for given patches.
    fn of(scene: &Scene, mut patches: Patches, settings: &Settings, watch: &(dyn Fn(Stage) -> bool + Sync)) -> Result<Self, Error> {
        if !watch(Stage::Patches(patches.len())) {
            return Err(Error::Cancelled);
        }
        let rows = |done, of| watch(Stage::Rows(done, of));
        let mut factors = settings.factors.find(scene, &patches, settings.rays, settings.seed, &rows)?;
        let open = cover::open(scene, &patches, settings.seed);
        cover::uncover(&mut patches, &mut factors, &open);
        let areas: Vec<f64> = patches.patches.iter().map(|p| p.area).collect();
        let repair = factors.repair(&areas);
        let mut direct = lights::irradiance(scene, &patches, settings.seed);
        direct.iter_mut().zip(&open).filter(|(_, open)| **open > 0.0).for_each(|(e, open)| *e /= *open);
        if !watch(Stage::Repaired) {
            return Err(Error::Cancelled);
        }
        let equation = Equation::new(&patches, &factors, direct);
        let sweep = |k, residual| watch(Stage::Sweep(k, residual));
        let until = Until { residual: settings.residual, sweeps: settings.sweeps, watch: &sweep };
        let solution = settings.method.solve(&equation, &until)?;
        let direct = equation.direct;
        Ok(Self { patches, factors, repair, direct, solution })
    }

    /// The patches before any is cut finer, if all that follows will fit.
    pub fn patches(scene: &Scene, settings: &Settings) -> Result<Patches, Error> {
        let size = match settings.size {
            PatchSize::Count(n) if settings.adaptive => PatchSize::Count(n / 2),
            size => size,
        };
        let cutting = Cutting { size, sides: Sides::ByMaterial, ..Cutting::default() };
        let patches = Patches::cut(scene, &cutting).map_err(Error::TooMany)?;
        let count = match settings.size {
            PatchSize::Count(n) => patches.len().max(n),
            _ => patches.len(),
        };
        if settings.method == Method::Direct && count > MOST {
            return Err(Error::TooLarge(TooLarge { patches: count }));
        }
        if count > settings.factors.most() {
            return Err(Error::Pairs { patches: count, factors: settings.factors });
        }
        let bytes = factor_bytes(count, settings.rays);
        if bytes > settings.memory {
            let fit = (1..40).map(|k| count >> k).find(|n| factor_bytes(*n, settings.rays) <= settings.memory);
            return Err(Error::Memory { patches: count, bytes, fit: fit.unwrap_or(1) });
        }
        Ok(patches)
    }

    /// The equation that was solved.
    pub fn equation(&self) -> Equation<'_, FormFactors> {
        Equation::new(&self.patches, &self.factors, self.direct.clone())
    }
}

/// The most that form factors and their repair take: a row has an entry a ray at most, the symmetric matrix twice as many, and three are held at one time.
fn factor_bytes(patches: usize, rays: u32) -> u64 {
    let row = (patches as u64).min(u64::from(rays));
    let symmetric = (patches as u64).min(2 * u64::from(rays));
    patches as u64 * 8 * (2 * row + symmetric)
}

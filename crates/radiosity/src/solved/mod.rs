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
//! | `rays` | form-factor rays a patch; of `analytic`, which shares them among the patches that may be hidden, 2^20 at least | 1024 |
//! | `method` | of solving | `neumann` |
//! | `residual` | relative, at which the solution is done | 1e-4 |
//! | `sweeps` | at most | 1000 |
//! | `seed` | of the rays | 0 |

mod error;
mod settings;

pub use error::Error;
pub use settings::{Factors, Method, Settings};

use crate::form_factor::{FormFactors, Open, Repair};
use crate::patch::{Cutting, PatchSize, Patches, Sides};
use crate::solve::direct::{MOST, TooLarge};
use crate::solve::{Equation, Solution, Until, lights};
use crate::{cover, refine};
use etendue_scene::Scene;
use glam::DVec3;

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
        let repair = factors.repair(&areas, Open::WithLosses);
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

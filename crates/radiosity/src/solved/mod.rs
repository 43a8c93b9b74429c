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
//! | `factors` | how they are found; patches that are yet to be cut finer have theirs by `hemisphere`, unless it is `hierarchical` | `hemisphere` |
//! | `rays` | form-factor rays a patch; where pieces alone are more than twice the patches asked for, they go by area, and all but large pieces have fewer; of `analytic`, which shares them among the patches that may be hidden, 2^20 at least | 1024 |
//! | `error` | of `hierarchical`: the bound on ‖B - B*‖ / ‖B - Be‖ at which links are fine enough | 0.2 |
//! | `method` | of solving; by links `neumann` alone | `neumann` |
//! | `open` | what rows of an open scene are brought to ([`crate::form_factor::Repair`]); by links `losses` alone | `losses` |
//! | `residual` | relative, at which the solution is done | 1e-4 |
//! | `sweeps` | at most | 1000 |
//! | `closure` | how near to one the rows of F are brought | 1e-13 |
//! | `seed` | of the rays | 0 |

mod carrier;
mod error;
mod settings;

pub use carrier::Carrier;
pub use error::{Error, Fit};
pub use settings::{Factors, Method, Settings};

use crate::form_factor::{FormFactors, Hemisphere, Open, Pairs, Repair, Share, analytic, by_area, hemisphere};
use crate::hierarchy::{Hierarchical, Hierarchy};
use crate::patch::{Cutting, PatchSize, Patches, Sides};
use crate::solve::direct::{MOST, TooLarge};
use crate::solve::{Equation, Solution, Until, lamps, lights, neumann};
use crate::{cover, refine};
use etendue_scene::Scene;
use glam::DVec3;

/// One ray to lamps for so many form-factor rays.
const LAMPS: usize = 8;

/// Points at least by which it is known what part of a patch is open.
const FEWEST: u32 = 16;

/// What has been reached.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Stage {
    /// So many patches.
    Patches(usize),
    /// So many rows of so many.
    Rows(usize, usize),
    /// Links of so many rays a patch, and the bound on their error.
    Links(usize, f64),
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
    pub exchange: Carrier,
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
                factors: if settings.factors == Factors::Hierarchical { settings.factors } else { Factors::Hemisphere },
                rays: (settings.rays / 4).max(64),
                error: 2.0 * settings.error,
                method: Method::Neumann,
                residual: 0.01,
                closure: 1e-3,
                ..*settings
            };
            let even = patches.len().max(n / 2);
            let finer = n.max(even + n / 2) - even;
            for round in 1..=refine::ROUNDS {
                let most = even + finer * round / refine::ROUNDS;
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
        let share = settings.share(&patches);
        let points = |i: u32| share.of(cover::POINTS, patches.get(i).area).max(FEWEST);
        let open = cover::open(scene, &patches, points, settings.seed);
        let mut direct = lights::irradiance(scene, &patches, settings.seed);
        direct.iter_mut().zip(&open).filter(|(_, open)| **open > 0.0).for_each(|(e, open)| *e /= *open);
        let sweep = |k, residual| watch(Stage::Sweep(k, residual));
        let until = Until { residual: settings.residual, sweeps: settings.sweeps, watch: &sweep };
        if settings.factors == Factors::Hierarchical {
            cover::shrink(&mut patches, &open);
            let memory = settings.memory.saturating_sub(settings.bytes(patches.len()));
            let method = Hierarchical { error: settings.error, seed: settings.seed, memory };
            let rows = |done, of| watch(Stage::Rows(done, of));
            let told = |rays, bound| watch(Stage::Links(rays, bound));
            let (links, b) = Hierarchy::new(scene, &patches, &open, &direct, &method, &rows, &told)?;
            let solution = neumann::go_on(&Equation::new(&patches, &links, direct.clone()), b, &until);
            let repair = links.repair;
            return Ok(Self { patches, exchange: Carrier::Links(Box::new(links)), repair, direct, solution });
        }
        // Of rays that meet lamps by chance there are few; pairs have no need of them.
        let rays = |i: u32| (share.of(settings.rays, patches.get(i).area) as usize / LAMPS).max(16);
        let by_rays = settings.factors == Factors::Hemisphere;
        let lit = by_rays.then(|| lamps::irradiance(scene, &patches, rays, settings.seed)).flatten();
        let (factors, repair) = factors(scene, &mut patches, &open, settings, share, watch)?;
        if !watch(Stage::Repaired) {
            return Err(Error::Cancelled);
        }
        if let Some(mut lit) = lit {
            lit.iter_mut().zip(&open).filter(|(_, open)| **open > 0.0).for_each(|(e, open)| *e /= *open);
            let equation = Equation::new(&patches, &factors, Vec::new());
            lamps::put_right(&mut direct, &lit, &factors.multiply(&equation.be), &equation.areas);
        }
        let solution = settings.method.solve(&Equation::new(&patches, &factors, direct.clone()), &until)?;
        let exchange = Carrier::Matrix(Box::new(factors));
        Ok(Self { patches, exchange, repair, direct, solution })
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
            PatchSize::Count(n) if settings.adaptive => n.max(patches.len() + n / 2),
            PatchSize::Count(n) => patches.len().max(n),
            _ => patches.len(),
        };
        if settings.method == Method::Direct && count > MOST {
            return Err(Error::TooLarge(TooLarge { patches: count }));
        }
        if settings.factors == Factors::Hierarchical && settings.method != Method::Neumann {
            return Err(Error::NoRows { method: settings.method });
        }
        if settings.factors == Factors::Hierarchical && settings.open == Open::Reciprocal {
            return Err(Error::LossesOnly);
        }
        let settings = &Settings { rays: settings.mean_rays(&patches), ..*settings };
        let bytes = settings.bytes(count);
        let (many, large) = (count > settings.factors.most(), bytes > settings.memory);
        if many || large {
            let methods = settings.fitting(count);
            let rays = (!methods.contains(&Factors::Hemisphere)).then(|| settings.fitting_rays(count)).flatten();
            let fits = |n: &usize| *n <= settings.factors.most() && settings.bytes(*n) <= settings.memory;
            let fit = Fit { methods, rays, patches: (1..40).map(|k| count >> k).find(fits).unwrap_or(1) };
            return Err(match many {
                true => Error::Pairs { patches: count, factors: settings.factors, fit },
                false => Error::Memory { patches: count, bytes, fit },
            });
        }
        Ok(patches)
    }

    /// The equation that was solved.
    pub fn equation(&self) -> Equation<'_, Carrier> {
        Equation::new(&self.patches, &self.exchange, self.direct.clone())
    }
}

/// F between patches as a matrix, repaired; what is covered is taken out of both.
fn factors(
    scene: &Scene,
    patches: &mut Patches,
    open: &[f64],
    settings: &Settings,
    share: Share,
    watch: &(dyn Fn(Stage) -> bool + Sync),
) -> Result<(FormFactors, Repair), Error> {
    let Settings { rays, seed, .. } = *settings;
    let rows = |done, of| watch(Stage::Rows(done, of));
    let mut factors = match settings.factors {
        Factors::Analytic => analytic(scene, patches, &Pairs { samples: rays.max(Pairs::default().samples), seed }, &rows)?,
        Factors::Area => by_area(scene, patches, &rows)?,
        Factors::Hemisphere | Factors::Hierarchical => {
            hemisphere(scene, patches, &Hemisphere { rays, share, errors: false, seed }, &rows)?
        }
    };
    cover::shrink(patches, open);
    cover::uncover(&mut factors, patches, open);
    let areas: Vec<f64> = patches.patches.iter().map(|p| p.area).collect();
    let repair = factors.repair_to(settings.closure, &areas, settings.open);
    Ok((factors, repair))
}

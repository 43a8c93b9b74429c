//! Radiosity: all light is diffuse, and goes from patch to patch; one linear equation holds it.
//!
//! ```text
//! B = Be + ρ (E + F B)                                  solved once, before the first pass
//! L(x) = Le(x) + ρ(x)/π [ E_direct(x) + H(x) ]          H = F (B - Be): irradiance by light that was reflected before
//! ```
//!
//! E_direct comes from a point on a light, sampled anew for each display ray, so that shadows are as sharp as they should be; H is interpolated
//! between patches ([`etendue_radiosity::Field`]). Surfaces that are not diffuse are shown as diffuse ones of their hemispherical reflectance.
//! Bounces are counted exactly: light of k bounces is ρ/π F b_{k-1} [Goral, Torrance, Greenberg, Battaile 1984].
//!
//! | parameter | meaning | default |
//! | --- | --- | --- |
//! | `patches` | how many, about | 12,000 |
//! | `patch_size` | their size, m; 0: by number | 0 |
//! | `samples` | form-factor rays a patch | 1024 |
//! | `method` | of form factors: `hemisphere`, `analytic`, `area`, `hierarchical` | `hemisphere` |
//! | `error` | of `hierarchical`: bound on the error of B, in parts of all reflected light, down to which links are refined | 0.2 |
//! | `solve` | `neumann`, `gauss-seidel`, `shooting`, `direct` | `neumann` |
//! | `open` | rows of open scenes: `losses`, one with what rays found lost; `reciprocal`, made reciprocal only | `losses` |
//! | `residual` | relative, at which the solution is done | 1e-4 |
//! | `show` | `smooth`; `gather`: H from one more ray a display ray; `patches`: B as it is | `smooth` |

mod look;
mod shown;

pub use look::Look;
pub use shown::{Show, Shown};

use crate::drivers::{Balance, Work, pixels};
use crate::parameters::{Parameter, Slot};
use crate::run::Run;
use crate::solver::{CannotGoOn, Estimates, Needs, Refusal, Solver};
use etendue_radiosity::form_factor::Open;
use etendue_radiosity::patch::PatchSize;
use etendue_radiosity::solved::{Factors, Method, Settings, Solved};
use etendue_scene::Scene;
use serde::{Deserialize, Serialize};

/// The solver `radiosity`.
#[derive(Clone, Copy, Debug)]
pub struct Radiosity {
    /// Patches in all, about.
    pub patches: u32,
    /// Their size, m; 0 goes by number.
    pub patch_size: f32,
    /// Form-factor rays a patch.
    pub samples: u32,
    /// A place in [`Factors::NAMES`].
    pub factors: usize,
    /// Bound on the error of `hierarchical`.
    pub error: f32,
    /// A place in [`Method::NAMES`].
    pub method: usize,
    /// A place in [`Open::NAMES`].
    pub open: usize,
    /// Relative residual.
    pub residual: f32,
    /// A place in [`Show::NAMES`].
    pub show: usize,
}

impl Default for Radiosity {
    fn default() -> Self {
        Self {
            patches: 12_000,
            patch_size: 0.0,
            samples: 1024,
            factors: 0,
            error: 0.2,
            method: 0,
            open: 0,
            residual: 1e-4,
            show: 0,
        }
    }
}

impl Radiosity {
    /// What users may set.
    pub const PARAMETERS: &'static [Parameter<Self>] = &[
        Parameter { name: "patches", summary: "patches in all, about", slot: |s| Slot::Count(&mut s.patches, 1..=4_000_000) },
        Parameter {
            name: "patch_size",
            summary: "size of patches in metres; 0 goes by their number",
            slot: |s| Slot::Number(&mut s.patch_size, 0.0..=1e6),
        },
        Parameter { name: "samples", summary: "form-factor rays a patch", slot: |s| Slot::Count(&mut s.samples, 16..=1 << 20) },
        Parameter { name: "method", summary: "how form factors are found", slot: |s| Slot::Choice(&mut s.factors, Factors::NAMES) },
        Parameter {
            name: "error",
            summary: "of `hierarchical`: bound on the error, in parts of all reflected light",
            slot: |s| Slot::Number(&mut s.error, 1e-3..=10.0),
        },
        Parameter { name: "solve", summary: "how the equation is solved", slot: |s| Slot::Choice(&mut s.method, Method::NAMES) },
        Parameter {
            name: "open",
            summary: "what the rows of an open scene are brought to",
            slot: |s| Slot::Choice(&mut s.open, Open::NAMES),
        },
        Parameter {
            name: "residual",
            summary: "relative residual at which it is solved",
            slot: |s| Slot::Number(&mut s.residual, 1e-12..=1.0),
        },
        Parameter { name: "show", summary: "how indirect light is shown", slot: |s| Slot::Choice(&mut s.show, Show::NAMES) },
    ];

    /// The same, as the radiosity room takes it.
    pub fn settings(&self, seed: u64) -> Settings {
        let size = match self.patch_size {
            0.0 => PatchSize::Count(self.patches as usize),
            h => PatchSize::Metres(f64::from(h)),
        };
        Settings {
            size,
            rays: self.samples,
            factors: Factors::nth(self.factors),
            error: f64::from(self.error),
            method: Method::nth(self.method),
            open: Open::nth(self.open),
            residual: f64::from(self.residual),
            seed,
            ..Settings::default()
        }
    }
}

/// What the first pass finds. A checkpoint does not hold it: it is found again.
#[derive(Default, Serialize, Deserialize)]
pub struct State {
    #[serde(skip)]
    shown: Option<Box<Shown>>,
}

impl Solver for Radiosity {
    type State = State;

    fn needs(&self) -> Needs {
        Needs { rgb: true, both_ways: true, ..Needs::default() }
    }

    fn estimates(&self) -> Estimates {
        Estimates::InTheLimit
    }

    fn refuses(&self, scene: &Scene) -> Option<Refusal> {
        let refusal = |e: etendue_radiosity::solved::Error| Refusal { reason: e.to_string(), instead: vec!["path-mis"] };
        Solved::patches(scene, &self.settings(0)).err().map(refusal)
    }

    fn splats(&self) -> bool {
        false
    }

    fn units(&self, size: [u32; 2]) -> usize {
        pixels::units(size)
    }

    fn books(&self, state: &State) -> Option<Balance> {
        let energy = state.shown.as_ref()?.energy;
        Some(Balance {
            emitted: (energy.emitted + energy.arrived).to_array(),
            absorbed: energy.absorbed.to_array(),
            escaped: energy.escaped.to_array(),
            cut: [0.0; 3],
            residual: energy.residual.to_array(),
        })
    }

    fn prepare(&self, _: &Scene, _: &Run<'_>) -> State {
        State::default()
    }

    fn pass(&self, scene: &Scene, run: &Run<'_>, state: &mut State, k: u32, work: &Work<'_>) -> Result<(), CannotGoOn> {
        let shown = state.shown.get_or_insert_with(|| {
            let goes_on = |_| !(work.stop_now)();
            let solved = Solved::new(scene, &self.settings(run.seed), &goes_on);
            Box::new(solved.map(|s| Shown::new(scene, &s, &run.rules, Show::nth(self.show))).unwrap_or_default())
        });
        pixels::pass(&Look(shown), scene, run, k, work);
        Ok(())
    }
}

//! Path tracing by a guide: [`crate::path_mis`] whose walks are sent where photons have shown that light comes from [Jensen 1995; Müller, Gross,
//! Novák 2017].
//!
//! ```text
//! wi ~ p = a p_b + (1 - a) p_g        p_b the BSDF's density, p_g the guide's, a the share of the former
//! ```
//!
//! | what | where |
//! | --- | --- |
//! | particles that teach | [`lesson`] |
//! | p_g around each place, and a | [`field`] |
//! | a density over directions | [`targets`] |
//! | the step of a walk | [`walk`] |
//! | whether to guide at all | [`trial`] |
//!
//! Before the first pass particles from the lights are followed, and what they leave behind makes the guide: at first few of them, and some walks that try it
//! tell whether the noise that it saves may be worth its time. If so, as many as the picture's size allows, and walks try again; where they find that it is not, all
//! passes are those of `path-mis`, to the bit. It is where light comes by mirrors or glass.
//!
//! **No bias.** The guide, and the decision for it, are made of numbers that no pass uses, and stand still from then on: whatever they are, each walk's mean is the
//! truth, since p is above zero wherever p_b is. No sample is weighed by what another has found.
//!
//! **Neighbours share** what they find, as walks of `path-mis` may (`neighbours`), and here they do unless told otherwise. What one of sixteen finds is weighed by the densities of all of them, so that not
//! each has to know every gap; and where hardly any walk finds light, that is all the noise there is. Errors of neighbours are alike then: `block=1` leaves each walk alone.
//!
//! What is spent before the first pass is a few per cent of what is planned; a time limit plans 200,000 walks a second, whatever the machine. Memory: while the
//! guide is made some 100 bytes a photon; about 10 remain.
//!
//! | parameter | meaning | default |
//! | --- | --- | --- |
//! | `photons` | photons that teach, about; fewer where that were more than one for eight walks that are planned | 2,097,152 |
//! | `guide` | `auto`; or `always`, whatever the trial says | `auto` |
//! | `block` | edge of the blocks of pixels that share, 1, 2 or 4; 1 leaves each walk alone | 4 |
//! | `follow` | κ: of n walks that find for each other κ √n are followed, from 0.25 to 4; 4 follows all of a block | 2 |

pub mod field;
pub mod lesson;
pub mod targets;
pub mod trial;
pub mod walk;

use crate::drivers::Work;
use crate::drivers::pixels::{self, Tiling};
use crate::parameters::{Parameter, Slot};
use crate::path_mis::PathMis;
use crate::run::{Run, Stop};
use crate::solver::{CannotGoOn, Needs, Solver};
use etendue_scene::Scene;
use field::Field;
use serde::{Deserialize, Serialize};
use walk::Guided;

/// Bytes of a photon, and of what is made of it.
const PER_PHOTON: u64 = 100;
/// Walks that a time limit plans for a second.
const PER_SECOND: f64 = 2e5;
/// Walks that must be planned for a guide to be thought of.
const FEWEST: u64 = 1 << 17;

/// A lesson and its trial.
struct Effort {
    /// Planned walks for a photon.
    photon: u64,
    /// Photons at most.
    photons: usize,
    /// Planned walks for one that tries.
    trial: u64,
    /// Gain from which the guide is worth it, or worth the next effort.
    gain: f64,
}

/// A glance, and then in earnest.
const EFFORTS: [Effort; 2] = [
    Effort { photon: 64, photons: 1 << 17, trial: 256, gain: 0.5 },
    Effort { photon: 8, photons: usize::MAX, trial: 128, gain: 1.0 },
];
/// Rays for a photon at most, where few arrive.
const RAYS: u64 = 4;
/// Walks of a trial at most.
const TRIED: u64 = 1 << 15;

/// The solver `path-guided`.
#[derive(Clone, Copy, Debug)]
pub struct PathGuided {
    /// Photons that teach, about.
    pub photons: u32,
    /// Place in [`GUIDE`].
    pub guide: usize,
    /// What guided walks have in common with those of `path-mis`, which take their place where a guide is not worth its time.
    pub mis: PathMis,
}

/// When to guide.
pub const GUIDE: &[&str] = &["auto", "always"];

impl Default for PathGuided {
    fn default() -> Self {
        Self { photons: 1 << 21, guide: 0, mis: PathMis { block: 2, follow: 2.0, ..PathMis::default() } }
    }
}

/// What is known before the first pass.
#[derive(Debug, Default, Serialize, Deserialize)]
pub enum State {
    /// Nothing yet.
    #[default]
    Untaught,
    /// That a guide is not worth its time.
    Unguided,
    /// Where light comes from.
    Guided(Field),
}

impl PathGuided {
    /// What users may set.
    pub const PARAMETERS: &[Parameter<Self>] = &[
        Parameter {
            name: "photons",
            summary: "photons that teach, about; fewer where few samples are planned, or few arrive",
            slot: |s| Slot::Count(&mut s.photons, 1..=1 << 22),
        },
        Parameter {
            name: "guide",
            summary: "auto: where a trial finds it worth its time; or always",
            slot: |s| Slot::Choice(&mut s.guide, GUIDE),
        },
        Parameter { name: "block", summary: PathMis::PARAMETERS[0].summary, slot: |s| (PathMis::PARAMETERS[0].slot)(&mut s.mis) },
        Parameter { name: "follow", summary: PathMis::PARAMETERS[1].summary, slot: |s| (PathMis::PARAMETERS[1].slot)(&mut s.mis) },
    ];

    /// The guide, or the decision against it; `None` where the render was stopped.
    fn teach(&self, scene: &Scene, run: &Run<'_>, work: &Work<'_>) -> Option<State> {
        let always = GUIDE[self.guide] == "always";
        let walks = planned(run, work);
        if !always && walks < FEWEST {
            return Some(State::Unguided);
        }
        let efforts = if always { &EFFORTS[1..] } else { &EFFORTS };
        let mut best = State::Unguided;
        for effort in efforts {
            let wanted = (self.photons as usize).min(effort.photons).min((walks / effort.photon) as usize);
            let photons = lesson::photons(scene, run, wanted, walks / effort.photon * RAYS, work)?;
            if photons.is_empty() {
                return Some(State::Unguided);
            }
            let field = Field::new(&photons);
            let tried = TRIED.min(walks / effort.trial);
            if !always && trial::gain(scene, run, &Guided { field: &field, mis: self.mis }, tried, work)? < effort.gain {
                return Some(State::Unguided);
            }
            best = State::Guided(field);
        }
        Some(best)
    }
}

/// Walks that are planned.
fn planned(run: &Run<'_>, work: &Work<'_>) -> u64 {
    let [width, height] = work.film.shape().size.map(u64::from);
    let passes = match run.stop {
        // However they are spread, and over replicates.
        Stop::Noise { limit, .. } => limit,
        _ => run.planned_samples(),
    };
    let all = u64::from(passes).saturating_mul(width * height);
    match run.stop {
        Stop::Time(limit) => all.min((limit.as_secs_f64() * PER_SECOND) as u64),
        _ => all,
    }
}

impl Solver for PathGuided {
    type State = State;

    fn needs(&self) -> Needs {
        Needs::default()
    }

    fn units(&self, size: [u32; 2]) -> usize {
        Tiling::new(size).len()
    }

    fn splats(&self) -> bool {
        false
    }

    /// By walks that are alone: the guide stands still.
    fn adapts(&self) -> bool {
        self.mis.block == 0
    }

    fn holds(&self, _: [u32; 2]) -> u64 {
        u64::from(self.photons) * PER_PHOTON
    }

    fn prepare(&self, _: &Scene, _: &Run<'_>) -> State {
        State::Untaught
    }

    fn pass(&self, scene: &Scene, run: &Run<'_>, state: &mut State, k: u32, work: &Work<'_>) -> Result<(), CannotGoOn> {
        if matches!(state, State::Untaught) {
            let Some(taught) = self.teach(scene, run, work) else { return Ok(()) };
            *state = taught;
        }
        match state {
            State::Guided(field) => pixels::pass(&Guided { field, mis: self.mis }, scene, run, k, work),
            _ => pixels::pass(&self.mis, scene, run, k, work),
        }
        Ok(())
    }
}

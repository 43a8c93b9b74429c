//! The numbers of a solution, and what should be said of its scene.

use crate::load::Loaded;
use crate::surfaces::{self, Defect};
use etendue_numerics::Spectrum;
use etendue_radiosity::Solved;
use etendue_radiosity::patch::Side;
use etendue_radiosity::solved::Settings;
use glam::DVec3;
use serde::Serialize;
use std::time::Duration;

/// The numbers of a solution. Fluxes are W by channel.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    /// Name and version.
    pub software: String,
    /// The scene.
    pub scene: String,
    /// Patches.
    pub patches: usize,
    /// How form factors were found.
    pub method: String,
    /// Form-factor rays a patch.
    pub rays_per_patch: u32,
    /// Factors above zero, or links between clusters.
    pub factors: usize,
    /// Bytes of the factors.
    pub factor_bytes: usize,
    /// Largest |1 - Σ F - losses| before the repair.
    pub closure_before: f64,
    /// After it.
    pub closure_after: f64,
    /// Σ |A_i F_ij - A_j F_ji| / Σ A before the repair; after it, it is zero.
    pub reciprocity_before: f64,
    /// Rows: `closed` where nothing is lost; of open scenes `losses`, one with what rays found lost, or `reciprocal`, what they lack is lost.
    pub rows: &'static str,
    /// The part of all light that the repair sent elsewhere: to make both estimates of each pair agree, and to close rows.
    pub moved_by_repair: f64,
    /// What of that the noise of the rays is expected to move; zero where it is not known.
    pub moved_by_noise: f64,
    /// Sweeps of scaling that the repair took.
    pub repair_sweeps: usize,
    /// By links: the bound on Σ A |B - B*| / Σ A |B - Be| against exact factors of the same patches; holds with 99.5 %.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub error_bound: Option<f64>,
    /// Whether that is as low as was asked.
    pub error_reached: bool,
    /// How the equation was solved.
    pub solve: String,
    /// The relative residual before the first sweep and after each.
    pub residuals: Vec<f64>,
    /// Whether the residual asked for was reached.
    pub converged: bool,
    /// Emitted by patches.
    pub emitted: [f64; 3],
    /// Arrived from lights that are no patches.
    pub arrived: [f64; 3],
    /// Absorbed.
    pub absorbed: [f64; 3],
    /// Escaped.
    pub escaped: [f64; 3],
    /// emitted + arrived - absorbed - escaped.
    pub residual: [f64; 3],
    /// Surfaces that are not diffuse, and what stands for them.
    pub not_diffuse: Vec<Substitute>,
    /// Surfaces that cannot be cut and are black.
    pub obstacles: Vec<String>,
    /// What is wrong with the surfaces.
    pub defects: Vec<Defect>,
    /// Threads.
    pub threads: usize,
    /// From the first patch to the last sweep, s.
    pub seconds: f64,
    /// Largest memory held, bytes.
    pub peak_memory_bytes: u64,
}

/// A diffuse surface in another's place.
#[derive(Clone, Debug, Serialize)]
pub struct Substitute {
    /// The surface.
    pub surface: String,
    /// Front or back.
    pub side: &'static str,
    /// Its material's model.
    pub material: String,
    /// Hemispherical reflectance that stands for it.
    pub reflectance: [f32; 3],
    /// What passes through it in truth, and is lost.
    pub transmitted: [f32; 3],
}

impl Report {
    pub(super) fn new(loaded: &Loaded, settings: &Settings, solved: &Solved, elapsed: Duration, threads: usize) -> Self {
        let energy = solved.equation().energy(&solved.solution.b);
        let rgb = |x: DVec3| x.to_array();
        let three = |s: Spectrum| s.to_rgb();
        let (repair, patches) = (&solved.repair, &solved.patches);
        let not_diffuse = patches.not_diffuse.iter().map(|n| Substitute {
            surface: surfaces::name(loaded, n.surface),
            side: if n.side == Side::Front { "front" } else { "back" },
            material: n.material.to_owned(),
            reflectance: three(n.reflected),
            transmitted: three(n.transmitted),
        });
        let links = solved.exchange.links();
        Self {
            software: crate::picture::software(),
            scene: loaded.name.clone(),
            patches: patches.len(),
            method: settings.factors.name().to_owned(),
            rays_per_patch: links.map_or(settings.rays, |l| l.rays as u32),
            factors: solved.exchange.entries(),
            factor_bytes: solved.exchange.bytes(),
            closure_before: repair.closure_before,
            closure_after: repair.closure_after,
            reciprocity_before: repair.reciprocity_before,
            rows: if repair.closed { "closed" } else { repair.open.name() },
            moved_by_repair: repair.moved_by_symmetry + repair.moved_by_scaling,
            moved_by_noise: repair.moved_by_noise,
            repair_sweeps: repair.sweeps,
            error_bound: links.map(|l| l.bound),
            error_reached: links.is_none_or(|l| l.reached),
            solve: settings.method.name().to_owned(),
            residuals: solved.solution.residuals.clone(),
            converged: solved.solution.residual() <= settings.residual,
            emitted: rgb(energy.emitted),
            arrived: rgb(energy.arrived),
            absorbed: rgb(energy.absorbed),
            escaped: rgb(energy.escaped),
            residual: rgb(energy.residual),
            not_diffuse: not_diffuse.collect(),
            obstacles: patches.obstacles.iter().map(|id| surfaces::name(loaded, *id)).collect(),
            defects: surfaces::defects(loaded, patches, &surfaces::names(loaded, patches)),
            threads,
            seconds: elapsed.as_secs_f64(),
            peak_memory_bytes: crate::memory::peak(),
        }
    }
}

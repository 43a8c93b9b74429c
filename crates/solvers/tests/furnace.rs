//! The furnace ladder: in a closed diffuse box with Le and albedo a, light of n bounces is Le aⁿ, and the sum up to n is
//! Le (1 - aⁿ⁺¹)/(1 - a), exactly: every solver is held to its own partial sum at every depth.
//!
//! Each test is one family of claims with 1 % of false alarms.

mod common;

use common::checks::{furnace, furnace_scene, neumann, round_furnace_scene};
use common::*;
use etendue_solvers::PathRules;
use etendue_solvers::direct::Direct;
use etendue_solvers::oracle::{Directions, Oracle, Recursion};
use etendue_solvers::path::Path;
use etendue_solvers::path_mis::PathMis;
use etendue_solvers::path_nee::PathNee;
use etendue_solvers::transport::Heuristic;

const ALBEDOS: [f32; 3] = [0.2, 0.5, 0.9];
const BALANCE: PathMis = PathMis::alone(Heuristic::Balance);
const POWER: PathMis = PathMis { block: 2, ..PathMis::alone(Heuristic::Power) };

/// Samples per pixel: more where light lives longer.
fn spp(a: f32, bounces: Option<u32>) -> u32 {
    match bounces {
        _ if a < 0.9 => 16,
        Some(_) => 64,
        None => 192,
    }
}

fn depths() -> impl Iterator<Item = Option<u32>> {
    (0..=6).map(Some).chain([None])
}

/// Cosine-sampled directions carry exactly the albedo: without roulette the walk has no noise at all.
#[test]
fn path_is_exact_without_roulette() {
    for a in ALBEDOS {
        let scene = furnace_scene([a; 3]);
        for n in 0..=6 {
            let job = samples(4).with(PathRules { max_edges: n + 1, rr_depth: Some(u32::MAX), ..PathRules::default() });
            for pixel in picture(&scene, &Path, job).iter().flatten() {
                let want = neumann(f64::from(a), Some(n));
                assert!((f64::from(*pixel) / want - 1.0).abs() < 2e-6, "albedo {a}, {n} bounces: {pixel} instead of {want}");
            }
        }
    }
}

#[test]
fn path() {
    let mut family = Family::default();
    for a in ALBEDOS {
        let scene = furnace_scene([a; 3]);
        for n in depths() {
            // Where little is reflected roulette leaves few walks, of great weight: enough must be begun to see some.
            let spp = if a < 0.5 { 1024 } else { spp(a, n) };
            furnace(&mut family, "path", &Path, (&scene, a), n, spp, 0.03);
        }
    }
    family.must_hold();
}

#[test]
fn path_nee() {
    let mut family = Family::default();
    for a in ALBEDOS {
        let scene = furnace_scene([a; 3]);
        for n in depths() {
            furnace(&mut family, "path-nee", &PathNee, (&scene, a), n, 4 * spp(a, n), 0.05);
        }
    }
    family.must_hold();
}

#[test]
fn path_mis() {
    let mut family = Family::default();
    for a in ALBEDOS {
        let scene = furnace_scene([a; 3]);
        for n in depths() {
            furnace(&mut family, "path-mis, power", &POWER, (&scene, a), n, spp(a, n), 0.02);
            furnace(&mut family, "path-mis, balance", &BALANCE, (&scene, a), n, spp(a, n), 0.02);
        }
    }
    family.must_hold();
}

/// One bounce, whatever the numbers of samples of each kind.
#[test]
fn direct() {
    let mut family = Family::default();
    for a in ALBEDOS {
        let scene = furnace_scene([a; 3]);
        for (emitter_samples, bsdf_samples) in [(1, 1), (2, 1), (1, 3), (0, 2), (2, 0), (8, 8)] {
            let name = format!("direct, {emitter_samples} + {bsdf_samples}");
            let solver = Direct { emitter_samples, bsdf_samples };
            let pictures = replicates(&scene, &solver, samples(32));
            family.expect(format!("{name}, albedo {a}"), &mean_of(&pictures, 0), 1.0 + f64::from(a), 0.04);
            // Without the one bounce the emitter is left.
            furnace(&mut family, &name, &solver, (&scene, a), Some(0), 1, 0.02);
        }
    }
    family.must_hold();
}

#[test]
fn oracle() {
    let mut family = Family::default();
    for directions in [Directions::Uniform, Directions::Cosine, Directions::Bsdf] {
        for a in ALBEDOS {
            let scene = round_furnace_scene([a; 3]);
            for n in depths() {
                if (directions, a, n) == (Directions::Uniform, 0.9, None) {
                    continue; // (2a cosθ)² has the mean 4/3 a² > 1: the variance of endless walks is infinite.
                }
                let solver = Oracle { directions, absorption: 0.1, ..Oracle::default() };
                let name = format!("oracle, {directions:?}");
                furnace(&mut family, &name, &solver, (&scene, a), n, 2 * spp(a, n), 0.06);
            }
        }
    }
    family.must_hold();
}

/// Trees of several samples per vertex are the same estimate.
#[test]
fn oracle_with_trees() {
    let mut family = Family::default();
    let solver = Oracle { view_samples: 2, shadow_rays: 2, indirect_samples: 3, ..Oracle::default() };
    let scene = round_furnace_scene([0.5; 3]);
    for n in 0..=3 {
        furnace(&mut family, "oracle, trees", &solver, (&scene, 0.5), Some(n), 16, 0.05);
    }
    family.must_hold();
}

/// The recursion taken word for word counts direct light twice: (1 + a)/(1 - a).
#[test]
fn the_unmended_recursion_counts_light_twice() {
    let mut family = Family::default();
    for a in [0.2f32, 0.5] {
        let solver = Oracle { recursion: Recursion::AsTold, ..Oracle::default() };
        let pictures = replicates(&round_furnace_scene([a; 3]), &solver, samples(64));
        let a = f64::from(a);
        family.expect(format!("albedo {a}"), &mean_of(&pictures, 0), (1.0 + a) / (1.0 - a), 0.04);
    }
    family.must_hold();
}

/// Light of exactly A to B bounces is the difference of two partial sums; the channels do not mix.
#[test]
fn ranges_of_bounces_and_channels() {
    let mut family = Family::default();
    let albedo = [0.2f32, 0.5, 0.9];
    let scene = round_furnace_scene(albedo);
    for (from, to) in [(0, 0), (0, 2), (1, 1), (2, 4), (3, u32::MAX - 1)] {
        let job = samples(64).with(PathRules::default().with_bounces(from..=to));
        let to = (to < 1000).then_some(to);
        let mut solver = |name: &str, pictures: Vec<Picture>| {
            for (channel, a) in albedo.iter().enumerate() {
                let a = f64::from(*a);
                let want = neumann(a, to) - if from == 0 { 0.0 } else { neumann(a, Some(from - 1)) };
                family.expect(format!("{name}, bounces {from} to {to:?}, albedo {a}"), &mean_of(&pictures, channel), want, 0.12);
            }
        };
        solver("path", replicates(&scene, &Path, job));
        solver("path-nee", replicates(&scene, &PathNee, job));
        solver("path-mis", replicates(&scene, &POWER, job));
        solver("oracle", replicates(&scene, &Oracle { absorption: 0.1, ..Oracle::default() }, job));
    }
    family.must_hold();
}

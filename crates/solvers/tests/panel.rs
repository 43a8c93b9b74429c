//! The judge of `verify` and `compare`: it lets right solvers pass at the stated rate over many seeds, and refutes each of several deliberate faults.

mod common;
#[macro_use]
#[path = "saboteurs/faults.rs"]
mod faults;

use common::{area, camera, diffuse, scene, threads};
use etendue_accel::Hit;
use etendue_numerics::Sampler;
use etendue_scene::Scene;
use etendue_solvers::agreement::{Expected, Panel, Standard, Trial, Verdict, judge};
use etendue_solvers::path::Path;
use etendue_solvers::path_mis::PathMis;
use etendue_solvers::path_nee::PathNee;
use etendue_solvers::transport::{Context, PathSolver, PathState, Step};
use etendue_solvers::{CancelToken, PathRules};

/// A coloured room with a lamp under its ceiling, a gold ball and a glass ball.
fn room() -> Scene {
    scene(&format!(
        r#"{}
        <shape type="cube"><boolean name="flip_normals" value="true"/>
            <bsdf type="diffuse"><rgb name="reflectance" value="0.7, 0.5, 0.3"/></bsdf></shape>
        <shape type="rectangle">
            <transform name="to_world"><rotate x="1" angle="90"/><scale x="0.6" z="0.6"/><translate y="0.9"/></transform>{}{}</shape>
        <shape type="sphere"><point name="center" value="-0.4, -0.6, 0.3"/><float name="radius" value="0.38"/>
            <bsdf type="roughconductor"><string name="material" value="Au"/><float name="alpha" value="0.3"/></bsdf></shape>
        <shape type="sphere"><point name="center" value="0.45, -0.6, 0"/><float name="radius" value="0.35"/>
            <bsdf type="dielectric"/></shape>"#,
        camera("0, 0, -0.95", "0, 0, 1", "0, 1, 0", 75.0, [16, 16]),
        diffuse(0.2),
        area("3, 4, 5")
    ))
}

const RULES: PathRules = PathRules { min_edges: 1, max_edges: 5, rr_depth: Some(3), hide_emitters: false, null_counts: true };

faults! {
    /// Sampled light is 5 % too bright: a density that is slightly off.
    DensityOff,
    /// f Le V / p, without cosθ.
    LostCosine,
    /// Light that is hit counts in full, beside light that is sampled.
    NoCompetition,
    /// Shadow rays are not cast.
    NoShadows,
    /// Every bounce takes 3 % with it.
    BounceLosesEnergy,
    /// Survivors of roulette are not paid.
    RouletteUnpaid,
    /// One bounce too many.
    OneBounceTooMany,
    /// Light is lost in one corner of the room only.
    DarkCorner,
    /// Red and blue are swapped on the way.
    SwappedChannels,
}

/// path-mis with a fault.
struct Faulty(Fault);

impl PathSolver for Faulty {
    fn scatter(&self, c: &Context<'_>, state: &mut PathState, hit: Option<Hit>, u: &Sampler) -> Step {
        let mut c = *c;
        let x = hit.map(|hit| c.scene.interaction(&state.ray, &hit));
        match self.0 {
            OneBounceTooMany => c.rules.max_edges += 1,
            BounceLosesEnergy if state.edges > 1 => state.beta.divide(1.0 / 0.97),
            // Before roulette divides by q, multiply by it: what it does to a throughput that is not paid.
            RouletteUnpaid if state.vertex > c.rules.rr_depth() => state.beta.divide(1.0 / 0.8),
            _ => (),
        }
        let before = state.l;
        let mut step = match self.0 {
            NoCompetition => {
                if let Some(x) = x.as_ref().filter(|_| state.edges > 1 && !state.pdf.is_delta()) {
                    state.collect(&c.rules, c.scene.le(x, &state.wl));
                }
                PathNee.scatter(&c, state, hit, u)
            }
            _ => PathMis::default().scatter(&c, state, hit, u),
        };
        if let (Some(query), Some(x)) = (&mut step.shadow, x) {
            match self.0 {
                DensityOff => query.contribution *= 1.05,
                LostCosine => query.contribution *= 1.0 / query.ray.d.normalize().dot(x.n).abs().max(0.05),
                OneBounceTooMany => query.edges = query.edges.min(RULES.max_edges),
                NoShadows => query.ray.t_max = 1e-6,
                DarkCorner if x.p.x > 0.6 && x.p.y > 0.3 => query.contribution *= 0.0,
                _ => (),
            }
        }
        if self.0 == SwappedChannels && !step.goes_on && state.vertex > 2 {
            let [r, g, b] = (state.l - before).to_rgb();
            state.l = before + etendue_numerics::Spectrum::rgb(b, g, r);
        }
        step
    }
}

#[test]
fn each_fault_fails_and_the_control_passes() {
    let (scene, pool, cancel) = (room(), threads(2), CancelToken::default());
    let trial = Trial { rules: RULES, ..Trial::new(&scene, &pool, &cancel) };
    let standard = Standard::default();
    let tests = 3 * trial.grid().len();
    let measure = |solver: Faulty, stream: u64| {
        let render = |run: &etendue_solvers::Run<'_>, film: &etendue_film::Film| {
            etendue_solvers::render(&solver, "faulty", &scene, run, film, None)
        };
        trial.sample(&render, 32, 16, stream).expect("nobody stops it")
    };
    let reference = measure(Faulty(Faultless), 0);
    let control = judge(&measure(Faulty(Faultless), 1), Expected::Sample(&reference), &standard, tests);
    assert_eq!(control.verdict, Verdict::Pass, "{} / {}", control.worst, control.blindest);
    for (i, fault) in FAULTS.into_iter().enumerate() {
        let found = judge(&measure(Faulty(fault), 2 + i as u64), Expected::Sample(&reference), &standard, tests);
        assert_eq!(found.verdict, Verdict::Fail, "{fault:?}: {}", found.worst);
    }
}

/// 60 seeds of three right solvers, 180 pairs in 60 families at α = 1 %: 6 families or more that fail have a probability below 5e-5.
/// A difference that is looked at a second time goes away.
#[test]
fn right_solvers_pass_over_many_seeds() {
    let (scene, pool, cancel) = (room(), threads(2), CancelToken::default());
    let standard = Standard { bound: 0.2, block_bound: 2.0, ..Standard::default() };
    let (mut failed, mut confirmed, mut passed) = (0, 0, 0);
    for seed in 0..60 {
        let mis = PathMis::default();
        let trial = Trial { rules: RULES, seed, ..Trial::new(&scene, &pool, &cancel) };
        let mut panel = Panel::new(trial);
        panel.enter("path", trial.renderer(&Path), 4);
        panel.enter("path-nee", trial.renderer(&PathNee), 4);
        panel.enter("path-mis", trial.renderer(&mis), 2);
        (0..3).for_each(|i| panel.measure(i, 16).expect("nobody stops it"));
        let tests = panel.tests();
        let mut pairs = panel.pairs(&standard, tests);
        assert_eq!((pairs.len(), tests), (3, 3 * 3 * 17));
        failed += usize::from(pairs.iter().any(|p| p.verdict == Verdict::Fail));
        panel.confirm(&mut pairs, &standard).expect("nobody stops it");
        confirmed += pairs.iter().filter(|p| p.verdict == Verdict::Fail).count();
        passed += pairs.iter().filter(|p| p.verdict == Verdict::Pass).count();
    }
    assert!(failed < 6 && confirmed == 0 && passed > 0, "{failed}, {confirmed}, {passed}");
}

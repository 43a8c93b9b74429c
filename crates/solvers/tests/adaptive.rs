//! More samples where there is noise, from whole renders: the same light as with as many in every pixel, less noise, and a stop that hardly moves the mean.

mod common;

use common::*;
use etendue_check::{Moments, t_test};
use etendue_numerics::{Dim, Sampler, Spectrum};
use etendue_scene::Scene;
use etendue_solvers::drivers::PixelSolver;
use etendue_solvers::path_guided::PathGuided;
use etendue_solvers::path_mis::PathMis;
use etendue_solvers::transport::{Context, PathState};
use etendue_solvers::{Spread, Stop, Stopped};

/// A pass takes numbers, not light: 1 on average, as flashes of 1/q with probability q, one for the left quarter of the picture and one for the rest.
struct Flashes([f32; 2]);

impl PixelSolver for Flashes {
    fn radiance(&self, _: &Context<'_>, eye: PathState, u: &Sampler, _: &mut u64) -> Spectrum {
        let q = self.0[usize::from(eye.ray.d.x < 0.5 * eye.ray.d.z)];
        Spectrum::splat(if u.u1(Dim::at(1, 0)) < q { 1.0 / q } else { 0.0 })
    }
}

fn nothing(size: [u32; 2]) -> Scene {
    scene(&camera("0, 0, 0", "0, 0, 1", "0, 1, 0", 90.0, size))
}

fn mean(picture: &Picture) -> f64 {
    picture.iter().map(|p| f64::from(p[0])).sum::<f64>() / picture.len() as f64
}

/// Half of the renders stop after 64 passes, the others later: whoever stops first has had luck, for brighter pictures have less relative noise. Without any bias the mean would
/// be 1; what it is must be within 1 %, three standard errors included. Once with as many samples everywhere, since noise is, and once with more on one side.
#[test]
fn a_stop_that_follows_the_noise_hardly_moves_the_mean() {
    const RENDERS: u64 = 100;
    let scene = nothing([16, 16]);
    for (flashes, differ) in [(Flashes([0.2, 0.2]), false), (Flashes([0.06, 0.6]), true)] {
        let told =
            |seed: u64| render(&scene, &flashes, samples(0).adaptive(1e-9, 64).seed(5000 + seed)).1.noise.expect("noise mode");
        let mut told: Vec<f64> = (0..31).map(|seed| told(seed).percent().0).collect();
        told.sort_by(f64::total_cmp);
        let (mut means, mut early, mut uneven) = (Moments::default(), 0, 0);
        for seed in 0..RENDERS {
            let (film, outcome) = render(&scene, &flashes, samples(0).adaptive(told[15], 4096).seed(seed));
            assert_eq!(outcome.stopped, Stopped::Noise);
            early += u64::from(outcome.passes <= 64);
            uneven += u64::from(outcome.samples.is_some());
            means.add(mean(&film.develop()));
        }
        assert!((RENDERS / 5..4 * RENDERS / 5).contains(&early), "{early} of {RENDERS} stopped early: there is a choice");
        assert!(if differ { uneven == RENDERS } else { uneven < RENDERS / 20 }, "{uneven} of {RENDERS} had counts that differ");
        let verdict = t_test(&means, 1.0);
        assert!(verdict.difference.abs() + 3.0 * verdict.standard_error < 0.01, "{verdict:?}");
    }
}

/// A small lamp and a ball of glass: noise in some parts of the picture, none in others.
fn uneven(filter: &str) -> Scene {
    scene(&format!(
        r#"{}<shape type="cube"><boolean name="flip_normals" value="true"/>{}</shape>
        <shape type="sphere"><point name="center" value="0.5, 0.5, 0.5"/><float name="radius" value="0.3"/><bsdf type="dielectric"/></shape>
        <shape type="sphere"><point name="center" value="-0.4, 0.6, 0.2"/><float name="radius" value="0.1"/>{}</shape>"#,
        camera_with("0, 0, -0.95", "0, 0, 1", "0, 1, 0", 75.0, [16, 16], filter),
        diffuse(0.6),
        area("50, 40, 30")
    ))
}

/// Block by block and channel by channel the same light, through a filter that reaches beyond its pixel.
#[test]
fn pictures_are_the_same() {
    let mut family = Family::default();
    let scene = uneven(r#"<rfilter type="gaussian"/>"#);
    let adaptive = samples(0).adaptive(1e-9, 128);
    let jobs = [Job { spread: Spread::Uniform, ..adaptive }, adaptive.seed(77)];
    let [even, fed] = jobs.map(|job| replicates(&scene, &PathMis::default(), job));
    let mut guide = PathGuided::default();
    (guide.photons, guide.guide, guide.mis.block) = (8192, 1, 0);
    let guided = replicates(&scene, &guide, adaptive.seed(177));
    for (name, fed) in [("path-mis", fed), ("path-guided", guided)] {
        for (a, b) in blocks_of(&even, 16).iter().zip(blocks_of(&fed, 16)) {
            family.agree(format!("{name}, {}", a.0), &a.1, &b.1, 0.75, a.1.mean);
        }
        for channel in 0..3 {
            let [even, fed] = [&even, &fed].map(|pictures| mean_of(pictures, channel));
            family.agree(format!("{name}, all of it, channel {channel}"), &even, &fed, 0.08, even.mean);
        }
    }
    family.must_hold();
}

/// Samples differ, as many as there are passes on average; who cannot spread them takes one a pass.
#[test]
fn samples_are_counted() {
    let scene = uneven("");
    let (_, outcome) = render(&scene, &PathMis::default(), samples(0).adaptive(1e-9, 256));
    let taken = outcome.samples.expect("they differ");
    let mean = taken.iter().map(|n| f64::from(*n)).sum::<f64>() / taken.len() as f64;
    let (least, most) = (taken.iter().min().expect("pixels"), taken.iter().max().expect("pixels"));
    assert!((mean / 256.0 - 1.0).abs() < 0.05 && *least < 200 && *most > 400, "{least} to {most}, {mean} on average");
    let light = etendue_solvers::light_nee::LightNee;
    let (_, outcome) =
        render(&scene, &light, Job { stop: Stop::Noise { percent: 1e-9, limit: 32 }, spread: Spread::Adaptive, ..samples(0) });
    assert!(outcome.samples.is_none());
}

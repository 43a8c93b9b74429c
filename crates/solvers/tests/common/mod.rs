//! What the proofs share: scenes from text, renders, replicates, and the judge.
//!
//! A *claim* says that the mean of independent replicates equals a number, or the mean of other replicates. All claims of one test are a
//! *family*: it raises a false alarm with probability [`ALPHA`] at most [Šidák 1967], and a claim that could hide a bias as large
//! as its bound is no proof and fails as well.

#![allow(dead_code, reason = "each test file uses its own part")]

pub mod bidirectional;
pub mod checks;
pub mod interrupted;
pub mod worlds;

use etendue_check::{MeanTest, Moments, Verdict, compare_means, family_wise, student_p, t_test};
use etendue_description::Diagnostics;
use etendue_film::{Film, FilmShape};
use etendue_formats::ReadOptions;
use etendue_numerics::SequenceKind;
use etendue_scene::{CompileOptions, Scene};
use etendue_solvers::{CancelToken, Outcome, PathRules, Progress, Run, Solver, Spread, Stop};
use std::path::Path;
use std::sync::OnceLock;

/// False alarms per family.
pub const ALPHA: f64 = 0.01;
/// Replicates of every estimate.
pub const K: u64 = 16;
/// What rounding in f32 may do to a long path's mean, relative.
pub const ROUNDING: f64 = 3e-6;

/// Linear Rec.709, rows from the top.
pub type Picture = Vec<[f32; 3]>;

/// The scene of a file's body; panics with the file's errors.
pub fn scene(body: &str) -> Scene {
    let text = format!("<scene version=\"3.0.0\">{body}</scene>");
    let (description, diagnostics) = etendue_formats::read_str("test.xml", &text, &ReadOptions::default());
    assert!(!diagnostics.has_errors(), "{}", diagnostics.render(&description.sources));
    let mut diagnostics = Diagnostics::default();
    let scene = etendue_scene::compile(&description, &CompileOptions::default(), &mut diagnostics);
    scene.unwrap_or_else(|| panic!("{}", diagnostics.render(&description.sources)))
}

/// A perspective camera with a box filter.
pub fn camera(origin: &str, target: &str, up: &str, fov: f32, [width, height]: [u32; 2]) -> String {
    camera_with(origin, target, up, fov, [width, height], r#"<rfilter type="box"/>"#)
}

/// A perspective camera whose film holds `film`: its filter, its crop.
pub fn camera_with(origin: &str, target: &str, up: &str, fov: f32, [width, height]: [u32; 2], film: &str) -> String {
    format!(
        r#"<sensor type="perspective">
            <float name="fov" value="{fov}"/>
            <transform name="to_world"><lookat origin="{origin}" target="{target}" up="{up}"/></transform>
            <film type="hdrfilm"><integer name="width" value="{width}"/><integer name="height" value="{height}"/>{film}</film>
        </sensor>"#
    )
}

/// A grey diffuse material.
pub fn diffuse(reflectance: f32) -> String {
    format!(r#"<bsdf type="diffuse"><rgb name="reflectance" value="{reflectance}"/></bsdf>"#)
}

/// An area light.
pub fn area(radiance: &str) -> String {
    format!(r#"<emitter type="area"><rgb name="radiance" value="{radiance}"/></emitter>"#)
}

/// A picture file of `width` columns, rows from the top; its path. `name` is the test's own.
pub fn picture_file(name: &str, width: usize, pixels: &[[f32; 3]]) -> String {
    let mut pfm = format!("PF\n{width} {}\n-1.0\n", pixels.len() / width).into_bytes();
    for row in pixels.chunks(width).rev() {
        pfm.extend(row.iter().flatten().flat_map(|x| x.to_le_bytes()));
    }
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("{name}.pfm"));
    std::fs::write(&path, pfm).expect("the folder for temporary files");
    path.display().to_string()
}

/// How a picture is rendered.
#[derive(Clone, Copy, Debug)]
pub struct Job {
    /// Which paths count.
    pub rules: PathRules,
    /// When it is done.
    pub stop: Stop,
    /// How samples are spread.
    pub spread: Spread,
    /// Seed.
    pub seed: u64,
    /// Threads.
    pub threads: usize,
}

/// So many samples per pixel, all paths.
pub fn samples(spp: u32) -> Job {
    Job { rules: PathRules::default(), stop: Stop::Samples(spp), spread: Spread::Uniform, seed: 1, threads: 0 }
}

impl Job {
    /// Other rules.
    pub fn with(self, rules: PathRules) -> Self {
        Self { rules, ..self }
    }

    /// Paths of so many edges at most.
    pub fn edges(self, max_edges: u32) -> Self {
        Self { rules: PathRules { max_edges, ..self.rules }, ..self }
    }

    /// Until the noise is so many per cent, or so many passes are done, with more samples where there is noise.
    pub fn adaptive(self, percent: f64, limit: u32) -> Self {
        Self { stop: Stop::Noise { percent, limit }, spread: Spread::Adaptive, ..self }
    }

    /// Another seed.
    pub fn seed(self, seed: u64) -> Self {
        Self { seed, ..self }
    }
}

fn pool() -> &'static rayon::ThreadPool {
    static POOL: OnceLock<rayon::ThreadPool> = OnceLock::new();
    POOL.get_or_init(|| threads(2))
}

/// A pool of its own.
pub fn threads(count: usize) -> rayon::ThreadPool {
    rayon::ThreadPoolBuilder::new().num_threads(count).build().expect("threads")
}

/// A blank film for the scene's first view.
pub fn blank(scene: &Scene) -> Film {
    let film = &scene.views[0].film;
    Film::new(FilmShape { size: film.crop_size, kernel: film.filter })
}

/// Renders; the film and how it ended.
pub fn render(scene: &Scene, solver: &impl Solver, job: Job) -> (Film, Outcome) {
    let own = (job.threads > 0).then(|| threads(job.threads));
    let film = blank(scene);
    let run = Run {
        view: 0,
        seed: job.seed,
        sequence: SequenceKind::Sobol,
        stop: job.stop,
        spread: job.spread,
        rules: job.rules,
        digest: 0,
        pool: own.as_ref().unwrap_or_else(|| pool()),
        cancel: &CancelToken::default(),
        progress: &Progress::default(),
        events: &|_| (),
        checkpoint_every: None,
    };
    let outcome = etendue_solvers::render(solver, "test", scene, &run, &film, None).expect("nothing to resume");
    assert_eq!(film.dropped().0, 0, "samples that are not finite: {:?}", film.dropped().1);
    (film, outcome)
}

/// The picture.
pub fn picture(scene: &Scene, solver: &impl Solver, job: Job) -> Picture {
    render(scene, solver, job).0.develop()
}

/// The bits of a picture's numbers.
pub fn bits(picture: &Picture) -> Vec<u32> {
    picture.iter().flatten().map(|x| x.to_bits()).collect()
}

/// K pictures of independent seeds, derived from the job's.
pub fn replicates(scene: &Scene, solver: &impl Solver, job: Job) -> Vec<Picture> {
    (0..K).map(|r| picture(scene, solver, job.seed(job.seed * 1000 + r))).collect()
}

/// The mean over all pixels of a channel, replicate by replicate.
pub fn mean_of(pictures: &[Picture], channel: usize) -> Moments {
    pictures.iter().map(|p| p.iter().map(|x| f64::from(x[channel])).sum::<f64>() / p.len() as f64).collect()
}

/// The means over blocks of 4 × 4 pixels and channels, replicate by replicate; the picture is `width` wide.
pub fn blocks_of(pictures: &[Picture], width: usize) -> Vec<(String, Moments)> {
    const EDGE: usize = 4;
    let height = pictures[0].len() / width;
    let mut blocks = Vec::new();
    for (y0, x0) in (0..height).step_by(EDGE).flat_map(|y| (0..width).step_by(EDGE).map(move |x| (y, x))) {
        for channel in 0..3 {
            let mean = |picture: &Picture| {
                let inside = (y0..y0 + EDGE).flat_map(|y| (x0..x0 + EDGE).map(move |x| y * width + x));
                inside.map(|i| f64::from(picture[i][channel])).sum::<f64>() / (EDGE * EDGE) as f64
            };
            blocks.push((format!("block ({x0}, {y0}) channel {channel}"), pictures.iter().map(mean).collect()));
        }
    }
    blocks
}

/// A claim about a mean.
struct Claim {
    what: String,
    test: MeanTest,
    bound: f64,
}

/// Claims that are judged together.
#[derive(Default)]
pub struct Family {
    claims: Vec<Claim>,
}

impl Family {
    /// Claims that the mean is `expected`; a bias of `bound`, relative to it, must not go unseen.
    pub fn expect(&mut self, what: impl Into<String>, moments: &Moments, expected: f64, bound: f64) {
        let scale = if expected == 0.0 { 1.0 } else { expected.abs() };
        self.claims.push(Claim {
            what: what.into(),
            test: beyond_rounding(t_test(moments, expected), scale),
            bound: bound * scale,
        });
    }

    /// Claims that two means are equal; a bias of `bound`, relative to `scale`, must not go unseen.
    pub fn agree(&mut self, what: impl Into<String>, a: &Moments, b: &Moments, bound: f64, scale: f64) {
        self.claims.push(Claim { what: what.into(), test: beyond_rounding(compare_means(a, b), scale), bound: bound * scale });
    }

    /// The claims with their verdicts.
    pub fn verdicts(&self) -> Vec<(&str, Verdict)> {
        let level = family_wise(ALPHA, self.claims.len());
        self.claims.iter().map(|c| (c.what.as_str(), c.test.verdict(level, c.bound))).collect()
    }

    /// The claims that were refuted.
    pub fn failures(&self) -> Vec<String> {
        self.verdicts().iter().filter(|(_, v)| v.fails()).map(|(what, v)| format!("{what}: {v}")).collect()
    }

    /// Panics unless every claim passes, an inconclusive one included; names the worst.
    pub fn must_hold(&self) {
        assert!(!self.claims.is_empty());
        let mut bad: Vec<_> = self.verdicts().into_iter().filter(|(_, v)| !v.passes()).collect();
        bad.sort_by(|(_, a), (_, b)| a.interval().p_value.total_cmp(&b.interval().p_value));
        let words: Vec<String> = bad.iter().take(12).map(|(what, v)| format!("{what}: {v}")).collect();
        assert!(bad.is_empty(), "{} of {} claims do not hold\n{}", bad.len(), self.claims.len(), words.join("\n"));
    }
}

/// The same test of what of the difference rounding does not explain.
fn beyond_rounding(test: MeanTest, scale: f64) -> MeanTest {
    if test.difference.is_nan() {
        return test;
    }
    let difference = (test.difference.abs() - ROUNDING * scale).max(0.0).copysign(test.difference);
    let p_value = if test.standard_error > 0.0 {
        student_p(difference / test.standard_error, test.dof)
    } else {
        f64::from(u8::from(difference == 0.0))
    };
    MeanTest { difference, p_value, ..test }
}

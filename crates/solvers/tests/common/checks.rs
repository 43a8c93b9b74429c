//! The checks themselves, as functions of a solver: the proofs expect them to hold, the saboteurs to be caught by them.

use super::*;
use etendue_solvers::bidirectional::Bidirectional;
use etendue_solvers::light_nee::LightNee;
use etendue_solvers::metropolis::Metropolis;
use etendue_solvers::path::Path;
use etendue_solvers::path_mis::PathMis;
use etendue_solvers::path_nee::PathNee;
use etendue_solvers::photon_map::PhotonMap;

/// The furnace: a closed diffuse box with Le = 1 and the given albedo per channel, seen from inside.
pub fn furnace_scene(albedo: [f32; 3]) -> Scene {
    closed("cube", albedo)
}

/// The same in a ball, where cosθx cosθy / r² = 1/(4R²) everywhere: light points by area have a finite variance, which they have not in the
/// corners of a box.
pub fn round_furnace_scene(albedo: [f32; 3]) -> Scene {
    closed("sphere", albedo)
}

fn closed(shape: &str, [r, g, b]: [f32; 3]) -> Scene {
    scene(&format!(
        r#"{}<shape type="{shape}"><boolean name="flip_normals" value="true"/>
            <bsdf type="diffuse"><rgb name="reflectance" value="{r}, {g}, {b}"/></bsdf>{}
        </shape>"#,
        camera("0, 0, -0.5", "0.1, 0.2, 1", "0, 1, 0", 70.0, [4, 4]),
        area("1")
    ))
}

/// Le (1 + a + … + aⁿ); unbounded without n.
pub fn neumann(a: f64, bounces: Option<u32>) -> f64 {
    match bounces {
        Some(n) => (1.0 - a.powi(n as i32 + 1)) / (1.0 - a),
        None => 1.0 / (1.0 - a),
    }
}

/// Claims that the solver gives the n-th partial Neumann sum in a furnace of albedo `a`.
pub fn furnace(
    family: &mut Family,
    name: &str,
    solver: &impl Solver,
    (scene, a): (&Scene, f32),
    bounces: Option<u32>,
    spp: u32,
    bound: f64,
) {
    let job = samples(spp).edges(bounces.map_or(u32::MAX, |n| n + 1));
    let pictures = replicates(scene, solver, job);
    family.expect(
        format!("{name}, albedo {a}, bounces {bounces:?}"),
        &mean_of(&pictures, 0),
        neumann(f64::from(a), bounces),
        bound,
    );
}

/// Claims that two solvers agree in every block and channel, where a bias of `bound` of the light there must show (or of half the mean light, in
/// the darker blocks), and in the picture's mean, where a quarter of it must show.
pub fn agreement(family: &mut Family, name: &str, scene: &Scene, a: &[Picture], b: &[Picture], bound: f64) {
    let width = scene.views[0].film.crop_size[0] as usize;
    for channel in 0..3 {
        let (x, y) = (mean_of(a, channel), mean_of(b, channel));
        family.agree(format!("{name}: picture, channel {channel}"), &x, &y, 0.25 * bound, y.mean.max(1e-9));
    }
    let least = (0..3).map(|c| mean_of(b, c).mean).sum::<f64>() / 6.0;
    for ((place, x), (_, y)) in blocks_of(a, width).iter().zip(&blocks_of(b, width)) {
        family.agree(format!("{name}: {place}"), x, y, bound, y.mean.max(least).max(1e-9));
    }
}

/// Claims that walks from the eye, walks from the lights, both connected, and chains of them find the light of `path-mis`; `spp` are the samples of
/// `path-mis`, `path-nee` and `path`, which is left out where it has none.
pub fn solvers_find_the_same(scene: &Scene, [mis, nee, path]: [u32; 3]) {
    let reference = replicates(scene, &PathMis::default(), samples(mis));
    let mut family = Family::default();
    let mut compare = |name: &str, pictures: Vec<Picture>| agreement(&mut family, name, scene, &pictures, &reference, 0.6);
    compare("path-nee", replicates(scene, &PathNee, samples(nee).seed(2)));
    if path > 0 {
        compare("path", replicates(scene, &Path, samples(path).seed(3)));
    }
    compare("light-nee", replicates(scene, &LightNee, samples(192).seed(4)));
    compare("bidirectional", replicates(scene, &Bidirectional::default(), samples(64).seed(5)));
    compare("metropolis", replicates(scene, &Metropolis::default(), samples(192).seed(6)));
    family.must_hold();
}

/// Photon maps are right in the limit: their means are held to those of `path-mis`, within what their radius blurs.
pub fn photons_bring_the_same_light(scene: &Scene) {
    let solver = PhotonMap { photons: 4096, radius: 0.15, ..PhotonMap::default() };
    let reference = replicates(scene, &PathMis::default(), samples(128));
    let photons = replicates(scene, &solver, samples(32).seed(2));
    for channel in 0..3 {
        let (a, b) = (mean_of(&photons, channel), mean_of(&reference, channel));
        assert!((a.mean / b.mean - 1.0).abs() < 0.04, "channel {channel}: {} instead of {}", a.mean, b.mean);
    }
}

/// A camera that looks at a single point.
pub fn at_point(origin: &str, target: &str) -> String {
    camera(origin, target, "0, 1, 0", 0.001, [1, 1])
}

/// A large diffuse floor z = 0.
pub fn floor(reflectance: f32) -> String {
    format!(r#"<shape type="rectangle"><transform name="to_world"><scale value="50"/></transform>{}</shape>"#, diffuse(reflectance))
}

/// Claims that every pixel of `scene` has the mean `expected`, in all channels.
pub fn closed_form(family: &mut Family, name: &str, scene: &Scene, solver: &impl Solver, expected: f64, spp: u32, bound: f64) {
    closed_form_by(family, name, scene, solver, expected, samples(spp), bound);
}

/// The same for any job.
pub fn closed_form_by(family: &mut Family, name: &str, scene: &Scene, solver: &impl Solver, expected: f64, job: Job, bound: f64) {
    let pictures = replicates(scene, solver, job);
    for channel in 0..3 {
        family.expect(format!("{name}, channel {channel}"), &mean_of(&pictures, channel), expected, bound);
    }
}

/// E on the plane z = 0 at `p` of a polygon that radiates 1 [Lambert 1760]: ½ |Σ θ_i (Γ_i)_z|, with the angle θ_i and the unit normal Γ_i of
/// the triangle that edge i forms with p.
pub fn polygon_irradiance(p: [f64; 3], corners: &[[f64; 3]]) -> f64 {
    let unit = |a: [f64; 3]| {
        let l = a.iter().map(|x| x * x).sum::<f64>().sqrt();
        a.map(|x| x / l)
    };
    let v: Vec<[f64; 3]> = corners.iter().map(|c| unit(std::array::from_fn(|i| c[i] - p[i]))).collect();
    let edge = |i: usize| {
        let (a, b) = (v[i], v[(i + 1) % v.len()]);
        let angle = (a[0] * b[0] + a[1] * b[1] + a[2] * b[2]).acos();
        let cross = unit([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]);
        angle * cross[2]
    };
    0.5 * (0..v.len()).map(edge).sum::<f64>().abs()
}

/// Fresnel's reflectance of a plane between indices 1 and `eta` for unpolarised light that comes at cosine `c`.
pub fn fresnel(c: f64, eta: f64) -> f64 {
    let t = (1.0 - (1.0 - c * c) / (eta * eta)).sqrt();
    let (s, p) = ((c - eta * t) / (c + eta * t), (eta * c - t) / (eta * c + t));
    0.5 * (s * s + p * p)
}

//! The checks themselves, as functions of a solver: the proofs expect them to hold, the saboteurs to be caught by them.

use super::*;

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

/// Claims that two solvers agree in every block and channel; a bias of `bound`, relative to the second's mean picture, must show.
pub fn agreement(family: &mut Family, name: &str, scene: &Scene, a: &[Picture], b: &[Picture], bound: f64) {
    let width = scene.views[0].film.crop_size[0] as usize;
    for channel in 0..3 {
        let (x, y) = (mean_of(a, channel), mean_of(b, channel));
        family.agree(format!("{name}: picture, channel {channel}"), &x, &y, bound, y.mean.max(1e-9));
    }
    let scale = (0..3).map(|c| mean_of(b, c).mean).sum::<f64>() / 3.0;
    for ((place, x), (_, y)) in blocks_of(a, width).iter().zip(&blocks_of(b, width)) {
        family.agree(format!("{name}: {place}"), x, y, bound, y.mean.max(scale).max(1e-9));
    }
}

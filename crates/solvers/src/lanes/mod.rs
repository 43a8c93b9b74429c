//! The step of [`PathMis`] for many walks at once, a walk a lane: its twin, bit for bit.
//!
//! Vertices on Lambert's surfaces become lanes, all others take the scalar step. What looks things up (surfaces, textures, lights)
//! goes from walk to walk; what computes is a loop over lanes that the compiler makes vectors of ([`etendue_numerics::wide`]).
//!
//! | stage | scalar step | lanes |
//! | --- | --- | --- |
//! | the vertex | `Scene::interaction`, `collect` | the same, walk by walk |
//! | random numbers | `Sampler::u2` | `Sampler::u2_each` |
//! | a light | `Scene::sample_light` | the same, walk by walk |
//! | its connection | `transport::connection` | [`connect`] |
//! | the next direction | `Vertex::sample`, `PathState::turn` | [`turn`] |

mod connect;
mod turn;
mod vertices;

use crate::path_mis::PathMis;
use crate::transport::{Context, Crowd, PathSolver, Step, slot};
use connect::Connect;
use etendue_numerics::{Dim, Sampler, Vec2, Wavelengths, wide};
use etendue_scene::SurfaceId;
use turn::Turn;
use vertices::{Lane, Vertices};

/// Memory for the vertices, used again and again.
pub struct Lanes(Box<Vertices>);

impl Default for Lanes {
    fn default() -> Self {
        Self(Vertices::new())
    }
}

/// Advances all walks of the crowd by one vertex.
pub(crate) fn scatter_all(solver: &PathMis, c: &Context<'_>, crowd: &mut Crowd) {
    let mut lanes = std::mem::take(&mut crowd.lanes).unwrap_or_default();
    let v = &mut *lanes.0;
    for k in 0..crowd.going.len() {
        let i = crowd.going[k];
        let (walk, u, hit) = (&mut crowd.walks[i as usize], &crowd.samplers[i as usize], crowd.hits[k]);
        let lambert = hit.filter(|hit| {
            let surface = c.scene.surface(SurfaceId(hit.geometry));
            c.scene.material(surface.material).is_lambert(c.scene) && walk.edges < c.rules.max_edges && walk.wl == Wavelengths::Rgb
        });
        let Some(hit) = &lambert else {
            let step = solver.scatter(c, walk, hit, u);
            crowd.take(i, &step);
            continue;
        };
        let x = c.scene.interaction(&walk.ray, hit);
        let surface = c.scene.surface(x.surface);
        if surface.emitter.is_some() {
            solver.collect(c, walk, Some(&x));
        }
        if let Some((rho, is_turned)) = c.scene.material(surface.material).lambert(c.scene, &x, &walk.wl) {
            v.push(i, walk, u, &x, rho, is_turned);
        }
        if v.is_full() {
            advance(solver, c, crowd, v);
        }
    }
    advance(solver, c, crowd, v);
    crowd.lanes = Some(lanes);
}

/// Advances the walks in lanes, and empties them.
fn advance(solver: &PathMis, c: &Context<'_>, crowd: &mut Crowd, v: &mut Vertices) {
    if v.count() == 0 {
        return;
    }
    // All walks of a crowd are at the same vertex.
    let vertex = crowd.walks[v.walk[0] as usize].vertex;

    // Light that a light sample finds.
    if !c.scene.lights.is_alone() {
        for (i, u) in v.samplers.iter().enumerate() {
            v.u_light[i] = u.u1(Dim::at(vertex, slot::LIGHT));
        }
    }
    draw(&v.samplers, Dim::at(vertex, slot::LIGHT_POINT), &mut v.u_point);
    for i in 0..v.count() {
        let u = Vec2::new(v.u_point[0][i], v.u_point[1][i]);
        let sample = c.scene.sample_light(&v.from[i], v.u_light[i], u, &Wavelengths::Rgb);
        v.set_light(i, sample.as_ref());
    }
    wide::widest(Connect { vertices: v, heuristic: solver.heuristic });

    // The next direction.
    let roulette = vertex >= c.rules.rr_depth;
    draw(&v.samplers, Dim::at(vertex, slot::BSDF), &mut v.u_bsdf);
    if roulette {
        draw(&v.samplers, Dim::at(vertex, slot::LOBE), &mut v.u_lobe);
    }
    wide::widest(Turn { vertices: v, roulette });

    for i in 0..v.count() {
        let walk = v.walk[i];
        let state = &mut crowd.walks[walk as usize];
        let (shadow, goes_on) = (v.shadow(i, state.edges + 1), v.goes_on[i] != 0);
        if goes_on {
            v.store(i, state);
        }
        crowd.take(walk, &Step { shadow, goes_on });
    }
    v.clear();
}

/// The numbers of all lanes in one dimension.
fn draw(samplers: &[Sampler], dim: Dim, [x, y]: &mut [Lane; 2]) {
    Sampler::u2_each(samplers, dim, x, y);
}

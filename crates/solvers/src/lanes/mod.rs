//! The step of [`PathMis`] for many walks at once, a walk a lane: its twin, bit for bit.
//!
//! Vertices on Lambert's surfaces become lanes, all others go one by one, if together ([`others`]). What looks things up (surfaces, textures, lights)
//! goes from walk to walk; what computes is a loop over lanes that the compiler makes vectors of ([`etendue_numerics::wide`]).
//!
//! | stage | scalar step | lanes |
//! | --- | --- | --- |
//! | light of the surroundings | `transport::emission` | [`escaped`]: of all rays that meet nothing |
//! | the vertex | `Scene::interaction` | [`place`]; gathering walk by walk |
//! | random numbers | `Sampler::u2` | `Sampler::u2_each` |
//! | a light | `Scene::sample_light` | [`light`]: a lone lamp; else the same, walk by walk |
//! | its connection | `transport::connection` | [`connect`] |
//! | the next direction | `Vertex::sample`, `PathState::turn` | [`turn`]; by a guide [`steer`] |

mod connect;
pub(crate) mod escaped;
mod light;
pub(crate) mod others;
pub(crate) mod pairs;
mod place;
mod steer;
mod turn;
mod vertices;

use crate::neighbours::First;
use crate::path_mis::PathMis;
use crate::transport::{Context, Crowd, HOPE, PathSolver, PathState, slot};
use connect::Connect;
use etendue_accel::Hit;
use etendue_bsdf::{Scatter, lobes};
use etendue_numerics::{Dim, Sampler, Spectrum, Vec2, Wavelengths, wide};
use etendue_scene::{ColorSlot, Lone, NO_INSTANCE, SurfaceId, TextureContext};
use place::Place;
use turn::Turn;
use vertices::Vertices;

/// A solver whose walks differ from those of [`PathMis`] in how they turn, and in nothing else.
trait Turns: PathSolver {
    /// κ of roulette.
    const HOPE: f32;

    /// Whether it turns as [`PathMis`] does where surfaces are not Lambert's.
    const ALIKE: bool;

    /// What they have in common.
    fn mis(&self) -> &PathMis;

    /// Turns the walks in lanes, all of which are at the same `vertex`.
    fn turn(&self, v: &mut Vertices, vertex: u32, roulette: bool);
}

/// Memory for the vertices, used again and again.
pub(crate) struct Lanes(Box<Vertices>);

impl Default for Lanes {
    fn default() -> Self {
        Self(Vertices::new())
    }
}

/// Advances all walks of the crowd by one vertex.
#[expect(private_bounds, reason = "the two solvers that turn on lanes are listed here")]
pub(crate) fn scatter_all<'a, T: Turns>(solver: &T, c: &Context<'a>, crowd: &mut Crowd<'a>) {
    let c = &c.eager();
    let mut lanes = std::mem::take(&mut crowd.lanes).unwrap_or_default();
    let v = &mut *lanes.0;
    let mut others = std::mem::take(&mut crowd.others);
    let mut escaped = std::mem::take(&mut crowd.escaped);
    let lone = c.scene.lights.lone(c.scene);
    let (going, hits) = (std::mem::take(&mut crowd.going), std::mem::take(&mut crowd.hits));
    for (i, hit) in going.iter().zip(&hits) {
        let (walk, u) = (&mut crowd.walks[*i as usize], &crowd.samplers[*i as usize]);
        match hit.as_ref().and_then(|hit| Some((hit, lambert(c, walk, hit)?))) {
            Some((hit, lambert)) => gather(solver.mis(), c, v, *i, walk, u, hit, lambert),
            None => match hit {
                None => escaped.push(*i),
                Some(hit) if T::ALIKE => others.push(solver.mis(), c, *i, walk, u, hit),
                Some(hit) => {
                    let before = crowd.neighbours.watches(walk.vertex).then_some(*walk);
                    let step = solver.scatter(c, walk, Some(*hit), u);
                    if let Some(before) = &before {
                        crowd.neighbours.note(c, *i, before, Some(hit), &step, walk);
                    }
                    crowd.take(*i, &step);
                }
            },
        }
        if v.is_full() {
            advance(solver, c, crowd, v, lone.as_ref());
        }
        if others.is_full() {
            others.advance(solver.mis(), c, crowd);
        }
    }
    advance(solver, c, crowd, v, lone.as_ref());
    others.advance(solver.mis(), c, crowd);
    escaped.collect(solver.mis(), c, &mut crowd.walks);
    (crowd.others, crowd.escaped) = (others, escaped);
    (crowd.lanes, crowd.going, crowd.hits) = (Some(lanes), going, hits);
}

/// ρ of the surface that is hit, and whether its back is a front as well, if the walk can go on in a lane.
#[inline(always)]
pub(crate) fn lambert<'a>(c: &Context<'a>, walk: &PathState, hit: &Hit) -> Option<(&'a ColorSlot, bool)> {
    let in_time = walk.edges < c.rules.max_edges;
    let material = c.scene.surface(SurfaceId(hit.geometry)).material;
    if in_time { c.scene.material(material).lambert(c.scene) } else { None }
}

/// Puts a walk's vertex into a lane, and collects what shines there.
#[expect(clippy::too_many_arguments, reason = "one half of a loop's body")]
#[inline(always)]
fn gather(
    solver: &PathMis,
    c: &Context<'_>,
    v: &mut Vertices,
    i: u32,
    walk: &mut PathState,
    u: &Sampler,
    hit: &Hit,
    (rho, two_sided): (&ColorSlot, bool),
) {
    let surface = c.scene.surface(SurfaceId(hit.geometry));
    if surface.emitter.is_some() {
        let x = c.scene.interaction(&walk.ray, hit);
        solver.collect(c, walk, Some(&x));
    }
    if let Some(mesh) = surface.shape.mesh().filter(|_| hit.instance == NO_INSTANCE) {
        let bary = Vec2::new(hit.u, hit.v);
        let rho = reflectance(rho, &walk.wl, || c.scene.texture_context(&c.scene.interaction(&walk.ray, hit)));
        v.push(i, walk, u, rho, two_sided);
        v.place_on(mesh, hit.primitive, bary);
    } else {
        let x = c.scene.interaction(&walk.ray, hit);
        v.push(i, walk, u, reflectance(rho, &walk.wl, || c.scene.texture_context(&x)), two_sided);
        v.place_at(&x);
    }
}

/// ρ at a place, as the lobe has it.
#[inline(always)]
pub(crate) fn reflectance<'a>(rho: &ColorSlot, wl: &Wavelengths, at: impl Fn() -> TextureContext<'a>) -> Spectrum {
    let reflectance = match rho {
        ColorSlot::Constant(color) => color.at(wl),
        ColorSlot::Texture(_) => rho.eval(&at(), wl),
    };
    lobes::Diffuse::new(lobes::DiffuseParams { reflectance }).diffuse_reflectance()
}

/// Advances the walks in lanes, and empties them.
fn advance<'a, T: Turns>(solver: &T, c: &Context<'a>, crowd: &mut Crowd<'a>, v: &mut Vertices, lone: Option<&Lone>) {
    if v.count() == 0 {
        return;
    }
    // All walks of a crowd are at the same vertex.
    let vertex = crowd.walks[v.walk[0] as usize].vertex;
    wide::widest(Place(v));

    // Light that a light sample finds.
    if !c.scene.lights.is_alone() {
        Sampler::u1_each(&v.samplers, Dim::at(vertex, slot::LIGHT), &mut v.u_light);
    }
    draw(&v.samplers, Dim::at(vertex, slot::LIGHT_POINT), &mut v.u_point);
    light::sample(c, v, lone);
    wide::widest(Connect { vertices: v, heuristic: solver.mis().heuristic });

    // The next direction.
    solver.turn(v, vertex, vertex >= c.rules.rr_depth());

    for i in 0..v.count() {
        let walk = v.walk[i];
        let state = &mut crowd.walks[walk as usize];
        if vertex == 1 && crowd.neighbours.watches(vertex) {
            let (p, p_error, ns) = (v.p.get(i), v.p_error.get(i), v.ns.get(i));
            let first = First::lambert(p, p_error, v.n.get(i), ns, v.wo.get(i), v.two_sided[i] != 0, state, v.rho.spectrum(i));
            crowd.neighbours.first(walk, first);
        }
        // Written where they stay: as a `Step` they would go through memory.
        if v.is_lit[i] != 0 {
            crowd.shadows.push((walk, v.shadow(i, state.edges + 1)));
        }
        if v.goes_on[i] != 0 {
            crowd.onward.push(walk);
            v.store(i, state, T::HOPE);
        }
    }
    v.clear();
}

impl Turns for PathMis {
    const HOPE: f32 = HOPE;
    const ALIKE: bool = true;

    fn mis(&self) -> &PathMis {
        self
    }

    fn turn(&self, v: &mut Vertices, vertex: u32, roulette: bool) {
        draw(&v.samplers, Dim::at(vertex, slot::BSDF), &mut v.u_bsdf);
        if roulette {
            draw(&v.samplers, Dim::at(vertex, slot::LOBE), &mut v.u_lobe);
        }
        wide::widest(Turn { vertices: v, roulette });
    }
}

/// The numbers of all lanes in one dimension.
fn draw<const N: usize>(samplers: &[Sampler], dim: Dim, [x, y]: &mut [[f32; N]; 2]) {
    Sampler::u2_each(samplers, dim, x, y);
}

//! Vertices that are not Lambert's: the step of [`PathMis`] for some of them at once, stage by stage, to the same bits.
//!
//! Lobes of facets go together ([`etendue_bsdf::Together`]), others one by one. Numbers are drawn on lanes, and lights are sampled for all together, so
//! that what light samples look up is asked for ahead.

use super::draw;
use crate::path_mis::PathMis;
use crate::transport::{Context, Crowd, HOPE, PathState, ShadowQuery, Step, Vertex, connection_of, mis_weight, slot};
use etendue_accel::Hit;
use etendue_bsdf::{BsdfSample, Draw, Together};
use etendue_numerics::{Dim, Sampler, Spectrum, Vec2, Vec3, Wavelengths};
use etendue_scene::{LightQuery, LightSample};

/// Vertices that are worked on together: they are large, and stay near by while they are.
const MANY: usize = 64;

/// The vertices, and what they ask for.
#[derive(Default)]
pub(crate) struct Others<'a> {
    /// The numbers of the walks.
    walks: Vec<u32>,
    samplers: Vec<Sampler>,
    vertices: Vec<Vertex<'a>>,
    /// Those that ask for a light.
    asking: Vec<usize>,
    queries: Vec<LightQuery>,
    /// Their wavelengths; none where all are RGB.
    wl: Vec<Wavelengths>,
    /// Light points, with the numbers of their vertices, and f cosθ and p of those.
    lights: Vec<(usize, LightSample)>,
    evaluated: Vec<(Spectrum, f32)>,
    shadows: Vec<Option<ShadowQuery>>,
    sampled: Vec<Option<BsdfSample>>,
    together: Together,
}

impl<'a> Others<'a> {
    pub fn is_full(&self) -> bool {
        self.walks.len() == MANY
    }

    /// Adds the vertex of a walk, and collects what shines there.
    #[inline(always)]
    pub fn push(&mut self, solver: &PathMis, c: &Context<'a>, i: u32, walk: &mut PathState, u: &Sampler, hit: &Hit) {
        self.vertices.push(Vertex::at(c.scene.interaction(&walk.ray, hit)));
        if let Some(vertex) = self.vertices.last_mut() {
            solver.collect(c, walk, Some(&vertex.x));
            if !c.ends(walk) {
                walk.evaluate(c.scene, vertex);
                vertex.shares_light = true;
                self.walks.push(i);
                self.samplers.push(*u);
                return;
            }
        }
        self.vertices.pop();
    }

    /// Advances the walks, and empties itself.
    pub fn advance(&mut self, solver: &PathMis, c: &Context<'a>, crowd: &mut Crowd<'a>) {
        let Some(first) = self.walks.first() else { return };
        // All walks of a crowd are at the same vertex.
        let vertex = crowd.walks[*first as usize].vertex;
        self.light(solver, c, crowd, vertex);

        // The next direction.
        let [mut u_lobe, mut u_bsdf] = [[[0.0; MANY]; 2]; 2];
        draw(&self.samplers, Dim::at(vertex, slot::LOBE), &mut u_lobe);
        draw(&self.samplers, Dim::at(vertex, slot::BSDF), &mut u_bsdf);
        let at = |[x, y]: &[[f32; MANY]; 2], k: usize| Vec2::new(x[k], y[k]);
        let draws: Vec<Draw<'_, 'a>> = (self.vertices.iter().enumerate())
            .map(|(k, y)| Draw { bsdf: &y.bsdf, wo: y.wo, u1: u_lobe[0][k], u2: at(&u_bsdf, k) })
            .collect();
        self.together.sample(&draws, &mut self.sampled);
        for (k, (i, y)) in self.walks.iter().zip(&self.vertices).enumerate() {
            let walk = &mut crowd.walks[*i as usize];
            let before = walk.beta;
            let shadow = self.shadows[k];
            let sample = self.sampled[k].as_ref().map(|s| y.for_radiance(s));
            let goes_on = walk.turn(&c.rules, y, sample, u_lobe[1][k]);
            walk.relate(HOPE);
            if crowd.neighbours.watches(vertex) {
                crowd.neighbours.note_other(*i, vertex, before, y, shadow.as_ref(), walk);
            }
            crowd.take(*i, &Step { shadow, goes_on });
        }
        self.walks.clear();
        self.samplers.clear();
        self.vertices.clear();
    }

    /// Light that light samples find: `transport::next_event` of each.
    fn light(&mut self, solver: &PathMis, c: &Context<'a>, crowd: &Crowd<'a>, vertex: u32) {
        let Self { walks, samplers, vertices, asking, queries, wl, lights, evaluated, shadows, together, .. } = self;
        let (mut u_light, mut u_point) = ([0.0; MANY], [[0.0; MANY]; 2]);
        if !c.scene.lights.is_alone() {
            Sampler::u1_each(samplers, Dim::at(vertex, slot::LIGHT), &mut u_light);
        }
        draw(samplers, Dim::at(vertex, slot::LIGHT_POINT), &mut u_point);
        asking.clear();
        queries.clear();
        wl.clear();
        for (k, y) in vertices.iter().enumerate() {
            let walk = &crowd.walks[walks[k] as usize];
            if y.is_smooth() && walk.edges < c.rules.max_edges {
                asking.push(k);
                let u = Vec2::new(u_point[0][k], u_point[1][k]);
                queries.push(LightQuery { from: y.light_reference(), u_light: u_light[k], u });
                wl.extend((!walk.wl.is_rgb()).then_some(walk.wl));
            }
        }
        lights.clear();
        c.scene.lights.sample_each(c.scene, queries, wl, |n, light| lights.extend(light.map(|light| (asking[n], light))));

        // What of it the vertices scatter.
        let asked: Vec<(&Vertex<'a>, Vec3)> = lights.iter().map(|(k, light)| (&vertices[*k], light.wi)).collect();
        Vertex::eval_each(&asked, together, evaluated);
        shadows.clear();
        shadows.resize(vertices.len(), None);
        let weight = |p_light: f32, p_bsdf: f32| mis_weight(solver.heuristic, p_light, p_bsdf);
        for ((k, light), f) in lights.iter().zip(evaluated) {
            shadows[*k] = connection_of(&crowd.walks[walks[*k] as usize], &vertices[*k], light, *f, weight);
        }
    }
}

//! A walk from either end, vertex by vertex: light tracing is path tracing of the adjoint equation, so there is one loop for both.

use super::path_vertex::{PathVertex, Sides};
use super::weights::Trail;
use crate::transport::{Context, HOPE, HOPE_OF_LIGHT, Heuristic, PathState, VertexSample, light_slot, slot};
use etendue_numerics::{Numbers, Ray, Spectrum, Vec2};
use etendue_scene::Interaction;

/// Which end a walk comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum End {
    /// The lens: it carries importance and asks for light.
    Eye,
    /// A light: it carries flux and asks for the lens.
    Light,
}

/// A walk between two vertices.
pub struct Walk<'w, 'a> {
    /// What all walks share.
    pub c: &'w Context<'a>,
    /// The scene's materials.
    pub sides: &'w Sides<'a>,
    /// How strategies share.
    pub heuristic: Heuristic,
    /// Where it comes from.
    pub end: End,
    /// The ray to be cast next, and β relative to the walk's start.
    pub state: PathState,
    /// Φ_0 of a particle, the camera's weight from the eye.
    pub start: Spectrum,
    /// The last vertex.
    pub trail: Trail,
    /// The last vertex's place among those stored.
    pub parent: Option<u32>,
    /// Vertices so far, those of null events left out.
    pub count: u32,
}

impl<'a> Walk<'_, 'a> {
    /// β.
    #[inline]
    pub fn beta(&self) -> Spectrum {
        self.state.beta.carry(self.start)
    }

    /// The surface that the ray meets.
    #[inline]
    pub fn meet(&self, rays: &mut u64) -> Option<Interaction> {
        *rays += 1;
        let hit = self.c.scene.intersect(&self.state.ray)?;
        Some(self.c.scene.interaction(&self.state.ray, &hit))
    }

    /// The vertex at x.
    #[inline(always)] // it is large, and better made where it stays
    pub fn vertex(&mut self, x: Interaction) -> PathVertex<'a> {
        let link = self.trail.arrive(x.p, x.n, x.wo);
        let vertex = self.state.vertex(self.c.scene, x);
        PathVertex {
            vertex,
            beta: self.beta(),
            is_alone: self.state.wl.is_alone(),
            edges: self.state.edges,
            count: self.count + 1,
            address: self.state.vertex,
            parent: self.parent,
            is_dirac: false,
            link,
        }
    }

    /// Turns into a direction sampled at `v`, which is stored at `place`; `false` where the walk ends.
    #[inline]
    pub fn turn(&mut self, v: &mut PathVertex, place: u32, u: &impl Numbers) -> bool {
        let (lobe, point) = match self.end {
            End::Eye => (slot::LOBE, slot::BSDF),
            End::Light => (light_slot::LOBE, light_slot::BSDF),
        };
        // Not drawn where nobody looks.
        let asked = v.vertex.bsdf.has_choice() || self.state.vertex >= self.c.rules.rr_depth();
        let u_lobe = if asked { u.u2(self.state.dim(lobe)) } else { Vec2::ZERO };
        let u_point = u.u2(self.state.dim(point));
        let sample = match self.end {
            End::Eye => v.vertex.sample(u_lobe.x, u_point),
            End::Light => self.sides.sample_to_eye(&v.vertex, u_lobe.x, u_point, &self.state.wl),
        };
        if let Some(s) = sample.filter(|s| !s.is_null) {
            self.leave(v, &s);
            self.parent = Some(place);
            self.count += 1;
        }
        let goes_on = self.state.turn(&self.c.rules, &v.vertex, sample, u_lobe.y);
        self.state.relate(match self.end {
            End::Eye => HOPE,
            End::Light => HOPE_OF_LIGHT,
        });
        goes_on
    }

    /// The walk leaves `v` along a sampled direction.
    #[inline]
    fn leave(&mut self, v: &mut PathVertex, s: &VertexSample) {
        let x = &v.vertex.x;
        v.is_dirac = s.pdf.is_delta();
        let (onward, way_back, connect) = if v.is_dirac {
            // Per projected solid angle; the same probability both ways.
            (x.shading.n.dot(s.wi).abs(), v.vertex.wo.z.abs(), 0.0)
        } else {
            (s.pdf.value(), self.sides.way_back(&v.vertex, s.wi, &self.state.wl), 1.0)
        };
        let sums = v.link.bracket(self.heuristic, way_back, !v.is_dirac);
        self.trail = Trail { p: x.p, n: x.n, distant: false, density: v.link.density, pdf_w: onward, connect, sums };
    }

    /// The ray to be cast next.
    pub fn ray(&self) -> &Ray {
        &self.state.ray
    }
}

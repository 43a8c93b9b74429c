//! A vertex of a walk from either end: a surface point that waits for connections.
//!
//! ```text
//! from the eye:   β = Π f |cosθ| / p                                contribution of light L arriving along w:  β f(w, x, wo) |cosθ| L
//! from a light:   β = Φ = Le |cosθ| / (p(y) p(w)) Π f* |cosθ| / p    contribution to importance W leaving along w:  β f*(wo → w) |cosθ| W
//! ```
//!
//! What is stored is what a photon map keeps as well: position, incoming flux, direction to where it came from, edges.

use super::weights::Link;
use crate::transport::{Vertex, VertexSample};
use etendue_bsdf::{Bsdf, Scatter};
use etendue_numerics::{Spectrum, Vec2, Vec3, Wavelengths};
use etendue_scene::{Interaction, Material, Scene};

/// A vertex of a walk.
#[derive(Clone, Copy, Debug)]
pub struct PathVertex<'a> {
    /// The point with its scattering; `x.wo` points back along the walk.
    pub vertex: Vertex<'a>,
    /// β: throughput up to here from the eye, flux in W from a light.
    pub beta: Spectrum,
    /// Edges between the walk's start and here; null and mask surfaces passed count as the rules say.
    pub edges: u32,
    /// Vertices of the walk up to this one, those of null events left out: s or t.
    pub count: u32,
    /// Vertices of the walk before it, those of null events included: the address of random decisions here.
    pub address: u32,
    /// Where in the walk the vertex before is, if it is not the first.
    pub parent: Option<u32>,
    /// Whether the walk left into a discrete direction.
    pub is_dirac: bool,
    /// Whether the walk goes on with the hero's wavelength alone.
    pub is_alone: bool,
    /// How it was reached, for the weights.
    pub link: Link,
}

impl PathVertex<'_> {
    /// Whether a walk may go straight on, as if there were nothing: the next vertex then has the same number.
    #[inline]
    pub fn may_be_passed(&self) -> bool {
        self.vertex.bsdf.events().has_null()
    }
}

/// Scattering between the walk and a direction that it did not choose.
#[derive(Clone, Copy, Debug)]
pub struct Turn {
    /// f |cosθ| from the eye, f* |cosθ| from a light.
    pub f_cos: Spectrum,
    /// Density, 1/sr, with which the walk would have gone there.
    pub onward: f32,
    /// Density, 1/sr, with which a walk from there would have gone back along this one.
    pub way_back: f32,
}

/// What may be known of a scene's materials beforehand: whether a surface is the same from all sides.
#[derive(Clone, Copy, Debug)]
pub struct Sides<'a> {
    scene: &'a Scene,
    bends: bool,
}

impl<'a> Sides<'a> {
    /// Looks at all materials of `scene`.
    pub fn new(scene: &'a Scene) -> Self {
        Self { scene, bends: scene.materials.iter().any(|m| matches!(m, Material::BumpMap(_) | Material::NormalMap(_))) }
    }

    /// The scene.
    pub fn scene(&self) -> &'a Scene {
        self.scene
    }

    /// The scattering at a vertex as one sees it who looks from the world direction `w`: two-sided surfaces and bent normals turn to who looks.
    /// Kept in `room` where it is another.
    #[inline]
    fn seen_from<'v>(&self, vertex: &'v Vertex<'a>, w: Vec3, wl: &Wavelengths, room: &'v mut Option<Bsdf<'a>>) -> &'v Bsdf<'a> {
        let material = self.scene.material(self.scene.surface(vertex.x.surface).material);
        let holds_others = matches!(
            material,
            Material::TwoSided(_) | Material::Mask(_) | Material::Blend(_) | Material::BumpMap(_) | Material::NormalMap(_)
        );
        if holds_others && (self.bends || vertex.x.shading.n.dot(w) * vertex.wo.z < 0.0) {
            room.insert(self.scene.bsdf(&Interaction { wo: w, ..vertex.x }, wl))
        } else {
            &vertex.bsdf
        }
    }

    /// Density, 1/sr, with which a walk that came from `w` goes on along `vertex.x.wo`.
    #[inline]
    pub fn way_back(&self, vertex: &Vertex, w: Vec3, wl: &Wavelengths) -> f32 {
        self.seen_from(vertex, w, wl, &mut None).pdf(vertex.x.shading.to_local(w), vertex.wo)
    }

    /// The vertex of a walk from the eye, connected to a light's side in the direction `w`.
    #[inline]
    pub fn turn_to_light(&self, vertex: &Vertex, w: Vec3, wl: &Wavelengths) -> Option<Turn> {
        let (f_cos, onward) = vertex.eval(w);
        (!f_cos.is_zero()).then(|| Turn { f_cos, onward, way_back: self.way_back(vertex, w, wl) })
    }

    /// The vertex of a walk from a light, connected to the eye's side in the direction `w`: f* as in [`Vertex::eval_adjoint`].
    #[inline]
    pub fn turn_to_eye(&self, vertex: &Vertex, w: Vec3, wl: &Wavelengths) -> Option<Turn> {
        let x = &vertex.x;
        let (eye, light) = (x.shading.to_local(w), vertex.wo);
        let mut room = None;
        let bsdf = self.seen_from(vertex, w, wl, &mut room);
        let (f, way_back) = if eye.z * light.z >= 0.0 {
            bsdf.eval_pdf(eye, light)
        } else if bsdf.events().transmits() {
            (bsdf.eval(light, eye), bsdf.pdf(eye, light))
        } else {
            return None;
        };
        let from = x.n.dot(x.wo).abs();
        if f.is_zero() || from == 0.0 {
            return None;
        }
        Some(Turn { f_cos: f * (light.z.abs() * x.n.dot(w).abs() / from), onward: vertex.bsdf.pdf(light, eye), way_back })
    }

    /// A direction for a walk from a light, as [`Vertex::sample_adjoint`].
    #[inline]
    pub fn sample_to_eye(&self, vertex: &Vertex, u_lobe: f32, u: Vec2, wl: &Wavelengths) -> Option<VertexSample> {
        let s = vertex.bsdf.sample(vertex.wo, u_lobe, u)?;
        if s.event.has_null() || s.pdf.is_delta() {
            return vertex.sample_adjoint(self.scene, u_lobe, u, wl);
        }
        let wi = vertex.x.shading.to_world(s.wi);
        let weight = self.turn_to_eye(vertex, wi, wl)?.f_cos / s.pdf.value();
        weight.is_finite().then_some(VertexSample { wi, weight, pdf: s.pdf, eta_scale: 1.0, is_null: false, event: s.event })
    }
}

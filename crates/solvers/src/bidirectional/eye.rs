//! The lens as the first vertex of eye paths.
//!
//! Places on the film are drawn uniformly, one a pixel and pass: over the film as many as it has pixels, with the density 1/(W H) each. Seen from the
//! surface point y at distance r, z = r cosθ before the lens,
//!
//! ```text
//! p⃖(y) = p_w |cosθ_y| / r² = |cosθ_y| / (4 tx ty cosθ z²)        pinhole and lens: p_w = 1 / (4 tx ty cos³θ)
//! p⃖(y) = |cosθ_y| / A_film                                       parallel rays
//! p⃖(y) = p_w |cosθ_y| / r²                                       rays to all sides: p_w = 1 / (W H Ω_px)
//! ```

use super::weights::{Trail, power};
use crate::transport::Heuristic;
use etendue_numerics::{Ray, Vec2, Vec3};
use etendue_scene::sensor::{Camera, Spherical};
use etendue_scene::{Sensor, View};

/// A camera as the weights see it.
#[derive(Clone, Copy, Debug)]
pub struct Eye {
    model: Model,
    /// ρ: light paths a pass over those that the full film would have.
    pub rho: f32,
}

#[derive(Clone, Copy, Debug)]
enum Model {
    /// All rays pass the plane through `p` across the unit vector `axis`; `area` = 4 tx ty.
    Central { p: Vec3, axis: Vec3, area: f32 },
    /// Parallel rays, `density` = 1 / A_film.
    Parallel { density: f32 },
    /// Rays to all sides.
    Around(Spherical),
}

/// A camera whose rays pass one point, or a lens around it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Center {
    pub p: Vec3,
    pub axis: Vec3,
    pub area: f32,
    /// ρ.
    pub rho: f32,
}

impl Eye {
    /// The camera of a view.
    pub fn new(view: &View) -> Self {
        let central = |projection: &etendue_scene::sensor::Projection| Model::Central {
            p: projection.p,
            axis: projection.axes.n,
            area: 4.0 * projection.tan_half.x * projection.tan_half.y,
        };
        let model = match &view.sensor {
            Sensor::Perspective(m) => central(&m.projection),
            Sensor::ThinLens(m) => central(&m.projection),
            Sensor::Orthographic(_) => {
                let middle = 0.5 * Vec2::new(view.film.size[0] as f32, view.film.size[1] as f32);
                let ray = view.sensor.sample_ray(middle, Vec2::splat(0.5), 0.0).ray;
                Model::Parallel { density: view.sensor.pdf(ray.o, ray.d).0.area() }
            }
            Sensor::Spherical(m) => Model::Around(*m),
        };
        let pixels = |[w, h]: [u32; 2]| f64::from(w) * f64::from(h);
        Self { model, rho: (pixels(view.film.crop_size) / pixels(view.film.size)) as f32 }
    }

    /// p⃖(y), 1/m², of the surface point y with normal n that the camera sees along the unit direction `w`.
    #[inline]
    pub fn density(&self, y: Vec3, n: Vec3, w: Vec3) -> f32 {
        let cos_y = n.dot(w).abs();
        match self.model {
            Model::Central { p, axis, area } => {
                let z = axis.dot(y - p);
                cos_y / (area * axis.dot(w) * z * z)
            }
            Model::Parallel { density } => cos_y * density,
            Model::Around(m) => cos_y * m.pdf(m.p, w).1.value() / y.distance_squared(m.p),
        }
    }

    /// The point that all rays pass, if there is one.
    pub(crate) fn center(&self) -> Option<Center> {
        match self.model {
            Model::Central { p, axis, area } => Some(Center { p, axis, area, rho: self.rho }),
            Model::Parallel { .. } | Model::Around(_) => None,
        }
    }

    /// A walk from the lens along the camera's ray. The place on the lens is the same for all strategies; its density cancels.
    pub fn trail(&self, ray: &Ray, heuristic: Heuristic) -> Trail {
        let connect = power(heuristic, self.rho, 1.0);
        match self.model {
            Model::Central { p, axis, area } => {
                let cos = axis.dot(ray.d);
                // Back from the near plane to the lens.
                let lens = ray.o - ray.d * (axis.dot(ray.o - p) / cos);
                let pdf_w = 1.0 / (area * cos * cos * cos);
                Trail { p: lens, n: axis, distant: false, density: 1.0, pdf_w, connect, sums: 0.0 }
            }
            Model::Parallel { density } => {
                Trail { p: ray.o, n: ray.d, distant: true, density: 1.0, pdf_w: density, connect, sums: 0.0 }
            }
            Model::Around(m) => Trail {
                p: m.p,
                n: Vec3::ZERO,
                distant: false,
                density: 1.0,
                pdf_w: m.pdf(m.p, ray.d).1.value(),
                connect,
                sums: 0.0,
            },
        }
    }
}

//! Round shapes over the unit square of parameters, in their own coordinates.
//!
//! ```text
//! sphere     (√(1-z²) cosφ, √(1-z²) sinφ, z),  φ = 2π s, z = 1 - 2 t
//! cylinder   (cosφ, sinφ, t),                  φ = 2π s
//! disk       (r cosφ, r sinφ, 0),              φ = 2π s, r = √t
//! ```

use glam::{DVec2, DVec3};
use std::f64::consts::TAU;

/// The round shapes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Round {
    /// The unit sphere.
    Sphere,
    /// The unit cylinder about z from z = 0 to 1, without caps.
    Cylinder,
    /// The unit disk at z = 0.
    Disk,
}

impl Round {
    pub(super) fn point(self, st: DVec2) -> DVec3 {
        let c = DVec2::from_angle(TAU * st.x);
        match self {
            Self::Sphere => {
                let z = 1.0 - 2.0 * st.y;
                (c * (1.0 - z * z).max(0.0).sqrt()).extend(z)
            }
            Self::Cylinder => c.extend(st.y),
            Self::Disk => (c * st.y.max(0.0).sqrt()).extend(0.0),
        }
    }

    pub(super) fn normal(self, st: DVec2) -> DVec3 {
        match self {
            Self::Sphere => self.point(st),
            Self::Cylinder => self.point(st).with_z(0.0),
            Self::Disk => DVec3::Z,
        }
    }

    /// ∂p/∂s and ∂p/∂t; their product stays finite where one of them does not: both are scaled to that.
    pub(super) fn tangents(self, st: DVec2) -> (DVec3, DVec3) {
        let c = DVec2::from_angle(TAU * st.x);
        match self {
            Self::Sphere => {
                // ∂p/∂s = 2π r c⊥ and ∂p/∂t = -2 (-z/r c, 1): the factors r and 1/r cancel.
                let z = 1.0 - 2.0 * st.y;
                let r = (1.0 - z * z).max(0.0).sqrt();
                (c.perp().extend(0.0) * TAU, (c * z).extend(-r) * 2.0)
            }
            Self::Cylinder => (c.perp().extend(0.0) * TAU, DVec3::Z),
            Self::Disk => (c.perp().extend(0.0) * TAU, c.extend(0.0) * 0.5),
        }
    }

    pub(super) fn locate(self, q: DVec3) -> DVec2 {
        let turn = q.y.atan2(q.x) / TAU;
        let s = if turn < 0.0 { turn + 1.0 } else { turn };
        let t = match self {
            Self::Sphere => 0.5 * (1.0 - q.z / q.length()),
            Self::Cylinder => q.z,
            Self::Disk => q.truncate().length_squared(),
        };
        DVec2::new(s, t)
    }
}

//! Where a texture over two or three dimensions is looked up.
//!
//! | mapping | coordinates of the point p, q = `from_world` p |
//! | --- | --- |
//! | `uv` | (u', v') = `to_uv` (u, v) |
//! | `spherical` | (θ/π, φ/2π) of q |
//! | `cylindrical` | ((π + atan2(q_y, q_x))/2π, q_z) |
//! | `planar` | (q · v1, q · v2) + shift |
//! | `solid` | q itself, in three dimensions |
//!
//! All but `uv` and `planar` are multiplied by `repeat` (default 1).

use crate::texture::{TextureContext, UvMap};
use etendue_numerics::math::{FRAC_1_PI, PI, TAU, atan2, safe_acos};
use etendue_numerics::{Vec2, Vec3};
use glam::Affine3A;

/// A mapping of any kind.
#[derive(Clone, Copy, Debug)]
pub enum Mapping {
    /// By the surface's own coordinates.
    Uv(UvMap),
    /// By the place in the world.
    Space(Space),
}

/// How a place in the world becomes two coordinates.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Chart {
    /// By angles around the origin.
    Spherical,
    /// By the angle around z, and z.
    Cylindrical,
    /// By distances along two vectors.
    Planar,
    /// In three dimensions; as two, x and y.
    Solid,
}

/// A mapping by the place in the world.
#[derive(Clone, Copy, Debug)]
pub struct Space {
    /// Two coordinates of three.
    pub chart: Chart,
    /// From the world into the texture's coordinates.
    pub from_world: Affine3A,
    /// A factor on the coordinates.
    pub repeat: f32,
    /// The vectors of a planar chart.
    pub axes: [Vec3; 2],
    /// Its shift.
    pub shift: Vec2,
}

impl Default for Mapping {
    fn default() -> Self {
        Self::Uv(UvMap::default())
    }
}

impl Mapping {
    /// Two coordinates.
    #[inline]
    pub fn uv(&self, x: &TextureContext) -> Vec2 {
        match self {
            Self::Uv(map) => map.apply(x.uv),
            Self::Space(space) => space.uv(x.p),
        }
    }

    /// Three coordinates; of a `uv` mapping the third is zero.
    #[inline]
    pub fn point(&self, x: &TextureContext) -> Vec3 {
        match self {
            Self::Uv(map) => map.apply(x.uv).extend(0.0),
            Self::Space(space) => space.from_world.transform_point3(x.p) * space.repeat,
        }
    }

    /// Whether it has three dimensions.
    pub fn is_solid(&self) -> bool {
        matches!(self, Self::Space(Space { chart: Chart::Solid, .. }))
    }
}

impl Space {
    fn uv(&self, p: Vec3) -> Vec2 {
        let q = self.from_world.transform_point3(p);
        match self.chart {
            Chart::Spherical => {
                let d = q.normalize_or(Vec3::Z);
                let phi = atan2(d.y, d.x);
                self.repeat * Vec2::new(safe_acos(d.z) * FRAC_1_PI, if phi < 0.0 { phi + TAU } else { phi } / TAU)
            }
            Chart::Cylindrical => self.repeat * Vec2::new((PI + atan2(q.y, q.x)) / TAU, q.z),
            Chart::Planar => Vec2::new(q.dot(self.axes[0]), q.dot(self.axes[1])) + self.shift,
            Chart::Solid => self.repeat * q.truncate(),
        }
    }
}

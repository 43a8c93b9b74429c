//! Where a camera stands and how directions fall on its film: what `perspective` and `thinlens` share.
//!
//! ```text
//! (X, Y, 1) the direction in the camera's coordinates, q the place on the film, (W, H) the film's size in pixels
//! q = ((1 - (X, Y)/t)/2 - o) (W, H),    t = (tan(fov_x/2), tan(fov_x/2) H/W)
//! A_px = 4 tx ty / (W H)     a pixel's area at distance 1
//! We cosθ dA dw = dA d²q / A_lens   and   dw = cos³θ dX dY   give   We = 1 / (A_px A_lens cos⁴θ)
//! ```
//!
//! o is the offset of the principal point, in film sizes [Pharr, Jakob, Humphreys 2016, §16.1.1 on We].

use etendue_numerics::{Frame, Ray, Vec2, Vec3};

/// A camera's place, field of view and film.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Projection {
    /// Where it stands, m.
    pub p: Vec3,
    /// Its x, y and z in the world, orthonormal; `n` is where it looks. A mirrored camera's are left-handed.
    pub axes: Frame,
    /// t: half the film's width and height at distance 1.
    pub tan_half: Vec2,
    /// o: the principal point's offset, as a share of the film's width and height.
    pub offset: Vec2,
    /// (W, H): the full film in pixels.
    pub size: Vec2,
    /// Distances of the near and the far plane along the axis, m; nothing outside is seen.
    pub clip: [f32; 2],
}

impl Projection {
    /// (X, Y, 1) of a place on the film.
    #[inline(always)]
    pub(super) fn direction(&self, pixel: Vec2) -> Vec3 {
        let s = pixel / self.size + self.offset;
        ((Vec2::ONE - 2.0 * s) * self.tan_half).extend(1.0)
    }

    /// The place on the film of (X, Y, 1); `None` beyond the film.
    #[inline]
    pub(super) fn pixel(&self, xy: Vec2) -> Option<Vec2> {
        let (pixel, on_film) = self.locate(xy);
        on_film.then_some(pixel)
    }

    /// The same without branches: the place, and whether it is on the film.
    #[inline(always)]
    pub(super) fn locate(&self, xy: Vec2) -> (Vec2, bool) {
        let s = 0.5 * (Vec2::ONE - xy / self.tan_half) - self.offset;
        let on_film = (s.x >= 0.0) & (s.y >= 0.0) & (s.x < 1.0) & (s.y < 1.0);
        // The product may round up to the border, which is no pixel any more.
        ((s * self.size).min(Vec2::new(self.size.x.next_down(), self.size.y.next_down())), on_film)
    }

    /// A_px.
    #[inline(always)]
    pub(super) fn pixel_area(&self) -> f32 {
        4.0 * self.tan_half.x * self.tan_half.y / (self.size.x * self.size.y)
    }

    /// We A_lens into the direction at angle θ from the axis.
    #[inline(always)]
    pub(super) fn we(&self, cos: f32) -> f32 {
        1.0 / (self.pixel_area() * (cos * cos) * (cos * cos))
    }

    /// Density, 1/sr, of directions whose place on the film is uniform: 1 / (W H A_px cos³θ).
    #[inline]
    pub(super) fn pdf_w(&self, cos: f32) -> f32 {
        1.0 / (self.size.x * self.size.y * self.pixel_area() * cos * cos * cos)
    }

    /// A ray from the lens point `lens` towards the unit direction `w`, both in the camera's coordinates, from the near to the far plane.
    #[inline(always)]
    pub(super) fn ray(&self, lens: Vec3, w: Vec3, time: f32) -> Ray {
        let [near, far] = self.clip;
        let o = lens + w * (near / w.z);
        let ray = Ray::new(self.p + self.axes.to_world(o), self.axes.to_world(w)).until((far - near) / w.z);
        Ray { time, ..ray }
    }

    /// The world's point in the camera's coordinates; `None` where it is not between the near and the far plane.
    #[inline]
    pub(super) fn place(&self, p: Vec3) -> Option<Vec3> {
        let local = self.local(p);
        self.is_between(local).then_some(local)
    }

    /// The world's point in the camera's coordinates.
    #[inline(always)]
    pub(super) fn local(&self, p: Vec3) -> Vec3 {
        self.axes.to_local(p - self.p)
    }

    /// Whether a point in the camera's coordinates is between the near and the far plane.
    #[inline(always)]
    pub(super) fn is_between(&self, local: Vec3) -> bool {
        (local.z >= self.clip[0]) & (local.z <= self.clip[1])
    }
}

//! Rays, and how they leave a surface without meeting it again.

use crate::Vec3;

/// A half-line x(t) = o + t d, t in [0, `t_max`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Origin.
    pub o: Vec3,
    /// Direction; unit length unless a routine says otherwise.
    pub d: Vec3,
    /// Where the ray ends, in units of `d`.
    pub t_max: f32,
    /// Time in [0, 1] within the shutter's opening.
    pub time: f32,
    /// The medium that the ray starts in, [`Ray::VACUUM`] for none.
    pub medium: u32,
}

impl Ray {
    /// The id that stands for "no medium".
    pub const VACUUM: u32 = u32::MAX;

    /// The endless ray from `o` towards `d`, at time 0 in vacuum.
    #[inline]
    pub fn new(o: Vec3, d: Vec3) -> Self {
        Self { o, d, t_max: f32::INFINITY, time: 0.0, medium: Self::VACUUM }
    }

    /// The same ray, ended at `t_max`.
    #[inline]
    pub fn until(self, t_max: f32) -> Self {
        Self { t_max, ..self }
    }

    /// The point o + t d.
    #[inline]
    pub fn at(&self, t: f32) -> Vec3 {
        self.o + self.d * t
    }
}

/// A point on a surface, moved off it to the side that `w` points to, by no more than rounding makes needful.
///
/// `error` bounds |p_computed - p| in each coordinate; `n` is the geometric normal. The point moves along n by |n|·error and is
/// then rounded away from the surface by one ulp in each coordinate [Pharr, Jakob, Humphreys 2023, §6.8.6].
#[inline(always)] // as a return value it would go through memory
pub fn offset_origin(p: Vec3, error: Vec3, n: Vec3, w: Vec3) -> Vec3 {
    let distance = n.abs().dot(error);
    let offset = if w.dot(n) < 0.0 { -n * distance } else { n * distance };
    let moved = p + offset;
    let round = |x: f32, d: f32| {
        if d > 0.0 {
            x.next_up()
        } else if d < 0.0 {
            x.next_down()
        } else {
            x
        }
    };
    Vec3::new(round(moved.x, offset.x), round(moved.y, offset.y), round(moved.z, offset.z))
}

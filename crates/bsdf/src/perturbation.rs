//! Local frames turned against the shading frame: bump maps, normal maps, two-sided surfaces.
//!
//! A lobe under a perturbation sees w' = (w·s, w·t, w·n). Where a direction lies on one side of the shading frame and on the other of
//! the perturbed frame, nothing is scattered: `eval`, `pdf` and `sample` agree on that. The measure of directions does not change
//! under rotation, but the cosine does: f = f' |w_i'·z| / |w_i·z|, so that f |cosθ_i| is what the lobe gives in its own frame.
//!
//! Shadow terminator: where normals are bent, light near the horizon is dimmed by Smith's masking of a GGX surface as rough as the
//! bend, 2 / (1 + √(1 + α² tan²θ_i)), α² = min(tan²θ_n/8, 1) [Conty Estevez, Lecocq, Stein 2019].
//!
//! Bent normals make f non-reciprocal, as interpolated ones do [Veach 1997, §5.3].

use etendue_numerics::{
    Vec3,
    math::{safe_sqrt, sqr},
};

/// A turned, and possibly mirrored, local frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Perturbation {
    s: Vec3,
    n: Vec3,
    /// α² of the shadow terminator; 0 leaves light alone.
    terminator: f32,
    /// Whether t = s × n instead of n × s: mirroring turned the handedness.
    left_handed: bool,
    /// Whether upper and lower side have changed places.
    upside_down: bool,
}

impl Perturbation {
    /// The back of a two-sided surface: z changes its sign.
    pub const BACK: Self = Self { s: Vec3::X, n: Vec3::NEG_Z, terminator: 0.0, left_handed: true, upside_down: true };

    /// A frame around the normal `n` (shading coordinates, any length) whose x leans towards local x; `soften` adds the shadow terminator.
    /// A normal that is not finite or zero changes nothing.
    pub fn from_normal(n: Vec3, soften: bool) -> Self {
        Self::new(n, Vec3::X, soften)
    }

    /// A frame around the normal `n` whose x leans towards `s`, both in shading coordinates, of any length.
    pub fn new(n: Vec3, s: Vec3, soften: bool) -> Self {
        let n = n.try_normalize().unwrap_or(Vec3::Z);
        let s = (s - n * n.dot(s)).try_normalize().or_else(|| (Vec3::Y - n * n.y).try_normalize()).unwrap_or(Vec3::Y);
        let tan2 = (1.0 - n.z * n.z).max(0.0) / (n.z * n.z).max(1e-12);
        Self { s, n, terminator: if soften { (0.125 * tan2).min(1.0) } else { 0.0 }, left_handed: false, upside_down: false }
    }

    /// The normal `n` (shading coordinates), mirrored about z where `wo` would see it from its wrong side
    /// [Schüßler et al. 2017]: never black spots from bent normals.
    pub fn facing(n: Vec3, wo: Vec3) -> Vec3 {
        if wo.z * wo.dot(n) <= 0.0 { Vec3::new(-n.x, -n.y, n.z) } else { n }
    }

    /// First `self`, then `inner` in the frame that `self` makes.
    pub fn then(&self, inner: &Self) -> Self {
        Self {
            s: self.to_shading(inner.s),
            n: self.to_shading(inner.n),
            terminator: self.terminator.max(inner.terminator),
            left_handed: self.left_handed != inner.left_handed,
            upside_down: self.upside_down != inner.upside_down,
        }
    }

    /// Second tangent.
    #[inline]
    fn t(&self) -> Vec3 {
        if self.left_handed { self.s.cross(self.n) } else { self.n.cross(self.s) }
    }

    /// Shading to perturbed coordinates; `None` where the direction changes sides.
    #[inline]
    pub(crate) fn to_local(self, w: Vec3) -> Option<Vec3> {
        let local = Vec3::new(w.dot(self.s), w.dot(self.t()), w.dot(self.n));
        self.keeps_side(w, local).then_some(local)
    }

    /// Perturbed to shading coordinates; `None` where the direction changes sides.
    #[inline]
    pub(crate) fn to_outer(self, local: Vec3) -> Option<Vec3> {
        let w = self.to_shading(local);
        self.keeps_side(w, local).then_some(w)
    }

    #[inline]
    fn to_shading(self, local: Vec3) -> Vec3 {
        self.s * local.x + self.t() * local.y + self.n * local.z
    }

    #[inline]
    fn keeps_side(&self, w: Vec3, local: Vec3) -> bool {
        let product = w.z * local.z;
        if self.upside_down { product < 0.0 } else { product > 0.0 }
    }

    /// The shadow terminator for light from `wi` (shading coordinates), in (0, 1].
    #[inline]
    pub(crate) fn shadow(&self, wi: Vec3) -> f32 {
        if self.terminator == 0.0 {
            return 1.0;
        }
        let c = wi.z.abs();
        2.0 * c / (c + safe_sqrt(sqr(c) + self.terminator * (1.0 - sqr(c)).max(0.0)))
    }
}

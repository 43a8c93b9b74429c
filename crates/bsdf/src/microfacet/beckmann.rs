//! Beckmann's surface of roughness 1: exact masking, and normals drawn as they are seen.
//!
//! Seen under the angle θ, slopes x in the plane of sight have the density
//! p(x) ∝ (cosθ - x sinθ) e^(-x²) for x < cotθ [Heitz and d'Eon 2014, eq. 5], with the integral
//! C(x) = (√π/2) cosθ (1 + erf x) + ½ sinθ e^(-x²); the other slope is Gaussian. C(x) = u C(cotθ) is solved for y = erf x by Newton's
//! method inside a bracket, in the domain of y as [Jakob 2014], so that the map is smooth in u. The start blends the exact solutions at
//! normal (y = (1 + erf cotθ) u - 1) and at grazing incidence (1 + y = (1 + erf cotθ) (1 - erf √(-ln u)), up to the end of the interval);
//! two or three steps do.

use super::erf::{erf, erf_inv};
use etendue_numerics::{
    Vec2, Vec3,
    math::{PI, exp, ln, safe_sqrt},
};

/// √π/2.
const HALF_SQRT_PI: f32 = 0.886_226_95;
/// The largest |erf x| that the inverse is asked for.
const ALMOST_ONE: f32 = 1.0 - 1e-7;

/// The exact G1(v)/cosθ_v = 2 / (cosθ (1 + erf a) + s e^(-a²)/√π), a = cosθ/s, s = α sinθ [Walter et al. 2007, eq. 26].
#[inline(always)]
pub fn g1_over_cos(cos: f32, s: f32) -> f32 {
    if cos >= 4.0 * s {
        return 1.0 / cos;
    }
    let a = cos / s;
    2.0 / (cos * (1.0 + erf(a)) + s * exp(-a * a) / PI.sqrt())
}

/// A visible normal of the surface of roughness 1 seen from the unit vector `v` (upper hemisphere), not normalised.
pub fn visible_normal(v: Vec3, u: Vec2) -> Vec3 {
    let mut search = Search::new(v, u.x);
    for _ in 0..STEPS {
        search.step();
        if search.is_over {
            break;
        }
    }
    search.normal(v, u.y)
}

/// Steps that a search may take.
pub const STEPS: usize = 8;

/// The search for y = erf x with C(x) = u C(cotθ), within a bracket.
#[derive(Clone, Copy)]
pub struct Search {
    pub cos: f32,
    pub sin: f32,
    /// u C(cotθ).
    pub target: f32,
    pub low: f32,
    pub high: f32,
    pub y: f32,
    pub is_over: bool,
}

impl Search {
    /// For the slope in the plane of sight of `v`.
    #[inline(always)]
    pub fn new(v: Vec3, u: f32) -> Self {
        let (cos, sin) = (v.z, (v.x * v.x + v.y * v.y).sqrt());
        let top = if sin * 4.0 <= cos { ALMOST_ONE } else { erf(cos / sin).min(ALMOST_ONE) };
        let end = if sin > 0.0 && cos < 4.0 * sin { exp(-cos * cos / (sin * sin)) } else { 0.0 };
        let target = u * (HALF_SQRT_PI * cos * (1.0 + top) + 0.5 * sin * end);

        let normal = (top + 1.0) * u - 1.0;
        let grazing = top - (top + 1.0) * erf(safe_sqrt(-ln(u.max(1e-7))));
        let y = (normal + sin * (grazing - normal)).max(-ALMOST_ONE).min(top);
        Self { cos, sin, target, low: -ALMOST_ONE, high: top, y, is_over: false }
    }

    /// A step of Newton's method, or half of the bracket.
    #[inline(always)]
    pub fn step(&mut self) {
        let &mut Self { cos, sin, target, low, high, y, .. } = self;
        let x = erf_inv(y);
        let excess = HALF_SQRT_PI * cos * (1.0 + y) + 0.5 * sin * exp(-x * x) - target;
        // dC/dy = (√π/2) (cosθ - x sinθ), which vanishes at the end x = cotθ.
        let next = y - excess / (HALF_SQRT_PI * (cos - x * sin));
        // Convergence is quadratic: a step of 1e-4 is the last that matters.
        self.is_over = ((next - y).abs() < 1e-4) & (next < high + 1e-7);
        let (below, above) = if excess > 0.0 { (low, y) } else { (y, high) };
        let inside = (next > below) & (next < above);
        self.y = if self.is_over | inside { next } else { 0.5 * (below + above) };
        (self.low, self.high) = (below, above);
    }

    /// The normal, with the number `u` for the slope across.
    #[inline(always)]
    pub fn normal(&self, v: Vec3, u: f32) -> Vec3 {
        let along = erf_inv(self.y.clamp(-ALMOST_ONE, ALMOST_ONE));
        let across = erf_inv((2.0 * u - 1.0).clamp(-ALMOST_ONE, ALMOST_ONE));
        let sin = self.sin;
        let (cos_phi, sin_phi) = if sin > 0.0 { (v.x / sin, v.y / sin) } else { (1.0, 0.0) };
        Vec3::new(sin_phi * across - cos_phi * along, -cos_phi * across - sin_phi * along, 1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_slope_solves_its_equation() {
        for (cos, sin) in [(1.0f32, 0.0f32), (0.8, 0.6), (0.1, 0.995), (1e-4, 1.0), (0.9999, 0.0141)] {
            let c = |x: f32| HALF_SQRT_PI * cos * (1.0 + erf(x)) + 0.5 * sin * exp(-x * x);
            let all = if sin > 0.0 { c((cos / sin).min(5.0)) } else { c(5.0) };
            for i in 0..=1000 {
                let u = (i as f32 / 1000.0).min(1.0 - 6e-8);
                let n = visible_normal(Vec3::new(sin, 0.0, cos), Vec2::new(u, 0.5));
                let x = -n.x;
                assert!(x.is_finite() && x * sin <= cos * 1.0001 + 1e-4, "{cos} {u} {x}");
                assert!((c(x) / all - u).abs() < 3e-6, "{cos} {u}: {} ", c(x) / all);
            }
        }
    }
}

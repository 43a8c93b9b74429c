//! The sphere as a square, areas kept: an octahedron's faces unfolded [Clarberg 2008].
//!
//! ```text
//! (u, v) in [-1, 1]²,  d = 1 - |u| - |v|,  r = 1 - |d|,  φ = π/4 ((|v| - |u|)/r + 1)
//! z = ±(1 - r²) as d,  (x, y) = r √(2 - r²) (±cosφ, ±sinφ) as u and v
//! ```
//!
//! z > 0 fills the diamond in the middle, z < 0 the corners around it. Density 1/4π per sr.

use crate::math::{FRAC_PI_2, FRAC_PI_4, atan2, safe_sqrt, sin_cos_near};
use glam::{Vec2, Vec3};

/// The unit direction of a point of the unit square.
#[inline(always)] // so that loops over lanes become vectors
pub fn square_to_equal_area_sphere(p: Vec2) -> Vec3 {
    let uv = 2.0 * p - 1.0;
    let a = uv.abs();
    let d = 1.0 - (a.x + a.y);
    let r = 1.0 - d.abs();
    let phi = (if r == 0.0 { 1.0 } else { (a.y - a.x) / r + 1.0 }) * FRAC_PI_4;
    let (sin, cos) = sin_cos_near(phi);
    let across = r * safe_sqrt(2.0 - r * r);
    Vec3::new(cos.copysign(uv.x) * across, sin.copysign(uv.y) * across, (1.0 - r * r).copysign(d))
}

/// The point of the unit square of a unit direction.
#[inline(always)] // so that loops over lanes become vectors
pub fn equal_area_sphere_to_square(w: Vec3) -> Vec2 {
    let a = w.abs();
    let r = safe_sqrt(1.0 - a.z);
    // φ in units of π/2.
    let phi = if a.x == 0.0 && a.y == 0.0 { 0.0 } else { atan2(a.y, a.x) / FRAC_PI_2 };
    let v = phi * r;
    let u = r - v;
    let (u, v) = if w.z < 0.0 { (1.0 - v, 1.0 - u) } else { (u, v) };
    (0.5 * (Vec2::new(u.copysign(w.x), v.copysign(w.y)) + 1.0)).clamp(Vec2::ZERO, Vec2::ONE)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_maps_undo_each_other_and_keep_areas() {
        const N: usize = 64;
        let mut octants = [0u32; 8];
        for i in 0..N * N {
            let p = Vec2::new((i % N) as f32 + 0.37, (i / N) as f32 + 0.61) / N as f32;
            let w = square_to_equal_area_sphere(p);
            assert!((w.length() - 1.0).abs() < 1e-5, "{p}: {w}");
            let back = equal_area_sphere_to_square(w);
            assert!((back - p).length() < 2e-4, "{p}: {back}");
            // The area of a small cell's image.
            let h = 1e-3;
            let [du, dv] = [Vec2::X, Vec2::Y]
                .map(|e| (square_to_equal_area_sphere(p + h * e) - square_to_equal_area_sphere(p - h * e)) / (2.0 * h));
            let area = du.cross(dv).length();
            let smooth = (1.0 - 2.0 * (p - 0.5).abs().element_sum()).abs() > 0.01 && (p - 0.5).abs().min_element() > 0.002;
            assert!(!smooth || (area / (4.0 * crate::math::PI) - 1.0).abs() < 0.02, "{p}: {area}");
            octants[usize::from(w.x > 0.0) + 2 * usize::from(w.y > 0.0) + 4 * usize::from(w.z > 0.0)] += 1;
        }
        assert!(octants.iter().all(|n| n.abs_diff((N * N / 8) as u32) < 70), "{octants:?}");
        assert!((square_to_equal_area_sphere(Vec2::splat(0.5)) - Vec3::Z).length() < 1e-6);
        assert!((square_to_equal_area_sphere(Vec2::ZERO) + Vec3::Z).length() < 1e-3);
    }
}

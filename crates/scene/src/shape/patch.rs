//! Drawing points on meshes. A *patch* is what light samplers choose among: one triangle, or two that make a flat quadrilateral.
//!
//! Seen large enough a patch is drawn uniformly in its solid angle Ω, with density 1/Ω: a rectangle as a whole [Ureña, Fajardo, King 2013], else
//! one of its triangles [Arvo 1995]. Below [`MIN_SOLID_ANGLE`] it is drawn by area, where the two hardly differ.

use super::mesh::{Mesh, cross};
use super::{SurfacePoint, sample};
use etendue_numerics::math::ONE_MINUS_EPSILON;
use etendue_numerics::warp::{SphericalRectangle, SphericalTriangle, square_to_triangle};
use etendue_numerics::{Vec2, Vec3};
use glam::DVec3;

/// Solid angle, sr, below which a patch is drawn by area.
const MIN_SOLID_ANGLE: f32 = 3e-5;

/// Two triangles with an edge in common, on either side of it, in one plane.
#[derive(Clone, Debug)]
pub(super) struct Quad {
    /// A corner and the two edges from it, where the quadrilateral is a rectangle.
    rectangle: Option<[Vec3; 3]>,
}

impl Quad {
    /// The quadrilateral that a mesh is. Only meshes without attributes count: their points need no triangle number.
    pub fn of(mesh: &Mesh) -> Option<Self> {
        let [a, b] = mesh.indices[..] else { return None };
        let (a, b) = (mesh.corners(a), mesh.corners(b));
        let apart = |p: &[Vec3; 3], q: &[Vec3; 3]| (0..3).filter(|i| !q.contains(&p[*i])).collect::<Vec<_>>();
        let ([i], [j]) = (&apart(&a, &b)[..], &apart(&b, &a)[..]) else { return None };
        let (x, y) = (a[*i], b[*j]);
        let (s, t) = (a[(i + 1) % 3], a[(i + 2) % 3]);

        // One plane, and x and y on either side of the common edge s t.
        let (na, nb) = (cross(a), cross(b));
        let flat = na.dot(nb) > (1.0 - 1e-9) * na.length() * nb.length() && nb != DVec3::ZERO;
        let side = |p: Vec3| (t - s).as_dvec3().cross((p - s).as_dvec3());
        if !mesh.attributes.is_empty() || !flat || side(x).dot(side(y)) >= 0.0 {
            return None;
        }

        // A rectangle: right angles at x, and y where the fourth corner must be.
        let (ex, ey) = (s - x, t - x);
        let size = ex.length() * ey.length();
        let right = ex.dot(ey).abs() <= 1e-6 * size && (x + ex + ey - y).length() <= 1e-6 * (ex.length() + ey.length());
        Some(Self { rectangle: right.then_some([x, ex, ey]) })
    }
}

impl Mesh {
    /// The triangles of a patch.
    pub(super) fn triangles_of(&self, patch: u32) -> impl Iterator<Item = (u32, [Vec3; 3])> {
        let range = if self.quad.is_some() { 0..2 } else { patch..patch + 1 };
        range.map(|i| (i, self.corners(self.indices[i as usize])))
    }

    /// Ω of a patch, sr.
    fn solid_angle(&self, patch: u32, from: Vec3) -> f32 {
        self.triangles_of(patch).map(|(_, corners)| solid_angle(corners, from)).sum()
    }

    /// The density at `from`, 1/sr; `None` where the patch is drawn by area.
    pub(super) fn patch_pdf(&self, patch: u32, from: Vec3) -> Option<f32> {
        let solid_angle = self.solid_angle(patch, from);
        (solid_angle >= MIN_SOLID_ANGLE).then(|| 1.0 / solid_angle)
    }

    /// A point uniform by area.
    pub(super) fn patch_by_area(&self, patch: u32, u: Vec2) -> SurfacePoint {
        let area: f32 = self.triangles_of(patch).map(|(_, corners)| triangle_area(corners)).sum();
        let pdf_a = if area > 0.0 { 1.0 / area } else { 0.0 };
        if let Some(Quad { rectangle: Some([corner, ex, ey]) }) = &self.quad {
            // Straight down onto the point, to learn in which triangle it lies.
            let down = ex.cross(*ey).normalize_or_zero() * ex.length();
            return SurfacePoint { pdf_a, ..self.point_towards(corner + ex * u.x + ey * u.y - down, down) };
        }
        let (triangle, u) = self.choose(patch, u, triangle_area);
        let [_, b1, b2] = square_to_triangle(u);
        SurfacePoint { pdf_a, ..self.point(triangle, Vec2::new(b1, b2)) }
    }

    /// A point in a direction uniform in the patch's solid angle, with its density at `from`, 1/sr.
    pub(super) fn patch_by_direction(&self, patch: u32, from: Vec3, u: Vec2) -> Option<(SurfacePoint, f32)> {
        let Some(pdf_w) = self.patch_pdf(patch, from) else {
            return sample::sample_direction_by_area(self.patch_by_area(patch, u), from);
        };
        if let Some(Quad { rectangle: Some([corner, ex, ey]) }) = &self.quad
            && let Some(rectangle) = SphericalRectangle::new(corner - from, *ex, *ey)
        {
            return Some((self.point_towards(from, rectangle.sample(u)), pdf_w));
        }
        let (triangle, u) = self.choose(patch, u, |corners| solid_angle(corners, from));
        let corners = self.corners(self.indices[triangle as usize]);
        let w = spherical(corners, from)?.sample(u);
        Some((self.point(triangle, barycentrics(corners, from, w).0), pdf_w))
    }

    /// The point of a quadrilateral in direction `w` from `from`.
    fn point_towards(&self, from: Vec3, w: Vec3) -> SurfacePoint {
        let [a, b] = [0, 1].map(|i: usize| barycentrics(self.corners(self.indices[i]), from, w));
        // On the common edge both are as good; rounding may put the point a hair outside of either.
        if a.1 >= b.1 { self.point(0, a.0) } else { self.point(1, b.0) }
    }

    /// One triangle of a patch, chosen in proportion to `weight`, and `u` made uniform again.
    fn choose(&self, patch: u32, u: Vec2, weight: impl Fn([Vec3; 3]) -> f32) -> (u32, Vec2) {
        if self.quad.is_none() {
            return (patch, u);
        }
        let [a, b] = [0, 1].map(|i: usize| weight(self.corners(self.indices[i])));
        let first = a / (a + b);
        if u.x < first || b == 0.0 {
            (0, Vec2::new((u.x / first).min(ONE_MINUS_EPSILON), u.y))
        } else {
            (1, Vec2::new(((u.x - first) / (1.0 - first)).clamp(0.0, ONE_MINUS_EPSILON), u.y))
        }
    }
}

/// Area of a triangle, m².
fn triangle_area(corners: [Vec3; 3]) -> f32 {
    (0.5 * cross(corners).length()) as f32
}

/// The triangle as seen from a point; `None` where it is seen edge-on.
fn spherical(corners: [Vec3; 3], from: Vec3) -> Option<SphericalTriangle> {
    let [a, b, c] = corners.map(|p| p - from);
    SphericalTriangle::new(a, b, c)
}

/// Ω of a triangle, sr; zero where it is seen edge-on.
fn solid_angle(corners: [Vec3; 3], from: Vec3) -> f32 {
    spherical(corners, from).map_or(0.0, |t| t.solid_angle())
}

/// Barycentrics (b1, b2) of the point of the triangle in direction `w` from `from`, moved into the triangle where they lay outside, and the smallest
/// of the three before that.
fn barycentrics(corners: [Vec3; 3], from: Vec3, w: Vec3) -> (Vec2, f64) {
    let [a, b, c] = corners.map(|p| p.as_dvec3() - from.as_dvec3());
    let w = w.as_dvec3();
    let weights = DVec3::new(w.dot(b.cross(c)), w.dot(c.cross(a)), w.dot(a.cross(b)));
    let weights = weights / weights.element_sum();
    let inside = weights.max(DVec3::ZERO);
    let inside = inside / inside.element_sum();
    // Edge-on nothing tells where: the middle is as good a point as any.
    let bary = if inside.is_finite() { Vec2::new(inside.y as f32, inside.z as f32) } else { Vec2::splat(1.0 / 3.0) };
    (bary, weights.min_element())
}

#[cfg(test)]
mod tests {
    use super::*;
    use etendue_numerics::Transform;

    #[test]
    fn only_flat_pairs_are_quadrilaterals() {
        let base = Mesh::rectangle(&Transform::IDENTITY);
        assert!(Quad::of(&base).is_some_and(|q| q.rectangle.is_some()));
        let with = |change: &dyn Fn(&mut Mesh)| {
            let mut mesh = base.clone();
            change(&mut mesh);
            Quad::of(&mesh).map(|q| q.rectangle.is_some())
        };
        assert_eq!(with(&|m| m.positions[3].x -= 0.5), Some(false), "a trapezium");
        assert_eq!(with(&|m| m.positions[3].z += 0.1), None, "folded");
        assert_eq!(with(&|m| m.indices[1] = [2, 0, 3]), None, "wound the other way");
        assert_eq!(with(&|m| m.positions[3] = Vec3::new(1.0, -0.5, 0.0)), None, "one over the other");
        assert_eq!(with(&|m| m.indices.truncate(1)), None, "one triangle");
    }

    #[test]
    fn a_rectangle_is_filled_in_step_with_the_square() {
        let mesh = Mesh::rectangle(&Transform::IDENTITY);
        let from = Vec3::new(0.3, -0.2, 2.0);
        // Neighbours stay neighbours: no seam along the diagonal.
        for i in 0..64 {
            for j in 0..64 {
                let u = Vec2::new(i as f32, j as f32) / 64.0;
                let next = u + Vec2::new(1.0 / 64.0, 1.0 / 64.0);
                let by_area = |u: Vec2| mesh.patch_by_area(0, u).p;
                let by_direction = |u: Vec2| mesh.patch_by_direction(0, from, u).expect("a point").0.p;
                assert!((by_area(u) - by_area(next)).length() < 0.05);
                assert!((by_direction(u) - by_direction(next)).length() < 0.1);
            }
        }
    }
}

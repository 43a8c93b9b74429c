//! Drawing points on meshes. A *patch* is what light samplers choose among: one triangle, or two that make a flat quadrilateral.
//!
//! Seen from nearby a patch is drawn uniformly in its solid angle Ω, with density 1/Ω: a rectangle as a whole [Ureña, Fajardo, King 2013], else
//! one of its triangles [Arvo 1995]. From further away it is drawn by area: there the two hardly differ, and area costs a tenth. Which of them
//! it is hangs on the patch and the place it is seen from alone, so a density can be told of any point ([`Mesh::patch_seen`]).

use super::mesh::{Mesh, cross};
use super::{SurfacePoint, Triangle, sample};
use crate::interaction::Interaction;
use etendue_numerics::math::{ONE_MINUS_EPSILON, gamma};
use etendue_numerics::warp::{SphericalRectangle, SphericalTriangle, square_to_triangle};
use etendue_numerics::{Vec2, Vec3};
use glam::DVec3;

/// Distance from a patch's middle, in radii of the sphere around it, beyond which it is drawn by area. Solid angles from twice as far cost an
/// eighth more time in a Cornell box and lower its error by a twentieth.
const NEAR: f32 = 2.0;

/// Solid angle, sr, below which a patch is drawn by area even from nearby: edge-on.
const MIN_SOLID_ANGLE: f32 = 3e-5;

/// A solid angle, sr, that only places very near to a patch see.
const LARGE: f32 = 3.0;

/// Distance from a patch's plane, in parts of the largest coordinate, at which a point may be on it: some roundings.
const TOUCH: f64 = 1e-6;

/// Two triangles with an edge in common, on either side of it, in one plane.
#[derive(Clone, Debug)]
pub(super) struct Quad {
    middle: Vec3,
    radius2: f32,
    area: f32,
    rectangle: Option<Rectangle>,
}

/// Two triangles that make a rectangle: (x, s, t) and (y, t, s) with y across from x.
#[derive(Clone, Copy, Debug)]
struct Rectangle {
    /// x.
    corner: Vec3,
    /// s - x and t - x.
    edges: [Vec3; 2],
    /// For each triangle the barycentrics (b1, b2) at u = 0, and how they change with u.x and u.y.
    bary: [[Vec2; 3]; 2],
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
        // Weights at u: of x, s, t in the first triangle, of y, s, t in the second.
        let s_of_b = if b[(j + 1) % 3] == s { (j + 1) % 3 } else { (j + 2) % 3 };
        let bary = [
            by_place([*i, (i + 1) % 3, (i + 2) % 3], [[1.0, 0.0, 0.0], [-1.0, 1.0, 0.0], [-1.0, 0.0, 1.0]]),
            by_place([*j, s_of_b, 3 - j - s_of_b], [[-1.0, 1.0, 1.0], [1.0, 0.0, -1.0], [1.0, -1.0, 0.0]]),
        ];

        let (middle, radius2) = sphere_around(&[x, y, s, t]);
        let area = triangle_area(a) + triangle_area(b);
        let rectangle = right.then_some(Rectangle { corner: x, edges: [ex, ey], bary });
        Some(Self { middle, radius2, area, rectangle })
    }
}

impl Rectangle {
    fn seen_from(&self, from: Vec3) -> Option<SphericalRectangle> {
        SphericalRectangle::new(self.corner - from, self.edges[0], self.edges[1])
    }

    /// The triangle at `corner` + u · `edges`, and barycentrics (b1, b2) in it.
    #[inline]
    fn locate(&self, u: Vec2) -> (u32, Vec2) {
        let second = u.x + u.y > 1.0;
        let [at_zero, along_x, along_y] = if second { self.bary[1] } else { self.bary[0] };
        (u32::from(second), at_zero + along_x * u.x + along_y * u.y)
    }
}

/// Weights of three corners that stand at `places` of their triangle, as barycentrics (b1, b2).
fn by_place(places: [usize; 3], weights: [[f32; 3]; 3]) -> [Vec2; 3] {
    weights.map(|w| {
        let mut b = [0.0; 3];
        places.into_iter().zip(w).for_each(|(place, weight)| b[place] = weight);
        Vec2::new(b[1], b[2])
    })
}

/// A patch seen large: what it looks like from there.
enum Seen {
    Rectangle(Rectangle, SphericalRectangle),
    Triangle(u32, SphericalTriangle),
    /// Two triangles, Ω of each.
    Two([f32; 2]),
}

impl Seen {
    /// Ω, sr.
    fn solid_angle(&self) -> f32 {
        match self {
            Self::Rectangle(_, seen) => seen.solid_angle(),
            Self::Triangle(_, seen) => seen.solid_angle(),
            Self::Two([a, b]) => a + b,
        }
    }
}

impl Mesh {
    /// Area of a patch, m².
    #[inline]
    pub(super) fn patch_area(&self, patch: u32) -> f32 {
        match &self.quad {
            Some(quad) => quad.area,
            None => triangle_area(self.corners(self.indices[patch as usize])),
        }
    }

    /// What a patch looks like from `from`, where it is drawn by solid angle; `None` where it is drawn by area.
    #[inline]
    fn patch_seen(&self, patch: u32, from: Vec3) -> Option<Seen> {
        let (middle, radius2) = match &self.quad {
            Some(quad) => (quad.middle, quad.radius2),
            None => sphere_around(&self.corners(self.indices[patch as usize])),
        };
        if (middle - from).length_squared() > NEAR * NEAR * radius2 {
            return None;
        }
        self.patch_from_nearby(patch, from).filter(|seen| seen.solid_angle() >= MIN_SOLID_ANGLE)
    }

    #[inline(never)]
    fn patch_from_nearby(&self, patch: u32, from: Vec3) -> Option<Seen> {
        match &self.quad {
            None => Some(Seen::Triangle(patch, spherical(self.corners(self.indices[patch as usize]), from)?)),
            Some(Quad { rectangle: Some(rectangle), .. }) => Some(Seen::Rectangle(*rectangle, rectangle.seen_from(from)?)),
            Some(_) => Some(Seen::Two([0, 1].map(|i: usize| solid_angle(self.corners(self.indices[i]), from)))),
        }
    }

    /// The density of [`Mesh::patch_by_direction`] at the point `at`, 1/sr.
    #[inline]
    pub(super) fn patch_pdf(&self, patch: u32, from: Vec3, at: &Interaction) -> f32 {
        match self.patch_seen(patch, from) {
            Some(seen) => 1.0 / seen.solid_angle(),
            None => sample::pdf_direction_by_area(self.patch_area(patch), from, at),
        }
    }

    /// A point uniform by area: its triangle, and barycentrics there.
    #[inline]
    fn place_by_area(&self, patch: u32, u: Vec2) -> (u32, Vec2) {
        if let Some(Quad { rectangle: Some(rectangle), .. }) = &self.quad {
            return rectangle.locate(u);
        }
        let (triangle, u) = self.choose(patch, u, |i| triangle_area(self.corners(self.indices[i])));
        let [_, b1, b2] = square_to_triangle(u);
        (triangle, Vec2::new(b1, b2))
    }

    /// A point uniform in solid angle, of a patch that looks like `seen`: its triangle, and barycentrics there.
    #[inline(never)]
    fn place_by_solid_angle(&self, patch: u32, seen: &Seen, from: Vec3, u: Vec2) -> (u32, Vec2) {
        let corners = |triangle: u32| self.corners(self.indices[triangle as usize]);
        match seen {
            Seen::Rectangle(rectangle, seen) => {
                let across = seen.sample(u) - (rectangle.corner - from);
                let along = rectangle.edges.map(|e| (across.dot(e) / e.length_squared()).clamp(0.0, 1.0));
                rectangle.locate(Vec2::from(along))
            }
            Seen::Triangle(triangle, seen) => (*triangle, barycentrics(corners(*triangle), from, seen.sample(u))),
            Seen::Two(solid_angles) => {
                let (triangle, u) = self.choose(patch, u, |i| solid_angles[i]);
                let seen = spherical(corners(triangle), from);
                let bary = seen.map_or(Vec2::splat(1.0 / 3.0), |seen| barycentrics(corners(triangle), from, seen.sample(u)));
                (triangle, bary)
            }
        }
    }

    /// A point uniform by area.
    #[inline]
    pub(super) fn patch_by_area(&self, patch: u32, u: Vec2) -> SurfacePoint {
        let area = self.patch_area(patch);
        let (triangle, bary) = self.place_by_area(patch, u);
        SurfacePoint { pdf_a: if area > 0.0 { 1.0 / area } else { 0.0 }, ..self.point(triangle, bary) }
    }

    /// A point by solid angle from nearby, by area from further away, with its density at `from`, 1/sr.
    #[inline(always)] // as a return value it would go through memory
    pub(super) fn patch_by_direction(&self, patch: u32, from: Vec3, u: Vec2) -> Option<(SurfacePoint, f32)> {
        let seen = self.patch_seen(patch, from);
        if seen.as_ref().is_some_and(|seen| seen.solid_angle() > LARGE && self.is_on_patch(patch, from)) {
            return None;
        }
        let (triangle, bary) = match &seen {
            Some(seen) => self.place_by_solid_angle(patch, seen, from, u),
            None => self.place_by_area(patch, u),
        };
        let point = self.point(triangle, bary);
        let pdf_w = match &seen {
            Some(seen) => 1.0 / seen.solid_angle(),
            None => sample::to_solid_angle(1.0 / self.patch_area(patch), from, point.p, point.n),
        };
        (pdf_w > 0.0).then_some((point, pdf_w))
    }

    /// Whether the point lies in the plane of the patch, as far as rounding can tell: from there it fills half of all directions by chance alone, and in
    /// truth is seen edge-on.
    #[inline(never)]
    fn is_on_patch(&self, patch: u32, from: Vec3) -> bool {
        let corners = self.corners(self.indices[patch as usize]);
        let size = corners.iter().fold(from.abs().max_element(), |most, c| most.max(c.abs().max_element()));
        let n = cross(corners).normalize_or_zero();
        n.dot(from.as_dvec3() - corners[0].as_dvec3()).abs() <= TOUCH * f64::from(size)
    }

    /// One triangle of a patch, chosen in proportion to `weight`, and `u` made uniform again.
    #[inline]
    fn choose(&self, patch: u32, u: Vec2, weight: impl Fn(usize) -> f32) -> (u32, Vec2) {
        if self.quad.is_none() {
            return (patch, u);
        }
        let [a, b] = [0, 1].map(weight);
        let first = a / (a + b);
        if u.x < first || b == 0.0 {
            (0, Vec2::new((u.x / first).min(ONE_MINUS_EPSILON), u.y))
        } else {
            (1, Vec2::new(((u.x - first) / (1.0 - first)).clamp(0.0, ONE_MINUS_EPSILON), u.y))
        }
    }
}

/// A point in the midst of some corners, and the square of the greatest distance from it.
#[inline]
fn sphere_around(corners: &[Vec3]) -> (Vec3, f32) {
    let middle = corners.iter().sum::<Vec3>() / corners.len() as f32;
    (middle, corners.iter().map(|c| (*c - middle).length_squared()).fold(0.0, f32::max))
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

/// Barycentrics (b1, b2) of the point of the triangle in direction `w` from `from`, moved into the triangle where rounding left it.
fn barycentrics(corners: [Vec3; 3], from: Vec3, w: Vec3) -> Vec2 {
    let [a, b, c] = corners.map(|p| p.as_dvec3() - from.as_dvec3());
    let w = w.as_dvec3();
    let weights = DVec3::new(w.dot(b.cross(c)), w.dot(c.cross(a)), w.dot(a.cross(b)));
    let inside = (weights / weights.element_sum()).max(DVec3::ZERO);
    let inside = inside / inside.element_sum();
    // Edge-on nothing tells where: the middle is as good a point as any.
    if inside.is_finite() { Vec2::new(inside.y as f32, inside.z as f32) } else { Vec2::splat(1.0 / 3.0) }
}

/// A flat rectangle by value, seen from far enough to be drawn by area: [`Mesh::patch_by_direction`] without branches, the same bits.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FarRectangle {
    middle: Vec3,
    near2: f32,
    pdf_a: f32,
    bary: [[Vec2; 3]; 2],
    triangles: [Triangle; 2],
}

impl FarRectangle {
    /// The rectangle that a mesh is.
    pub fn of(mesh: &Mesh) -> Option<Self> {
        let quad = mesh.quad.as_ref()?;
        let rectangle = quad.rectangle?;
        let triangles = [mesh.triangle(0), mesh.triangle(1)];
        let flat = triangles.iter().all(|t| t.error >= 0.0) && quad.area > 0.0;
        let (middle, near2) = (quad.middle, NEAR * NEAR * quad.radius2);
        flat.then_some(Self { middle, near2, pdf_a: 1.0 / quad.area, bary: rectangle.bary, triangles })
    }

    /// Whether it is so near that it is not drawn by area.
    #[inline(always)]
    pub fn is_near(&self, from: Vec3) -> bool {
        (self.middle - from).length_squared() <= self.near2
    }

    /// A point uniform by area, its error bound and normal, and its density at `from`, 1/sr; zero where it cannot be drawn.
    #[inline(always)]
    pub fn sample(&self, from: Vec3, u: Vec2) -> (Vec3, Vec3, Vec3, f32) {
        let second = u.x + u.y > 1.0;
        let either = |i: usize| if second { self.bary[1][i] } else { self.bary[0][i] };
        let bary = either(0) + either(1) * u.x + either(2) * u.y;
        let b = [1.0 - bary.x - bary.y, bary.x, bary.y];
        let [first, other] = &self.triangles;
        let corner = |i: usize| if second { other.corners[i] } else { first.corners[i] };
        let [q0, q1, q2] = [corner(0) * b[0], corner(1) * b[1], corner(2) * b[2]];
        let p = q0 + q1 + q2;
        let error = if second { other.error } else { first.error };
        let p_error = (q0.abs() + q1.abs() + q2.abs()) * gamma(7) + Vec3::splat(error.abs());
        let n = if second { other.n } else { first.n };
        let n = if first.flipped { -n } else { n };
        (p, p_error, n, sample::to_solid_angle(self.pdf_a, from, p, n))
    }
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

    /// A lamp that reflects must not light itself: a point of its plane, rounded to either side, would see it fill a hemisphere.
    #[test]
    fn a_patch_is_not_seen_from_its_own_points() {
        let place = glam::DMat4::from_translation(DVec3::new(0.3, 0.7, -0.2)) * glam::DMat4::from_rotation_x(1.2);
        let mesh = Mesh::rectangle(&Transform::new(place).expect("a map with an inverse"));
        for i in 0..1000 {
            let u = Vec2::new((i as f32 * 0.618).fract(), (i as f32 * 0.377).fract());
            let point = mesh.patch_by_area(0, u);
            // Rounded into the plane itself it is edge-on, and drawn by area with next to no chance of light.
            assert!(mesh.patch_by_direction(0, point.p, Vec2::new(0.3, 0.8)).is_none_or(|(_, pdf)| pdf > 100.0));
            let above = point.p + 1e-3 * point.n;
            assert!(mesh.patch_by_direction(0, above, Vec2::new(0.3, 0.8)).is_some());
        }
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

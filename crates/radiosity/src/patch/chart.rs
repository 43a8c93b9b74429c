//! Charts: pieces of exact surfaces over a square or triangle of parameters.
//!
//! ```text
//! triangle   p = p0 + s (p1 - p0) + t (p2 - p0),                      s, t ≥ 0, s + t ≤ 1
//! quad       p = (1-s)(1-t) p0 + s (1-t) p1 + s t p2 + (1-s) t p3,    flat and convex
//! sphere     p = M (√(1-z²) cosφ, √(1-z²) sinφ, z),  φ = 2π s, z = 1 - 2 t
//! cylinder   p = M (cosφ, sinφ, t),                  φ = 2π s
//! disk       p = M (r cosφ, r sinφ, 0),              φ = 2π s, r = √t
//! ```
//!
//! M is affine. Equal parts of the parameters are equal parts of the area, but for quads that are no parallelograms and for spheres and
//! cylinders that M makes elliptic; [`Chart::stretch`] tells by how much.

use super::round::Round;
use super::span::Span;
use glam::{DAffine3, DVec2, DVec3};

/// A piece of a surface with parameters (s, t), in the world. Metres.
#[derive(Clone, Debug)]
pub enum Chart {
    /// A flat triangle.
    Triangle {
        /// p0, p1, p2.
        corners: [DVec3; 3],
        /// Unit normal of the front.
        n: DVec3,
    },
    /// A flat convex quadrilateral.
    Quad {
        /// p0 to p3, around.
        corners: [DVec3; 4],
        /// Unit normal of the front.
        n: DVec3,
    },
    /// A round shape, whole.
    Round {
        /// Which.
        shape: Round,
        /// M.
        to_world: DAffine3,
        /// M⁻¹.
        to_object: DAffine3,
        /// +1 where the front is outside (of a disk: above), -1 where it is inside.
        outward: f64,
    },
}

impl Chart {
    /// p(s, t).
    pub fn point(&self, st: DVec2) -> DVec3 {
        match self {
            Self::Triangle { corners: [a, b, c], .. } => a + (b - a) * st.x + (c - a) * st.y,
            Self::Quad { corners: [a, b, c, d], .. } => a.lerp(*b, st.x).lerp(d.lerp(*c, st.x), st.y),
            Self::Round { shape, to_world, .. } => to_world.transform_point3(shape.point(st)),
        }
    }

    /// The unit normal of the front at (s, t).
    pub fn normal(&self, st: DVec2) -> DVec3 {
        match self {
            Self::Triangle { n, .. } | Self::Quad { n, .. } => *n,
            Self::Round { shape, to_object, outward, .. } => normal(to_object, *outward, shape.normal(st)),
        }
    }

    /// The unit normal of the front at a point p of the surface.
    #[inline]
    pub fn normal_at(&self, p: DVec3) -> DVec3 {
        match self {
            Self::Triangle { n, .. } | Self::Quad { n, .. } => *n,
            Self::Round { shape, to_object, outward, .. } => {
                let q = to_object.transform_point3(p);
                let object = match shape {
                    Round::Sphere => q,
                    Round::Cylinder => q.with_z(0.0),
                    Round::Disk => DVec3::Z,
                };
                normal(to_object, *outward, object)
            }
        }
    }

    /// |∂p/∂s × ∂p/∂t|, m².
    pub fn stretch(&self, st: DVec2) -> f64 {
        let (ds, dt) = match self {
            Self::Triangle { corners: [a, b, c], .. } => (b - a, c - a),
            Self::Quad { corners: [a, b, c, d], .. } => ((b - a).lerp(c - d, st.y), (d - a).lerp(c - b, st.x)),
            Self::Round { shape, to_world, .. } => {
                let (ds, dt) = shape.tangents(st);
                (to_world.transform_vector3(ds), to_world.transform_vector3(dt))
            }
        };
        ds.cross(dt).length()
    }

    /// Whether [`Chart::stretch`] is the same everywhere.
    pub fn is_even(&self) -> bool {
        const SAME: f64 = 1e-9;
        match self {
            Self::Triangle { .. } => true,
            Self::Quad { corners: [a, b, c, d], .. } => (a + c - b - d).length() <= SAME * (c - a).length(),
            Self::Round { shape: Round::Disk, .. } => true,
            Self::Round { shape, to_world, .. } => {
                let m = to_world.matrix3;
                let (x, y, z) = (m.x_axis, m.y_axis, m.z_axis);
                let size = x.length_squared();
                let circle = (size - y.length_squared()).abs() <= SAME * size && x.dot(y).abs() <= SAME * size;
                let straight = x.dot(z).abs().max(y.dot(z).abs()) <= SAME * x.length() * z.length();
                circle && straight && (*shape == Round::Cylinder || (size - z.length_squared()).abs() <= SAME * size)
            }
        }
    }

    /// Area of the part `cell`, m²: exact, but for ellipsoids and elliptic cylinders, where it is a quadrature of 64 points a 32nd of a turn.
    pub fn area(&self, cell: &Span) -> f64 {
        match self {
            Self::Triangle { .. } => 0.5 * self.stretch(DVec2::ZERO) * (cell.size.x * cell.size.y).abs(),
            Self::Quad { .. } => {
                let [a, b, c, d] = cell.corners().map(|st| self.point(st));
                0.5 * (c - a).cross(d - b).length()
            }
            Self::Round { .. } if self.is_even() => self.stretch(DVec2::splat(0.5)) * cell.size.x * cell.size.y,
            Self::Round { .. } => cell.integrate(|st| self.stretch(st)),
        }
    }

    /// The parameters of a point of the surface.
    pub fn locate(&self, p: DVec3) -> DVec2 {
        match self {
            Self::Triangle { corners: [a, b, c], .. } => barycentrics(p - a, b - a, c - a),
            Self::Quad { corners, .. } => locate_in_quad(corners, p),
            Self::Round { shape, to_object, .. } => shape.locate(to_object.transform_point3(p)),
        }
    }

    /// Points whose convex hull holds it, where it is flat.
    pub(crate) fn hull(&self) -> Vec<DVec3> {
        match self {
            Self::Triangle { corners, .. } => corners.to_vec(),
            Self::Quad { corners, .. } => corners.to_vec(),
            Self::Round { shape: Round::Disk, to_world, .. } => {
                let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
                corners.map(|(x, y)| to_world.transform_point3(DVec3::new(x, y, 0.0))).to_vec()
            }
            Self::Round { .. } => Vec::new(),
        }
    }

    /// Whether it lies in a plane.
    pub fn is_flat(&self) -> bool {
        !matches!(self, Self::Round { shape: Round::Sphere | Round::Cylinder, .. })
    }

    /// Whether its cells are triangles.
    pub fn is_triangle(&self) -> bool {
        matches!(self, Self::Triangle { .. })
    }
}

/// A covector goes by the transposed inverse.
#[inline]
fn normal(to_object: &DAffine3, outward: f64, object: DVec3) -> DVec3 {
    (to_object.matrix3.transpose() * object).normalize_or(DVec3::Z) * outward
}

/// (s, t) with `p` = s `a` + t `b`, in the plane of the two.
fn barycentrics(p: DVec3, a: DVec3, b: DVec3) -> DVec2 {
    let n = a.cross(b);
    DVec2::new(p.cross(b).dot(n), a.cross(p).dot(n)) / n.length_squared()
}

/// The inverse of the bilinear map: t solves a quadratic of which one root lies in [0, 1], s follows.
fn locate_in_quad([a, b, c, d]: &[DVec3; 4], p: DVec3) -> DVec2 {
    // p - a = s e + t f + s t g
    let (e, f, g, h) = (b - a, d - a, a + c - b - d, p - a);
    let n = (c - a).cross(d - b).normalize_or(DVec3::Z);
    let cross = |x: DVec3, y: DVec3| x.cross(y).dot(n);
    // (h - t f) × (e + t g) = 0
    let (k2, k1, k0) = (-cross(f, g), cross(h, g) - cross(f, e), cross(h, e));
    let t = if k2.abs() <= 1e-12 * k1.abs() {
        -k0 / k1
    } else {
        // Without cancellation [Press et al. 2007, §5.6]; the root nearer to the square is the one.
        let q = -0.5 * (k1 + (k1 * k1 - 4.0 * k2 * k0).max(0.0).sqrt().copysign(k1));
        let roots = [q / k2, k0 / q];
        let outside = |t: f64| if t.is_finite() { (t - 0.5).abs() } else { f64::INFINITY };
        if outside(roots[0]) <= outside(roots[1]) { roots[0] } else { roots[1] }
    };
    let along = e + g * t;
    DVec2::new((h - f * t).dot(along) / along.length_squared(), t)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DMat3;
    use std::f64::consts::{PI, TAU};

    /// Area of a sphere of radius 1.
    const UNIT_SPHERE: f64 = 4.0 * PI;

    fn round(shape: Round, m: DAffine3) -> Chart {
        Chart::Round { shape, to_world: m, to_object: m.inverse(), outward: 1.0 }
    }

    fn charts() -> Vec<Chart> {
        let turned = DAffine3::from_axis_angle(DVec3::new(1.0, 2.0, -1.0).normalize(), 0.7);
        let moved = DAffine3::from_translation(DVec3::new(3.0, -1.0, 0.5)) * turned;
        let squashed = moved * DAffine3::from_scale(DVec3::new(1.0, 2.0, 0.5)) * turned;
        let flat = [DVec2::ZERO, DVec2::new(2.0, 0.1), DVec2::new(1.5, 1.2), DVec2::new(0.2, 0.9)];
        let quad = flat.map(|p| moved.transform_point3(p.extend(0.0)));
        let n = moved.transform_vector3(DVec3::Z);
        let mut charts = vec![
            Chart::Triangle { corners: [quad[0], quad[1], quad[2]], n },
            Chart::Quad { corners: quad, n },
            Chart::Quad { corners: [quad[0], quad[1], quad[1] + quad[3] - quad[0], quad[3]], n },
        ];
        for m in [moved * DAffine3::from_scale(DVec3::splat(1.7)), squashed] {
            charts.extend([Round::Sphere, Round::Cylinder, Round::Disk].map(|shape| round(shape, m)));
        }
        charts
    }

    #[test]
    fn parameters_and_points_go_both_ways() {
        for chart in charts() {
            for (s, t) in [(0.1, 0.2), (0.4, 0.55), (0.7, 0.25), (0.01, 0.9)] {
                let st = DVec2::new(s, t);
                let p = chart.point(st);
                assert!((chart.locate(p) - st).length() < 1e-9, "{chart:?} at {st}: {}", chart.locate(p));
                assert!((chart.normal(st) - chart.normal_at(p)).length() < 1e-9);
                // The normal is across, and the stretch that of small steps.
                let h = 1e-6;
                let ds = (chart.point(st + DVec2::X * h) - chart.point(st - DVec2::X * h)) / (2.0 * h);
                let dt = (chart.point(st + DVec2::Y * h) - chart.point(st - DVec2::Y * h)) / (2.0 * h);
                assert!(chart.normal(st).dot(ds).abs() < 1e-7 * ds.length() && chart.normal(st).dot(dt).abs() < 1e-7 * dt.length());
                assert!((ds.cross(dt).length() / chart.stretch(st) - 1.0).abs() < 1e-7, "{chart:?}");
            }
        }
    }

    #[test]
    fn quarters_fill_their_cell_and_are_found() {
        for chart in charts() {
            let triangle = chart.is_triangle();
            let cell = if triangle {
                Span { at: DVec2::new(0.5, 0.5), size: DVec2::splat(-0.25) }
            } else {
                Span { at: DVec2::new(0.25, 0.5), size: DVec2::new(0.25, 0.5) }
            };
            let quarters = cell.quarters(triangle);
            let sum: f64 = quarters.iter().map(|q| chart.area(q)).sum();
            assert!((sum / chart.area(&cell) - 1.0).abs() < 1e-12, "{chart:?}");
            for (i, q) in quarters.iter().enumerate() {
                let middle = q.middle(&chart);
                assert_eq!(Span::quarter_of(cell.local(middle), triangle), i);
                assert!(q.local(middle).min_element() > 0.2);
            }
        }
    }

    #[test]
    fn areas_are_known() {
        let sphere = round(Round::Sphere, DAffine3::from_scale(DVec3::splat(2.0)));
        assert!((sphere.area(&Span::WHOLE) - 4.0 * UNIT_SPHERE).abs() < 1e-12);
        let band = Span { at: DVec2::new(0.25, 0.0), size: DVec2::new(0.5, 0.1) };
        assert!((sphere.area(&band) - 0.05 * 4.0 * UNIT_SPHERE).abs() < 1e-12, "Archimedes: equal heights, equal areas");
        let tube = round(Round::Cylinder, DAffine3::from_scale(DVec3::new(2.0, 2.0, 3.0)));
        assert!((tube.area(&Span::WHOLE) - 12.0 * PI).abs() < 1e-12);
        let ellipse = round(Round::Disk, DAffine3::from_scale(DVec3::new(2.0, 3.0, 1.0)));
        assert!((ellipse.area(&Span::WHOLE) - 6.0 * PI).abs() < 1e-12);
        // A spheroid of radius a and half height c < a: 2π a² (1 + (1 - e²)/e artanh e), e² = 1 - c²/a².
        let spheroid = round(Round::Sphere, DAffine3::from_mat3(DMat3::from_diagonal(DVec3::new(1.0, 1.0, 0.5))));
        let e = 0.75f64.sqrt();
        let exact = TAU * (1.0 + (1.0 - e * e) / e * e.atanh());
        assert!((spheroid.area(&Span::WHOLE) / exact - 1.0).abs() < 1e-9);
    }
}

//! Curves as meshes: tubes, and ribbons that keep their normals.
//!
//! ```text
//! Bézier of degree 2 or 3: segments share their ends;  B-spline: segments share all but one control point
//! c(t) by de Casteljau's or de Boor's scheme,  width(u) = (1 - u) width0 + u width1,  u along the whole curve
//! ```
//!
//! A `flat` curve always faces its viewer. A mesh cannot, and a tube of the same width has the same outline: `flat` is rendered as `cylinder`, and so
//! is whatever is made of `hair`, which needs the wall of a fibre. A segment has as many steps as its bend asks for: chords stay within a twentieth of the
//! width, or a thousandth of the length: 100,000 hairs of one bend each are some 15 million triangles.
//! Frames along a tube do not twist: each is the one before it, turned by the least rotation [Bloomenthal 1990].

use super::shapes::{Geometry, grid};
use super::values::List;
use super::{Reader, param};
use etendue_description::{MeshData, Value};
use glam::{DQuat, DVec3, Vec2};

/// Sides of a tube.
const SIDES: u32 = 6;
/// How far chords may be from the curve, in widths, and in lengths of the whole.
const NEAR: f64 = 0.05;
const STRAIGHT: f64 = 1e-3;
/// The most steps along a segment.
const MOST_STEPS: usize = 32;

pub(super) fn curve(reader: &mut Reader, list: &mut List) -> Option<Geometry> {
    let control = reader.positions(list)?;
    let d = &mut reader.diagnostics;
    let mut kind = list.choice(d, "type", &["flat", "cylinder", "ribbon"]);
    let basis = list.choice(d, "basis", &["bezier", "bspline"]);
    let degree = list.integer(d, "degree", 3, 2..=3) as usize;
    let width = list.float(d, "width", 1.0);
    let widths = [list.float(d, "width0", width), list.float(d, "width1", width)];
    // How far pbrt splits curves before it intersects them.
    list.ignore(&["splitdepth"]);
    let normals = list.points(d, "N");
    let n = control.len();
    let bezier = basis == "bezier";
    let fits = n > degree && (!bezier || (n - 1).is_multiple_of(degree));
    if !fits {
        let wanted = if bezier { format!("{} + {degree} k", degree + 1) } else { format!("at least {}", degree + 1) };
        d.error(list.span_of("P"), format!("a {basis} curve of degree {degree} has {wanted} control points, not {n}"));
        return None;
    }
    let segments = if bezier { (n - 1) / degree } else { n - degree };
    if kind == "ribbon" && normals.as_ref().is_none_or(|v| v.len() != segments + 1) {
        d.error(list.span, format!("a `ribbon` of {segments} segments needs {} normals `N`", segments + 1));
        return None;
    }

    // A mesh of fibres is seen from outside, whatever `ReverseOrientation` says.
    let hair = reader.state.material.is_some_and(|m| reader.description.node(m).model.value == "hair");
    if hair {
        if kind == "ribbon" {
            reader.once(list.span, "a `ribbon` of hair is rendered as a `cylinder` of the same width");
        }
        kind = "cylinder";
    }

    // Points along the whole curve.
    let control: Vec<DVec3> = control.iter().map(|p| p.as_dvec3()).collect();
    let each = steps_of(&control, degree, bezier, widths[0].max(widths[1]));
    let steps = segments * each;
    let point = |i: usize| {
        let segment = i.min(steps - 1) / each;
        let t = (i - segment * each) as f64 / each as f64;
        let first = if bezier { segment * degree } else { segment };
        along(&control[first..=first + degree], bezier, t)
    };
    let points: Vec<DVec3> = (0..=steps).map(point).collect();
    let tangents: Vec<DVec3> =
        (0..=steps).map(|i| (points[(i + 1).min(steps)] - points[i.saturating_sub(1)]).normalize_or(DVec3::Z)).collect();
    let half_width = |i: usize| 0.5 * (widths[0] + (widths[1] - widths[0]) * i as f64 / steps as f64);

    let mut mesh = MeshData::default();
    let columns = if let Some(normals) = normals.filter(|_| kind == "ribbon") {
        for i in 0..=steps {
            let segment = i.min(steps - 1) / each;
            let t = (i - segment * each) as f64 / each as f64;
            let [a, b] = [segment, segment + 1].map(|k| normals[k].as_dvec3().normalize_or(DVec3::Z));
            let n = DQuat::IDENTITY.slerp(DQuat::from_rotation_arc(a, b), t) * a;
            let across = n.cross(tangents[i]).normalize_or(tangents[i].any_orthonormal_vector());
            for side in [-1.0, 1.0] {
                mesh.positions.push((points[i] + across * (side * half_width(i))).as_vec3());
                mesh.normals
                    .push(tangents[i].cross(across).as_vec3() * if tangents[i].cross(across).dot(n) < 0.0 { -1.0 } else { 1.0 });
                mesh.uvs.push(Vec2::new(i as f32 / steps as f32, if side < 0.0 { 0.0 } else { 1.0 }));
            }
        }
        1
    } else {
        if kind == "flat" {
            reader.once(list.span, "`flat` curves are rendered as `cylinder` curves of the same width");
        }
        let mut across = tangents[0].any_orthonormal_vector();
        for i in 0..=steps {
            if i > 0 {
                across = DQuat::from_rotation_arc(tangents[i - 1], tangents[i]) * across;
            }
            let other = tangents[i].cross(across);
            for k in 0..=SIDES {
                let (sin, cos) = (std::f64::consts::TAU * f64::from(k) / f64::from(SIDES)).sin_cos();
                let n = across * cos + other * sin;
                mesh.positions.push((points[i] + n * half_width(i)).as_vec3());
                mesh.normals.push(n.as_vec3());
                mesh.uvs.push(Vec2::new(i as f32 / steps as f32, k as f32 / SIDES as f32));
            }
        }
        SIDES
    };
    mesh.indices = grid(columns, steps as u32).collect();
    let mesh = crate::mesh::finish::finish(mesh, 0).mesh;
    let mesh: Value = reader.mesh(mesh);
    let mut params = vec![param("filename", mesh, list.span)];
    if hair && reader.state.reverse_orientation {
        params.push(param("flip_normals", Value::Bool(false), list.span));
    }
    Some(("trianglemesh", params))
}

/// Steps a segment: n chords of a curve c leave it by max |c''|/(8 n²), and |c''| is at most a multiple of the control points' second differences.
fn steps_of(control: &[DVec3], degree: usize, bezier: bool, width: f64) -> usize {
    let bend = control.windows(3).map(|p| (p[0] - 2.0 * p[1] + p[2]).length()).fold(0.0, f64::max);
    let second = bend * if bezier { (degree * (degree - 1)) as f64 } else { 1.0 };
    let length: f64 = control.windows(2).map(|p| (p[1] - p[0]).length()).sum();
    let steps = (second / (8.0 * (NEAR * width.abs()).max(STRAIGHT * length))).sqrt().ceil();
    if steps.is_finite() { (steps as usize).clamp(2, MOST_STEPS) } else { MOST_STEPS }
}

/// The point at t in [0, 1] of one segment.
fn along(control: &[DVec3], bezier: bool, t: f64) -> DVec3 {
    let degree = control.len() - 1;
    let mut p = [DVec3::ZERO; 4];
    p[..=degree].copy_from_slice(control);
    for level in 1..=degree {
        for i in 0..=degree - level {
            // De Boor's scheme over whole knots: the share grows over as many segments as the level leaves.
            let a = if bezier { t } else { (t + (degree - level - i) as f64) / (degree + 1 - level) as f64 };
            p[i] = p[i] * (1.0 - a) + p[i + 1] * a;
        }
    }
    p[0]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn segments_meet_and_have_the_values_of_their_bases() {
        let p = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z, DVec3::new(3.0, 1.0, 2.0)];
        // Uniform cubic B-spline: (1, 4, 1)/6 at the knots.
        let at = along(&p[..4], false, 0.0);
        assert!((at - (p[0] + 4.0 * p[1] + p[2]) / 6.0).length() < 1e-12, "{at}");
        assert!((along(&p[..4], false, 1.0) - along(&p[1..], false, 0.0)).length() < 1e-12);
        // Quadratic: (1, 1)/2.
        assert!((along(&p[..3], false, 0.0) - 0.5 * (p[0] + p[1])).length() < 1e-12);
        assert!((along(&p[..3], false, 1.0) - 0.5 * (p[1] + p[2])).length() < 1e-12);
        // Bernstein polynomials at the middle.
        let middle = (p[0] + 3.0 * p[1] + 3.0 * p[2] + p[3]) / 8.0;
        assert!((along(&p[..4], true, 0.5) - middle).length() < 1e-12);
    }
}

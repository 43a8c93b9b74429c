//! Spheres, disks and cylinders: whole ones as themselves, parts of them and stretched ones as meshes.
//!
//! ```text
//! sphere    p = r (sinθ cosφ, sinθ sinφ, cosθ)     u = φ/φmax,  v = (θ - θmin)/(θmax - θmin),  θmin at zmin
//! cylinder  p = (r cosφ, r sinφ, z)                u = φ/φmax,  v = (z - zmin)/(zmax - zmin)
//! disk      p = (x cosφ, x sinφ, h)                u = φ/φmax,  v = (r - x)/(r - rinner)
//! ```

use super::shapes::{Geometry, grid, keeps_round, raised};
use super::values::List;
use super::{Reader, param};
use etendue_description::{MeshData, Value};
use etendue_numerics::Transform;
use glam::{DVec2, DVec3};

/// Cells of the meshes: around, and along.
const AROUND: u32 = 256;
const ALONG: u32 = 128;

/// Texture coordinates as above; those of [`crate::mitsuba`] differ.
const PBRT_UV: (&str, Value) = ("pbrt_uv", Value::Bool(true));

/// A mesh of points and normals over (u, v) in the unit square.
fn tessellated(
    reader: &mut Reader,
    list: &List,
    [columns, rows]: [u32; 2],
    surface: impl Fn(f64, f64) -> (DVec3, DVec3),
) -> Option<Geometry> {
    let mut mesh = MeshData::default();
    for j in 0..=rows {
        for i in 0..=columns {
            let uv = DVec2::new(f64::from(i) / f64::from(columns), f64::from(j) / f64::from(rows));
            let (p, n) = surface(uv.x, uv.y);
            mesh.positions.push(p.as_vec3());
            mesh.normals.push(n.as_vec3());
            mesh.uvs.push(uv.as_vec2());
        }
    }
    mesh.indices = grid(columns, rows).collect();
    reader.once(list.span, "parts of spheres, disks and cylinders, and stretched ones, are rendered as fine meshes");
    // Triangles at a pole have no area; that is no one's mistake.
    let mesh = crate::mesh::finish::finish(mesh, 0).mesh;
    let mesh = reader.mesh(mesh);
    Some(("trianglemesh", vec![param("filename", mesh, list.span)]))
}

/// φmax in radians.
fn sweep(reader: &mut Reader, list: &mut List) -> f64 {
    list.float(&mut reader.diagnostics, "phimax", 360.0).clamp(0.0, 360.0).to_radians()
}

fn is_whole(phi_max: f64) -> bool {
    phi_max > 359.999_f64.to_radians()
}

pub(super) fn sphere(reader: &mut Reader, list: &mut List, to_world: &Transform) -> Option<Geometry> {
    let d = &mut reader.diagnostics;
    let r = list.positive(d, "radius", 1.0);
    let z_min = list.float(d, "zmin", -r).clamp(-r, r);
    let z_max = list.float(d, "zmax", r).clamp(-r, r);
    let phi_max = sweep(reader, list);
    let (z_min, z_max) = (z_min.min(z_max), z_min.max(z_max));
    let full = z_min <= -r && z_max >= r && is_whole(phi_max);
    if full && keeps_round(to_world) {
        let params = [("radius", Value::Float(r)), PBRT_UV].map(|(name, value)| param(name, value, list.span_of(name)));
        return Some(("sphere", params.to_vec()));
    }
    let [from, to] = [z_min, z_max].map(|z| (z / r).clamp(-1.0, 1.0).acos());
    tessellated(reader, list, [AROUND, ALONG], |u, v| {
        let ((sin, cos), (sin_phi, cos_phi)) = ((from + v * (to - from)).sin_cos(), (u * phi_max).sin_cos());
        let n = DVec3::new(sin * cos_phi, sin * sin_phi, cos);
        (n * r, n)
    })
}

pub(super) fn disk(reader: &mut Reader, list: &mut List) -> Option<Geometry> {
    let d = &mut reader.diagnostics;
    let r = list.positive(d, "radius", 1.0);
    let inner = list.float(d, "innerradius", 0.0).clamp(0.0, r);
    let height = list.float(d, "height", 0.0);
    let phi_max = sweep(reader, list);
    if inner == 0.0 && is_whole(phi_max) {
        let place = raised(DVec3::new(r, r, 1.0), height)?;
        let params = [("to_world", Value::Transform(Box::new(place))), PBRT_UV];
        return Some(("disk", params.map(|(name, value)| param(name, value, list.span)).to_vec()));
    }
    tessellated(reader, list, [AROUND, 1], |u, v| {
        let (sin, cos) = (u * phi_max).sin_cos();
        let x = r + v * (inner - r);
        (DVec3::new(x * cos, x * sin, height), DVec3::Z)
    })
}

pub(super) fn cylinder(reader: &mut Reader, list: &mut List, to_world: &Transform) -> Option<Geometry> {
    let d = &mut reader.diagnostics;
    let r = list.positive(d, "radius", 1.0);
    let z_min = list.float(d, "zmin", -1.0);
    let z_max = list.float(d, "zmax", 1.0);
    let phi_max = sweep(reader, list);
    let (z_min, z_max) = (z_min.min(z_max), z_min.max(z_max));
    if z_min == z_max {
        reader.diagnostics.error(list.span, "`zmin` and `zmax` of this cylinder are the same");
        return None;
    }
    if is_whole(phi_max) && keeps_round(to_world) {
        let ends = [("p0", z_min), ("p1", z_max)].map(|(name, z)| param(name, Value::Vector(DVec3::Z * z), list.span));
        let mut params = ends.to_vec();
        params.push(param("radius", Value::Float(r), list.span_of("radius")));
        return Some(("cylinder", params));
    }
    tessellated(reader, list, [AROUND, 1], |u, v| {
        let (sin, cos) = (u * phi_max).sin_cos();
        (DVec3::new(r * cos, r * sin, z_min + v * (z_max - z_min)), DVec3::new(cos, sin, 0.0))
    })
}

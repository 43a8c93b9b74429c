//! What every mesh goes through once it is read: unit normals, no triangle without area, no number that is not finite.
//!
//! A vertex without a usable normal gets the mean of the normals of the faces around it, each weighted by the face's angle at the
//! vertex [Thürmer and Wüthrich 1998].

use super::Loaded;
use etendue_description::{AttributeKind, MeshData};
use glam::Vec3;

/// Mends a mesh and says what was mended. Positions must be finite and indices in range.
///
/// Where `mesh.normals` is not empty, a zero or non-finite one means that the file gave none that can be used; `unusable` counts those
/// which the file did give.
pub(crate) fn finish(mut mesh: MeshData, mut unusable: usize) -> Loaded {
    let mut warnings = Vec::new();
    let dropped = drop_zero_area(&mut mesh);
    if !dropped.is_empty() {
        /// Numbers that are told of those left out.
        const TOLD: usize = 8;
        let told: Vec<String> = dropped.iter().take(TOLD).map(u32::to_string).collect();
        let more = if dropped.len() > TOLD { ", …" } else { "" };
        warnings.push(format!(
            "{} of {} triangles have no area and are left out: {}{more} (from 0; those that stay are numbered without them)",
            dropped.len(),
            dropped.len() + mesh.indices.len(),
            told.join(", ")
        ));
    }
    if mesh.indices.is_empty() {
        warnings.push("the mesh has no triangles".to_owned());
    }

    let mut missing = false;
    for n in mesh.normals.iter_mut().filter(|n| !is_unit(**n)) {
        let given = *n != Vec3::ZERO;
        match n.try_normalize() {
            Some(unit) => *n = unit,
            None => {
                unusable += usize::from(given);
                missing = true;
                *n = Vec3::ZERO;
            }
        }
    }
    if missing {
        fill_normals(&mut mesh);
    }
    if unusable > 0 {
        warnings.push(format!("{unusable} vertex normals are zero or not finite; those of the faces around take their place"));
    }

    let mut strange = 0;
    for uv in &mut mesh.uvs {
        if !uv.is_finite() {
            *uv = glam::Vec2::ZERO;
            strange += 1;
        }
    }
    for x in mesh.attributes.iter_mut().flat_map(|a| &mut a.data) {
        if !x.is_finite() {
            *x = 0.0;
            strange += 1;
        }
    }
    if strange > 0 {
        warnings.push(format!("{strange} texture coordinates or attributes are not finite and are taken as zero"));
    }
    Loaded { mesh, warnings }
}

/// Whether a normal is as near to unit length as rounding allows: then it stays as it is, so that a mesh that was finished comes back the same.
fn is_unit(n: Vec3) -> bool {
    (n.length_squared() - 1.0).abs() <= 8.0 * f32::EPSILON
}

/// Removes the triangles without area, and their attributes; the answer is which.
fn drop_zero_area(mesh: &mut MeshData) -> Vec<u32> {
    let positions = &mesh.positions;
    let area = |[a, b, c]: [u32; 3]| {
        let [a, b, c] = [a, b, c].map(|i| positions[i as usize].as_dvec3());
        (b - a).cross(c - a) != glam::DVec3::ZERO
    };
    let before = mesh.indices.len();
    if mesh.indices.iter().all(|t| area(*t)) {
        return Vec::new();
    }
    let (kept, dropped): (Vec<u32>, Vec<u32>) = (0..before as u32).partition(|&i| area(mesh.indices[i as usize]));
    mesh.indices = kept.iter().map(|&i| mesh.indices[i as usize]).collect();
    for attribute in mesh.attributes.iter_mut().filter(|a| a.kind == AttributeKind::Face) {
        let n = attribute.channels;
        attribute.data = kept.iter().flat_map(|&i| &attribute.data[i as usize * n..][..n]).copied().collect();
    }
    mesh.groups.iter_mut().for_each(|g| g.first = kept.partition_point(|k| *k < g.first) as u32);
    dropped
}

/// Gives every vertex whose normal is zero that of the faces around it.
fn fill_normals(mesh: &mut MeshData) {
    let mut sums = vec![Vec3::ZERO; mesh.positions.len()];
    for triangle in &mesh.indices {
        let p = triangle.map(|i| mesh.positions[i as usize]);
        let Some(n) = (p[1] - p[0]).as_dvec3().cross((p[2] - p[0]).as_dvec3()).try_normalize() else { continue };
        for i in 0..3 {
            let a = (p[(i + 1) % 3] - p[i]).normalize_or_zero();
            let b = (p[(i + 2) % 3] - p[i]).normalize_or_zero();
            // The angle between unit vectors, accurate for small ones too [Kahan 2006].
            let angle = 2.0 * etendue_numerics::math::atan2((a - b).length(), (a + b).length());
            sums[triangle[i] as usize] += n.as_vec3() * angle;
        }
    }
    for (n, sum) in mesh.normals.iter_mut().zip(sums) {
        if *n == Vec3::ZERO {
            *n = sum.try_normalize().unwrap_or(Vec3::Z);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use etendue_description::{Attribute, Group};

    #[test]
    fn triangles_without_area_leave_with_their_attributes() {
        let face = Attribute { name: "face_id".into(), kind: AttributeKind::Face, channels: 1, data: vec![1.0, 2.0, 3.0, 4.0] };
        let mesh = MeshData {
            positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y, 2.0 * Vec3::X],
            indices: vec![[0, 1, 2], [0, 1, 3], [1, 1, 2], [1, 3, 2]],
            attributes: vec![face],
            groups: vec![Group { name: "last".into(), first: 2 }],
            ..MeshData::default()
        };
        let Loaded { mesh, warnings } = finish(mesh, 0);
        assert_eq!(mesh.indices, [[0, 1, 2], [1, 3, 2]]);
        assert_eq!(mesh.attributes[0].data, [1.0, 4.0]);
        assert_eq!(mesh.groups[0].first, 1);
        assert_eq!(warnings.len(), 1);
        assert!(warnings[0].starts_with("2 of 4 triangles have no area and are left out: 1, 2 (from 0"), "{warnings:?}");
    }

    #[test]
    fn missing_normals_are_those_of_the_faces_weighted_by_angle() {
        // Two faces of a right dihedral angle meet in the edge 0-1: pi/2 of the one and pi/4 of the other at vertex 0.
        let mesh = MeshData {
            positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::new(1.0, 0.0, -1.0)],
            normals: vec![Vec3::ZERO, Vec3::new(f32::NAN, 0.0, 1.0), Vec3::new(0.0, 0.0, 3.0), Vec3::ZERO],
            indices: vec![[0, 1, 2], [0, 3, 1]],
            ..MeshData::default()
        };
        let Loaded { mesh, warnings } = finish(mesh, 0);
        let expected = Vec3::new(0.0, -1.0, 2.0).normalize();
        assert!((mesh.normals[0] - expected).length() < 1e-6, "{}", mesh.normals[0]);
        assert_eq!(mesh.normals[2], Vec3::Z);
        assert!((mesh.normals[3] + Vec3::Y).length() < 1e-6);
        assert_eq!(warnings.len(), 1);
        assert!(warnings[0].starts_with("1 vertex normals are zero or not finite"));
    }
}

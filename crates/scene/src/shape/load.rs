//! Meshes put in their place: files' vertices moved to the world, normals made where there are none, and the two meshes that need no file.
//!
//! A vertex normal is a covector and keeps its side when the map mirrors space. Normals that are made here follow the winding in the world, as
//! faces without normals do: [Thürmer, Wüthrich 1998] weight each face around a vertex by its angle there.

use super::Mesh;
use etendue_description::MeshData;
use etendue_numerics::{Transform, Vec3};
use glam::DVec3;

impl Mesh {
    /// A mesh file in its place. With `face_normals` faces are flat; else normals are made where the file has none.
    pub fn new(data: &MeshData, to_world: &Transform, face_normals: bool) -> Self {
        let moved = |p: &Vec3| if *to_world == Transform::IDENTITY { *p } else { to_world.point_f64(p.as_dvec3()).as_vec3() };
        let positions: Vec<Vec3> = data.positions.iter().map(moved).collect();
        let normals = match (face_normals, data.normals.is_empty()) {
            (true, _) => Vec::new(),
            (false, false) => data.normals.iter().map(|n| to_world.normal(*n).normalize_or_zero()).collect(),
            (false, true) => vertex_normals(&positions, &data.indices),
        };
        let mesh = Self {
            positions,
            normals,
            uvs: data.uvs.clone(),
            indices: data.indices.clone(),
            attributes: data.attributes.clone(),
            ..Self::default()
        };
        mesh.finish()
    }

    /// The square [-1, 1]² at z = 0 with normal +z and texture coordinates from 0 to 1.
    pub fn rectangle(to_world: &Transform) -> Self {
        Self::new(&MeshData::rectangle(), to_world, false)
    }

    /// The cube [-1, 1]³ with normals outwards; each face has texture coordinates from 0 to 1.
    pub fn cube(to_world: &Transform) -> Self {
        Self::new(&MeshData::cube(), to_world, false)
    }
}

/// Unit normals at the vertices, the mean of the normals of the faces around weighted by their angles; zero where no face says anything.
fn vertex_normals(positions: &[Vec3], indices: &[[u32; 3]]) -> Vec<Vec3> {
    let mut sums = vec![DVec3::ZERO; positions.len()];
    for triangle in indices {
        let p = triangle.map(|i| positions[i as usize].as_dvec3());
        let Some(n) = (p[1] - p[0]).cross(p[2] - p[0]).try_normalize() else { continue };
        for k in 0..3 {
            let (a, b) = (p[(k + 1) % 3] - p[k], p[(k + 2) % 3] - p[k]);
            sums[triangle[k] as usize] += n * a.cross(b).length().atan2(a.dot(b));
        }
    }
    sums.into_iter().map(|n| n.normalize_or_zero().as_vec3()).collect()
}

/// Two unit tangents that make a right-handed frame with the unit vector `n` [Duff et al. 2017, Listing 3], in f64.
pub(crate) fn tangents(n: DVec3) -> (DVec3, DVec3) {
    let sign = 1f64.copysign(n.z);
    let a = -1.0 / (sign + n.z);
    let b = n.x * n.y * a;
    (DVec3::new(1.0 + sign * n.x * n.x * a, sign * b, -sign * n.x), DVec3::new(b, sign + n.y * n.y * a, -n.y))
}

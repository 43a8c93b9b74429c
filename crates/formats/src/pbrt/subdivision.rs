//! Loop's subdivision of triangle meshes [Loop 1987], with the limit surface and its normals at the end.
//!
//! ```text
//! new vertex on an edge     3/8 (a + b) + 1/8 (c + d),  c and d opposite;   on a border (a + b)/2
//! old vertex of valence n   (1 - nβ) v + β Σ ring,  β = 3/16 for n = 3, else 3/(8n);   on a border 3/4 v + 1/8 (a + b)
//! limit                     (1 - nγ) v + γ Σ ring,  γ = 1/(n + 3/(8β));   on a border 3/5 v + 1/5 (a + b)
//! normal                    Σ cos(2πi/n) ring_i × Σ sin(2πi/n) ring_i;   on a border the mean of its faces
//! ```

use super::shapes::Geometry;
use super::values::List;
use super::{Reader, param};
use etendue_description::MeshData;
use glam::{DVec3, Vec3};
use std::collections::BTreeMap;

/// Triangles beyond this number are not made.
const MOST: usize = 1 << 22;

pub(super) fn subdivided(reader: &mut Reader, list: &mut List) -> Option<Geometry> {
    let levels = list.integer(&mut reader.diagnostics, "levels", 3, 0..=12);
    let _ = list.text_opt(&mut reader.diagnostics, "scheme");
    let positions = reader.positions(list)?;
    let indices = reader.triangles(list, positions.len(), 3)?;
    let faces: Vec<[u32; 3]> = indices.as_chunks::<3>().0.iter().map(|t| t.map(|i| i as u32)).collect();
    if faces.iter().any(|[a, b, c]| a == b || b == c || c == a) {
        reader.diagnostics.error(list.span_of("indices"), "a face of this `loopsubdiv` names a vertex twice");
        return None;
    }
    if faces.len() << (2 * levels) > MOST {
        let text = format!("{levels} levels make {} triangles; at most {MOST} are made", faces.len() << (2 * levels));
        reader.diagnostics.error(list.span_of("levels"), text);
        return None;
    }
    let mut surface = Surface { points: positions.iter().map(|p| p.as_dvec3()).collect(), faces };
    for _ in 0..levels {
        surface = surface.refined();
    }
    let mesh = crate::mesh::finish::finish(surface.limit(), 0).mesh;
    let mesh = reader.mesh(mesh);
    Some(("trianglemesh", vec![param("filename", mesh, list.span)]))
}

struct Surface {
    points: Vec<DVec3>,
    faces: Vec<[u32; 3]>,
}

/// The vertices around one, in order; open at a border.
struct Ring {
    around: Vec<u32>,
    border: bool,
}

impl Surface {
    /// For each vertex its ring, by walking from face to face.
    fn rings(&self) -> Vec<Ring> {
        // next[v][a] = b where a face (v, a, b) is.
        let mut next: Vec<Vec<(u32, u32)>> = vec![Vec::new(); self.points.len()];
        for &[a, b, c] in &self.faces {
            next[a as usize].push((b, c));
            next[b as usize].push((c, a));
            next[c as usize].push((a, b));
        }
        next.into_iter()
            .map(|spokes| {
                // A border begins at the spoke that no face leads to.
                let start = spokes.iter().find(|(a, _)| !spokes.iter().any(|(_, b)| b == a)).or(spokes.first());
                let Some(&(first, _)) = start else { return Ring { around: Vec::new(), border: true } };
                let (mut around, mut at) = (vec![first], first);
                while let Some(&(_, b)) = spokes.iter().find(|(a, _)| *a == at) {
                    if b == first || around.len() > spokes.len() {
                        return Ring { around, border: false };
                    }
                    around.push(b);
                    at = b;
                }
                Ring { around, border: true }
            })
            .collect()
    }

    fn sum(&self, ring: &Ring) -> DVec3 {
        ring.around.iter().map(|i| self.points[*i as usize]).sum()
    }

    /// Both ends of a border's ring.
    fn ends(&self, ring: &Ring) -> DVec3 {
        let [a, b] = [ring.around.first(), ring.around.last()].map(|i| i.map_or(DVec3::ZERO, |i| self.points[*i as usize]));
        a + b
    }

    /// A vertex moved towards its ring by `inner`, or on a border by `edge` towards each end.
    fn moved(&self, v: usize, ring: &Ring, inner: f64, edge: f64) -> DVec3 {
        let p = self.points[v];
        match (ring.border, ring.around.len()) {
            (_, 0) => p,
            (true, _) => p * (1.0 - 2.0 * edge) + self.ends(ring) * edge,
            (false, n) => p * (1.0 - n as f64 * inner) + self.sum(ring) * inner,
        }
    }

    fn refined(&self) -> Self {
        let rings = self.rings();
        let mut points: Vec<DVec3> =
            rings.iter().enumerate().map(|(v, ring)| self.moved(v, ring, beta(ring.around.len()), 0.125)).collect();
        // For each edge the vertices opposite, then its new vertex.
        let mut opposite: BTreeMap<(u32, u32), Vec<u32>> = BTreeMap::new();
        for &[a, b, c] in &self.faces {
            for (a, b, c) in [(a, b, c), (b, c, a), (c, a, b)] {
                opposite.entry((a.min(b), a.max(b))).or_default().push(c);
            }
        }
        let mut middle = BTreeMap::new();
        for ((a, b), across) in opposite {
            let ends = self.points[a as usize] + self.points[b as usize];
            let point = match across[..] {
                [c, d] => ends * 0.375 + (self.points[c as usize] + self.points[d as usize]) * 0.125,
                _ => ends * 0.5,
            };
            middle.insert((a, b), points.len() as u32);
            points.push(point);
        }
        let at = |a: u32, b: u32| middle[&(a.min(b), a.max(b))];
        let split = |&[a, b, c]: &[u32; 3]| {
            let (ab, bc, ca) = (at(a, b), at(b, c), at(c, a));
            [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
        };
        Self { faces: self.faces.iter().flat_map(split).collect(), points }
    }

    /// The points moved to the limit, with its normals.
    fn limit(&self) -> MeshData {
        let rings = self.rings();
        let gamma = |n: usize| 1.0 / (n as f64 + 3.0 / (8.0 * beta(n)));
        let points: Vec<DVec3> =
            rings.iter().enumerate().map(|(v, ring)| self.moved(v, ring, gamma(ring.around.len()), 0.2)).collect();
        let normal = |ring: &Ring| {
            if ring.border {
                return Vec3::ZERO; // filled by the faces around
            }
            let n = ring.around.len() as f64;
            let (mut s, mut t) = (DVec3::ZERO, DVec3::ZERO);
            for (i, v) in ring.around.iter().enumerate() {
                let (sin, cos) = (std::f64::consts::TAU * i as f64 / n).sin_cos();
                s += self.points[*v as usize] * cos;
                t += self.points[*v as usize] * sin;
            }
            s.cross(t).normalize_or_zero().as_vec3()
        };
        MeshData {
            normals: rings.iter().map(normal).collect(),
            positions: points.iter().map(|p| p.as_vec3()).collect(),
            indices: self.faces.clone(),
            ..MeshData::default()
        }
    }
}

fn beta(n: usize) -> f64 {
    if n == 3 { 3.0 / 16.0 } else { 3.0 / (8.0 * n.max(1) as f64) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_octahedron_becomes_round_and_faces_outwards() {
        let points = [DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_Z].to_vec();
        let faces = vec![[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]];
        let mut surface = Surface { points, faces };
        for _ in 0..4 {
            surface = surface.refined();
        }
        assert_eq!(surface.faces.len(), 8 << 8);
        let mesh = surface.limit();
        // Euler: a sphere.
        assert_eq!(mesh.positions.len() + surface.faces.len() - surface.faces.len() * 3 / 2, 2);
        for (p, n) in mesh.positions.iter().zip(&mesh.normals) {
            assert!(p.normalize().dot(*n) > 0.9, "{p} {n}");
        }
        let radii: Vec<f32> = mesh.positions.iter().map(|p| p.length()).collect();
        let (low, high) = (radii.iter().copied().fold(9.0, f32::min), radii.iter().copied().fold(0.0, f32::max));
        assert!(high / low < 1.35, "{low} {high}");
    }

    #[test]
    fn a_flat_sheet_stays_flat_and_its_border_stays_a_line() {
        let points = [DVec3::ZERO, DVec3::X, DVec3::new(1.0, 1.0, 0.0), DVec3::Y].to_vec();
        let mut surface = Surface { points, faces: vec![[0, 1, 2], [0, 2, 3]] };
        for _ in 0..3 {
            surface = surface.refined();
        }
        let mesh = crate::mesh::finish::finish(surface.limit(), 0).mesh;
        assert!(mesh.positions.iter().all(|p| p.z == 0.0));
        assert!(mesh.normals.iter().all(|n| (*n - Vec3::Z).length() < 1e-5));
    }
}

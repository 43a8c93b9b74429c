//! Meshes, rays and the slow truth, for the tests.
#![allow(dead_code)]

use etendue_accel::{Accel, BuildOptions, Builder, Hit, NoShapes, Path, TriangleMesh};
use etendue_numerics::{Ray, Vec3};

/// A small generator of numbers [xorshift64*, Vigna 2016].
pub struct Random(u64);

impl Random {
    pub fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1)
    }

    pub fn bits(&mut self) -> u64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        self.0.wrapping_mul(0x2545_f491_4f6c_dd1d)
    }

    /// Uniform in [0, 1).
    pub fn unit(&mut self) -> f32 {
        (self.bits() >> 40) as f32 / (1 << 24) as f32
    }

    pub fn below(&mut self, n: usize) -> usize {
        (self.bits() % n as u64) as usize
    }

    /// Uniform in the cube [-1, 1]³.
    pub fn cube(&mut self) -> Vec3 {
        Vec3::new(self.unit(), self.unit(), self.unit()) * 2.0 - 1.0
    }

    /// A direction that is no zero.
    pub fn direction(&mut self) -> Vec3 {
        loop {
            let d = self.cube();
            if d.length_squared() > 1e-2 && d.length_squared() <= 1.0 {
                return d;
            }
        }
    }
}

#[derive(Clone, Debug, Default)]
pub struct Mesh {
    pub positions: Vec<Vec3>,
    pub indices: Vec<[u32; 3]>,
}

impl Mesh {
    pub fn view(&self, geometry: u32) -> TriangleMesh<'_> {
        TriangleMesh { positions: &self.positions, indices: &self.indices, geometry }
    }

    pub fn accel(&self, options: &BuildOptions) -> Accel {
        let mut builder = Builder::new();
        builder.add_mesh(self.view(0));
        builder.build(options).expect("builds")
    }

    pub fn corners(&self, triangle: usize) -> [Vec3; 3] {
        self.indices[triangle].map(|i| self.positions[i as usize])
    }

    pub fn map(&self, f: impl Fn(Vec3) -> Vec3) -> Self {
        Self { positions: self.positions.iter().map(|&p| f(p)).collect(), indices: self.indices.clone() }
    }
}

/// Triangles without any order, small and large.
pub fn soup(n: usize, random: &mut Random) -> Mesh {
    let mut mesh = Mesh::default();
    for k in 0..n as u32 {
        let center = random.cube();
        let size = 0.02 + random.unit().powi(4);
        for _ in 0..3 {
            mesh.positions.push(center + size * random.cube());
        }
        mesh.indices.push([3 * k, 3 * k + 1, 3 * k + 2]);
    }
    mesh
}

/// A grid of (nu · nv · 2) triangles over f(u, v); wraps around in u where `closed`.
pub fn grid(nu: u32, nv: u32, closed: bool, f: impl Fn(f32, f32) -> Vec3) -> Mesh {
    let mut mesh = Mesh::default();
    let columns = if closed { nu } else { nu + 1 };
    for j in 0..=nv {
        for i in 0..columns {
            mesh.positions.push(f(i as f32 / nu as f32, j as f32 / nv as f32));
        }
    }
    for j in 0..nv {
        for i in 0..nu {
            let next = (i + 1) % columns;
            let (a, b, c, d) = (j * columns + i, j * columns + next, (j + 1) * columns + i, (j + 1) * columns + next);
            mesh.indices.push([a, b, c]);
            mesh.indices.push([b, d, c]);
        }
    }
    mesh
}

/// A closed surface around the origin, bumpy, radius about 1: every ray from inside must hit it. The poles are single corners.
pub fn closed_surface(n: u32, bumps: f32) -> Mesh {
    let pi = std::f32::consts::PI;
    let mut mesh = grid(2 * n, n, true, |u, v| {
        let (theta, phi) = (pi * v, 2.0 * pi * u);
        let r = 1.0 + bumps * (7.0 * theta).sin() * (5.0 * phi).cos();
        r * Vec3::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos())
    });
    // join the rows at the poles
    let last = mesh.positions.len() as u32 - 2 * n;
    for index in mesh.indices.iter_mut().flatten() {
        if *index < 2 * n {
            *index = 0;
        } else if *index >= last {
            *index = last;
        }
    }
    mesh.indices.retain(|t| t[0] != t[1] && t[1] != t[2] && t[2] != t[0]);
    mesh
}

/// The nearest hit of every triangle on its own, in f64 [Möller, Trumbore 1997], with how near the ray passes to an edge:
/// the smallest barycentric, signed.
pub fn brute_force(mesh: &Mesh, ray: &Ray, margin: f64) -> Option<(f64, usize)> {
    let (o, d) = (ray.o.as_dvec3(), ray.d.as_dvec3());
    let mut best: Option<(f64, usize)> = None;
    for i in 0..mesh.indices.len() {
        let [a, b, c] = mesh.corners(i).map(|p| p.as_dvec3());
        let (e, f) = (b - a, c - a);
        let p = d.cross(f);
        let det = e.dot(p);
        if det == 0.0 {
            continue;
        }
        let s = o - a;
        let u = s.dot(p) / det;
        let q = s.cross(e);
        let v = d.dot(q) / det;
        let t = f.dot(q) / det;
        if u >= margin
            && v >= margin
            && u + v <= 1.0 - margin
            && t > 0.0
            && t < f64::from(ray.t_max)
            && best.is_none_or(|(b, _)| t < b)
        {
            best = Some((t, i));
        }
    }
    best
}

/// Casts a ray in every way this machine has, and asks for one answer: both paths, both questions.
pub fn cast(accels: &[Accel], ray: &Ray) -> Option<Hit> {
    let hit = accels[0].closest(ray, &NoShapes);
    for accel in accels {
        let other = accel.closest(ray, &NoShapes);
        assert_eq!(bits(hit), bits(other), "{:?} disagrees on {ray:?}", accel.path());
        assert_eq!(accel.occluded(ray, &NoShapes), hit.is_some(), "any-hit, {:?}, {ray:?}", accel.path());
        cast_each(accel, &[*ray]);
    }
    hit
}

/// Casts many rays at once, and asks for the hits of each alone.
pub fn cast_each(accel: &Accel, rays: &[Ray]) {
    let (mut hits, mut occluded) = (Vec::new(), Vec::new());
    accel.closest_each(rays, &NoShapes, &mut hits);
    accel.occluded_each(rays, &NoShapes, &mut occluded);
    assert_eq!((hits.len(), occluded.len()), (rays.len(), rays.len()));
    for ((ray, hit), occluded) in rays.iter().zip(hits).zip(occluded) {
        let alone = accel.closest(ray, &NoShapes);
        assert_eq!(bits(hit), bits(alone), "{:?} disagrees with itself on {ray:?} among {}", accel.path(), rays.len());
        assert_eq!(occluded, alone.is_some(), "any-hit, {:?}, {ray:?} among {}", accel.path(), rays.len());
    }
}

/// One tree, cast in every way this machine has.
pub fn every_path(accel: &Accel) -> Vec<Accel> {
    [Path::Plain, Path::Avx2, Path::Avx512].into_iter().filter_map(|p| accel.clone().with_path(p)).collect()
}

type Bits = (u32, u32, u32, u32, u32, u32);

pub fn bits(hit: Option<Hit>) -> Option<Bits> {
    hit.map(|h| (h.t.to_bits(), h.u.to_bits(), h.v.to_bits(), h.geometry, h.primitive, h.instance))
}

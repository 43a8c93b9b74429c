//! Procedural meshes, and rays through them.

use etendue_accel::{Accel, BuildOptions, Builder, NoShapes, TriangleMesh};
use etendue_numerics::{Ray, Vec3};

pub struct Mesh {
    pub positions: Vec<Vec3>,
    pub indices: Vec<[u32; 3]>,
}

/// xorshift64*.
pub struct Random(pub u64);

impl Random {
    pub fn unit(&mut self) -> f32 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        (self.0.wrapping_mul(0x2545_f491_4f6c_dd1d) >> 40) as f32 / (1 << 24) as f32
    }

    pub fn direction(&mut self) -> Vec3 {
        let (z, phi) = (1.0 - 2.0 * self.unit(), std::f32::consts::TAU * self.unit());
        let r = (1.0 - z * z).max(0.0).sqrt();
        Vec3::new(r * phi.cos(), r * phi.sin(), z)
    }
}

impl Mesh {
    fn grid(mut self, nu: u32, nv: u32, f: impl Fn(f32, f32) -> Vec3) -> Self {
        let base = self.positions.len() as u32;
        for j in 0..=nv {
            self.positions.extend((0..=nu).map(|i| f(i as f32 / nu as f32, j as f32 / nv as f32)));
        }
        for j in 0..nv {
            for i in 0..nu {
                let a = base + j * (nu + 1) + i;
                self.indices.extend([[a, a + 1, a + nu + 1], [a + 1, a + nu + 2, a + nu + 1]]);
            }
        }
        self
    }

    fn none() -> Self {
        Self { positions: Vec::new(), indices: Vec::new() }
    }

    pub fn spheres(n: u32, segments: u32) -> Self {
        (0..n * n * n).fold(Self::none(), |mesh, k| {
            let center = Vec3::new((k % n) as f32, (k / n % n) as f32, (k / n / n) as f32);
            mesh.grid(2 * segments, segments, |u, v| {
                let (theta, phi) = (std::f32::consts::PI * v, std::f32::consts::TAU * u);
                let r = 0.4 + 0.03 * (13.0 * theta).sin() * (11.0 * phi).cos();
                center + r * Vec3::new(theta.sin() * phi.cos(), theta.cos(), theta.sin() * phi.sin())
            })
        })
    }

    pub fn terrain(nu: u32, nv: u32) -> Self {
        Self::none().grid(nu, nv, |u, v| {
            let hills = 0.4 * (9.0 * u).sin() * (7.0 * v).cos() + 0.16 * (31.0 * u + 17.0 * v).sin();
            Vec3::new(10.0 * u, hills + 0.04 * (97.0 * u).cos() * (83.0 * v).sin(), 10.0 * v)
        })
    }

    pub fn soup(n: u32) -> Self {
        let mut random = Random(77);
        let mut mesh = Self::none();
        for k in 0..n {
            let center = 10.0 * Vec3::new(random.unit(), random.unit(), random.unit());
            let size = 0.02 + 0.3 * random.unit().powi(6);
            mesh.positions.extend((0..3).map(|_| center + size * random.direction()));
            mesh.indices.push([3 * k, 3 * k + 1, 3 * k + 2]);
        }
        mesh
    }

    pub fn build(&self, duplicates: f32) -> Accel {
        let mut builder = Builder::new();
        builder.add_mesh(TriangleMesh { positions: &self.positions, indices: &self.indices, geometry: 0 });
        builder.build(&BuildOptions { duplicates, ..BuildOptions::default() }).unwrap_or_else(|e| panic!("{e}"))
    }
}

/// The rays of one scene, by kind; the last two are any-hit rays.
pub struct Rays(pub [(&'static str, Vec<Ray>); 4]);

pub fn rays(mesh: &Mesh, accel: &Accel) -> Rays {
    const N: u32 = 256;
    let (center, size) = (accel.bounds().center(), accel.bounds().size().length());
    let eye = center + Vec3::new(0.55, 0.35, 0.65) * size;
    let forward = (center - eye).normalize();
    let right = forward.cross(Vec3::Y).normalize();
    let up = right.cross(forward);
    let mut random = Random(1);
    let camera: Vec<Ray> = (0..N * N)
        .map(|k| {
            let (x, y) = ((k % N) as f32 + random.unit(), (k / N) as f32 + random.unit());
            Ray::new(eye, (forward + (x / N as f32 - 0.5) * right + (y / N as f32 - 0.5) * up).normalize())
        })
        .collect();
    let (mut bounce, mut shadow, mut occlusion) = (Vec::new(), Vec::new(), Vec::new());
    let light = center + 0.5 * size * Vec3::Y;
    for ray in &camera {
        let Some(hit) = accel.closest(ray, &NoShapes) else { continue };
        let [a, b, c] = mesh.indices[hit.primitive as usize].map(|i| mesh.positions[i as usize]);
        let n = (b - a).cross(c - a).normalize();
        let n = if n.dot(ray.d) > 0.0 { -n } else { n };
        let p = ray.at(hit.t) + 1e-5 * size * n;
        bounce.push(Ray::new(p, (n + 0.999 * random.direction()).normalize()));
        shadow.push(Ray::new(p, light + 0.05 * size * random.direction() - p).until(0.999));
        occlusion.push(Ray::new(p, (n + 0.999 * random.direction()).normalize()).until(0.03 * size));
    }
    Rays([("camera", camera), ("bounce", bounce), ("shadow", shadow), ("occlusion", occlusion)])
}

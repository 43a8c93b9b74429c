//! A world of a few shapes, without a compiler.
#![allow(dead_code)]

pub mod document;

use etendue_accel::{Accel, BuildOptions, Builder, Hit, TriangleMesh};
use etendue_check::Rng;
use etendue_description::NodeId;
use etendue_numerics::{Ray, Transform, Vec2, Vec3};
use etendue_scene::shape::{Geometry, Shape, Surface, Surfaces};
use etendue_scene::{Interaction, MaterialId, SurfaceId};
use glam::{DMat4, DVec3};

pub struct World {
    pub surfaces: Surfaces,
    pub accel: Accel,
    pub instances: Vec<Transform>,
}

impl World {
    pub fn new(shapes: Vec<Shape>) -> Self {
        Self::instanced(shapes, Vec::new())
    }

    /// The shapes themselves, or where there are instances those in their place.
    pub fn instanced(shapes: Vec<Shape>, instances: Vec<Transform>) -> Self {
        let mut surfaces = Surfaces::default();
        for shape in shapes {
            surfaces.push(Surface { shape, material: MaterialId(0), emitter: None, node: NodeId(0), in_world: true });
        }
        let mut builder = Builder::new();
        for (id, surface) in surfaces.iter() {
            match surface.shape.mesh() {
                Some(m) => builder.add_mesh(TriangleMesh { positions: &m.positions, indices: &m.indices, geometry: id.0 }),
                None => builder.add_custom(id.0, surface.shape.bounds()),
            };
        }
        let mut accel = builder.build(&BuildOptions::default()).expect("a tree");
        if !instances.is_empty() {
            let mut outer = Builder::new();
            let tree = outer.add_tree(accel.into());
            for (i, instance) in instances.iter().enumerate() {
                outer.add_instance(tree, instance, i as u32);
            }
            accel = outer.build(&BuildOptions::default()).expect("a tree");
        }
        Self { surfaces, accel, instances }
    }

    pub fn hit(&self, ray: &Ray) -> Option<Hit> {
        self.accel.closest(ray, &self.surfaces)
    }

    pub fn look(&self, o: Vec3, d: Vec3) -> Option<Interaction> {
        self.see(&Ray::new(o, d.normalize()))
    }

    pub fn see(&self, ray: &Ray) -> Option<Interaction> {
        let hit = self.hit(ray)?;
        let shape = &self.surfaces.get(SurfaceId(hit.geometry)).shape;
        Some(match self.instances.get(hit.instance as usize) {
            Some(to_world) => shape.interaction_through(to_world, ray, &hit),
            None => shape.interaction(ray, &hit),
        })
    }
}

pub fn transform(m: DMat4) -> Transform {
    Transform::new(m).expect("a map with an inverse")
}

pub fn translation(x: f64, y: f64, z: f64) -> Transform {
    transform(DMat4::from_translation(DVec3::new(x, y, z)))
}

pub fn direction(rng: &mut Rng) -> Vec3 {
    loop {
        let v = Vec3::from(rng.u3()) * 2.0 - 1.0;
        if v.length_squared() > 1e-4 && v.length_squared() <= 1.0 {
            return v.normalize();
        }
    }
}

pub fn uv(rng: &mut Rng) -> Vec2 {
    rng.u2()
}

pub fn close(a: f32, b: f32, tolerance: f32) {
    assert!((a - b).abs() <= tolerance, "{a} is not {b}");
}

pub fn close3(a: Vec3, b: Vec3, tolerance: f32) {
    assert!((a - b).abs().max_element() <= tolerance, "{a} is not {b}");
}

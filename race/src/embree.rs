//! Embree behind the questions that étendue's tree answers.

use crate::meshes::Mesh;
use embree3::{BufferUsage, BuildQuality, Device, Format, Geometry, GeometryKind, IntersectContext, RayHit, Scene, SceneFlags};
use etendue_numerics::{Ray, Transform};
use std::sync::Arc;
use std::sync::atomic::{AtomicIsize, Ordering};

/// A nearest hit.
#[derive(Clone, Copy)]
pub struct Nearest {
    pub t: f32,
    pub primitive: u32,
    pub instance: u32,
}

/// Its device, which counts the bytes it holds.
pub struct Embree {
    device: Device,
    bytes: Arc<AtomicIsize>,
}

impl Embree {
    pub fn new() -> Self {
        let device = Device::new().expect("Embree starts");
        let bytes = Arc::new(AtomicIsize::new(0));
        let held = Arc::clone(&bytes);
        device.set_memory_monitor_function(move |more, _| {
            held.fetch_add(more, Ordering::Relaxed);
            true
        });
        Self { device, bytes }
    }

    pub fn bytes(&self) -> isize {
        self.bytes.load(Ordering::Relaxed)
    }

    fn scene<'a>(&'a self, robust: bool, geometries: &[Geometry<'a>]) -> Scene<'a> {
        let mut scene = self.device.create_scene().expect("a scene");
        scene.set_build_quality(BuildQuality::HIGH);
        scene.set_flags(if robust { SceneFlags::ROBUST } else { SceneFlags::NONE });
        for geometry in geometries {
            scene.attach_geometry(geometry);
        }
        scene.commit();
        scene
    }

    pub fn mesh(&self, mesh: &Mesh, robust: bool) -> Scene<'_> {
        let mut triangles = self.device.create_geometry(GeometryKind::TRIANGLE).expect("a mesh");
        let (n, m) = (mesh.positions.len(), mesh.indices.len());
        let mut positions = triangles.set_new_buffer::<[f32; 3]>(BufferUsage::VERTEX, 0, Format::FLOAT3, 12, n).expect("vertices");
        for (to, p) in positions.iter_mut().zip(&mesh.positions) {
            *to = p.to_array();
        }
        triangles
            .set_new_buffer::<[u32; 3]>(BufferUsage::INDEX, 0, Format::UINT3, 12, m)
            .expect("indices")
            .copy_from_slice(&mesh.indices);
        self.scene(robust, &[triangles.commit()])
    }

    pub fn instances(&self, of: &Scene<'_>, maps: &[Transform], robust: bool) -> Scene<'_> {
        let instance = |map: &Transform| {
            let mut instance = self.device.create_geometry(GeometryKind::INSTANCE).expect("an instance");
            instance.set_instanced_scene(of);
            instance.set_transform(0, &map.matrix().as_mat4().to_cols_array());
            instance.commit()
        };
        self.scene(robust, &maps.iter().map(instance).collect::<Vec<_>>())
    }
}

pub fn closest(scene: &Scene<'_>, ray: &Ray) -> Option<Nearest> {
    let mut hit = RayHit::from(cast(ray));
    scene.intersect(&mut IntersectContext::incoherent(), &mut hit);
    hit.hit.is_valid().then(|| Nearest { t: hit.ray.tfar, primitive: hit.hit.primID, instance: hit.hit.instID[0] })
}

pub fn occluded(scene: &Scene<'_>, ray: &Ray) -> bool {
    scene.occluded(&mut IntersectContext::incoherent(), &mut cast(ray))
}

fn cast(ray: &Ray) -> embree3::Ray {
    embree3::Ray::segment(ray.o.to_array(), ray.d.to_array(), 0.0, ray.t_max)
}

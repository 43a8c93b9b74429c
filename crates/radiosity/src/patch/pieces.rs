//! The surfaces of a scene in their places, as charts that are not cut yet.

use super::chart::Chart;
use super::grid::Grid;
use super::round::Round;
use super::{ChartEntry, Corners, NONE, Object, Patches};
use etendue_bsdf::Event;
use etendue_numerics::Transform;
use etendue_scene::shape::Mesh;
use etendue_scene::{NO_INSTANCE, Scene, Shape, SurfaceId};
use glam::{DAffine3, DVec3};
use std::collections::BTreeMap;

impl Patches {
    /// Objects and charts, not cut yet.
    pub(super) fn pieces(scene: &Scene) -> Self {
        let mut patches = Self {
            objects: Vec::new(),
            charts: Vec::new(),
            cells: Vec::new(),
            patches: Vec::new(),
            not_diffuse: Vec::new(),
            obstacles: Vec::new(),
            faults: Vec::new(),
            contacts: BTreeMap::new(),
            volumes: Vec::new(),
            facets: Vec::new(),
            instance_objects: Vec::new(),
            surface_objects: vec![NONE; scene.surfaces.len()],
            sides: Vec::new(),
        };
        for (id, _) in scene.surfaces.iter().filter(|(_, s)| s.in_world) {
            patches.surface_objects[id.index()] = patches.objects.len() as u32;
            patches.object(scene, id, NO_INSTANCE, &Transform::IDENTITY);
        }
        for (i, surfaces) in scene.instance_surfaces.iter().enumerate() {
            patches.instance_objects.push(patches.objects.len() as u32);
            for (place, id) in surfaces.iter().enumerate() {
                patches.surface_objects[id.index()] = place as u32;
                patches.object(scene, *id, i as u32, &scene.instances[i]);
            }
        }
        patches
    }

    /// A surface in its place.
    fn object(&mut self, scene: &Scene, surface: SurfaceId, instance: u32, place: &Transform) {
        let first = self.charts.len() as u32;
        let shape = &scene.surface(surface).shape;
        let place = DAffine3::from_mat4(place.matrix());
        let facets = shape.mesh().map(|mesh| self.mesh(mesh, &place));
        let round = match shape {
            Shape::Mesh(_) => None,
            Shape::Sphere(s) => Some((Round::Sphere, s.to_world(), s.outward())),
            Shape::Cylinder(s) => Some((Round::Cylinder, s.to_world(), s.outward())),
            Shape::Disk(s) => {
                let up = s.to_world().inverse().matrix3.row(2);
                Some((Round::Disk, s.to_world(), up.dot(s.normal().as_dvec3()).signum()))
            }
            Shape::SdfGrid(_) => {
                if !self.obstacles.contains(&surface) {
                    self.obstacles.push(surface);
                }
                None
            }
        };
        if let Some((shape, own, outward)) = round {
            let to_world = place * own;
            let chart = Chart::Round { shape, to_world, to_object: to_world.inverse(), outward };
            self.add(chart, [0, 0]);
        }
        let events = scene.material(scene.surface(surface).material).events();
        let is_clear = events.has_null() && !events.has_smooth() && !events.intersects(Event::REFLECT.with(Event::TRANSMIT));
        let charts = if is_clear { first..first } else { first..self.charts.len() as u32 };
        self.charts.truncate(charts.end as usize);
        self.objects.push(Object { surface, instance, charts, patches: 0..0, facets, is_clear });
    }

    /// Adds a chart of the object in the making.
    fn add(&mut self, chart: Chart, triangles: [u32; 2]) -> u32 {
        let even = chart.is_even();
        let object = self.objects.len() as u32;
        self.charts.push(ChartEntry { chart, even, object, triangles, grid: Grid::Square([1, 1]), first_cell: 0 });
        self.charts.len() as u32 - 1
    }

    /// The triangles of a mesh as charts; where its facets begin.
    fn mesh(&mut self, mesh: &Mesh, place: &DAffine3) -> u32 {
        let begin = self.facets.len() as u32;
        let corners = |k: usize| mesh.indices[k].map(|i| mesh.positions[i as usize].as_dvec3());
        let normal_map = place.matrix3.inverse().transpose();
        let mut k = 0;
        while k < mesh.indices.len() {
            let (a, n) = (corners(k), front(mesh, k));
            let next = (k + 1 < mesh.indices.len()).then(|| (corners(k + 1), front(mesh, k + 1)));
            if let (Some(n), Some((b, Some(m)))) = (n, next)
                && n.dot(m) > 1.0 - 1e-9
                && let Some((quad, facets)) = quadrilateral(a, b, n)
            {
                let n = (normal_map * n).normalize();
                let chart = Chart::Quad { corners: quad.map(|p| place.transform_point3(p)), n };
                let chart = self.add(chart, [k as u32, k as u32 + 1]);
                self.facets.extend(facets.map(|corners| Corners { chart, corners }));
                k += 2;
                continue;
            }
            let chart = n.map_or(NONE, |n| {
                let n = (normal_map * n).normalize();
                self.add(Chart::Triangle { corners: a.map(|p| place.transform_point3(p)), n }, [k as u32; 2])
            });
            self.facets.push(Corners { chart, corners: [0, 1, 2] });
            k += 1;
        }
        begin
    }
}

/// The unit normal of the front of a triangle; `None` where it has no area.
fn front(mesh: &Mesh, k: usize) -> Option<DVec3> {
    let [a, b, c] = mesh.indices[k].map(|i| mesh.positions[i as usize].as_dvec3());
    let n = (b - a).cross(c - a).try_normalize()?;
    let shading: DVec3 = mesh.indices[k].iter().filter_map(|i| mesh.normals.get(*i as usize)).map(|n| n.as_dvec3()).sum();
    Some(if (n.dot(shading) < 0.0) != mesh.flip_normals { -n } else { n })
}

/// The flat convex quadrilateral x, s, y, t that two triangles with the side s t in common make, and the corners of either among its own.
fn quadrilateral(a: [DVec3; 3], b: [DVec3; 3], n: DVec3) -> Option<([DVec3; 4], [[u8; 3]; 2])> {
    let apart = |p: &[DVec3; 3], q: &[DVec3; 3]| {
        let mut alone = (0..3).filter(|i| !q.contains(&p[*i]));
        let first = alone.next()?;
        alone.next().is_none().then_some(first)
    };
    let (i, j) = (apart(&a, &b)?, apart(&b, &a)?);
    let quad = [a[i], a[(i + 1) % 3], b[j], a[(i + 2) % 3]];
    let turn = |k: usize| {
        let (before, at, after) = (quad[(k + 3) % 4], quad[k], quad[(k + 1) % 4]);
        (at - before).cross(after - at).dot(n)
    };
    let size = (quad[2] - quad[0]).length() * (quad[3] - quad[1]).length();
    let convex = (0..4).all(|k| turn(k).abs() > 1e-9 * size && turn(k).signum() == turn(0).signum());
    let flat = (b[j] - a[0]).dot(n).abs() <= 1e-6 * size.sqrt();
    let place = |p: DVec3| quad.iter().position(|q| *q == p).map(|k| k as u8);
    let corners = |t: [DVec3; 3]| Some([place(t[0])?, place(t[1])?, place(t[2])?]);
    (convex && flat).then_some((quad, [corners(a)?, corners(b)?]))
}

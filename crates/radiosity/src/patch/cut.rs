//! From a scene to patches.

use super::chart::{Chart, Round, Span};
use super::grid::Grid;
use super::{Cell, ChartEntry, Corners, NONE, Object, Patch, Patches, Side, optics};
use etendue_bsdf::Event;
use etendue_numerics::math::gamma;
use etendue_numerics::{Spectrum, Transform};
use etendue_scene::shape::Mesh;
use etendue_scene::{NO_INSTANCE, Scene, Shape, SurfaceId};
use glam::{DAffine3, DVec3};
use rayon::prelude::*;
use std::collections::BTreeMap;

/// How large patches shall be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PatchSize {
    /// Each piece as it is: triangles, flat quadrilaterals, whole round shapes.
    Whole,
    /// Near this length, m.
    Metres(f64),
    /// Near this many patches in all; no fewer than there are pieces.
    Count(usize),
}

/// Which sides are patches.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sides {
    /// Fronts, and backs that reflect.
    ByMaterial,
    /// Fronts alone.
    Front,
    /// All.
    Both,
}

/// How to cut.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cutting {
    /// The size of patches.
    pub size: PatchSize,
    /// Their sides.
    pub sides: Sides,
    /// More patches than this are refused before any is made.
    pub most: usize,
}

impl Default for Cutting {
    fn default() -> Self {
        Self { size: PatchSize::Whole, sides: Sides::ByMaterial, most: 4_000_000 }
    }
}

/// There would be more patches than allowed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TooMany {
    /// How many.
    pub patches: usize,
    /// How many are allowed.
    pub most: usize,
    /// The size in metres at which there would be about as many as allowed; `None` where even the uncut pieces are too many.
    pub size: Option<f64>,
}

impl Patches {
    /// The patches of `scene`.
    pub fn cut(scene: &Scene, cutting: &Cutting) -> Result<Self, TooMany> {
        let mut patches = Self::pieces(scene);
        patches.sides = patches.choose_sides(scene, cutting.sides);
        let h = match cutting.size {
            PatchSize::Whole => f64::INFINITY,
            PatchSize::Metres(h) => h,
            PatchSize::Count(n) => patches.size_for(n),
        };
        let count = patches.count_at(h);
        if count > cutting.most {
            let fits = patches.count_at(f64::INFINITY) <= cutting.most;
            let size = fits.then(|| patches.size_for(cutting.most));
            return Err(TooMany { patches: count, most: cutting.most, size });
        }
        for entry in &mut patches.charts {
            entry.grid = Grid::new(&entry.chart, h);
        }
        for i in 0..patches.charts.len() {
            patches.charts[i].first_cell = patches.cells.len() as u32;
            let cell = |span| Cell { chart: i as u32, span, children: NONE, patches: [NONE; 2] };
            let cells = patches.charts[i].grid.cells();
            patches.cells.extend(cells.into_iter().map(cell));
        }
        patches.inspect(scene);
        patches.number(scene);
        Ok(patches)
    }

    /// The same with each marked patch, and the other side of its cell, cut into four.
    #[must_use]
    pub fn subdivided(&self, scene: &Scene, marked: impl Fn(u32) -> bool) -> Self {
        let mut finer = self.clone();
        for i in 0..self.cells.len() {
            let cell = self.cells[i];
            if cell.patches.iter().any(|p| *p != NONE && marked(*p)) {
                finer.cells[i].children = finer.cells.len() as u32;
                let triangle = self.charts[cell.chart as usize].chart.is_triangle();
                let quarter = |span| Cell { span, children: NONE, patches: [NONE; 2], ..cell };
                finer.cells.extend(cell.span.quarters(triangle).map(quarter));
            }
        }
        finer.number(scene);
        finer
    }

    /// Objects and charts, not cut yet.
    fn pieces(scene: &Scene) -> Self {
        let mut patches = Self {
            objects: Vec::new(),
            charts: Vec::new(),
            cells: Vec::new(),
            patches: Vec::new(),
            not_diffuse: Vec::new(),
            obstacles: Vec::new(),
            faults: Vec::new(),
            contacts: BTreeMap::new(),
            facets: Vec::new(),
            instance_objects: Vec::new(),
            surface_objects: vec![NONE; scene.surfaces.len()],
            sides: Vec::new(),
        };
        for (id, _) in scene.surfaces.iter().filter(|(_, s)| !s.instanced) {
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

    /// [front, back] of each surface: whether they are patches.
    fn choose_sides(&self, scene: &Scene, sides: Sides) -> Vec<[bool; 2]> {
        let mut chosen = vec![[true, sides == Sides::Both]; scene.surfaces.len()];
        if sides != Sides::ByMaterial {
            return chosen;
        }
        /// Points of a surface at which its back is looked at.
        const LOOKS: usize = 64;
        for object in &self.objects {
            let back = &mut chosen[object.surface.index()][1];
            let charts = &self.charts[object.charts.start as usize..object.charts.end as usize];
            let stride = charts.len().div_ceil(LOOKS).max(1);
            let each = LOOKS.div_ceil(charts.len().max(1));
            let points = charts.iter().step_by(stride).flat_map(|entry| {
                (0..each).map(move |k| {
                    let u = glam::DVec2::new((k as f64 + 0.5) / each as f64, (k as f64 * 0.618_033_988_749_895).fract());
                    let st = if entry.chart.is_triangle() && u.element_sum() > 1.0 { 1.0 - u } else { u };
                    self.look_at(scene, entry, st, Side::Back)
                })
            });
            let points: Vec<_> = points.collect();
            *back |= !points.is_empty() && !optics::mean(scene, Side::Back, &points).rho.is_zero();
        }
        chosen
    }

    /// How many patches there are at size h.
    fn count_at(&self, h: f64) -> usize {
        let sides = |e: &ChartEntry| self.sides[self.objects[e.object as usize].surface.index()].iter().filter(|s| **s).count();
        self.charts.iter().map(|e| Grid::new(&e.chart, h).count() * sides(e)).sum()
    }

    /// The size at which there are about `n` patches, and not more if the pieces allow it.
    fn size_for(&self, n: usize) -> f64 {
        let area: f64 = self.charts.iter().map(|e| e.chart.area(&Span::WHOLE)).sum();
        let start = (area / n.max(1) as f64).sqrt();
        let (mut small, mut large) = (start / 64.0, start * 64.0);
        if self.count_at(large) >= n {
            return f64::INFINITY;
        }
        for _ in 0..24 {
            let h = (small * large).sqrt();
            if self.count_at(h) > n { small = h } else { large = h }
        }
        large
    }

    /// Makes the patches of all leaves.
    pub(super) fn number(&mut self, scene: &Scene) {
        self.patches.clear();
        for o in 0..self.objects.len() {
            let begin = self.patches.len() as u32;
            let sides = self.sides[self.objects[o].surface.index()];
            for c in self.objects[o].charts.clone() {
                let ChartEntry { first_cell, grid, .. } = &self.charts[c as usize];
                for cell in *first_cell..*first_cell + grid.count() as u32 {
                    self.number_below(cell, o as u32, sides);
                }
            }
            self.objects[o].patches = begin..self.patches.len() as u32;
        }
        let measured: Vec<_> = (0..self.len() as u32).into_par_iter().map(|i| self.measured(scene, i)).collect();
        self.patches = measured;
        self.look_up(scene);
        self.find_contacts(scene);
    }

    fn number_below(&mut self, cell: u32, object: u32, sides: [bool; 2]) {
        let Cell { children, .. } = self.cells[cell as usize];
        if children != NONE {
            self.cells[cell as usize].patches = [NONE; 2];
            (children..children + 4).for_each(|child| self.number_below(child, object, sides));
            return;
        }
        for (k, side) in [Side::Front, Side::Back].into_iter().enumerate() {
            self.cells[cell as usize].patches[k] = NONE;
            if sides[k] {
                self.cells[cell as usize].patches[k] = self.patches.len() as u32;
                let (zero, dark) = (DVec3::ZERO, Spectrum::ZERO);
                self.patches.push(Patch { cell, side, object, area: 0.0, p: zero, n: zero, rho: dark, be: dark, clearance: 0.0 });
            }
        }
    }

    /// Patch i with its geometry.
    fn measured(&self, scene: &Scene, i: u32) -> Patch {
        let patch = self.get(i).clone();
        let (span, chart) = self.geometry(i);
        let st = span.middle(chart);
        let p = chart.point(st);
        // Of its own points a patch knows the rounding of the shape, and that of the point to single precision.
        let x = self.interaction(scene, i, st);
        let reach = span.corners().iter().map(|st| chart.point(*st).abs().max_element()).fold(0.0, f64::max) as f32;
        let clearance = 1.5 * x.p_error.dot(x.n.abs()) + reach * gamma(8);
        Patch { area: chart.area(span), p, n: chart.normal(st) * patch.side.sign(), clearance, ..patch }
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

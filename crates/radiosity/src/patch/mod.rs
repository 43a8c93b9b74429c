//! Patches: what the radiosity equation counts.
//!
//! ```text
//! B_i = Be_i + ρ_i Σ_j F_ij B_j        a patch i is one side of one cell of a surface
//! ```
//!
//! | symbol | identifier | unit |
//! | --- | --- | --- |
//! | A_i | [`Patch::area`] | m², exact |
//! | n_i | [`Patch::n`] | unit normal in its middle, on its side |
//! | ρ_i | [`Patch::rho`] | hemispherical reflectance, mean over the patch |
//! | Be_i | [`Patch::be`] | emitted radiosity π Le, W/m², mean over the patch |
//!
//! The winding of a mesh, or the normal of a shape, is its front. A side is a patch if it is a front, if it reflects or emits, or if the caller
//! wants both sides ([`Sides`]); a back that is no patch absorbs what arrives.
//!
//! From surfaces to patches:
//!
//! 1. Each surface, once for each instance that shows it, is an [`Object`] of [`Chart`]s: triangles, pairs of triangles that make a flat
//!    convex quadrilateral, or a round shape, exact ([`chart`]).
//! 2. Each chart is cut into cells near a target size ([`grid`]). A cell may be cut into four again ([`Patches::subdivided`]).
//! 3. Each cell has a patch on one side or on two. Patches are numbered in the order of objects, charts, cells, sides.
//!
//! A hit finds its patch by the way back ([`Patches::locate`]).

pub mod chart;
mod cut;
mod faults;
pub mod grid;
mod optics;
mod vertices;

pub use chart::{Chart, Span};
pub use cut::{Cutting, PatchSize, Sides, TooMany};
pub use faults::{Facet, Fault};
pub use optics::NotDiffuse;
pub use vertices::{Hanging, Vertices};

use arrayvec::ArrayVec;
use etendue_accel::Hit;
use etendue_numerics::{Ray, Spectrum, Vec2, Vec3, warp::square_to_triangle};
use etendue_scene::{Interaction, NO_INSTANCE, Scene, SurfaceId};
use glam::{DVec2, DVec3};
use grid::Grid;
use std::collections::BTreeMap;
use std::ops::Range;

/// Stands for "no patch" and "no child".
pub(crate) const NONE: u32 = u32::MAX;

/// Which side of a surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// Where the normal points.
    Front,
    /// The other.
    Back,
}

impl Side {
    /// +1 in front, -1 behind.
    #[inline]
    pub fn sign(self) -> f64 {
        if self == Self::Front { 1.0 } else { -1.0 }
    }
}

/// One side of one cell.
#[derive(Clone, Debug)]
pub struct Patch {
    /// The cell, an index of [`Patches::cells`].
    pub cell: u32,
    /// Its side.
    pub side: Side,
    /// The object, an index of [`Patches::objects`].
    pub object: u32,
    /// A_i, m².
    pub area: f64,
    /// A point in its midst: of flat ones the centroid.
    pub p: DVec3,
    /// Unit normal there, on the patch's side.
    pub n: DVec3,
    /// Hemispherical reflectance ρ, mean over the patch.
    pub rho: Spectrum,
    /// Emitted radiosity Be = π Le, W/m², mean over the patch.
    pub be: Spectrum,
    /// How far from its points a ray must start to be clear of the surface, m.
    pub clearance: f32,
}

/// A surface in its place.
#[derive(Clone, Debug)]
pub struct Object {
    /// The surface.
    pub surface: SurfaceId,
    /// The instance that shows it, or [`NO_INSTANCE`].
    pub instance: u32,
    /// Its charts, indices of [`Patches::charts`].
    pub charts: Range<u32>,
    /// Its patches.
    pub patches: Range<u32>,
    /// Of a mesh, the place of its first triangle in the list of facets.
    facets: Option<u32>,
    /// Rays pass as if it were not there.
    pub is_clear: bool,
}

/// A chart with what leads to and from it.
#[derive(Clone, Debug)]
pub struct ChartEntry {
    /// The geometry.
    pub chart: Chart,
    /// Whether parameters are in step with area.
    pub even: bool,
    /// Its object.
    pub object: u32,
    /// The triangles of the mesh that it is made of: one twice, or two.
    pub triangles: [u32; 2],
    /// How it is cut.
    pub grid: Grid,
    /// The first of its cells.
    pub first_cell: u32,
}

/// A part of a chart; a leaf unless it has been cut into four.
#[derive(Clone, Copy, Debug)]
pub struct Cell {
    /// The chart.
    pub chart: u32,
    /// Which part.
    pub span: Span,
    /// The first of four cells that it was cut into.
    children: u32,
    /// Patches on the front and on the back.
    patches: [u32; 2],
}

impl Cell {
    /// Whether it has not been cut.
    #[inline]
    pub fn is_leaf(&self) -> bool {
        self.children == NONE
    }

    /// How many of its sides are patches.
    pub fn sides(&self) -> usize {
        self.patches.iter().filter(|p| **p != NONE).count()
    }

    /// The patch on a side.
    #[inline]
    pub fn patch(&self, side: Side) -> Option<u32> {
        let patch = self.patches[usize::from(side == Side::Back)];
        (patch != NONE).then_some(patch)
    }
}

/// A triangle of a mesh: its chart, and which corners of the chart its own are.
#[derive(Clone, Copy, Debug)]
struct Corners {
    chart: u32,
    corners: [u8; 3],
}

/// A point drawn on a patch.
#[derive(Clone, Copy, Debug)]
pub struct PatchPoint {
    /// The point, exact.
    pub p: DVec3,
    /// Unit normal on the patch's side.
    pub n: DVec3,
    /// Parameters in the chart.
    pub st: DVec2,
    /// Density of uniform points over that of this one: 1 but where parameters are not in step with area.
    pub weight: f64,
}

/// Where a hit lies.
#[derive(Clone, Copy, Debug)]
pub struct Place {
    /// The cell.
    pub cell: u32,
    /// The side that the ray came from.
    pub side: Side,
    /// The patch; none on a back that absorbs.
    pub patch: Option<u32>,
    /// Coordinates within the cell: [0, 1]² of a rectangle, barycentrics (b1, b2) of a triangle.
    pub local: DVec2,
}

/// The patches of a scene.
#[derive(Clone, Debug)]
pub struct Patches {
    /// Surfaces in their places.
    pub objects: Vec<Object>,
    /// Geometry.
    pub charts: Vec<ChartEntry>,
    /// Parts of charts.
    pub cells: Vec<Cell>,
    /// One side of each leaf, or both.
    pub patches: Vec<Patch>,
    /// Surfaces that are not diffuse, and what was made of them.
    pub not_diffuse: Vec<NotDiffuse>,
    /// Surfaces that cannot be cut: they are black obstacles.
    pub obstacles: Vec<SurfaceId>,
    /// What is wrong with the surfaces.
    pub faults: Vec<Fault>,
    /// For patches that others cover face to face: which, and where.
    contacts: BTreeMap<u32, Vec<faults::Contact>>,
    facets: Vec<Corners>,
    /// For each instance the number of its first object.
    instance_objects: Vec<u32>,
    /// For each surface its object, or of an instanced one its place within the group.
    surface_objects: Vec<u32>,
    /// Sides that are patches, by surface.
    sides: Vec<[bool; 2]>,
}

impl Patches {
    /// How many.
    pub fn len(&self) -> usize {
        self.patches.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.patches.is_empty()
    }

    /// Patch i.
    #[inline]
    pub fn get(&self, i: u32) -> &Patch {
        &self.patches[i as usize]
    }

    /// The cell and the chart of patch i.
    #[inline]
    pub fn geometry(&self, i: u32) -> (&Span, &Chart) {
        let cell = &self.cells[self.get(i).cell as usize];
        (&cell.span, &self.charts[cell.chart as usize].chart)
    }

    /// The triangles of its mesh that patch i lies on: one twice, or two; 0 of what is no mesh.
    pub fn triangles_of(&self, i: u32) -> [u32; 2] {
        self.charts[self.cells[self.get(i).cell as usize].chart as usize].triangles
    }

    /// The object of a hit.
    #[inline]
    pub fn object_of(&self, hit: &Hit) -> u32 {
        let place = self.surface_objects[hit.geometry as usize];
        if hit.instance == NO_INSTANCE { place } else { self.instance_objects[hit.instance as usize] + place }
    }

    /// Where `ray` has hit; `None` on an obstacle that could not be cut.
    #[inline]
    pub fn locate(&self, ray: &Ray, hit: &Hit) -> Option<Place> {
        let object = &self.objects[self.object_of(hit) as usize];
        let facet = object.facets.map(|first| self.facets[(first + hit.primitive) as usize]);
        let index = facet.map_or(object.charts.start, |f| f.chart);
        let ChartEntry { chart, even, grid, first_cell, .. } =
            self.charts.get(index as usize).filter(|_| !object.charts.is_empty())?;
        let bary = DVec2::new(hit.u.into(), hit.v.into());
        let d = ray.d.as_dvec3();
        let (st, n) = match (chart, facet) {
            (Chart::Triangle { n, .. }, _) => (bary, *n),
            (Chart::Quad { n, corners }, Some(facet)) => {
                let b = [1.0 - bary.x - bary.y, bary.x, bary.y];
                let of = |weights: [DVec2; 4]| (0..3).map(|k| weights[usize::from(facet.corners[k])] * b[k]).sum();
                let st: DVec2 = if *even || grid.count() == 1 && self.cells[*first_cell as usize].is_leaf() {
                    of(Span::WHOLE.corners())
                } else {
                    chart.locate((0..3).map(|k| corners[usize::from(facet.corners[k])] * b[k]).sum())
                };
                (st, *n)
            }
            _ => {
                let p = ray.o.as_dvec3() + d * f64::from(hit.t);
                (chart.locate(p), chart.normal_at(p))
            }
        };

        let triangle = chart.is_triangle();
        let mut index = first_cell + grid.find(st) as u32;
        let mut cell = &self.cells[index as usize];
        let mut local = cell.span.local(st);
        while !cell.is_leaf() {
            index = cell.children + Span::quarter_of(local, triangle) as u32;
            cell = &self.cells[index as usize];
            local = cell.span.local(st);
        }
        let side = if d.dot(n) < 0.0 { Side::Front } else { Side::Back };
        Some(Place { cell: index, side, patch: cell.patch(side), local })
    }

    /// A point of patch i, uniform over its area.
    #[inline]
    pub fn sample(&self, i: u32, u: Vec2) -> PatchPoint {
        let patch = self.get(i);
        let (span, chart) = self.geometry(i);
        let local = if chart.is_triangle() {
            let [_, b1, b2] = square_to_triangle(u);
            DVec2::new(b1.into(), b2.into())
        } else {
            u.as_dvec2()
        };
        let st = span.global(local);
        let even = self.charts[self.cells[patch.cell as usize].chart as usize].even;
        let weight = if even { 1.0 } else { chart.stretch(st) * (span.size.x * span.size.y).abs() / patch.area };
        PatchPoint { p: chart.point(st), n: chart.normal(st) * patch.side.sign(), st, weight }
    }

    /// A point of patch i moved clear of its surface, and of the surfaces that meet it at its edges: in front, and as far towards the midst.
    #[inline]
    pub(crate) fn lifted(&self, i: u32, x: &PatchPoint) -> DVec3 {
        let patch = self.get(i);
        let clearance = f64::from(patch.clearance);
        let p = x.p + x.n * clearance;
        if !self.geometry(i).1.is_flat() {
            return p;
        }
        // Half the side of a square lies between its midst and its edge.
        p + (patch.p - x.p) * (2.0 * clearance / patch.area.sqrt()).min(0.01)
    }

    /// The ray that leaves a point of patch i towards the unit direction `w` on its side.
    #[inline]
    pub fn spawn(&self, i: u32, x: &PatchPoint, w: Vec3) -> Ray {
        Ray::new(self.lifted(i, x).as_vec3(), w)
    }

    /// The surface at parameters of the chart of patch i, seen from the patch's side along the normal.
    pub fn interaction(&self, scene: &Scene, i: u32, st: DVec2) -> Interaction {
        let patch = self.get(i);
        let entry = &self.charts[self.cells[patch.cell as usize].chart as usize];
        self.look_at(scene, entry, st, patch.side)
    }

    fn look_at(&self, scene: &Scene, entry: &ChartEntry, st: DVec2, side: Side) -> Interaction {
        let object = &self.objects[entry.object as usize];
        let (p, n) = (entry.chart.point(st), entry.chart.normal(st) * side.sign());
        let (primitive, u, v) = match &entry.chart {
            Chart::Triangle { .. } => (entry.triangles[0], st.x, st.y),
            Chart::Quad { corners, .. } => self.in_triangle(object, entry, corners, p),
            Chart::Round { to_object, .. } => {
                let q = to_object.transform_point3(p);
                (0, q.x, q.y)
            }
        };
        let ray = Ray::new((p + n).as_vec3(), -n.as_vec3());
        let hit = Hit { t: 1.0, u: u as f32, v: v as f32, geometry: object.surface.0, primitive, instance: object.instance };
        scene.interaction(&ray, &hit)
    }

    /// The triangle of a quad that holds p, and its barycentrics there.
    fn in_triangle(&self, object: &Object, entry: &ChartEntry, corners: &[DVec3; 4], p: DVec3) -> (u32, f64, f64) {
        let first = object.facets.unwrap_or(0);
        let weights = entry.triangles.map(|k| {
            let [a, b, c] = self.facets[(first + k) as usize].corners.map(|c| corners[usize::from(c)]);
            let st = Chart::Triangle { corners: [a, b, c], n: DVec3::Z }.locate(p);
            (k, st, st.min_element().min(1.0 - st.element_sum()))
        });
        let (k, st, _) = if weights[0].2 >= weights[1].2 { weights[0] } else { weights[1] };
        (k, st.x, st.y)
    }

    /// The corners of patch i, counter-clockwise as seen from its side; `None` where its edges are not straight or it is not flat.
    pub fn polygon(&self, i: u32) -> Option<ArrayVec<DVec3, 4>> {
        let (span, chart) = self.geometry(i);
        let mut polygon: ArrayVec<DVec3, 4> = match chart {
            Chart::Triangle { .. } => span.triangle().into_iter().map(|st| chart.point(st)).collect(),
            Chart::Quad { .. } => span.corners().into_iter().map(|st| chart.point(st)).collect(),
            Chart::Round { .. } => return None,
        };
        let n = (polygon[1] - polygon[0]).cross(polygon[2] - polygon[0]);
        if n.dot(self.get(i).n) < 0.0 {
            polygon.reverse();
        }
        Some(polygon)
    }

    /// The ball around patch i: its middle, and the distance of the furthest of its points, in metres; of round patches that of many points, and a bit.
    pub fn ball(&self, i: u32) -> (DVec3, f64) {
        let (span, chart) = self.geometry(i);
        let p = self.get(i).p;
        let furthest = |points: &mut dyn Iterator<Item = DVec2>| points.map(|st| chart.point(st).distance(p)).fold(0.0, f64::max);
        let radius = match chart {
            Chart::Triangle { .. } => furthest(&mut span.triangle().into_iter()),
            Chart::Quad { .. } => furthest(&mut span.corners().into_iter()),
            Chart::Round { .. } => {
                let n = 16;
                let at = |k: u32| f64::from(k) / f64::from(n);
                1.02 * furthest(&mut (0..=n).flat_map(|i| (0..=n).map(move |j| span.global(DVec2::new(at(i), at(j))))))
            }
        };
        (p, radius)
    }
}

//! From a hit to its patch, and from a place on a patch to the surface there.

use super::{Chart, ChartEntry, Object, Patches, Side, Span};
use etendue_accel::Hit;
use etendue_numerics::Ray;
use etendue_scene::{Interaction, NO_INSTANCE, Scene};
use glam::{DVec2, DVec3};

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

impl Patches {
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

    /// The surface at parameters of the chart of patch i, seen from the patch's side along the normal.
    pub fn interaction(&self, scene: &Scene, i: u32, st: DVec2) -> Interaction {
        let patch = self.get(i);
        let entry = &self.charts[self.cells[patch.cell as usize].chart as usize];
        self.look_at(scene, entry, st, patch.side)
    }

    pub(super) fn look_at(&self, scene: &Scene, entry: &ChartEntry, st: DVec2, side: Side) -> Interaction {
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
}

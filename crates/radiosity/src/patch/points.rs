//! Points on patches, rays that leave them, and what lies around them.

use super::{Chart, Patches};
use arrayvec::ArrayVec;
use etendue_numerics::{Ray, Vec2, Vec3, warp::square_to_triangle};
use glam::{DVec2, DVec3};

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

impl Patches {
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

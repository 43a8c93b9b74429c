//! Patches that lie on each other, face to face: a box on a floor, boxes on each other, a picture on a wall.
//!
//! ```text
//! covered parts of patches exchange with each other alone
//! ```
//!
//! No light gets between. Of four sides in one plane two face each other, and the other two are what rays meet. Which is which the plane does not tell, and
//! with materials of two sides rays do not either; but solids do:
//!
//! | in one plane | in contact |
//! | --- | --- |
//! | two solids | the outside of the smaller, and what faces it of the other: a room that holds it, or a solid beside it |
//! | a solid, and a sheet | the fronts of the solid, and what faces them of the sheet |
//! | neither | both fronts, if they face each other and nothing can be seen from between |
//!
//! A mesh bounds a solid if each edge has two facets that are wound alike. A ray that meets the covered part of a patch has come from behind it, and
//! has met the other side of what covers it.

use super::faults::{Facet, Fault};
use super::{Chart, ChartEntry, Object, Patch, Patches, Side};
use crate::form_factor::polygon::{self, Polygon};
use etendue_numerics::warp::square_to_cosine_hemisphere;
use etendue_numerics::{Frame, Net4, Ray, Vec2};
use etendue_scene::Scene;
use glam::{DVec2, DVec3};

/// A part of a patch that another covers, face to face.
#[derive(Clone, Debug)]
pub(crate) struct Contact {
    /// The other patch.
    pub other: u32,
    /// What is covered.
    pub part: Polygon,
    /// Its area, m².
    pub area: f64,
}

impl Contact {
    /// Whether the part holds a point of its plane.
    pub fn holds(&self, p: DVec3, n: DVec3) -> bool {
        let turn = |k: usize| {
            let (a, b) = (self.part[k], self.part[(k + 1) % self.part.len()]);
            (b - a).cross(p - a).dot(n)
        };
        let sign = turn(0).signum();
        (0..self.part.len()).all(|k| turn(k) * sign >= 0.0)
    }
}

impl Patches {
    /// The area, m², that patches i and j cover of each other, face to face.
    pub(crate) fn contact(&self, i: u32, j: u32) -> Option<f64> {
        let area: f64 = self.contacts.get(&i)?.iter().filter(|c| c.other == j).map(|c| c.area).sum();
        (area > 0.0).then_some(area)
    }

    /// The patches that lie on patch i, face to face.
    pub(crate) fn touching(&self, i: u32) -> impl Iterator<Item = u32> + '_ {
        self.contacts.get(&i).into_iter().flatten().map(|c| c.other)
    }

    /// The patch that lies on patch i at its point p, face to face.
    #[inline]
    pub(crate) fn touching_at(&self, i: u32, p: DVec3) -> Option<u32> {
        if self.contacts.is_empty() {
            return None;
        }
        let n = self.get(i).n;
        self.contacts.get(&i)?.iter().find(|c| c.holds(p, n)).map(|c| c.other)
    }

    /// Whether something lies on patch i.
    pub(crate) fn is_touched(&self, i: u32) -> bool {
        self.contacts.contains_key(&i)
    }

    /// The other side of the cell of patch i.
    pub(crate) fn other_side(&self, i: u32) -> Option<u32> {
        let Patch { cell, side, .. } = self.get(i);
        self.cells[*cell as usize].patch(side.opposite())
    }

    /// The patch that a ray has met in truth, of several in one plane: what patch j is covered by at p is met from behind, and it from there.
    #[inline]
    pub(crate) fn behind_contact(&self, j: u32, p: DVec3) -> Option<u32> {
        match self.touching_at(j, p) {
            Some(k) => self.other_side(k),
            None => Some(j),
        }
    }

    /// V = 1/3 ∮ p · n dA of a closed surface: positive where its fronts are outside.
    pub(super) fn volume(&self, object: &Object) -> f64 {
        let of = |k: u32| {
            let chart = &self.charts[k as usize].chart;
            let p = chart.polygon();
            p.first().map_or(0.0, |first| polygon::area(&p) * first.dot(chart.normal(DVec2::ZERO)) / 3.0)
        };
        object.charts.clone().map(of).sum()
    }

    /// Looks for flat pieces that cover each other in one plane.
    pub(super) fn find_contacts(&mut self, scene: &Scene) {
        self.contacts.clear();
        self.faults.retain(|f| !matches!(f, Fault::Touching { .. } | Fault::Doubled { .. }));
        let rim = 1e-6 * f64::from(scene.bounds.size().length());
        let pieces: Vec<_> = self.charts.iter().map(|e| (e.chart.polygon(), e.chart.normal(DVec2::ZERO))).collect();
        let extent = |k: usize| pieces[k].0.iter().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(l, h), p| (l.min(*p), h.max(*p)));
        let boxes: Vec<_> = (0..pieces.len()).map(extent).collect();
        // A sweep along x.
        let mut order: Vec<usize> = (0..pieces.len()).filter(|k| !pieces[*k].0.is_empty()).collect();
        order.sort_by(|a, b| boxes[*a].0.x.total_cmp(&boxes[*b].0.x).then(a.cmp(b)));
        let mut open: Vec<usize> = Vec::new();
        let mut found = Vec::new();
        for k in order {
            open.retain(|o| boxes[*o].1.x >= boxes[k].0.x - rim);
            for &o in &open {
                let apart = (boxes[o].0 - rim).cmpgt(boxes[k].1).any() || (boxes[k].0 - rim).cmpgt(boxes[o].1).any();
                let (a, b) = (o.min(k), o.max(k));
                let ((p, n), (q, m)) = (&pieces[a], &pieces[b]);
                let in_plane = || n.dot(*m).abs() > 1.0 - 1e-9 && q.iter().all(|q| (*q - p[0]).dot(*n).abs() <= rim);
                if !apart && in_plane() {
                    let part = polygon::common(p, q, *n);
                    let area = polygon::area(&part);
                    if area > 1e-6 * polygon::area(p).min(polygon::area(q)) {
                        found.push((a, b, part, area, n.dot(*m) < 0.0));
                    }
                }
            }
            open.push(k);
        }
        found.sort_by_key(|f| (f.0, f.1));
        for (a, b, part, area, opposite) in found {
            let name = |e: &ChartEntry| Facet { surface: self.objects[e.object as usize].surface, facet: e.triangles[0] };
            let pair = [name(&self.charts[a]), name(&self.charts[b])];
            let sides = self.sides_in_contact(a, b).or_else(|| {
                let shut = opposite && self.is_shut(scene, a, b, &part);
                shut.then_some([Side::Front; 2])
            });
            let touch = sides.is_some_and(|sides| self.touch([a, b], sides));
            self.faults.push(if touch { Fault::Touching { pair, area } } else { Fault::Doubled { pair, area } });
        }
    }

    /// Which sides of two pieces in one plane face each other, if one of them bounds a solid.
    fn sides_in_contact(&self, a: usize, b: usize) -> Option<[Side; 2]> {
        let object = |chart: usize| self.charts[chart].object;
        let normal = |chart: usize| self.charts[chart].chart.normal(DVec2::ZERO);
        let volume = |chart: usize| self.volumes.get(object(chart) as usize).copied().unwrap_or(0.0);
        let (v, w) = (volume(a), volume(b));
        let twice = (v.abs() - w.abs()).abs() <= 1e-6 * v.abs() && normal(a).dot(normal(b)) > 0.0;
        if object(a) == object(b) || v == 0.0 && w == 0.0 || twice {
            return None;
        }
        let inner = if w == 0.0 || v != 0.0 && v.abs() <= w.abs() { a } else { b };
        let outer = a + b - inner;
        // Of two solids the smaller is beside the other or within it, and touches it with its outside. What is no solid is where fronts are.
        let side = if volume(outer) == 0.0 || volume(inner) > 0.0 { Side::Front } else { Side::Back };
        let across = if normal(inner).dot(normal(outer)) < 0.0 { side } else { side.opposite() };
        Some(if inner == a { [side, across] } else { [across, side] })
    }

    /// Whether nothing can be seen from between two pieces: every ray from the middle of what they cover ends on a back that is no patch, or leaves
    /// the scene on the outer side. Face to face and back to back are the same place; this tells one from the other.
    fn is_shut(&self, scene: &Scene, a: usize, b: usize, part: &Polygon) -> bool {
        let middle = part.iter().sum::<DVec3>() / part.len() as f64;
        let mut absorbed = false;
        for chart in [a, b] {
            let entry = &self.charts[chart];
            let n = entry.chart.normal(DVec2::ZERO).as_vec3();
            let start = middle.as_vec3() + n * (1e-5 * scene.bounds.size().length());
            for [u, v, ..] in Net4::new(0, chart as u64).take(32) {
                let w = Frame::from_normal(n).to_world(square_to_cosine_hemisphere(Vec2::new(u, v)));
                let ray = Ray::new(start, w);
                if let Some(hit) = scene.intersect(&ray) {
                    if self.locate(&ray, &hit).is_some_and(|place| place.patch.is_some()) {
                        return false;
                    }
                    absorbed = true;
                }
            }
        }
        absorbed
    }

    /// Notes which patches of two charts, on these sides, cover each other, and whether any do.
    fn touch(&mut self, charts: [usize; 2], sides: [Side; 2]) -> bool {
        let of = |k: usize| -> Vec<u32> {
            let of_chart = |i: &u32| self.cells[self.get(*i).cell as usize].chart as usize == charts[k];
            let object = &self.objects[self.charts[charts[k]].object as usize];
            object.patches.clone().filter(of_chart).filter(|i| self.get(*i).side == sides[k]).collect()
        };
        let mut found = Vec::new();
        let others = of(1);
        for i in of(0) {
            let Some(p) = self.polygon(i) else { continue };
            for j in &others {
                let Some(q) = self.polygon(*j) else { continue };
                let part = polygon::common(&p, &q, self.get(i).n);
                let area = polygon::area(&part);
                if area > 1e-9 * self.get(i).area.min(self.get(*j).area) {
                    found.push((i, *j, part, area));
                }
            }
        }
        let any = !found.is_empty();
        for (i, j, part, area) in found {
            self.contacts.entry(i).or_default().push(Contact { other: j, part: part.clone(), area });
            self.contacts.entry(j).or_default().push(Contact { other: i, part, area });
        }
        any
    }
}

impl Chart {
    /// The corners of a polygon, around its front; none of what is no polygon.
    fn polygon(&self) -> Polygon {
        let mut p: Polygon = match self {
            Self::Triangle { corners, .. } => corners.iter().copied().collect(),
            Self::Quad { corners, .. } => corners.iter().copied().collect(),
            Self::Round { .. } => Polygon::new(),
        };
        if p.len() > 2 && (p[1] - p[0]).cross(p[2] - p[0]).dot(self.normal(DVec2::ZERO)) < 0.0 {
            p.reverse();
        }
        p
    }
}

//! What is wrong with a scene's surfaces, and what was done about it.
//!
//! | fault | what is done |
//! | --- | --- |
//! | a facet without area | it is no patch |
//! | facets side by side that are wound against each other | each keeps the front that its winding, or its vertex normals, give it |
//! | edges of one facet only that no other surface has, where a surface is not a flat sheet | nothing: what passes through the gap is counted where it ends, or as escaped |
//! | facets that cover each other in one plane, face to face | the covered parts exchange with each other alone ([`Contact`]) |
//! | the same, facing one way | rays see the one of them that the tree gives; the other sends light and gets none |

use super::{Chart, ChartEntry, NONE, Object, Patches};
use crate::form_factor::polygon::{self, Polygon};
use etendue_numerics::warp::square_to_cosine_hemisphere;
use etendue_numerics::{Frame, Net4, Ray, Vec2};
use etendue_scene::{Scene, SurfaceId};
use glam::DVec3;
use std::collections::{BTreeMap, HashMap};

/// A facet of a surface: a triangle of a mesh, 0 of anything else.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Facet {
    /// The surface.
    pub surface: SurfaceId,
    /// The triangle, from 0.
    pub facet: u32,
}

/// Something that is wrong.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Fault {
    /// Facets without area.
    NoArea {
        /// The first of them.
        first: Facet,
        /// How many there are in that surface.
        count: usize,
    },
    /// Edges along which two facets are wound against each other.
    AgainstEachOther {
        /// Two facets at the first of them.
        first: [Facet; 2],
        /// How many there are in that surface.
        count: usize,
    },
    /// Edges of one facet only.
    Open {
        /// The facet at the first of them.
        first: Facet,
        /// How many there are in that surface.
        count: usize,
    },
    /// Facets in one plane that cover each other, face to face.
    Touching {
        /// The facets.
        pair: [Facet; 2],
        /// The area covered, m².
        area: f64,
    },
    /// Facets in one plane that cover each other, facing one way or back to back.
    Doubled {
        /// The facets.
        pair: [Facet; 2],
        /// The area covered, m².
        area: f64,
    },
}

/// Both ends of an edge: the bits of their coordinates.
type Ends = [[u32; 3]; 2];

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

    /// Looks for faults of meshes: facets by themselves, and along their edges.
    pub(super) fn inspect(&mut self, scene: &Scene) {
        let mut first = vec![None; scene.surfaces.len()];
        self.objects.iter().rev().for_each(|o| first[o.surface.index()] = Some(o));
        let mut faults = Vec::new();
        let mut open = Vec::new();
        for object in first.into_iter().flatten() {
            if scene.surface(object.surface).shape.mesh().is_some() && !object.is_clear {
                faults.extend(self.faults_of_mesh(scene, object, &mut open));
            }
        }
        // An edge that other surfaces have, too, is no gap: a room may be made of many.
        let mut surfaces: HashMap<Ends, u32> = HashMap::new();
        open.iter().for_each(|(ends, ..)| *surfaces.entry(*ends).or_insert(0) += 1);
        let mut gaps: BTreeMap<SurfaceId, (Facet, usize)> = BTreeMap::new();
        for (_, facet, _) in open.iter().filter(|(ends, _, matters)| *matters && surfaces[ends] == 1) {
            gaps.entry(facet.surface).or_insert((*facet, 0)).1 += 1;
        }
        faults.extend(gaps.into_values().map(|(first, count)| Fault::Open { first, count }));
        self.faults = faults;
    }

    /// All but open edges, which are noted in `open`.
    fn faults_of_mesh(&self, scene: &Scene, object: &Object, open: &mut Vec<(Ends, Facet, bool)>) -> Vec<Fault> {
        let surface = object.surface;
        let facet = |facet: u32| Facet { surface, facet };
        let Some(mesh) = scene.surface(surface).shape.mesh() else { return Vec::new() };
        let mut faults = Vec::new();
        let first = object.facets.unwrap_or(0) as usize;
        let of_chart = |k: usize| self.facets[first + k].chart;
        let mut empty = (0..mesh.indices.len()).filter(|k| of_chart(*k) == NONE);
        if let Some(k) = empty.next() {
            faults.push(Fault::NoArea { first: facet(k as u32), count: 1 + empty.count() });
        }

        // Corners by place, and each edge with the facets along it.
        let mut places: HashMap<[u32; 3], u32> = HashMap::new();
        // Zeros of either sign are one.
        let key = |i: u32| mesh.positions[i as usize].to_array().map(|x| (x + 0.0).to_bits());
        let place = |i: u32, places: &mut HashMap<[u32; 3], u32>| {
            let next = places.len() as u32;
            *places.entry(key(i)).or_insert(next)
        };
        let mut edges: BTreeMap<[u32; 2], Vec<(u32, bool)>> = BTreeMap::new();
        let mut normals = Vec::new();
        for (k, triangle) in mesh.indices.iter().enumerate().filter(|(k, _)| of_chart(*k) != NONE) {
            let corners = triangle.map(|i| place(i, &mut places));
            // The winding about the front: charts know that, winding alone does not where vertex normals turn it.
            let [a, b, c] = triangle.map(|i| mesh.positions[i as usize].as_dvec3());
            let n = self.charts[of_chart(k) as usize].chart.normal(glam::DVec2::ZERO);
            let turned = object.instance == etendue_scene::NO_INSTANCE && (b - a).cross(c - a).dot(n) < 0.0;
            normals.push(n);
            for e in 0..3 {
                let (p, q) = (corners[e], corners[(e + 1) % 3]);
                edges.entry([p.min(q), p.max(q)]).or_default().push((k as u32, (p < q) != turned));
            }
        }
        let against = |e: &&Vec<(u32, bool)>| e.len() == 2 && e[0].1 == e[1].1;
        let mut both = edges.values().filter(against);
        if let Some(e) = both.next() {
            faults.push(Fault::AgainstEachOther { first: [facet(e[0].0), facet(e[1].0)], count: 1 + both.count() });
        }
        let flat = normals.iter().all(|n| n.dot(normals[0]).abs() > 1.0 - 1e-9);
        for (ends, e) in edges.iter().filter(|(_, e)| e.len() == 1) {
            let corners = mesh.indices[e[0].0 as usize].map(|i| (places[&key(i)], key(i)));
            let mut at = ends.map(|end| corners.iter().find(|c| c.0 == end).map_or([0; 3], |c| c.1));
            at.sort_unstable();
            // The edges of a flat sheet are no gaps, but close those of others.
            open.push((at, facet(e[0].0), !flat));
        }
        faults
    }

    /// Looks for flat pieces that cover each other in one plane.
    pub(super) fn find_contacts(&mut self, scene: &Scene) {
        self.contacts.clear();
        self.faults.retain(|f| !matches!(f, Fault::Touching { .. } | Fault::Doubled { .. }));
        let rim = 1e-6 * f64::from(scene.bounds.size().length());
        let pieces: Vec<_> = self.charts.iter().map(|e| (e.chart.polygon(), e.chart.normal(glam::DVec2::ZERO))).collect();
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
            if opposite && self.is_shut(scene, a, b, &part) {
                self.faults.push(Fault::Touching { pair, area });
                self.touch(a, b);
            } else {
                self.faults.push(Fault::Doubled { pair, area });
            }
        }
    }

    /// Whether nothing can be seen from between two pieces: every ray from the middle of what they cover ends on a back that is no patch, or leaves
    /// the scene on the outer side. Face to face and back to back are the same place; this tells one from the other.
    fn is_shut(&self, scene: &Scene, a: usize, b: usize, part: &Polygon) -> bool {
        let middle = part.iter().sum::<DVec3>() / part.len() as f64;
        let mut absorbed = false;
        for chart in [a, b] {
            let entry = &self.charts[chart];
            let n = entry.chart.normal(glam::DVec2::ZERO).as_vec3();
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

    /// Notes which patches of two charts cover each other.
    fn touch(&mut self, a: usize, b: usize) {
        let fronts = |chart: usize| -> Vec<u32> {
            let of_chart = |i: &u32| self.cells[self.get(*i).cell as usize].chart as usize == chart;
            let object = &self.objects[self.charts[chart].object as usize];
            object.patches.clone().filter(of_chart).filter(|i| self.get(*i).side == super::Side::Front).collect()
        };
        let mut found = Vec::new();
        let others = fronts(b);
        for i in fronts(a) {
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
        for (i, j, part, area) in found {
            self.contacts.entry(i).or_default().push(Contact { other: j, part: part.clone(), area });
            self.contacts.entry(j).or_default().push(Contact { other: i, part, area });
        }
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
        if p.len() > 2 && (p[1] - p[0]).cross(p[2] - p[0]).dot(self.normal(glam::DVec2::ZERO)) < 0.0 {
            p.reverse();
        }
        p
    }
}

//! What is wrong with a scene's surfaces, and what was done about it.
//!
//! | fault | what is done |
//! | --- | --- |
//! | a facet without area | it is no patch |
//! | facets side by side that are wound against each other | each keeps the front that its winding, or its vertex normals, give it |
//! | edges of one facet only that no other surface has or stands against, where a surface is not a flat sheet | nothing: what passes through the gap is counted where it ends, or as escaped |
//! | a side that no light reaches, as the inside of a box | it is no patch ([`super::dark`]) |
//! | facets that cover each other in one plane, face to face | the covered parts exchange with each other alone ([`super::contacts`]) |
//! | the same, where it cannot be told which sides face each other | rays see the one of them that the tree gives; the other sends light and gets none |

use super::{NONE, Object, Patches, Side};
use etendue_numerics::{Ray, Vec3};
use etendue_scene::{NO_INSTANCE, Scene, SurfaceId};
use glam::DVec2;
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
    /// A side that no light reaches.
    Dark {
        /// The first facet of its surface.
        first: Facet,
        /// Which.
        side: Side,
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

/// An edge of one facet only, and whether it may be a gap.
type OpenEdge = (Ends, Facet, bool);

impl Patches {
    /// Looks for faults of meshes: facets by themselves, and along their edges.
    pub(super) fn inspect(&mut self, scene: &Scene) {
        let mut first = vec![None; scene.surfaces.len()];
        self.objects.iter().rev().for_each(|o| first[o.surface.index()] = Some(o));
        let mut faults = Vec::new();
        let mut open = Vec::new();
        let mut shut = vec![false; scene.surfaces.len()];
        for object in first.into_iter().flatten() {
            if scene.surface(object.surface).shape.mesh().is_some() && !object.is_clear {
                let before = open.len();
                let (found, closed) = self.faults_of_mesh(scene, object, &mut open);
                faults.extend(found);
                shut[object.surface.index()] = closed && open.len() == before;
            }
        }
        // An edge that other surfaces have, too, is no gap: a room may be made of many.
        let mut surfaces: HashMap<Ends, u32> = HashMap::new();
        open.iter().for_each(|(ends, ..)| *surfaces.entry(*ends).or_insert(0) += 1);
        let mut gaps: BTreeMap<SurfaceId, (Facet, usize)> = BTreeMap::new();
        let alone = |(ends, _, matters): &&OpenEdge| *matters && surfaces[ends] == 1;
        for (_, facet, _) in open.iter().filter(alone).filter(|edge| !self.stands_against_another(scene, edge)) {
            gaps.entry(facet.surface).or_insert((*facet, 0)).1 += 1;
        }
        faults.extend(gaps.into_values().map(|(first, count)| Fault::Open { first, count }));
        self.faults.extend(faults);
        let volume = |o: &Object| if shut[o.surface.index()] { self.volume(o) } else { 0.0 };
        self.volumes = self.objects.iter().map(volume).collect();
    }

    /// Whether an edge lies on another surface all along, as that of a box without a bottom on the floor: a step beyond it meets something.
    fn stands_against_another(&self, scene: &Scene, (ends, facet, _): &OpenEdge) -> bool {
        /// Where along the edge it is looked at, and how far beyond, in diameters of the scene.
        const ALONG: [f32; 5] = [0.02, 0.25, 0.5, 0.75, 0.98];
        const STEP: f32 = 1e-5;
        let placed = self.objects.iter().any(|o| o.surface == facet.surface && o.instance == NO_INSTANCE);
        let (true, Some(mesh)) = (placed, scene.surface(facet.surface).shape.mesh()) else { return false };
        let [a, b] = ends.map(|p| Vec3::from_array(p.map(f32::from_bits)));
        let corners = mesh.indices[facet.facet as usize].map(|i| mesh.positions[i as usize]);
        let Some(c) = corners.into_iter().find(|p| *p != a && *p != b) else { return false };
        let along = (b - a).normalize_or_zero();
        let beyond = ((a - c) - along * along.dot(a - c)).normalize_or_zero();
        let step = STEP * scene.bounds.size().length();
        ALONG.iter().all(|t| scene.intersect(&Ray::new(a.lerp(b, *t) - beyond * step, beyond).until(2.0 * step)).is_some())
    }

    /// All but open edges, which are noted in `open`; and whether the rest of the mesh is the surface of a solid.
    fn faults_of_mesh(&self, scene: &Scene, object: &Object, open: &mut Vec<OpenEdge>) -> (Vec<Fault>, bool) {
        let surface = object.surface;
        let facet = |facet: u32| Facet { surface, facet };
        let Some(mesh) = scene.surface(surface).shape.mesh() else { return (Vec::new(), false) };
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
            let n = self.charts[of_chart(k) as usize].chart.normal(DVec2::ZERO);
            let turned = object.instance == NO_INSTANCE && (b - a).cross(c - a).dot(n) < 0.0;
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
        let closed = edges.values().all(|e| e.len() == 2 && e[0].1 != e[1].1);
        (faults, closed)
    }
}

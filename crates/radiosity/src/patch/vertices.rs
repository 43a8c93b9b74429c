//! The corners of patches, shared where surfaces go on smoothly: what a picture interpolates between.
//!
//! Corners are one [`Vertices`] entry where they lie at one place and their shading normals are alike; where patches meet at an angle, each side
//! has a vertex of its own and the discontinuity stays; so it does where a wall that stands on the surface hides one patch from the other. A vertex within the side of a larger patch (a T-junction) hangs: its value is not free
//! but that of the side's ends, interpolated ([`Hanging`]), so that no crack shows.

use super::round::Round;
use super::{Chart, NONE, Patches};
use etendue_numerics::Ray;
use etendue_scene::Scene;
use glam::{DVec2, DVec3, I64Vec3};
use std::collections::{BTreeMap, HashMap, HashSet};

/// Cosine between normals above which a surface goes on smoothly: 20°.
const SMOOTH: f64 = 0.94;

/// How near, in diameters of the scene, two corners are one.
const SAME: f64 = 1e-6;

/// A vertex within the side of another patch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hanging {
    /// The vertex.
    pub vertex: u32,
    /// The ends of the side.
    pub ends: [u32; 2],
    /// How far along: value = (1 - t) first + t second.
    pub t: f64,
}

/// Shared corners.
#[derive(Clone, Debug, Default)]
pub struct Vertices {
    /// Places.
    pub points: Vec<DVec3>,
    /// Unit shading normals, on the side of the patches.
    pub normals: Vec<DVec3>,
    /// For each patch its corners in the order of [`super::Span::corners`], or of [`super::Span::triangle`] and `u32::MAX`.
    pub corners: Vec<[u32; 4]>,
    /// Vertices that are not free, those that rest on other hanging ones after them.
    pub hanging: Vec<Hanging>,
}

impl Patches {
    /// The corners of all patches.
    pub fn vertices(&self, scene: &Scene) -> Vertices {
        let mut vertices = Vertices::default();
        let tolerance = f64::from(scene.bounds.size().length()) * SAME;
        let mut places: HashMap<I64Vec3, Vec<u32>> = HashMap::new();
        // For each vertex the patch that it was made for.
        let mut owners: Vec<u32> = Vec::new();
        for (i, patch) in self.patches.iter().enumerate() {
            let (span, chart) = self.geometry(i as u32);
            let mut corners = [NONE; 4];
            let around = if chart.is_triangle() { span.triangle().to_vec() } else { span.corners().to_vec() };
            for (corner, st) in corners.iter_mut().zip(around) {
                // Slightly inside, so that a mesh looks up its own triangle.
                let inside = st.lerp(span.middle(chart), 1e-6);
                let n = self.interaction(scene, i as u32, inside).shading.n.as_dvec3() * patch.side.sign();
                let joined = |v: u32| !self.are_parted(scene, i as u32, owners[v as usize]);
                *corner = vertices.weld(&mut places, tolerance, chart.point(st), n, joined);
                owners.resize(vertices.points.len(), i as u32);
            }
            vertices.corners.push(corners);
        }
        vertices.hang(self, tolerance, &|i, v| !self.are_parted(scene, i as u32, owners[v as usize]));
        vertices
    }

    /// Whether something that stands on one of two neighbours hides what is open of either from the other.
    fn are_parted(&self, scene: &Scene, i: u32, j: u32) -> bool {
        /// How far above the surface they look at each other, in parts of their distance.
        const LIFT: f64 = 1e-3;
        if i == j || !self.is_touched(i) && !self.is_touched(j) {
            return false;
        }
        let (Some(x), Some(y)) = (self.open_point(i), self.open_point(j)) else { return true };
        let lift = LIFT * x.distance(y);
        let (start, end) = (x + self.get(i).n * lift, y + self.get(j).n * lift);
        let d = end - start;
        let ray = Ray::new(start.as_vec3(), d.normalize_or_zero().as_vec3()).until((d.length() * (1.0 - LIFT)) as f32);
        lift > 0.0 && scene.accel.occluded(&ray, &scene.surfaces)
    }

    /// A point of patch i that nothing lies on: its middle, or one half way to a corner.
    fn open_point(&self, i: u32) -> Option<DVec3> {
        let (span, chart) = self.geometry(i);
        let middle = span.middle(chart);
        let corners = if chart.is_triangle() { span.triangle().to_vec() } else { span.corners().to_vec() };
        let around = corners.iter().flat_map(|c| [0.5, 0.9].map(|t| middle.lerp(*c, t)));
        std::iter::once(middle).chain(around).map(|st| chart.point(st)).find(|p| self.touching_at(i, *p).is_none())
    }
}

impl Vertices {
    /// The vertex at `p` with a normal like `n`, of a patch that is `joined` to this one.
    fn weld(
        &mut self,
        places: &mut HashMap<I64Vec3, Vec<u32>>,
        tolerance: f64,
        p: DVec3,
        n: DVec3,
        joined: impl Fn(u32) -> bool,
    ) -> u32 {
        // What is nearer than half a box lies in one of the eight boxes around the nearest box corner.
        let scaled = p / (2.0 * tolerance);
        let low = (scaled - 0.5).floor();
        for k in 0..8 {
            let key = (low + DVec3::new((k & 1).into(), (k >> 1 & 1).into(), (k >> 2).into())).as_i64vec3();
            let near = places.get(&key).into_iter().flatten();
            let alike = |v: &u32| self.points[*v as usize].distance(p) <= tolerance && self.normals[*v as usize].dot(n) >= SMOOTH;
            if let Some(v) = near.copied().find(|v| alike(v) && joined(*v)) {
                return v;
            }
        }
        self.points.push(p);
        self.normals.push(n);
        let v = self.points.len() as u32 - 1;
        places.entry(scaled.floor().as_i64vec3()).or_default().push(v);
        v
    }

    /// The sides of patch i as pairs of places in its list of corners.
    fn sides(&self, i: usize) -> impl Iterator<Item = [usize; 2]> {
        let n = if self.corners[i][3] == NONE { 3 } else { 4 };
        (0..n).map(move |k| [k, (k + 1) % n])
    }

    /// Finds the vertices that hang.
    fn hang(&mut self, patches: &Patches, tolerance: f64, joined: &dyn Fn(usize, u32) -> bool) {
        let mut found: BTreeMap<u32, Hanging> = BTreeMap::new();
        self.hang_on_straight_sides(patches, tolerance, joined, &mut found);
        self.hang_on_bent_sides(patches, &mut found);

        // What rests on a hanging vertex comes after it; rounds of chains that cannot be put in order are let go.
        let mut placed: Vec<bool> = vec![true; self.points.len()];
        found.keys().for_each(|v| placed[*v as usize] = false);
        while !found.is_empty() {
            let ready: Vec<Hanging> = found.values().filter(|h| h.ends.iter().all(|e| placed[*e as usize])).copied().collect();
            if ready.is_empty() {
                break;
            }
            for h in ready {
                placed[h.vertex as usize] = true;
                found.remove(&h.vertex);
                self.hanging.push(h);
            }
        }
    }

    /// Sides in space: any vertex that lies on one, with a normal like those of the ends.
    fn hang_on_straight_sides(
        &self,
        patches: &Patches,
        tolerance: f64,
        joined: &dyn Fn(usize, u32) -> bool,
        found: &mut BTreeMap<u32, Hanging>,
    ) {
        let flat = |i: usize| !matches!(patches.geometry(i as u32).1, Chart::Round { .. });
        let flat: Vec<usize> = (0..self.corners.len()).filter(|i| flat(*i)).collect();
        let side = |i: usize, [a, b]: [usize; 2]| [self.corners[i][a], self.corners[i][b]];
        let length = |[a, b]: [u32; 2]| self.points[a as usize].distance(self.points[b as usize]);
        // The geometric mean of the sides: of a floor and ten thousand screws the boxes are neither.
        let lengths = flat.iter().flat_map(|i| self.sides(*i).map(|s| length(side(*i, s)))).filter(|l| *l > 0.0);
        let (sum, count) = lengths.fold((0.0, 0), |(sum, n), l| (sum + l.ln(), n + 1));
        if count == 0 {
            return;
        }
        let step = (sum / f64::from(count)).exp().max(tolerance);
        let key = |p: DVec3| (p / step).floor().as_i64vec3();
        let mut boxes: HashMap<I64Vec3, Vec<u32>> = HashMap::new();
        for (v, p) in self.points.iter().enumerate() {
            boxes.entry(key(*p)).or_default().push(v as u32);
        }
        let mut seen: HashSet<I64Vec3> = HashSet::new();
        for i in flat {
            for s in self.sides(i) {
                let ends @ [a, b] = side(i, s);
                let (p, q) = (self.points[a as usize], self.points[b as usize]);
                let along = q - p;
                // The boxes that the side passes, or comes as near to as two places are one: those around each piece of it, no longer than half a box.
                let pieces = (along.length() / step).ceil().max(1.0) as u32 * 2;
                seen.clear();
                for k in 0..pieces {
                    let [from, to] = [k, k + 1].map(|k| p + along * (f64::from(k) / f64::from(pieces)));
                    let (low, high) = (key(from.min(to) - tolerance), key(from.max(to) + tolerance));
                    for d in 0..8 {
                        let box_ = I64Vec3::select(I64Vec3::new(d & 1, d >> 1 & 1, d >> 2).cmpeq(I64Vec3::ZERO), low, high);
                        if boxes.contains_key(&box_) {
                            seen.insert(box_);
                        }
                    }
                }
                for v in seen.iter().flat_map(|k| &boxes[k]).copied().filter(|v| *v != a && *v != b) {
                    let x = self.points[v as usize] - p;
                    let t = x.dot(along) / along.length_squared();
                    let on = (x - along * t).length() <= tolerance
                        && t * along.length() > tolerance
                        && (1.0 - t) * along.length() > tolerance;
                    let alike = self.normals[v as usize].dot(self.normals[a as usize]) >= SMOOTH
                        && self.normals[v as usize].dot(self.normals[b as usize]) >= SMOOTH;
                    if on && alike && joined(i, v) {
                        self.offer(found, Hanging { vertex: v, ends, t });
                    }
                }
            }
        }
    }

    /// Sides of round patches: in the parameters of their chart.
    fn hang_on_bent_sides(&self, patches: &Patches, found: &mut BTreeMap<u32, Hanging>) {
        // Lines of one chart, side and direction, each with the vertices on it.
        let key =
            |chart: u32, back: bool, along: usize, across: f64| (chart, back, along, (across.rem_euclid(1.0) * 1e9).round() as i64);
        let mut lines: BTreeMap<_, Vec<(f64, u32)>> = BTreeMap::new();
        let round = |i: usize| {
            let cell = &patches.cells[patches.patches[i].cell as usize];
            let Chart::Round { shape, .. } = patches.charts[cell.chart as usize].chart else { return None };
            Some((cell, shape, patches.patches[i].side == super::Side::Back))
        };
        for i in 0..self.corners.len() {
            let Some((cell, _, back)) = round(i) else { continue };
            for (v, st) in self.corners[i].iter().zip(cell.span.corners()) {
                lines.entry(key(cell.chart, back, 0, st.y)).or_default().push((st.x, *v));
                lines.entry(key(cell.chart, back, 1, st.x)).or_default().push((st.y, *v));
            }
        }
        for line in lines.values_mut() {
            line.sort_by(|a, b| a.0.total_cmp(&b.0));
        }
        for i in 0..self.corners.len() {
            let Some((cell, shape, back)) = round(i) else { continue };
            let corners = cell.span.corners();
            for [a, b] in self.sides(i) {
                let ends = [self.corners[i][a], self.corners[i][b]];
                let along = usize::from(corners[a].x == corners[b].x);
                // t = 0 and 1 of a sphere, and t = 0 of a disk, are points.
                let across = corners[a][1 - along];
                if along == 0
                    && (shape == Round::Sphere && (across == 0.0 || across == 1.0) || shape == Round::Disk && across == 0.0)
                {
                    continue;
                }
                let Some(line) = lines.get(&key(cell.chart, back, along, across)) else { continue };
                let (from, to) = (corners[a][along], corners[b][along]);
                let begin = line.partition_point(|(x, _)| *x <= from.min(to) + 1e-9);
                for (x, v) in line[begin..].iter().take_while(|(x, _)| *x < from.max(to) - 1e-9) {
                    if !ends.contains(v) {
                        self.offer(found, Hanging { vertex: *v, ends, t: (x - from) / (to - from) });
                    }
                }
            }
        }
    }

    /// Of several sides that a vertex hangs on, the longest counts: its ends are free, or nearer to being so.
    fn offer(&self, found: &mut BTreeMap<u32, Hanging>, h: Hanging) {
        let length = |h: &Hanging| self.points[h.ends[0] as usize].distance(self.points[h.ends[1] as usize]);
        let entry = found.entry(h.vertex).or_insert(h);
        if length(&h) > length(entry) {
            *entry = h;
        }
    }

    /// Values at the vertices from values of the patches: means by area of the patches around, and of the ends where a vertex hangs.
    pub fn average(&self, patches: &Patches, values: &[DVec3]) -> Vec<DVec3> {
        let mut sums = vec![(DVec3::ZERO, 0.0); self.points.len()];
        for ((corners, patch), value) in self.corners.iter().zip(&patches.patches).zip(values) {
            for v in corners.iter().filter(|v| **v != NONE) {
                let (sum, weight) = &mut sums[*v as usize];
                *sum += *value * patch.area;
                *weight += patch.area;
            }
        }
        let mut at: Vec<DVec3> = sums.into_iter().map(|(sum, weight)| if weight > 0.0 { sum / weight } else { sum }).collect();
        self.settle(&mut at);
        at
    }

    /// Gives hanging vertices the values of their ends, interpolated.
    pub fn settle(&self, at: &mut [DVec3]) {
        for h in &self.hanging {
            at[h.vertex as usize] = at[h.ends[0] as usize].lerp(at[h.ends[1] as usize], h.t);
        }
    }

    /// The vertices of patch i with their weights at a place within it ([`super::Place::local`]).
    #[inline]
    pub fn weights(&self, i: u32, local: DVec2) -> [(u32, f64); 4] {
        let corners = self.corners[i as usize];
        let (x, y) = (local.x.clamp(0.0, 1.0), local.y.clamp(0.0, 1.0));
        if corners[3] == NONE {
            let [a, b, c, _] = corners;
            return [(a, 1.0 - x - y), (b, x), (c, y), (a, 0.0)];
        }
        let weights = [(1.0 - x) * (1.0 - y), x * (1.0 - y), x * y, (1.0 - x) * y];
        std::array::from_fn(|k| (corners[k], weights[k]))
    }
}

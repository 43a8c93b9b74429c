//! V between two points, and pairs of patches that surely see each other in full.

use crate::patch::{PatchPoint, Patches};
use etendue_numerics::Ray;
use etendue_scene::Scene;
use glam::DVec3;

/// An axis-parallel box.
#[derive(Clone, Copy, Debug)]
struct Block {
    low: DVec3,
    high: DVec3,
}

impl Block {
    const NOTHING: Self = Self { low: DVec3::INFINITY, high: DVec3::NEG_INFINITY };

    fn including(self, p: DVec3) -> Self {
        Self { low: self.low.min(p), high: self.high.max(p) }
    }

    fn ball((p, r): (DVec3, f64)) -> Self {
        Self { low: p - r, high: p + r }
    }

    fn union(self, other: &Self) -> Self {
        Self { low: self.low.min(other.low), high: self.high.max(other.high) }
    }

    /// Whether they share more than their rims, which are `rim` wide.
    fn meets(&self, other: &Self, rim: f64) -> bool {
        (self.low + rim).cmplt(other.high).all() && (other.low + rim).cmplt(self.high).all()
    }
}

/// Rays between points of patches.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sight<'a> {
    scene: &'a Scene,
    patches: &'a Patches,
    has_clear: bool,
}

/// What may stand between patches.
#[derive(Debug)]
pub(crate) struct Between<'a> {
    patches: &'a Patches,
    sight: Sight<'a>,
    /// Boxes of patches, of charts, and of objects.
    patch_boxes: Vec<Block>,
    charts: Vec<Block>,
    objects: Vec<Block>,
    /// Corners of flat pieces.
    corners: Vec<Vec<DVec3>>,
    /// How far things are on one plane, m.
    rim: f64,
    /// There are obstacles without charts: nothing is sure.
    unsure: bool,
}

impl<'a> Between<'a> {
    pub fn new(scene: &'a Scene, patches: &'a Patches) -> Self {
        let points = |i: u32| match patches.polygon(i) {
            Some(polygon) => polygon.iter().fold(Block::NOTHING, |b, p| b.including(*p)),
            None => Block::ball(patches.ball(i)),
        };
        let patch_boxes: Vec<Block> = (0..patches.len() as u32).map(points).collect();
        let mut charts = vec![Block::NOTHING; patches.charts.len()];
        let mut objects = vec![Block::NOTHING; patches.objects.len()];
        for (patch, block) in patches.patches.iter().zip(&patch_boxes) {
            let chart = patches.cells[patch.cell as usize].chart as usize;
            charts[chart] = charts[chart].union(block);
            objects[patch.object as usize] = objects[patch.object as usize].union(block);
        }
        let corners = patches.charts.iter().map(|e| e.chart.hull()).collect();
        let sight = Sight::new(scene, patches);
        let rim = 1e-6 * f64::from(scene.bounds.size().length());
        Self { patches, sight, patch_boxes, charts, objects, corners, rim, unsure: !patches.obstacles.is_empty() }
    }

    /// Whether surely nothing blocks any ray between patches i and j: no piece of the scene reaches into the box around both, in front of the
    /// planes of either that is flat.
    pub fn is_clear(&self, i: u32, j: u32) -> bool {
        let block = self.patch_boxes[i as usize].union(&self.patch_boxes[j as usize]);
        let outside = |k: usize| {
            let corners = &self.corners[k];
            let behind = |p: u32| {
                let patch = self.patches.get(p);
                let flat = self.patches.geometry(p).1.is_flat();
                flat && !corners.is_empty() && corners.iter().all(|c| (*c - patch.p).dot(patch.n) <= self.rim)
            };
            // A round piece may hide parts of itself.
            !block.meets(&self.charts[k], self.rim) || behind(i) || behind(j)
        };
        let clear = |o: usize| {
            let charts = &self.patches.objects[o].charts;
            !block.meets(&self.objects[o], self.rim) || (charts.start as usize..charts.end as usize).all(outside)
        };
        // Covered parts see nothing.
        let touched = self.patches.is_touched(i) || self.patches.is_touched(j);
        !self.unsure && !touched && (0..self.objects.len()).all(clear)
    }

    /// V between points of patches i and j.
    pub fn sees(&self, x: (u32, &PatchPoint), y: (u32, &PatchPoint)) -> bool {
        self.sight.sees(x, y)
    }
}

impl<'a> Sight<'a> {
    pub fn new(scene: &'a Scene, patches: &'a Patches) -> Self {
        Self { scene, patches, has_clear: patches.objects.iter().any(|o| o.is_clear) }
    }

    /// V between points of patches i and j.
    pub fn sees(&self, (i, x): (u32, &PatchPoint), (j, y): (u32, &PatchPoint)) -> bool {
        if self.patches.touching_at(i, x.p).is_some() || self.patches.touching_at(j, y.p).is_some() {
            return false;
        }
        let (start, end) = (self.patches.lifted(i, x), self.patches.lifted(j, y));
        let d = end - start;
        let distance = d.length();
        if distance <= f64::from(self.patches.get(j).clearance) {
            return true;
        }
        let ray = Ray::new(start.as_vec3(), (d / distance).as_vec3()).until((distance * (1.0 - 1e-5)) as f32);
        if self.has_clear {
            return self.passes(ray);
        }
        !self.scene.accel.occluded(&ray, &self.scene.surfaces)
    }

    /// Whether only surfaces without substance are in the way.
    fn passes(&self, mut ray: Ray) -> bool {
        for _ in 0..64 {
            let Some(hit) = self.scene.intersect(&ray) else { return true };
            if !self.patches.objects[self.patches.object_of(&hit) as usize].is_clear {
                return false;
            }
            let next = self.scene.interaction(&ray, &hit).spawn(ray.d);
            ray = next.until(ray.t_max - hit.t);
        }
        false
    }
}

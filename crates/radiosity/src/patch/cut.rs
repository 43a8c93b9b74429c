//! From a scene to patches.

use super::grid::Grid;
use super::{Cell, ChartEntry, NONE, Patch, Patches, Side, Span, optics};
use etendue_numerics::Spectrum;
use etendue_numerics::math::gamma;
use etendue_scene::Scene;
use glam::DVec3;
use rayon::prelude::*;

/// How large patches shall be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PatchSize {
    /// Each piece as it is: triangles, flat quadrilaterals, whole round shapes.
    Whole,
    /// Near this length, m.
    Metres(f64),
    /// Near this many patches in all. Where pieces alone are more than half of that, half as many more than there are pieces: a floor of two triangles is
    /// cut, however many triangles the furniture has.
    Count(usize),
}

/// Which sides are patches.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sides {
    /// Fronts, and backs that reflect; neither where no light gets.
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

/// How many patches are made where n were asked for and there are so many pieces: large ones among many are cut all the same, and more finely where the
/// many small ones ask for few rays.
fn patches_for(n: usize, pieces: usize) -> usize {
    n.max(pieces + if pieces > 4 * n { 4 * n } else { n / 2 })
}

impl Patches {
    /// The patches of `scene`.
    pub fn cut(scene: &Scene, cutting: &Cutting) -> Result<Self, TooMany> {
        let mut patches = Self::pieces(scene);
        patches.sides = patches.choose_sides(scene, cutting.sides);
        if cutting.sides == Sides::ByMaterial {
            patches.leave_out_dark_sides(scene);
        }
        let h = match cutting.size {
            PatchSize::Whole => f64::INFINITY,
            PatchSize::Metres(h) => h,
            PatchSize::Count(n) => patches.size_for(patches_for(n, patches.count_at(f64::INFINITY))),
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
        patches.number(scene, None);
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
        finer.number(scene, Some(self));
        finer
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

    /// Makes the patches of all leaves; what they reflect is known of those that were there `before`.
    pub(super) fn number(&mut self, scene: &Scene, before: Option<&Self>) {
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
        self.look_up(scene, before);
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

//! Does a sampler draw from the density that it claims? Pearson's chi-square test [Pearson 1900].
//!
//! ```text
//! X² = Σᵢ (Oᵢ - Eᵢ)² / Eᵢ,    Eᵢ = N ∫_cell p,    p-value = P(χ²_{k-1} ≥ X²)
//! ```
//!
//! The cells adapt to the density: a pilot draw (from its own seed, so that the test stays a test) divides every cell of the
//! starting grid that holds many of its points. A lobe a thousandth of a radian wide is thereby seen in hundreds of cells, and its
//! density is integrated where it lives. Cells with E < 5 are pooled. Draws that give `None` form a cell of their own, expected
//! N (1 - ∫p): a sampler that absorbs must have a density that integrates to less than one by just that much.
//!
//! Besides the statistic a run fails where a point falls outside the domain, where points fall where p is zero, where p is negative or
//! not finite, and where ∫p and the share of draws that gave a point disagree.

use crate::{Rng, domain::Domain, domain::Rect, quadrature, special};
use std::fmt;

/// Least expected count of a cell that stands alone.
const POOL_BELOW: f64 = 5.0;
/// Pilot points above which a cell is divided.
const DIVIDE_ABOVE: usize = 48;
/// Pilot points above which a piece of a cell is divided for quadrature.
const INTEGRATE_ABOVE: usize = 4;
/// Divisions of a starting cell at the most: f32 directions cannot be told apart much finer.
const MAX_DIVISIONS: u32 = 9;
/// What the quadrature of ∫p is trusted to.
const MASS_TOLERANCE: f64 = 2e-3;

/// How a test is made; see [`ChiSquareTest::run`].
#[derive(Clone, Copy, Debug)]
pub struct ChiSquareTest<D> {
    domain: D,
    samples: usize,
    pilot: usize,
    seed: u64,
}

/// The cells of a test and the probability of each: what a test needs besides its draws.
pub struct Cells<D> {
    test: ChiSquareTest<D>,
    nodes: Vec<Node>,
    grid: [usize; 2],
    mass: f64,
}

struct Node {
    rect: Rect,
    /// First child and number of children; none for a cell that counts.
    children: Option<(usize, usize)>,
    probability: f64,
}

/// What a test found.
#[derive(Clone, Debug, PartialEq)]
pub struct ChiSquare {
    /// X².
    pub statistic: f64,
    /// Degrees of freedom: cells after pooling, less one.
    pub dof: usize,
    /// The probability of an X² as large, were the sampler right.
    pub p_value: f64,
    /// Draws.
    pub samples: usize,
    /// Draws that gave no point.
    pub absorbed: usize,
    /// ∫p over the domain.
    pub mass: f64,
    /// Points outside the domain or not a number.
    pub outside: usize,
    /// Points at which p is not above zero.
    pub stray: usize,
    /// Points at which p is negative, infinite or not a number.
    pub invalid: usize,
    /// The cell that adds most to X².
    pub worst: Option<WorstCell>,
}

/// A cell, by its middle.
#[derive(Clone, Debug, PartialEq)]
pub struct WorstCell {
    /// The point in the middle of the cell, printed.
    pub point: String,
    /// The cell on the domain's square.
    pub rect: Rect,
    /// Draws counted.
    pub observed: f64,
    /// Draws expected.
    pub expected: f64,
}

impl<D: Domain + Copy> ChiSquareTest<D> {
    /// A test with 2¹⁷ draws from seed 1.
    pub fn new(domain: D) -> Self {
        Self { domain, samples: 1 << 17, pilot: 1 << 13, seed: 1 }
    }

    /// The same test with `n` draws.
    pub fn samples(self, n: usize) -> Self {
        Self { samples: n.max(1), ..self }
    }

    /// The same test with another seed.
    pub fn seed(self, seed: u64) -> Self {
        Self { seed, ..self }
    }

    /// Draws from `sample` (of three uniform numbers; `None` where nothing is drawn) and compares with `pdf`, in the measure of the domain.
    pub fn run(self, mut sample: impl FnMut([f32; 3]) -> Option<D::Point>, pdf: impl Fn(D::Point) -> f32) -> ChiSquare {
        self.cells(&mut sample, &pdf).test(self.seed, sample, pdf)
    }

    /// The cells and their probabilities, for several tests of one density.
    pub fn cells(self, mut sample: impl FnMut([f32; 3]) -> Option<D::Point>, pdf: impl Fn(D::Point) -> f32) -> Cells<D> {
        // The pilot: where do points fall?
        let mut rng = Rng::new(self.seed ^ 0x7069_6c6f_7420_2020);
        let mut points: Vec<[f64; 2]> = Vec::new();
        for _ in 0..self.pilot {
            points.extend(sample(rng.u3()).and_then(|p| self.domain.square_of(p)));
        }

        // Divide the crowded cells, breadth first.
        let grid = self.domain.grid();
        let whole = Rect { min: [0.0; 2], max: [1.0; 2] };
        let mut nodes: Vec<Node> =
            whole.grid(grid[0], grid[1]).map(|rect| Node { rect, children: None, probability: 0.0 }).collect();
        let mut members: Vec<Vec<[f64; 2]>> = vec![Vec::new(); nodes.len()];
        for p in points {
            members[base_cell(grid, p)].push(p);
        }
        let mut depth = vec![0u32; nodes.len()];
        let mut next = 0;
        while next < nodes.len() {
            if members[next].len() > DIVIDE_ABOVE && depth[next] < MAX_DIVISIONS {
                let first = nodes.len();
                let parts = self.domain.divide(&nodes[next].rect);
                nodes[next].children = Some((first, parts.len()));
                for rect in parts {
                    nodes.push(Node { rect, children: None, probability: 0.0 });
                    members.push(Vec::new());
                    depth.push(depth[next] + 1);
                }
                for p in std::mem::take(&mut members[next]) {
                    let child = child_of(&nodes, first, nodes.len() - first, p);
                    members[child].push(p);
                }
            }
            next += 1;
        }

        // The probability of each cell. Quadrature need only be good beside the noise of the counts.
        let density = |s: f64, t: f64| {
            let (point, jacobian) = self.domain.point_at(s, t);
            let p = f64::from(pdf(point)) * jacobian;
            if p.is_finite() { p } else { 0.0 }
        };
        let n = self.samples as f64;
        let tolerance = |p: f64| 0.02 * (p.abs().max(1.0 / n) / n).sqrt();
        let mut mass = 0.0;
        for (node, points) in nodes.iter_mut().zip(&members).filter(|(node, _)| node.children.is_none()) {
            node.probability = guided(&node.rect, points, 10, &density, &tolerance);
            mass += node.probability;
        }
        Cells { test: self, nodes, grid, mass }
    }
}

/// ∫ f over `rect`, quadrature starting from pieces that hold at most a few of the pilot's points: what is narrow within the cell is found.
fn guided(rect: &Rect, points: &[[f64; 2]], depth: u32, f: &impl Fn(f64, f64) -> f64, tolerance: &impl Fn(f64) -> f64) -> f64 {
    if points.len() <= INTEGRATE_ABOVE || depth == 0 {
        return quadrature::adaptive(rect, f, 8, tolerance);
    }
    let inside = |q: &Rect, p: &[f64; 2]| (0..2).all(|i| q.min[i] <= p[i] && p[i] < q.max[i]);
    let part = |q: &Rect| points.iter().copied().filter(|p| inside(q, p)).collect::<Vec<_>>();
    rect.quarters().iter().map(|q| guided(q, &part(q), depth - 1, f, tolerance)).sum()
}

fn base_cell(grid: [usize; 2], [s, t]: [f64; 2]) -> usize {
    let index = |x: f64, n: usize| ((x * n as f64) as usize).min(n - 1);
    index(t, grid[1]) * grid[0] + index(s, grid[0])
}

/// The child among `count` from `first` that holds the point.
fn child_of(nodes: &[Node], first: usize, count: usize, [s, t]: [f64; 2]) -> usize {
    // Children lie in rows, s fastest, so the first child's far corner tells column and row; halves have no second row.
    let [column, row] = nodes[first].rect.max;
    first + usize::from(s >= column) + if count == 4 { 2 * usize::from(t >= row) } else { 0 }
}

impl<D: Domain + Copy> Cells<D> {
    fn find(&self, p: [f64; 2]) -> usize {
        let mut at = base_cell(self.grid, p);
        while let Some((first, count)) = self.nodes[at].children {
            at = child_of(&self.nodes, first, count, p);
        }
        at
    }

    /// Draws under `seed` and compares.
    pub fn test(
        &self,
        seed: u64,
        mut sample: impl FnMut([f32; 3]) -> Option<D::Point>,
        pdf: impl Fn(D::Point) -> f32,
    ) -> ChiSquare {
        let domain = &self.test.domain;
        let n = self.test.samples;
        let mut counts = vec![0usize; self.nodes.len()];
        let (mut absorbed, mut outside, mut stray, mut invalid) = (0, 0, 0, 0);
        let mut rng = Rng::new(seed);
        for _ in 0..n {
            let Some(point) = sample(rng.u3()) else {
                absorbed += 1;
                continue;
            };
            let Some(square) = domain.square_of(point) else {
                outside += 1;
                continue;
            };
            let p = pdf(point);
            invalid += usize::from(!p.is_finite() || p < 0.0);
            stray += usize::from(p == 0.0);
            counts[self.find(square)] += 1;
        }

        // Observed and expected, smallest expectation first.
        let total = n as f64;
        let leaves = self.nodes.iter().zip(&counts).filter(|(node, _)| node.children.is_none());
        let mut cells: Vec<(f64, f64, Option<Rect>)> =
            leaves.map(|(node, &count)| (count as f64, total * node.probability.max(0.0), Some(node.rect))).collect();
        if absorbed > 0 || 1.0 - self.mass > MASS_TOLERANCE {
            cells.push((absorbed as f64, total * (1.0 - self.mass).max(0.0), None));
        }
        cells.sort_by(|a, b| a.1.total_cmp(&b.1));

        // Pool the small ones.
        let mut pooled: Vec<(f64, f64, Option<Rect>)> = Vec::new();
        let mut pool = (0.0, 0.0, None);
        for (observed, expected, rect) in cells {
            if pool.1 > 0.0 && pool.1 < POOL_BELOW || expected < POOL_BELOW {
                pool = (pool.0 + observed, pool.1 + expected, pool.2.or(rect));
                if pool.1 >= POOL_BELOW {
                    pooled.push(std::mem::replace(&mut pool, (0.0, 0.0, None)));
                }
            } else {
                pooled.push((observed, expected, rect));
            }
        }
        // Counts that no expectation is left for go to the smallest cell; `stray` speaks for them too.
        match pooled.first_mut() {
            Some(first) => *first = (first.0 + pool.0, first.1 + pool.1, first.2),
            None => pooled.push(pool),
        }

        let excess = |&(o, e, _): &(f64, f64, Option<Rect>)| if e > 0.0 { (o - e) * (o - e) / e } else { 0.0 };
        let statistic = pooled.iter().map(excess).sum();
        let dof = pooled.len() - 1;
        let worst = pooled.iter().max_by(|a, b| excess(a).total_cmp(&excess(b))).map(|&(observed, expected, rect)| WorstCell {
            point: rect.map_or("no point".into(), |r| format!("{:?}", domain.point_at(r.center()[0], r.center()[1]).0)),
            rect: rect.unwrap_or(Rect { min: [0.0; 2], max: [1.0; 2] }),
            observed,
            expected,
        });
        let p_value = special::chi_square_p(statistic, dof as f64);
        ChiSquare { statistic, dof, p_value, samples: n, absorbed, mass: self.mass, outside, stray, invalid, worst }
    }
}

impl ChiSquare {
    /// Whether ∫p agrees with the share of draws that gave a point, to six standard errors and the quadrature's tolerance.
    pub fn mass_agrees(&self) -> bool {
        let n = self.samples as f64;
        let given = 1.0 - self.absorbed as f64 / n;
        let m = self.mass.clamp(0.0, 1.0);
        (given - self.mass).abs() <= MASS_TOLERANCE + 6.0 * (m * (1.0 - m) / n).sqrt()
    }

    /// Whether nothing is wrong at the significance `alpha`: a right sampler fails with that probability.
    ///
    /// A few points in 10⁵ may fall where p has rounded to zero.
    pub fn passes(&self, alpha: f64) -> bool {
        let stray_allowed = 1 + self.samples / 50_000;
        self.p_value >= alpha && self.mass_agrees() && self.outside == 0 && self.invalid == 0 && self.stray <= stray_allowed
    }
}

impl fmt::Display for ChiSquare {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { statistic, dof, p_value, samples, absorbed, mass, outside, stray, invalid, .. } = self;
        write!(f, "chi-square: X² = {statistic:.1}, {dof} degrees of freedom, p = {p_value:.3e}; {samples} draws, ")?;
        write!(
            f,
            "{absorbed} gave no point, {outside} fell outside, {stray} where the density is zero, {invalid} where it is invalid; ∫p = {mass:.6}"
        )?;
        if !self.mass_agrees() {
            write!(
                f,
                ", which disagrees with the share of draws that gave a point, {:.6}",
                1.0 - *absorbed as f64 / *samples as f64
            )?;
        }
        if let Some(WorstCell { point, rect, observed, expected }) = &self.worst {
            write!(f, "; worst cell at {point}: {observed} drawn, {expected:.1} expected")?;
            write!(f, " (s in {:.4}..{:.4}, t in {:.4}..{:.4})", rect.min[0], rect.max[0], rect.min[1], rect.max[1])?;
        }
        Ok(())
    }
}

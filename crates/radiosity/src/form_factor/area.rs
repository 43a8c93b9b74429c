//! `area`: the double integral of G/π over both patches, by quadrature.
//!
//! ```text
//! A_i F_ij = ∫_i ∫_j V(x, y) cosθx cosθy / (π r²) dA dA
//! ```
//!
//! Both patches are cut in four again and again, the larger one first, until they are further apart than they are large: there Gauss-Legendre
//! points do. Where patches touch G has no bound, but what is left shrinks with the strip along the edge in common; it ends at
//! [`FINEST`] of the size. Where some rays between the points are blocked and others not, both are cut until what hangs on it is small.
//!
//! Points at fixed places miss what is small, and take sides in shadows that lie along them. So the last pieces are judged by random points, of
//! two halves that judge each other:
//!
//! ```text
//! mean of V g + β (q - g),    β the part of the other half's light that gets through
//! ```
//!
//! with q the quadrature without V. That is q where all gets through, nothing where nothing does, and without bias in between.

use super::visible::Between;
use crate::patch::{Chart, PatchPoint, Patches, Span};
use crate::quadrature::gauss;
use arrayvec::ArrayVec;
use etendue_numerics::warp::square_to_triangle;
use etendue_numerics::{Net4, Vec2};
use glam::{DVec2, DVec3};
use std::cell::Cell;
use std::f64::consts::PI;

/// Distance over the sum of both radii beyond which points suffice.
const APART: f64 = 1.5;

/// Size of the smallest pieces that touch, in sizes of their patches.
const FINEST: f64 = 1.0 / 512.0;

/// Points along a side of the smallest pieces that touch: by 3 and 3 walls of a room would give each other 1e-3 of their light too much.
const TOUCHING: [usize; 2] = [5, 4];

/// Pieces whose visibility is mixed are cut until this part of the smaller patch's light hangs on them.
const MIXED: f64 = 3e-5;

/// Rays between two pieces that are not cut any further.
const RAYS: usize = 8;

/// Pieces through which more than this part of it goes are cut in any case where something may be in the way.
const LARGE: f64 = 1e-4;

/// The same for pieces that the plane of the other cuts, where G does not jump but bends.
const HORIZON: f64 = 1e-4;

/// A quadrature point: a point of a patch with its area, m².
struct Node {
    p: DVec3,
    n: DVec3,
    area: f64,
}

/// A piece of a patch.
#[derive(Clone, Copy)]
struct Piece<'a> {
    chart: &'a Chart,
    span: Span,
    patch: u32,
    sign: f64,
    /// Of a triangle the last is the first again.
    corners: [DVec3; 4],
    middle: DVec3,
    radius: f64,
    area: f64,
}

impl<'a> Piece<'a> {
    fn new(chart: &'a Chart, span: Span, patch: u32, sign: f64) -> Self {
        let middle = chart.point(span.middle(chart));
        let mut corners = span.corners().map(|st| chart.point(st));
        if chart.is_triangle() {
            corners[2] = corners[0];
        }
        let reach = corners.iter().map(|p| p.distance(middle)).fold(0.0, f64::max);
        let radius =
            if matches!(chart, Chart::Round { .. }) && span.size.max_element() > 0.25 { 1.5 * reach } else { 1.05 * reach };
        Self { chart, span, patch, sign, corners, middle, radius, area: chart.area(&span) }
    }

    /// How far `other` reaches below and above the plane of this piece, if it is flat.
    fn heights(&self, other: &Self) -> Option<(f64, f64)> {
        let n = self.chart.normal(DVec2::ZERO) * self.sign;
        let heights = other.corners.map(|p| (p - self.middle).dot(n));
        let flat = self.chart.is_flat() && !matches!(other.chart, Chart::Round { .. });
        flat.then(|| heights.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), h| (low.min(*h), high.max(*h))))
    }

    /// Whether all of `other` lies behind its plane.
    fn is_behind(&self, other: &Self) -> bool {
        self.heights(other).is_some_and(|(_, high)| high <= 1e-9 * other.radius)
    }

    /// Whether its plane cuts `other`.
    fn cuts(&self, other: &Self) -> bool {
        self.heights(other).is_some_and(|(low, high)| low < -1e-6 * other.radius && high > 1e-6 * other.radius)
    }

    fn quarters(&self) -> [Self; 4] {
        self.span.quarters(self.chart.is_triangle()).map(|span| Self::new(self.chart, span, self.patch, self.sign))
    }

    /// A point at random: u uniform in the unit square.
    fn node(&self, u: Vec2) -> Node {
        let (local, area) = if self.chart.is_triangle() {
            let [_, b1, b2] = square_to_triangle(u);
            (DVec2::new(b1.into(), b2.into()), Some(self.area))
        } else {
            (u.as_dvec2(), None)
        };
        let st = self.span.global(local);
        let area = area.unwrap_or_else(|| self.chart.stretch(st) * (self.span.size.x * self.span.size.y).abs());
        Node { p: self.chart.point(st), n: self.chart.normal(st) * self.sign, area }
    }

    /// n x n points; of triangles by squeezing the square's side t = 1 to a point.
    fn nodes(&self, n: usize) -> ArrayVec<Node, 81> {
        let rule = gauss(n);
        let pairs = rule.iter().flat_map(|x| rule.iter().map(move |y| (x, y)));
        pairs
            .map(|((x, wx), (y, wy))| {
                let (local, squeeze) =
                    if self.chart.is_triangle() { (DVec2::new(x * (1.0 - y), *y), 1.0 - y) } else { (DVec2::new(*x, *y), 1.0) };
                let st = self.span.global(local);
                let area = wx * wy * squeeze * self.chart.stretch(st) * (self.span.size.x * self.span.size.y).abs();
                Node { p: self.chart.point(st), n: self.chart.normal(st) * self.sign, area }
            })
            .collect()
    }
}

/// A sum with its standard error, squared.
#[derive(Clone, Copy, Default)]
pub(crate) struct Sum {
    pub value: f64,
    pub variance: f64,
}

/// A_i F_ij, m². With `between` rays are tested for what stands between.
pub(crate) fn exchange(patches: &Patches, i: u32, j: u32, between: Option<&Between>) -> Sum {
    let piece = |k: u32| {
        let (span, chart) = patches.geometry(k);
        Piece::new(chart, *span, k, patches.get(k).side.sign())
    };
    let (a, b) = (piece(i), piece(j));
    let mut sum = Sum::default();
    // On one round shape the integrand is smooth, touching or not: 9 and 8 points never meet.
    if std::ptr::eq(a.chart, b.chart) && !a.chart.is_flat() {
        let seen = points(&a, &b, [9, 8], between);
        if seen.clear == seen.all || between.is_none() {
            sum.value = seen.clear;
            return sum;
        }
    }
    let job = Job {
        between,
        finest: [a.radius * FINEST, b.radius * FINEST],
        smaller: a.area.min(b.area),
        seed: u64::from(i) << 32 | u64::from(j),
        leaves: Cell::new(0),
    };
    job.cut(&a, &b, &mut sum);
    sum
}

/// What does not change while two patches are cut.
struct Job<'a> {
    between: Option<&'a Between<'a>>,
    /// Radii below which pieces are not cut.
    finest: [f64; 2],
    /// Area of the smaller patch, m².
    smaller: f64,
    /// Of random points, and how many pieces have had some.
    seed: u64,
    leaves: Cell<u64>,
}

impl Job<'_> {
    /// Adds the exchange between two pieces.
    fn cut(&self, a: &Piece, b: &Piece, sum: &mut Sum) {
        if a.is_behind(b) || b.is_behind(a) {
            return;
        }
        let distance = a.middle.distance(b.middle);
        let small = [a.radius <= self.finest[0], b.radius <= self.finest[1]];
        let apart = distance > APART * (a.radius + b.radius);
        if apart || small == [true; 2] {
            // What of the smaller patch's light goes this way at most.
            let flow = (a.area * b.area / (PI * distance * distance)).min(a.area.min(b.area)) / self.smaller;
            let done = flow < MIXED || small == [true; 2];
            // What is in the way may be small: large pieces are never taken for clear by the look of a few rays.
            if self.between.is_some() && flow > LARGE && !done {
                return self.halve(a, b, small, sum);
            }
            let seen = points(a, b, [2, 2], self.between.filter(|_| !done));
            let mixed = seen.clear > 0.0 && seen.clear < seen.all;
            let horizon = seen.cut_by_horizon || a.cuts(b) || b.cuts(a);
            if done || !mixed && (!horizon || flow < HORIZON) {
                let all = match distance / (a.radius + b.radius) {
                    6.0.. => seen.all,
                    APART.. => points(a, b, [3, 3], None).all,
                    _ => points(a, b, TOUCHING, None).all,
                };
                self.by_rays(a, b, all, sum);
            } else {
                self.halve(a, b, small, sum);
            }
        } else {
            self.halve(a, b, small, sum);
        }
    }

    /// Adds what gets through between two pieces, of `all` if nothing is in the way.
    fn by_rays(&self, a: &Piece, b: &Piece, all: f64, sum: &mut Sum) {
        let Some(between) = self.between else {
            sum.value += all;
            return;
        };
        self.leaves.set(self.leaves.get() + 1);
        // g and V g of each pair of points, one half after the other.
        let pairs: ArrayVec<(f64, f64), RAYS> = Net4::new(self.seed, self.leaves.get())
            .take(RAYS)
            .map(|[u, v, s, t]| {
                let (x, y) = (a.node(Vec2::new(u, v)), b.node(Vec2::new(s, t)));
                let g = flow(&x, &y).unwrap_or(0.0);
                (g, if g > 0.0 && sees(between, (a, &x), (b, &y)) { g } else { 0.0 })
            })
            .collect();
        let (first, second) = pairs.split_at(RAYS / 2);
        let part = |half: &[(f64, f64)]| {
            let (g, vg) = half.iter().fold((0.0, 0.0), |s, p| (s.0 + p.0, s.1 + p.1));
            if g > 0.0 { vg / g } else { 1.0 }
        };
        let n = RAYS as f64;
        let (mut value, mut squares) = (0.0, 0.0);
        for (half, beta) in [(first, part(second)), (second, part(first))] {
            for (g, vg) in half {
                let term = vg + beta * (all - g);
                value += term / n;
                squares += term * term / n;
            }
        }
        sum.value += value;
        sum.variance += (squares - value * value).max(0.0) / (n - 1.0);
    }

    /// Cuts the larger piece.
    fn halve(&self, a: &Piece, b: &Piece, small: [bool; 2], sum: &mut Sum) {
        if small[1] || a.radius >= b.radius && !small[0] {
            a.quarters().iter().for_each(|a| self.cut(a, b, sum));
        } else {
            b.quarters().iter().for_each(|b| self.cut(a, b, sum));
        }
    }
}

/// The exchange by quadrature points, m².
#[derive(Default)]
struct Seen {
    /// As if nothing were between.
    all: f64,
    /// Between points that see each other.
    clear: f64,
    /// Some points are behind the others, some are not.
    cut_by_horizon: bool,
}

/// n x n points of one piece with m x m of the other.
fn points(a: &Piece, b: &Piece, [n, m]: [usize; 2], between: Option<&Between>) -> Seen {
    let (xs, ys) = (a.nodes(n), b.nodes(m));
    let mut seen = Seen::default();
    let mut behind = false;
    for x in &xs {
        for y in &ys {
            let Some(flow) = flow(x, y) else {
                behind = true;
                continue;
            };
            seen.all += flow;
            if between.is_none_or(|v| sees(v, (a, x), (b, y))) {
                seen.clear += flow;
            }
        }
    }
    seen.cut_by_horizon = behind && seen.all > 0.0;
    seen
}

/// G/π dA dA between two points, m²; `None` where one is behind the other.
fn flow(x: &Node, y: &Node) -> Option<f64> {
    let d = y.p - x.p;
    let (r2, cos_x, cos_y) = (d.length_squared(), d.dot(x.n), -d.dot(y.n));
    (cos_x > 0.0 && cos_y > 0.0).then(|| cos_x * cos_y / (PI * r2 * r2) * x.area * y.area)
}

/// V.
fn sees(between: &Between, (a, x): (&Piece, &Node), (b, y): (&Piece, &Node)) -> bool {
    let point = |node: &Node| PatchPoint { p: node.p, n: node.n, st: DVec2::ZERO, weight: 1.0 };
    between.sees((a.patch, &point(x)), (b.patch, &point(y)))
}

//! Which clusters are linked: those whose link is wrong by no more than its noise, or than a threshold.
//!
//! ```text
//! A_i F_ij ≈ Σ g over rays between i and j,   g = A_i A_j / (A_i + A_j) / N      both ways pooled, each weighted by the inverse of its variance
//! k = Σ g / (A_R A_S) over the n rays between R and S
//! split (R, S) where   ε √n > 1   and   ε G (ρ_R B_S + ρ_S B_R) > threshold,       G = Σ g
//! ```
//!
//! ε is how K varies over the pair, relative to its mean: by distance and angles, (r_R + r_S) / d + (turn_R + turn_S) / 2, and by what stands between,
//! √((1 - v) / v), where v is the part of the exchange that got through. k itself has a relative error of 1/√n, so a split gains nothing where
//! ε √n ≤ 1: with more rays links get finer of themselves. The threshold counts brightness, as BFA refinement does [Hanrahan, Salzman,
//! Aupperle 1991, §3]: what is dark is linked coarsely.
//!
//! That a ray finds the level of its link by itself, and no pair is looked at that no ray has gone between, is of hierarchical Monte Carlo radiosity
//! [Bekaert, Neumann, Neumann, Sbert, Willems 1998]. So the work is that of sorting the rays: N n of them through the levels of the tree.

use super::Link;
use super::rays::Sample;
use super::tree::{Node, Tree};
use glam::{DVec3, DVec4};

/// Pairs with fewer rays are the work of one thread.
const ALONE: usize = 1 << 13;

/// What refinement knows of the light of a cluster, sums over channels.
#[derive(Clone, Copy, Debug, Default)]
pub struct Light {
    /// A, m².
    pub area: f32,
    /// Mean B by area, W/m².
    pub b: f32,
    /// Mean ρ by area.
    pub rho: f32,
}

/// The light of all clusters, for radiosities b.
pub fn lights(tree: &Tree, areas: &[f64], rho: &[DVec3], b: &[DVec3]) -> Vec<Light> {
    let leaf = |i: u32| {
        let i = i as usize;
        DVec4::new(1.0, b[i].element_sum(), rho[i].element_sum() / 3.0, 0.0) * areas[i]
    };
    let of = |s: DVec4| Light { area: s.x as f32, b: (s.y / s.x) as f32, rho: (s.z / s.x) as f32 };
    tree.sums(leaf, DVec4::ZERO).into_iter().map(of).collect()
}

/// Makes links of rays.
pub struct Refinement<'a> {
    pub tree: &'a Tree,
    pub lights: &'a [Light],
    /// Whole areas of the leaves, m².
    pub areas: &'a [f32],
    /// Rays a leaf.
    pub rays: usize,
    /// W over channels.
    pub threshold: f32,
}

impl Refinement<'_> {
    /// The links of all rays between leaves of one tree; the rays are sorted on the way. Those between the two trees are left out.
    pub fn links(&self, samples: &mut [Sample]) -> Vec<Link> {
        let [Some(dark), bright] = self.tree.roots else {
            return self.tree.roots[1].map_or(Vec::new(), |bright| self.descend([bright; 2], samples));
        };
        let middle = self.tree.nodes[dark as usize].end;
        samples.iter_mut().for_each(|s| s.sort_unstable());
        let (dark_rays, rest) = part(samples, |s| s[1] < middle);
        let (_, bright_rays) = part(rest, |s| s[0] < middle);
        let mut links = self.descend([dark; 2], dark_rays);
        links.extend(bright.into_iter().flat_map(|bright| self.descend([bright; 2], bright_rays)));
        links
    }

    /// The links within a pair of clusters, whose rays go from the first to the second.
    fn descend(&self, ends: [u32; 2], samples: &mut [Sample]) -> Vec<Link> {
        let mut links = Vec::new();
        self.descend_into(ends, samples, &mut links);
        links
    }

    fn descend_into(&self, ends: [u32; 2], samples: &mut [Sample], links: &mut Vec<Link>) {
        let [r, s] = ends.map(|k| &self.tree.nodes[k as usize]);
        if samples.is_empty() {
            return;
        }
        if ends[0] == ends[1] {
            if r.is_leaf() {
                links.push(Link { ends, k: 2.0 * self.mean(ends, samples) });
                return;
            }
            let [c, d] = self.tree.children(ends[0]);
            let middle = self.tree.nodes[d as usize].begin;
            samples.iter_mut().for_each(|s| s.sort_unstable());
            let (first, rest) = part(samples, |s| s[1] < middle);
            let (across, second) = part(rest, |s| s[0] < middle);
            self.both(([c, c], first), ([d, d], second), links);
            return self.descend_into([c, d], across, links);
        }
        if r.is_leaf() && s.is_leaf() || !self.splits(ends, r, s, samples.len()) {
            links.push(Link { ends, k: self.mean(ends, samples) });
            return;
        }
        let apart = (r.middle() - s.middle()).length();
        let size = |n: &Node| n.radius() + n.spread * apart;
        let end = usize::from(r.is_leaf() || !s.is_leaf() && size(s) > size(r));
        let [c, d] = self.tree.children(ends[end]);
        let middle = self.tree.nodes[d as usize].begin;
        let (first, second) = part(samples, |s| s[end] < middle);
        let of = |child: u32| if end == 0 { [child, ends[1]] } else { [ends[0], child] };
        self.both((of(c), first), (of(d), second), links);
    }

    /// Two pairs, one after the other in the list of links.
    fn both(&self, a: ([u32; 2], &mut [Sample]), b: ([u32; 2], &mut [Sample]), links: &mut Vec<Link>) {
        if a.1.len() + b.1.len() < ALONE {
            self.descend_into(a.0, a.1, links);
            self.descend_into(b.0, b.1, links);
        } else {
            let (first, second) = rayon::join(|| self.descend(a.0, a.1), || self.descend(b.0, b.1));
            links.extend(first);
            links.extend(second);
        }
    }

    /// k.
    fn mean(&self, ends: [u32; 2], samples: &[Sample]) -> f32 {
        let [r, s] = ends.map(|k| f64::from(self.lights[k as usize].area));
        let g = |s: &Sample| {
            let [a, b] = s.map(|k| f64::from(self.areas[k as usize]));
            a * b / (a + b)
        };
        (samples.iter().map(g).sum::<f64>() / (self.rays as f64 * r * s)) as f32
    }

    /// Whether a pair with `n` rays is to be split.
    fn splits(&self, ends: [u32; 2], r: &Node, s: &Node, n: usize) -> bool {
        let [l, m] = ends.map(|k| &self.lights[k as usize]);
        let each = |node: &Node, light: &Light| light.area / (node.end - node.begin) as f32;
        let (a, b) = (each(r, l), each(s, m));
        let exchange = n as f32 * a * b / (a + b) / self.rays as f32;
        let d = s.middle() - r.middle();
        let d2 = d.length_squared();
        let mut varies = ((r.radius() + s.radius()) / d2.sqrt() + 0.5 * (r.spread + s.spread)).min(FAR);
        if varies < 1.0 {
            let clear = r.axis.dot(d) * -s.axis.dot(d) / (std::f32::consts::PI * d2 * d2) * l.area * m.area;
            let through = (exchange / clear.max(exchange)).min(1.0);
            varies += ((1.0 - through) / through).sqrt();
        }
        varies * varies * n as f32 > NOISE && varies * exchange * (l.rho * m.b + m.rho * l.b) > self.threshold
    }
}

/// The most that K is said to vary by distance and angles.
const FAR: f32 = 4.0;

/// The square of ε √n at which a split is due.
const NOISE: f32 = 1.0;

/// Those of which something holds, and the others.
fn part(samples: &mut [Sample], holds: impl Fn(&Sample) -> bool) -> (&mut [Sample], &mut [Sample]) {
    let mut n = 0;
    for k in 0..samples.len() {
        if holds(&samples[k]) {
            samples.swap(n, k);
            n += 1;
        }
    }
    samples.split_at_mut(n)
}

//! Which vertices of light paths lie within a radius of a point: a hash grid [Teschner et al. 2003].
//!
//! ```text
//! cell(p) = ⌊p / 2r⌋        the ball of radius r around a point meets 2 × 2 × 2 cells
//! ```
//!
//! The vertices are sorted by bucket, those of a bucket by number, so that the index and every sum over it do not depend on threads. Cells that are
//! neighbours along x have neighbouring buckets. Different cells may share a bucket: the distance tells their vertices apart.
//!
//! The index knows positions alone: what is kept of a vertex is the caller's, a photon or a whole [`crate::bidirectional::PathVertex`].

use etendue_numerics::Vec3;
use rayon::prelude::*;

/// Vertices by place. Built anew in the same memory.
#[derive(Clone, Debug, Default)]
pub struct VertexIndex {
    radius: f32,
    /// How far from a point cells are looked at: the radius, and what rounding may do to coordinates.
    reach: f32,
    /// 1 / edge of a cell.
    per_edge: f32,
    /// Bucket b holds the places `starts[b]..starts[b + 1]`.
    starts: Vec<u32>,
    /// The points by place.
    points: Vec<Vec3>,
    /// Their numbers, by place.
    numbers: Vec<u32>,
    /// Their buckets, by number.
    buckets: Vec<u32>,
}

/// Buckets of a query: two cells along each axis, three where rounding says so.
const MOST: usize = 27;

impl VertexIndex {
    /// Sorts `points` for queries of the given radius; fewer than 2³² of them.
    pub fn build(&mut self, points: &[Vec3], radius: f32) {
        let largest = points.par_iter().map(|p| p.abs().max_element()).reduce(|| 0.0, f32::max);
        (self.radius, self.reach) = (radius, 1.001 * radius + 1e-6 * largest);
        self.per_edge = 1.0 / (2.1 * self.reach);
        // A bucket for each point, or somewhat more.
        let buckets = points.len().next_power_of_two().max(1);
        self.starts.clear();
        self.starts.resize(buckets + 1, 0);
        let mut of = std::mem::take(&mut self.buckets);
        points.par_iter().map(|p| self.bucket(self.cell(*p))).collect_into_vec(&mut of);

        // Counting sort: counts, their sums, and every point to its place, first come, first served.
        of.iter().for_each(|b| self.starts[*b as usize] += 1);
        let mut sum = 0;
        for start in &mut self.starts {
            sum += std::mem::replace(start, sum);
        }
        self.points.clear();
        self.points.resize(points.len(), Vec3::ZERO);
        self.numbers.clear();
        self.numbers.resize(points.len(), 0);
        for (number, b) in of.iter().enumerate() {
            let place = &mut self.starts[*b as usize];
            self.points[*place as usize] = points[number];
            self.numbers[*place as usize] = number as u32;
            *place += 1;
        }
        self.buckets = of;
        // Every start has moved to its bucket's end.
        self.starts.rotate_right(1);
        self.starts[0] = 0;
    }

    /// The radius of queries.
    pub fn radius(&self) -> f32 {
        self.radius
    }

    /// The points' numbers, by place.
    pub fn numbers(&self) -> &[u32] {
        &self.numbers
    }

    /// The point at a place.
    #[inline]
    pub fn point(&self, place: usize) -> Vec3 {
        self.points[place]
    }

    /// Hands over the place of every point within the radius of `p`, and its distance squared.
    #[inline]
    pub fn near(&self, p: Vec3, mut found: impl FnMut(usize, f32)) {
        let (low, high) = (self.cell(p - self.reach), self.cell(p + self.reach));
        let along = |i: usize| low[i]..=high[i].min(low[i].saturating_add(2));
        let (mut seen, mut count) = ([0u32; MOST], 0);
        for z in along(2) {
            for y in along(1) {
                for x in along(0) {
                    let b = self.bucket([x, y, z]);
                    if seen[..count].contains(&b) {
                        continue;
                    }
                    seen[count] = b;
                    count += 1;
                    let places = self.starts[b as usize] as usize..self.starts[b as usize + 1] as usize;
                    for (place, q) in places.clone().zip(&self.points[places]) {
                        let d2 = p.distance_squared(*q);
                        if d2 < self.radius * self.radius {
                            found(place, d2);
                        }
                    }
                }
            }
        }
    }

    #[inline]
    fn cell(&self, p: Vec3) -> [i32; 3] {
        let cell = (p * self.per_edge).floor();
        [cell.x as i32, cell.y as i32, cell.z as i32]
    }

    #[inline]
    fn bucket(&self, [x, y, z]: [i32; 3]) -> u32 {
        let row = (y as u32).wrapping_mul(0x9e37_79b1) ^ (z as u32).wrapping_mul(0x85eb_ca77);
        let row = (row ^ row >> 15).wrapping_mul(0x2c1b_3c6d);
        row.wrapping_add(x as u32) & (self.starts.len() as u32 - 2)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use etendue_numerics::{Dim, Sampler, SequenceKind, Vec2};

    fn cloud(seed: u64, count: u32, place: impl Fn(Vec2, f32) -> Vec3) -> Vec<Vec3> {
        let u = |i| Sampler::new(SequenceKind::Independent, seed, 0, i, count);
        (0..count).map(|i| place(u(i).u2(Dim(0)), u(i).u1(Dim(1)))).collect()
    }

    /// The same points as by looking at all of them: spread, on a plane, all at one place, far from the origin, far apart.
    #[test]
    fn finds_what_is_near() {
        let spread = cloud(1, 2000, |a, b| 2.0 * Vec3::new(a.x, a.y, b) - 1.0);
        let clouds = [
            ("spread", spread.clone(), 0.2),
            ("plane", cloud(2, 2000, |a, _| Vec3::new(a.x, -1.0, a.y)), 0.05),
            ("one place", vec![Vec3::splat(0.3); 50], 0.1),
            ("far", cloud(3, 500, |a, b| Vec3::new(1e4, -2e4, 3e3) + 0.5 * Vec3::new(a.x, a.y, b)), 0.1),
            ("few cells", spread, 3.0),
            ("apart", cloud(4, 300, |a, b| 1e6 * (Vec3::new(a.x, a.y, b) - 0.5)), 0.01),
            ("lattice", (0..4096).map(|i| Vec3::new((i & 15) as f32, (i >> 4 & 15) as f32, (i >> 8) as f32)).collect(), 1.0),
            ("none", Vec::new(), 1.0),
        ];
        let mut index = VertexIndex::default();
        for (name, points, radius) in clouds {
            index.build(&points, radius);
            let mut total = 0;
            for p in points.iter().step_by(7).copied().chain([Vec3::ZERO]) {
                let mut found = Vec::new();
                index.near(p, |place, d2| {
                    assert!(
                        d2 == p.distance_squared(index.point(place))
                            && index.point(place) == points[index.numbers()[place] as usize]
                    );
                    found.push(index.numbers()[place]);
                });
                found.sort_unstable();
                let all = (0..points.len() as u32).filter(|i| p.distance_squared(points[*i as usize]) < radius * radius);
                assert_eq!(found, all.collect::<Vec<_>>(), "{name} at {p}");
                total += found.len();
            }
            assert!(points.is_empty() || total >= points.len().div_ceil(7), "{name}");
        }
    }
}

//! A density over directions that knows parallax: light is looked for where it left, not in the direction in which it arrived elsewhere [Ruppert et al. 2020].
//!
//! ```text
//! p(wi) = 1/n Σ_t [ |wi × (y_t - x)| ≤ r_t,  wi · (y_t - x) ≥ 0 ] / (2π h_t),        1/h_t = q + √(q² - q),    q = max(1, |y_t - x|²/r_t²)
//! ```
//!
//! Each of n = 64 targets y_t is a ball, sampled by solid angle, 2π h_t, 1/h_t being 1/(1 - cosθ); seen from within it is half of all directions. Balls reach as far as the eighth nearest target, as seen from
//! the middle of the places that they stand for.

use etendue_numerics::math::{PI, sin_cos};
use etendue_numerics::{Frame, Vec2, Vec3};
use serde::{Deserialize, Serialize};

/// n.
const COUNT: usize = ROWS * WIDE;
/// They stand in rows.
const ROWS: usize = 2;
const WIDE: usize = 32;
/// Which of the nearest targets a ball reaches to.
const NEAR: usize = 8;
/// Its radius over its distance, at least and at most.
const LEAST: f32 = 0.02;
const MOST: f32 = 1.0;

/// The targets.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Targets {
    /// y_t: x, y and z.
    y: [[[f32; WIDE]; 3]; ROWS],
    /// 1/r_t².
    over_r2: [[f32; WIDE]; ROWS],
}

impl Targets {
    /// Those of light that left at some places, and how much, for places around `middle`: each as likely as any other to stand for a part of it.
    pub fn new(left: &[(Vec3, f32)], middle: Vec3) -> Self {
        let mut targets = Self { y: [[[0.0; WIDE]; 3]; ROWS], over_r2: [[1.0; WIDE]; ROWS] };
        let all: f64 = left.iter().map(|(_, flux)| f64::from(*flux)).sum();
        let mut waiting = left.iter();
        let (mut y, mut below) = (Vec3::ZERO, 0.0);
        for t in 0..COUNT {
            while below <= all * (t as f64 + 0.5) / COUNT as f64
                && let Some((p, flux)) = waiting.next()
            {
                (y, below) = (*p, below + f64::from(*flux));
            }
            let [a, b, c] = &mut targets.y[t / WIDE];
            (a[t % WIDE], b[t % WIDE], c[t % WIDE]) = y.into();
        }
        let to: Vec<Vec3> = (0..COUNT).map(|t| targets.at(t) - middle).collect();
        let d: Vec<Vec3> = to.iter().map(|to| to.normalize_or_zero()).collect();
        for t in 0..COUNT {
            let mut apart: Vec<f32> = d.iter().map(|e| (*e - d[t]).length()).collect();
            apart.sort_by(f32::total_cmp);
            let r = apart[NEAR].clamp(LEAST, MOST) * to[t].length();
            targets.over_r2[t / WIDE][t % WIDE] = 1.0 / (r * r).max(1e-12);
        }
        targets
    }

    fn at(&self, t: usize) -> Vec3 {
        let [a, b, c] = &self.y[t / WIDE];
        Vec3::new(a[t % WIDE], b[t % WIDE], c[t % WIDE])
    }

    /// y_t - x, and 1/h_t.
    #[inline(always)]
    fn cap(&self, row: usize, t: usize, x: Vec3) -> (Vec3, f32) {
        let [a, b, c] = &self.y[row];
        let to = Vec3::new(a[t] - x.x, b[t] - x.y, c[t] - x.z);
        let q = (to.length_squared() * self.over_r2[row][t]).max(1.0);
        (to, q + (q * (q - 1.0)).sqrt())
    }

    /// p(wi) at x, 1/sr.
    #[inline(always)]
    pub fn pdf(&self, x: Vec3, wi: Vec3) -> f32 {
        let mut found = [0.0f32; WIDE];
        for row in 0..ROWS {
            for (t, found) in found.iter_mut().enumerate() {
                let (to, over_h) = self.cap(row, t, x);
                let within = (wi.cross(to).length_squared() * self.over_r2[row][t] <= 1.0) & (wi.dot(to) >= 0.0);
                *found += if within { over_h } else { 0.0 };
            }
        }
        // In a fixed order, pair by pair, which vectors can do.
        let mut half = WIDE / 2;
        while half > 0 {
            for t in 0..half {
                found[t] += found[t + half];
            }
            half /= 2;
        }
        found[0] / (2.0 * PI * COUNT as f32)
    }

    /// A direction wi, and p(wi) at x, 1/sr.
    #[inline(always)]
    pub fn sample(&self, x: Vec3, u: Vec2) -> (Vec3, f32) {
        let place = u.x * COUNT as f32;
        let t = (place as usize).min(COUNT - 1);
        let (to, over_h) = self.cap(t / WIDE, t % WIDE, x);
        let below = (place - t as f32) / over_h;
        let (sin, cos) = sin_cos(2.0 * PI * u.y);
        let r = (below * (2.0 - below)).max(0.0).sqrt();
        let wi = Frame::from_normal(to / to.length().max(1e-10)).to_world(Vec3::new(r * cos, r * sin, 1.0 - below));
        (wi, self.pdf(x, wi))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use etendue_check::{ChiSquareTest, Sphere};
    use etendue_numerics::{Dim, Sampler, SequenceKind};

    /// Light from one place, from a wall, from all around, and of very different strengths; 1 % of false alarms over all.
    #[test]
    fn samples_follow_the_density() {
        let u = |i: u32| Sampler::new(SequenceKind::Independent, 7, 0, i, 1000).u2(Dim(0));
        let wall = |i: u32| Vec3::new(4.0 * u(i).x - 2.0, 4.0 * u(i).y - 2.0, 2.0);
        let cases = [
            ("place", Vec3::new(0.3, -0.2, 0.4), vec![(Vec3::new(1.0, 2.0, 3.0), 1.0)]),
            ("wall", Vec3::new(0.0, 0.0, 1.95), (0..500).map(|i| (wall(i), 1.0)).collect::<Vec<_>>()),
            ("weights", Vec3::ZERO, (0..500).map(|i| (wall(i), 1e-4 + u(i).x.powi(8))).collect()),
            ("around", Vec3::new(0.3, -0.2, 0.4), (0..500).map(|i| (wall(i) * if i % 2 == 0 { 1.0 } else { -1.0 }, 1.0)).collect()),
        ];
        for (name, x, left) in cases {
            let targets = Targets::new(&left, Vec3::ZERO);
            let found = ChiSquareTest::new(Sphere)
                .run(|[a, b, _]| Some(targets.sample(x, Vec2::new(a, b)).0), |wi: Vec3| targets.pdf(x, wi));
            assert!(found.p_value > 0.01 / 4.0 && (found.mass - 1.0).abs() < 2e-2, "{name}: {found:?}");
        }
    }
}

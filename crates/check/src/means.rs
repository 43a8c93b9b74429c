//! Do means agree? Student's t, the normal z, and three verdicts.
//!
//! ```text
//! t = (x̄ - μ) / (s/√n),    Welch: t = (x̄ - ȳ) / √(s_x²/n_x + s_y²/n_y)
//! ```
//!
//! A test that finds no difference has not yet shown that there is none: the verdict is PASS only where the confidence interval is
//! so narrow that a bias as large as the stated bound would have been seen, else INCONCLUSIVE. Monte Carlo estimates from
//! low-discrepancy points enter as means of independently scrambled blocks, never point by point.

use crate::special::{student_p, student_quantile};
use std::fmt;

/// Count, mean and variance of a stream of numbers [Welford 1962].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Moments {
    /// How many.
    pub n: usize,
    /// Their mean.
    pub mean: f64,
    squares: f64,
}

impl Moments {
    /// One number more.
    pub fn add(&mut self, x: f64) {
        self.n += 1;
        let d = x - self.mean;
        self.mean += d / self.n as f64;
        self.squares += d * (x - self.mean);
    }

    /// The unbiased variance of one number; 0 for fewer than two.
    pub fn variance(&self) -> f64 {
        if self.n < 2 { 0.0 } else { self.squares / (self.n - 1) as f64 }
    }

    /// The standard error of the mean.
    pub fn standard_error(&self) -> f64 {
        (self.variance() / self.n.max(1) as f64).sqrt()
    }
}

impl FromIterator<f64> for Moments {
    fn from_iter<I: IntoIterator<Item = f64>>(numbers: I) -> Self {
        let mut m = Self::default();
        numbers.into_iter().for_each(|x| m.add(x));
        m
    }
}

/// A difference of means and what chance makes of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeanTest {
    /// Mean less expectation, or first mean less second.
    pub difference: f64,
    /// The standard error of the difference.
    pub standard_error: f64,
    /// Degrees of freedom; infinite for the z-test.
    pub dof: f64,
    /// The probability of a difference as large, were there none (two-sided).
    pub p_value: f64,
}

/// Many independent numbers (a few hundred at least) against an expectation.
pub fn z_test(moments: &Moments, expected: f64) -> MeanTest {
    MeanTest::new(moments.mean - expected, moments.standard_error(), f64::INFINITY)
}

/// A few independent, nearly normal numbers, such as means of blocks, against an expectation.
pub fn t_test(blocks: &Moments, expected: f64) -> MeanTest {
    MeanTest::new(blocks.mean - expected, blocks.standard_error(), blocks.n as f64 - 1.0)
}

/// Two sets of independent, nearly normal numbers against each other, variances free to differ [Welch 1947].
pub fn compare_means(a: &Moments, b: &Moments) -> MeanTest {
    let (va, vb) = (a.standard_error().powi(2), b.standard_error().powi(2));
    let freedom = |v: f64, m: &Moments| if v > 0.0 { v * v / (m.n as f64 - 1.0) } else { 0.0 };
    let dof = if va + vb > 0.0 { (va + vb).powi(2) / (freedom(va, a) + freedom(vb, b)) } else { 1.0 };
    MeanTest::new(a.mean - b.mean, (va + vb).sqrt(), dof)
}

/// Šidák's level: n independent tests, each at this level, raise at least one false alarm with probability `alpha`.
pub fn family_wise(alpha: f64, n: usize) -> f64 {
    // 1 - (1 - α)^(1/n), kept accurate for small α.
    -((-alpha).ln_1p() / n.max(1) as f64).exp_m1()
}

impl MeanTest {
    fn new(difference: f64, standard_error: f64, dof: f64) -> Self {
        let p_value = if standard_error > 0.0 {
            if dof > 0.0 { student_p(difference / standard_error, dof) } else { 1.0 }
        } else {
            // Without noise any difference beyond rounding is one. (Not a number is never none.)
            f64::from(u8::from(difference.abs() <= 1e-12))
        };
        Self { difference, standard_error, dof, p_value }
    }

    /// The verdict at significance `alpha`, where a bias of `bound` or more must not go unseen.
    pub fn verdict(&self, alpha: f64, bound: f64) -> Verdict {
        let half_width = if self.standard_error > 0.0 { student_quantile(alpha, self.dof) * self.standard_error } else { 0.0 };
        let interval = Interval { difference: self.difference, half_width, bound, p_value: self.p_value };
        if self.p_value < alpha || self.difference.is_nan() {
            Verdict::Fail(interval)
        } else if self.difference.abs() + half_width <= bound {
            Verdict::Pass(interval)
        } else {
            Verdict::Inconclusive(interval)
        }
    }
}

/// The figures of a verdict.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval {
    /// The difference found.
    pub difference: f64,
    /// Half the width of its confidence interval.
    pub half_width: f64,
    /// The bias that must not go unseen.
    pub bound: f64,
    /// The probability of such a difference by chance.
    pub p_value: f64,
}

/// What a test of means says.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Verdict {
    /// No difference, and one as large as the bound would have been seen.
    Pass(Interval),
    /// A difference that chance does not explain.
    Fail(Interval),
    /// No difference seen, but one as large as the bound could hide.
    Inconclusive(Interval),
}

impl Verdict {
    /// Whether it is a PASS; INCONCLUSIVE is never one.
    pub fn passes(&self) -> bool {
        matches!(self, Self::Pass(_))
    }

    /// Whether it is a FAIL.
    pub fn fails(&self) -> bool {
        matches!(self, Self::Fail(_))
    }

    /// The figures.
    pub fn interval(&self) -> Interval {
        match *self {
            Self::Pass(i) | Self::Fail(i) | Self::Inconclusive(i) => i,
        }
    }
}

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name = match self {
            Self::Pass(_) => "PASS",
            Self::Fail(_) => "FAIL",
            Self::Inconclusive(_) => "INCONCLUSIVE",
        };
        let Interval { difference, half_width, bound, p_value } = self.interval();
        write!(f, "{name}: difference {difference:.4e} ± {half_width:.2e}, bound {bound:.2e}, p = {p_value:.3e}")
    }
}

impl fmt::Display for MeanTest {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { difference, standard_error, dof, p_value } = self;
        write!(
            f,
            "difference {difference:.4e}, standard error {standard_error:.2e}, {dof:.1} degrees of freedom, p = {p_value:.3e}"
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng;

    #[test]
    fn tests_alarm_at_their_rate() {
        // 4000 right experiments at α = 5 %: alarms are binomial, mean 200, deviation 13.8; five deviations either way.
        let mut alarms = [0; 3];
        for seed in 0..4000 {
            let mut r = rng(seed);
            let mut block = |n: usize| -> Moments { (0..n).map(|_| (0..12).map(|_| r.u1_f64()).sum::<f64>()).collect() };
            let (many, few, other) = (block(300), block(16), block(40));
            alarms[0] += usize::from(z_test(&many, 6.0).p_value < 0.05);
            alarms[1] += usize::from(t_test(&few, 6.0).p_value < 0.05);
            alarms[2] += usize::from(compare_means(&few, &other).p_value < 0.05);
        }
        assert!(alarms.iter().all(|a| (131..=269).contains(a)), "{alarms:?}");
    }

    #[test]
    fn three_verdicts() {
        let mut r = rng(7);
        let m: Moments = (0..10_000).map(|_| r.u1_f64()).collect();
        let se = (1.0f64 / 12.0 / 10_000.0).sqrt();
        assert!((m.standard_error() - se).abs() < 0.05 * se);
        assert!(matches!(z_test(&m, 0.5).verdict(1e-6, 0.05), Verdict::Pass(_)));
        assert!(matches!(z_test(&m, 0.5).verdict(1e-6, 0.001), Verdict::Inconclusive(_)));
        assert!(matches!(z_test(&m, 0.53).verdict(1e-6, 0.05), Verdict::Fail(_)));
        // Without noise: equal or not. And a lost number is a failure.
        let constant: Moments = [2.0; 4].into_iter().collect();
        assert!(t_test(&constant, 2.0).verdict(0.01, 1e-9).passes());
        assert!(t_test(&constant, 2.1).verdict(0.01, 1e-9).fails());
        assert!(z_test(&[f64::NAN; 3].into_iter().collect(), 0.0).verdict(0.01, 1.0).fails());
    }

    #[test]
    fn a_family_alarms_as_one() {
        let level = family_wise(0.01, 100);
        assert!((1.0 - (1.0 - level).powi(100) - 0.01).abs() < 1e-12);
        assert!((family_wise(0.3, 1) - 0.3).abs() < 1e-15);
    }
}

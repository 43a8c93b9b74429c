//! Two samples, or a sample and known means, against each other: area by area, channel by channel, and one verdict of all.

use super::{Area, Sample};
use etendue_check::{MeanTest, Moments, Verdict as Single, compare_means, family_wise, student_p, student_quantile, t_test};
use serde::Serialize;
use std::fmt;

/// Contributions, all alike, that a mean must be worth to be compared: a standard error of 10 %. Means of fewer rare bright paths are
/// skewed, mostly too small, and so is their spread: Student's t would take that for a difference.
const ENOUGH: f64 = 100.0;
/// What rounding in f32 may do to the mean of long paths, relative.
const ROUNDING: f64 = 3e-6;

/// How strictly is judged.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Standard {
    /// Probability of a false alarm in the whole family of tests.
    pub alpha: f64,
    /// The bias of the whole picture that must not hide, relative.
    pub bound: f64,
    /// The bias of one block that must not hide, relative.
    pub block_bound: f64,
}

impl Default for Standard {
    /// α = 1 %, 2 % of the picture, 20 % of one of its blocks, which are noisier.
    fn default() -> Self {
        Self { alpha: 0.01, bound: 0.02, block_bound: 0.2 }
    }
}

impl Standard {
    /// Bounds that are so many times wider.
    #[must_use]
    pub fn widened(self, times: f64) -> Self {
        Self { bound: times * self.bound, block_bound: times * self.block_bound, ..self }
    }
}

/// What a test, or a family of tests, says.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "UPPERCASE")]
pub enum Verdict {
    /// No difference, and one as large as the bound would have been seen.
    Pass,
    /// No difference seen, but one as large as the bound could hide.
    Inconclusive,
    /// A difference that chance does not explain.
    Fail,
}

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::Pass => "PASS",
            Self::Inconclusive => "INCONCLUSIVE",
            Self::Fail => "FAIL",
        })
    }
}

/// One comparison of means. Differences are relative to `scale`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Finding {
    /// Where.
    pub area: Area,
    /// Channel: 0 red, 1 green, 2 blue.
    pub channel: usize,
    /// First mean less second (or less the known mean), relative.
    pub difference: f64,
    /// Its standard error, relative.
    pub standard_error: f64,
    /// Half the width of its confidence interval at the family's level, relative.
    pub half_width: f64,
    /// Standard errors that the difference is away from zero; infinite where there is a difference and no noise.
    pub t: f64,
    /// Probability of such a difference by chance.
    pub p_value: f64,
    /// The smallest bias that would have been seen with a probability of 95 %, relative.
    pub visible: f64,
    /// The bias that must not hide, relative.
    pub bound: f64,
    /// The radiance that relative numbers are relative to.
    pub scale: f64,
    /// Contributions that the poorer of the means is worth, measured by how many are enough. Below 1 its spread is not known either, and the
    /// comparison is inconclusive.
    pub evidence: f64,
    /// The verdict of this comparison.
    pub verdict: Verdict,
}

/// The outcome of all comparisons of two samples.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Agreement {
    /// The worst verdict of all comparisons.
    pub verdict: Verdict,
    /// The comparison that chance explains least.
    pub worst: Finding,
    /// The comparison where a bias could hide best: the widest interval, measured by its bound.
    pub blindest: Finding,
    /// Of the whole picture, the smallest bias that would have been seen in every channel.
    pub visible_picture: f64,
    /// Of a block, the smallest bias that would have been seen wherever it is.
    pub visible_block: f64,
    /// All comparisons: areas in the order of [`super::Grid::areas`], three channels each.
    pub findings: Vec<Finding>,
}

/// What a sample is held against.
#[derive(Clone, Copy, Debug)]
pub enum Expected<'a> {
    /// Another sample, noise of its own included.
    Sample(&'a Sample),
    /// Means of the areas that are known exactly.
    Known(&'a [[f64; 3]]),
}

/// Compares the means of all areas; `tests` is the number of comparisons in the whole family, those of other pairs included.
pub fn judge(sample: &Sample, expected: Expected<'_>, standard: &Standard, tests: usize) -> Agreement {
    let level = family_wise(standard.alpha, tests);
    let other_mean = |area: usize, channel: usize| match expected {
        Expected::Sample(other) => 0.5 * (sample.areas()[area][channel].mean + other.areas()[area][channel].mean),
        Expected::Known(means) => means[area][channel],
    };
    // A channel without light is measured by the others.
    let light = (0..3).map(|c| other_mean(0, c).abs()).sum::<f64>() / 3.0;
    let picture = |channel: usize| other_mean(0, channel).abs().max(0.1 * light).max(f64::from(f32::MIN_POSITIVE));

    let other = match expected {
        Expected::Sample(other) => Some(other),
        Expected::Known(_) => None,
    };
    let grains: [Grains; 2] = [Grains::of(sample), other.map_or(Grains::default(), Grains::of)];
    let mut findings = Vec::with_capacity(3 * sample.grid().len());
    for (i, area) in sample.grid().areas().enumerate() {
        for channel in 0..3 {
            let x = &sample.areas()[i][channel];
            let y = other.map(|o| &o.areas()[i][channel]);
            let mean = other_mean(i, channel);
            let scale = match area {
                Area::Picture => picture(channel),
                Area::Block(..) => mean.abs().max(0.5 * picture(channel)),
            };
            let test = y.map_or_else(|| t_test(x, mean), |y| compare_means(x, y));
            let bound = if area == Area::Picture { standard.bound } else { standard.block_bound };
            let poorer =
                |of: &dyn Fn(&Grains, &Moments) -> f64| of(&grains[0], x).min(y.map_or(f64::INFINITY, |y| of(&grains[1], y)));
            let worth = Worth {
                most: x.mean.abs().max(y.map_or(0.0, |y| y.mean.abs())) / scale,
                evidence: poorer(&|g, m| g.evidence(m, area, channel, mean)),
                of_bound: poorer(&|g, _| g.due(area, channel, bound * scale)),
            };
            findings.push(finding((area, channel), &beyond_rounding(test, scale), level, bound, scale, worth));
        }
    }
    summary(findings)
}

/// The light that one contribution brings in a typical block, φ = σ²/μ of its mean, per channel: what a count of rare, equal contributions
/// has for its variance over its mean.
#[derive(Default)]
struct Grains([f64; 3]);

impl Grains {
    fn of(sample: &Sample) -> Self {
        Self(std::array::from_fn(|c| {
            let blocks = sample.areas()[1..].iter().map(|a| &a[c]).filter(|m| m.mean > 0.0);
            let mut grains: Vec<f64> = blocks.map(|m| m.standard_error().powi(2) / m.mean).collect();
            grains.sort_by(f64::total_cmp);
            grains.get(grains.len() / 2).copied().unwrap_or(0.0)
        }))
    }

    /// What a mean is worth: by its own spread, and, since a block where hardly any light was found has a small spread too, by as many
    /// contributions as should have been found if `mean` is the truth. A picture that is black altogether tells that it is.
    fn evidence(&self, m: &Moments, area: Area, channel: usize, mean: f64) -> f64 {
        let se = m.standard_error();
        let seen = if se > 0.0 { (m.mean / se).powi(2) / ENOUGH } else { f64::INFINITY };
        seen.min(self.due(area, channel, mean.abs()))
    }

    /// Contributions that make up `light`, measured by how many are enough.
    fn due(&self, area: Area, channel: usize, light: f64) -> f64 {
        if area == Area::Picture || self.0[channel] <= 0.0 { f64::INFINITY } else { light / self.0[channel] / ENOUGH }
    }
}

/// How well the light of an area is known.
#[derive(Clone, Copy)]
struct Worth {
    /// The larger of the means, relative.
    most: f64,
    /// [`Finding::evidence`].
    evidence: f64,
    /// The same of light that is as bright as the bound.
    of_bound: f64,
}

fn finding((area, channel): (Area, usize), test: &MeanTest, level: f64, bound: f64, scale: f64, worth: Worth) -> Finding {
    let (se, difference) = (test.standard_error / scale, test.difference / scale);
    let (half_width, margin, t) = if se > 0.0 {
        let quantile = student_quantile(level, test.dof);
        (se * quantile, se * power_margin(quantile, test.dof), difference / se)
    } else {
        (0.0, ROUNDING, if difference == 0.0 { 0.0 } else { f64::INFINITY.copysign(difference) })
    };
    let visible = half_width + margin;
    // Next to no light: whatever it is, it is less than the bound, and more would have been seen.
    let dark = worth.most + half_width <= bound && worth.evidence < 1.0;
    let evidence = if dark { worth.of_bound } else { worth.evidence };
    let verdict = match test.verdict(level, bound * scale) {
        _ if evidence < 1.0 => Verdict::Inconclusive,
        Single::Pass(_) => Verdict::Pass,
        Single::Fail(_) if dark => Verdict::Inconclusive,
        Single::Fail(_) => Verdict::Fail,
        Single::Inconclusive(_) => Verdict::Inconclusive,
    };
    Finding {
        area,
        channel,
        difference,
        standard_error: se,
        half_width,
        t,
        p_value: test.p_value,
        visible,
        bound,
        scale,
        evidence,
        verdict,
    }
}

/// How many standard errors beyond `t` a bias must be to exceed it with a probability of 95 %: by the normal approximation of the noncentral t,
/// (t - δ) / √(1 + t²/2ν) [Johnson, Welch 1940].
fn power_margin(t: f64, dof: f64) -> f64 {
    const Z: f64 = 1.645; // P(Z < 1.645) = 0.95
    if t.is_finite() { Z * (1.0 + t * t / (2.0 * dof)).sqrt() } else { 0.0 }
}

fn summary(findings: Vec<Finding>) -> Agreement {
    // Of equals the first: the picture before its blocks.
    let by = |measure: &dyn Fn(&Finding) -> f64| {
        *findings
            .iter()
            .rev()
            .max_by(|a, b| measure(a).total_cmp(&measure(b)))
            .unwrap_or_else(|| unreachable!("a grid has an area"))
    };
    let visible =
        |picture: bool| findings.iter().filter(|f| (f.area == Area::Picture) == picture).map(|f| f.visible).fold(0.0, f64::max);
    Agreement {
        verdict: findings.iter().map(|f| f.verdict).max().unwrap_or(Verdict::Inconclusive),
        // The p-value decides, and where it is too small for a number, t does; what says nothing comes last.
        worst: by(&|f| if f.evidence >= 1.0 { f.t.abs().min(1e6) + 1e7 * (1.0 - f.p_value) } else { 0.0 }),
        blindest: by(&|f| f.half_width / f.bound),
        visible_picture: visible(true),
        visible_block: visible(false),
        findings,
    }
}

/// The same test of what of the difference rounding does not explain.
fn beyond_rounding(test: MeanTest, scale: f64) -> MeanTest {
    if test.difference.is_nan() {
        return test;
    }
    let difference = (test.difference.abs() - ROUNDING * scale).max(0.0).copysign(test.difference);
    let p_value = if test.standard_error > 0.0 && test.dof > 0.0 {
        student_p(difference / test.standard_error, test.dof)
    } else {
        f64::from(u8::from(difference == 0.0))
    };
    MeanTest { difference, p_value, ..test }
}

impl Agreement {
    /// Comparisons that found a difference.
    pub fn failures(&self) -> impl Iterator<Item = &Finding> {
        self.findings.iter().filter(|f| f.verdict == Verdict::Fail)
    }

    /// How many times the replicates it takes for a PASS, if there is no difference and noise falls as it should: 1 where there are enough.
    pub fn more(&self, level: f64) -> f64 {
        let most = quantile_of_many(level);
        let open = self.findings.iter().filter(|f| f.verdict == Verdict::Inconclusive);
        open.map(|f| (most * f.standard_error / f.bound).powi(2).max(f.evidence.recip())).fold(1.0, f64::max)
    }
}

/// How many standard errors must fit within the bound at a level, with many replicates: the quantile, and how far out one of many areas is by chance.
pub fn quantile_of_many(level: f64) -> f64 {
    const FAR: f64 = 2.0;
    student_quantile(level, 1e6) + FAR
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let channel = ["red", "green", "blue"][self.channel.min(2)];
        let (d, h) = (100.0 * self.difference, 100.0 * self.half_width);
        write!(f, "{} {channel}: {d:+.3} % ± {h:.3} %, t = {:+.2}, p = {:.1e}", self.area, self.t, self.p_value)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::agreement::Grid;
    use etendue_check::rng;

    /// K pictures of a mean and of noise that is far from normal in a single pixel: a few bright hits.
    fn sample(seed: u64, k: u32, mean: impl Fn(usize) -> f64, hit: f64) -> Sample {
        let grid = Grid::new([16, 16], 8);
        let mut sample = Sample::new(grid);
        let mut r = rng(seed);
        for _ in 0..k {
            let pixel = |i: usize, r: &mut etendue_check::Rng| {
                let light = if r.u1_f64() < hit { mean(i) / hit } else { 0.0 };
                [light as f32, (0.5 * light) as f32, (2.0 * light) as f32]
            };
            let picture: Vec<_> = (0..256).map(|i| pixel(i, &mut r)).collect();
            sample.add(&picture);
        }
        sample
    }

    const LOOSE: Standard = Standard { alpha: 0.01, bound: 0.3, block_bound: 2.0 };

    /// 200 families of right pairs: 2 false alarms are expected at most, and 10 or more have a probability below 1e-4.
    #[test]
    fn right_pairs_alarm_at_the_stated_rate() {
        let tests = 3 * 17;
        let fails = (0..200)
            .filter(|s| {
                let (a, b) = (sample(2 * s, 16, |_| 1.0, 0.8), sample(2 * s + 1, 24, |_| 1.0, 0.9));
                judge(&a, Expected::Sample(&b), &LOOSE, tests).verdict == Verdict::Fail
            })
            .count();
        assert!(fails < 10, "{fails} of 200");
    }

    /// A bias as large as is said to be visible is seen in 95 of 100 cases: of 200, fewer than 175 have a probability below 1e-4.
    #[test]
    fn what_is_said_to_be_visible_is_seen() {
        let known = vec![[1.0, 0.5, 2.0]; 17];
        let at = |s: u64, mean: f64| judge(&sample(s, 16, |_| mean, 0.5), Expected::Known(&known), &LOOSE, 51);
        let visible = (0..50).map(|s| at(s, 1.12).findings[0].visible).sum::<f64>() / 50.0;
        let seen = (1000..1200).filter(|s| at(*s, 1.0 + visible).findings[0].verdict == Verdict::Fail).count();
        assert!(seen >= 175, "{seen} of 200");
    }

    #[test]
    fn a_biased_block_is_named() {
        let a = sample(1, 16, |i| if i % 16 >= 12 && i / 16 < 4 { 6.0 } else { 1.0 }, 0.5);
        let b = sample(2, 16, |_| 1.0, 0.5);
        let found = judge(&a, Expected::Sample(&b), &LOOSE, 51);
        assert_eq!((found.verdict, found.worst.area), (Verdict::Fail, Area::Block(3, 0)));
        assert!(found.failures().count() >= 2 && found.worst.difference > 0.5);
    }

    #[test]
    fn noise_hides_and_makes_it_inconclusive() {
        let (a, b) = (sample(3, 16, |_| 1.0, 0.01), sample(4, 16, |_| 1.0, 0.5));
        let found = judge(&a, Expected::Sample(&b), &Standard::default(), 51);
        assert_eq!(found.verdict, Verdict::Inconclusive);
        assert!(found.more(1e-4) > 1.0 && found.visible_picture > 0.02);
    }

    /// Rare bright hits: most blocks see too few, and their spread with them. That is no difference, however large t is.
    #[test]
    fn rare_hits_are_no_failure() {
        let tests = 51;
        let (mut untold, mut large) = (0, 0);
        for s in 0..100 {
            let (a, b) = (sample(2 * s, 16, |_| 1.0, 0.02), sample(2 * s + 1, 16, |_| 1.0, 0.9));
            let found = judge(&a, Expected::Sample(&b), &LOOSE, tests);
            assert_ne!(found.verdict, Verdict::Fail, "{}", found.worst);
            untold += found.findings.iter().filter(|f| f.evidence < 1.0).count();
            large += found.findings.iter().filter(|f| f.p_value < 1e-4).count();
        }
        assert!(untold > 4000 && large > 3, "{untold}, {large}");
    }

    /// A corner without light, in both: where light as bright as the bound would have been seen, it is told to be dark.
    #[test]
    fn darkness_is_told() {
        let corner = |i: usize| if i % 16 < 4 && i / 16 < 4 { 0.0 } else { 1.0 };
        let at = |hit: f64| judge(&sample(9, 16, corner, hit), Expected::Sample(&sample(10, 16, corner, hit)), &LOOSE, 51);
        assert_eq!(at(0.9).findings[3].verdict, Verdict::Pass);
        assert_eq!(at(0.05).findings[3].verdict, Verdict::Inconclusive);
        assert!(at(0.05).more(1e-4) > 1.0);
    }

    /// Without noise: equal or not, but for rounding. And what of blocks without any light.
    #[test]
    fn without_noise() {
        let known = |x: f64| vec![[x, 0.5 * x, 2.0 * x]; 17];
        let exact = sample(5, 16, |_| 1.0, 1.0);
        assert_eq!(judge(&exact, Expected::Known(&known(1.000_001)), &LOOSE, 51).verdict, Verdict::Pass);
        assert_eq!(judge(&exact, Expected::Known(&known(1.000_01)), &LOOSE, 51).verdict, Verdict::Fail);
        // Nothing in a block where many contributions are due is a difference; where few are due, it is not.
        let corner = |i: usize| if i % 16 < 4 && i / 16 < 4 { 0.0 } else { 1.0 };
        let at = |hit: f64| judge(&sample(6, 16, |_| 1.0, hit), Expected::Sample(&sample(7, 16, corner, hit)), &LOOSE, 51);
        assert_eq!((at(0.9).verdict, at(0.9).worst.area), (Verdict::Fail, Area::Block(0, 0)));
        assert_eq!((at(0.05).findings[3].evidence >= 1.0, at(0.05).verdict), (false, Verdict::Inconclusive));
        let black = judge(&sample(8, 16, |_| 0.0, 0.5), Expected::Sample(&exact), &LOOSE, 51);
        assert_eq!((black.verdict, black.worst.area), (Verdict::Fail, Area::Picture));
    }
}

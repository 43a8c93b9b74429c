//! Elementary functions against the standard library's in f64: over every 4099th float, which is half a million of them in all magnitudes.

use etendue_numerics::math::{atan2, exp, ln, powf, safe_acos, safe_asin, sin_cos};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

/// |ours - exact| in units of the last place of the exact value; 0 where both are NaN or the same special value.
fn ulps(ours: f32, exact: f64) -> f64 {
    let rounded = exact as f32;
    if ours == rounded || (ours.is_nan() && rounded.is_nan()) {
        return if rounded.is_finite() && rounded != 0.0 { (f64::from(ours) - exact).abs() / ulp(rounded) } else { 0.0 };
    }
    if !rounded.is_finite() || !ours.is_finite() {
        return f64::INFINITY;
    }
    (f64::from(ours) - exact).abs() / ulp(rounded)
}

fn ulp(x: f32) -> f64 {
    f64::from(x.abs().next_up()) - f64::from(x.abs())
}

fn worst(f: impl Fn(f32) -> (f32, f64)) -> (f64, f32) {
    let floats = (0..=u32::MAX).step_by(4099).map(f32::from_bits);
    floats.map(|x| (ulps(f(x).0, f(x).1), x)).fold((0.0, 0.0), |a, b| if b.0 > a.0 { b } else { a })
}

/// The signed zeros, infinities, ones and the like that go wrong first.
const SPECIAL: [f32; 17] = [
    0.0,
    -0.0,
    1.0,
    -1.0,
    0.5,
    -0.5,
    2.0,
    -2.0,
    3.0,
    -3.0,
    f32::MIN_POSITIVE,
    1e-45,
    f32::MAX,
    f32::MIN,
    f32::INFINITY,
    f32::NEG_INFINITY,
    f32::NAN,
];

#[test]
fn errors_stay_near_half_an_ulp() {
    let bound = |name: &str, (error, x): (f64, f32)| assert!(error <= 0.56, "{name}({x:e}) is {error} ulp off");
    bound("exp", worst(|x| (exp(x), f64::from(x).exp())));
    bound("ln", worst(|x| (ln(x), f64::from(x).ln())));
    bound("acos", worst(|x| (safe_acos(x), f64::from(x.clamp(-1.0, 1.0)).acos())));
    bound("asin", worst(|x| (safe_asin(x), f64::from(x.clamp(-1.0, 1.0)).asin())));
    bound("atan", worst(|x| (atan2(x, 1.0), f64::from(x).atan())));
    bound("atan of the reciprocal", worst(|x| (atan2(-2.0, x), (-2.0f64).atan2(f64::from(x)))));
    let within = |x: f32| if x.abs() <= 1e6 { x } else { 0.0 };
    bound("sin", worst(|x| (sin_cos(within(x)).0, f64::from(within(x)).sin())));
    bound("cos", worst(|x| (sin_cos(within(x)).1, f64::from(within(x)).cos())));
    bound("cube root", worst(|x| (powf(x, 1.0 / 3.0), f64::from(x).powf(f64::from(1.0f32 / 3.0)))));
    bound("power 2.2", worst(|x| (powf(x, 2.2), f64::from(x).powf(f64::from(2.2f32)))));
    bound("power of 1.5", worst(|x| (powf(1.5, x), 1.5f64.powf(f64::from(x)))));
}

#[test]
fn near_multiples_of_a_quarter_turn() {
    for n in -1000..1000 {
        let x = (f64::from(n) * std::f64::consts::FRAC_PI_2) as f32;
        for x in [x.next_down(), x, x.next_up()] {
            let (s, c) = sin_cos(x);
            assert!(ulps(s, f64::from(x).sin()) <= 0.56 && ulps(c, f64::from(x).cos()) <= 0.56, "{x:e}");
        }
    }
    // Far out: bounded, and on the circle.
    for x in [1e7f32, -1e20, f32::MAX] {
        let (s, c) = sin_cos(x);
        assert!((s * s + c * c - 1.0).abs() < 1e-6);
    }
}

#[test]
fn special_values_are_those_of_the_library() {
    let same = |name: &str, ours: f32, library: f32| {
        // Signs of zero count; any NaN is as good as another.
        let equal =
            (ours.is_nan() && library.is_nan()) || (ours == library && ours.is_sign_negative() == library.is_sign_negative());
        assert!(equal || (ours - library).abs() <= 2e-7 * library.abs(), "{name}: {ours} is not {library}");
    };
    for x in SPECIAL {
        same("exp", exp(x), x.exp());
        same("ln", ln(x), x.ln());
        if x.abs() <= 1e6 || !x.is_finite() {
            same("sin", sin_cos(x).0, x.sin());
            same("cos", sin_cos(x).1, x.cos());
        }
        same("acos", safe_acos(x), x.clamp(-1.0, 1.0).acos());
        same("asin", safe_asin(x), x.clamp(-1.0, 1.0).asin());
        for y in SPECIAL {
            same(&format!("{x} to the {y}"), powf(x, y), x.powf(y));
            same(&format!("atan2 {x} {y}"), atan2(x, y), x.atan2(y));
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 20_000, failure_persistence: None, rng_seed: RngSeed::Fixed(1), ..ProptestConfig::default() })]

    #[test]
    fn powers_and_angles_of_anything(x in any::<f32>(), y in any::<f32>(), small in -40f32..40.0) {
        prop_assert!(ulps(atan2(y, x), f64::from(y).atan2(f64::from(x))) <= 0.56);
        prop_assert!(ulps(powf(x.abs(), small), f64::from(x.abs()).powf(f64::from(small))) <= 0.56);
        prop_assert!(ulps(powf(x, small.round()), f64::from(x).powf(f64::from(small.round()))) <= 0.56);
        prop_assert!(ulps(powf(1.0 + small / 50.0, y), (f64::from(1.0 + small / 50.0)).powf(f64::from(y))) <= 0.56 || y.abs() > 1e4);
    }
}

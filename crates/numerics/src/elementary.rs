//! sin, cos, exp, ln, powers and inverse angles of f32, the same bits everywhere.
//!
//! The libraries of different systems (and one library on different processors) round their transcendentals differently, and a picture that
//! hangs on the last bit cannot be compared with one made elsewhere. These are polynomials in f64 without fused multiply-add, rounded to f32
//! once at the end, so they are also nearly as good as can be: within 0.56 ulp of the exact value (tests), where 0.5 is unavoidable.
//!
//! | function | reduced to | by | polynomial |
//! | --- | --- | --- | --- |
//! | sin, cos | \|r\| ≤ π/4 | r = x - n π/2, π/2 in two parts | degree 7 and 8, relative error 3.3e-9 and 6e-11 |
//! | exp | \|r\| ≤ 1/64 | 2ˣ = 2^(k/32) 2ʳ, the first from a table [Tang 1989] | degree 3, 7e-11 |
//! | ln, powers | \|r\| ≤ 0.03 | x = 2ⁿ c (1 + r), log₂ c from a table [Tang 1990] | degree 6, 3e-12 |
//! | atan2 | t in \[0, 1] | smaller over larger | degree 19, 2.4e-9 |
//! | acos, asin | \[0, ½] | asin x = π/2 - 2 asin √((1 - x)/2) | degree 13, 2.6e-10 |
//!
//! Polynomials are fitted by reweighted least squares, so that the largest relative error is least. Special values are those of the standard library.

use std::f64::consts::{FRAC_PI_2, LN_2, LOG2_E, PI, TAU};

/// 1.5 · 2⁵²: added to a number below 2⁵¹ it leaves the nearest integer in the low bits (ties to even).
const ROUNDER: f64 = 6_755_399_441_055_744.0;

/// The integer nearest to x, as a float and as an integer; |x| < 2³¹.
#[inline]
fn nearest(x: f64) -> (f64, i32) {
    let shifted = x + ROUNDER;
    (shifted - ROUNDER, shifted.to_bits() as i32)
}

/// sin x and cos x. Beyond |x| = 10⁶ the argument is reduced modulo the f64 next to 2π first, which costs accuracy as x grows.
#[inline]
pub fn sin_cos(x: f32) -> (f32, f32) {
    if x.abs() > 1e6 { sin_cos_reduced(f64::from(x) % TAU) } else { sin_cos_reduced(f64::from(x)) }
}

/// [`sin_cos`] for |x| up to 10⁶: the same bits, and nothing in it that keeps a loop from being made of vectors.
#[inline(always)]
pub fn sin_cos_near(x: f32) -> (f32, f32) {
    sin_cos_reduced(f64::from(x))
}

#[inline(always)]
fn sin_cos_reduced(x: f64) -> (f32, f32) {
    /// π/2, its first 33 bits, and the rest: n times the first part is exact for n < 2²⁰.
    const HIGH: f64 = 1.570_796_326_734_125_6;
    const LOW: f64 = 6.077_100_506_506_192e-11;
    let (n, quadrant) = nearest(x * (1.0 / FRAC_PI_2));
    let r = (x - n * HIGH) - n * LOW;

    let z = r * r;
    let z2 = z * z;
    let sin = (0.999_999_996_748_697_1 - 0.166_666_501_745_701_88 * z)
        + z2 * (0.008_332_013_810_893_506 - 0.000_195_014_829_828_582_96 * z);
    let cos = (0.999_999_999_943_647 - 0.499_999_995_697_941_5 * z)
        + z2 * (0.041_666_613_069_534_01 - 0.001_388_652_434_480_151_7 * z)
        + z2 * z2 * 0.000_024_372_245_178_446_914;
    let (sin, cos) = ((r * sin) as f32, cos as f32);

    // Quarter turns exchange the two and change signs; as bits, for there is no guessing the branch.
    let (sin, cos, quadrant) = (sin.to_bits(), cos.to_bits(), quadrant as u32);
    let exchange = (sin ^ cos) & (quadrant & 1).wrapping_neg();
    let s = sin ^ exchange ^ (quadrant & 2) << 30;
    let c = cos ^ exchange ^ (quadrant.wrapping_add(1) & 2) << 30;
    (f32::from_bits(s), f32::from_bits(c))
}

/// Cells per octave in [`LOG2`] and [`EXP2`].
const LOG2_CELLS: usize = 16;
const EXP2_CELLS: usize = 32;

/// (1/c, log₂ c) for c in the middle of each cell of [0.699, 1.398); c = 1 in the cell around 1, so that logarithms near 1 keep their precision.
static LOG2: [(f64, f64); LOG2_CELLS] = [
    (1.3989070653915405, -0.48430012207933043),
    (1.3403141498565674, -0.4225711867440103),
    (1.286432147026062, -0.3633753640047848),
    (1.2367149591445923, -0.30651302301826494),
    (1.1906976699829102, -0.25180714503608187),
    (1.147982120513916, -0.19910017263487428),
    (1.1082251071929932, -0.148250957240328),
    (1.0711296796798706, -0.09913315506985332),
    (1.0364372730255127, -0.05163280469291231),
    (1.0, -0.0),
    (0.9481481313705444, 0.07681562257950586),
    (0.8951048851013184, 0.15987135290176302),
    (0.8476821184158325, 0.23840474066869335),
    (0.805031418800354, 0.31288300499809124),
    (0.7664670944213867, 0.38370423872947484),
    (0.7314285635948181, 0.4512111272838952),
];

/// The bits of 2^(i/32), less i/32 in the exponent's place: added to k = 32 n + i there they give 2^(k/32).
static EXP2: [u64; EXP2_CELLS] = [
    0x3ff0000000000000,
    0x3fefd9b0d3158574,
    0x3fefb5586cf9890f,
    0x3fef9301d0125b51,
    0x3fef72b83c7d517b,
    0x3fef54873168b9aa,
    0x3fef387a6e756238,
    0x3fef1e9df51fdee1,
    0x3fef06fe0a31b715,
    0x3feef1a7373aa9cb,
    0x3feedea64c123422,
    0x3feece086061892d,
    0x3feebfdad5362a27,
    0x3feeb42b569d4f82,
    0x3feeab07dd485429,
    0x3feea47eb03a5585,
    0x3feea09e667f3bcd,
    0x3fee9f75e8ec5f74,
    0x3feea11473eb0187,
    0x3feea589994cce13,
    0x3feeace5422aa0db,
    0x3feeb737b0cdc5e5,
    0x3feec49182a3f090,
    0x3feed503b23e255d,
    0x3feee89f995ad3ad,
    0x3feeff76f2fb5e47,
    0x3fef199bdd85529c,
    0x3fef3720dcef9069,
    0x3fef5818dcfba487,
    0x3fef7c97337b9b5f,
    0x3fefa4afa2a490da,
    0x3fefd0765b6e4540,
];

/// 2ˣ for x within ±1000; relative error 1e-10.
#[inline]
fn exp2_f64(x: f64) -> f64 {
    let (k, index) = nearest(x * EXP2_CELLS as f64);
    let r = x - k * (1.0 / EXP2_CELLS as f64);
    let scale = f64::from_bits(EXP2[index as usize % EXP2_CELLS].wrapping_add((i64::from(index) << 47) as u64));
    let p =
        (0.999_999_999_928_054 + 0.693_147_180_669_636_4 * r) + r * r * (0.240_228_859_822_311_87 + 0.055_503_782_101_116_03 * r);
    scale * p
}

/// log₂ x for a positive finite x; relative error 1e-11.
#[inline]
fn log2_f64(x: f64) -> f64 {
    /// The bits of 0.69921875, where the cells begin.
    const START: u64 = 0x3fe6_6000_0000_0000;
    let bits = x.to_bits();
    let above = bits.wrapping_sub(START);
    let (inverse, log) = LOG2[(above >> 48) as usize % LOG2_CELLS];
    let n = (above as i64) >> 52;
    let m = f64::from_bits(bits.wrapping_sub((n << 52) as u64));

    // log₂ m = log₂ c + log₂(1 + r), |r| < 0.03.
    let r = m * inverse - 1.0;
    let r2 = r * r;
    let p = (1.442_695_040_893_324_3 - 0.721_347_520_456_183_4 * r)
        + r2 * (0.480_898_257_548_155 - 0.360_673_646_721_830_83 * r)
        + r2 * r2 * (0.288_810_586_432_126 - 0.240_718_539_241_090_7 * r);
    (n as f64 + log) + r * p
}

/// eˣ.
#[inline]
pub fn exp(x: f32) -> f32 {
    exp2_f64((f64::from(x) * LOG2_E).clamp(-1000.0, 1000.0)) as f32
}

/// ln x; -∞ at zero, NaN below.
#[inline]
pub fn ln(x: f32) -> f32 {
    if x > 0.0 && x < f32::INFINITY {
        (log2_f64(f64::from(x)) * LN_2) as f32
    } else if x == 0.0 {
        f32::NEG_INFINITY
    } else if x > 0.0 {
        x
    } else {
        f32::NAN
    }
}

/// xʸ.
#[inline]
pub fn powf(x: f32, y: f32) -> f32 {
    if x > 0.0 && x < f32::INFINITY && y.abs() < f32::INFINITY {
        exp2_f64((log2_f64(f64::from(x)) * f64::from(y)).clamp(-1000.0, 1000.0)) as f32
    } else {
        powf_special(x, y)
    }
}

/// xʸ of what is not positive or not finite.
#[cold]
fn powf_special(x: f32, y: f32) -> f32 {
    if x < 0.0 && x > f32::NEG_INFINITY && y % 1.0 == 0.0 {
        // A negative number to a whole power.
        if y % 2.0 == 0.0 { powf(-x, y) } else { -powf(-x, y) }
    } else {
        // Zero, infinities and NaN: no rounding, hence no difference between systems.
        x.powf(y)
    }
}

/// The angle of (x, y) in [-π, π].
#[inline(always)] // so that loops over lanes become vectors
pub fn atan2(y: f32, x: f32) -> f32 {
    let (ax, ay) = (f64::from(x.abs()), f64::from(y.abs()));
    let steep = ay > ax;
    let (small, large) = if steep { (ax, ay) } else { (ay, ax) };
    // Two zeros and two infinities have a ratio too.
    let t = if small == large { f64::from(u8::from(large > 0.0)) } else { small / large };
    let angle = atan_f64(t);
    let angle = if steep { FRAC_PI_2 - angle } else { angle };
    let angle = if x.is_sign_negative() { PI - angle } else { angle };
    (angle as f32).copysign(y)
}

/// arctan t for t in [0, 1].
#[inline(always)]
fn atan_f64(t: f64) -> f64 {
    let z = t * t;
    let z2 = z * z;
    let z4 = z2 * z2;
    let z8 = z4 * z4;
    let p = (0.999_999_997_630_616 - 0.333_332_836_414_602_3 * z) + z2 * (0.199_982_660_350_809_03 - 0.142_619_330_387_063_98 * z);
    let q =
        (0.109_420_303_159_321_76 - 0.083_773_144_212_768_1 * z) + z2 * (0.057_552_084_295_701_92 - 0.030_804_579_370_078_74 * z);
    let r = 0.010_726_934_495_953_874 - 0.001_753_928_011_301_327_3 * z;
    t * (p + z4 * q + z8 * r)
}

/// arcsin x for x in [0, ½].
#[inline(always)]
fn asin_f64(x: f64) -> f64 {
    let z = x * x;
    let z2 = z * z;
    let z4 = z2 * z2;
    let p =
        (1.000_000_000_254_603_4 + 0.166_666_569_447_359_8 * z) + z2 * (0.075_006_041_048_872_93 + 0.044_503_085_564_306_114 * z);
    let q = (0.031_900_811_998_266_43 + 0.014_139_464_361_723_482 * z) + z2 * 0.037_885_618_158_303_4;
    x * (p + z4 * q)
}

/// arccos x of x clamped to [-1, 1], in [0, π].
#[inline(always)] // so that loops over lanes become vectors
pub fn safe_acos(x: f32) -> f32 {
    let x = f64::from(x.clamp(-1.0, 1.0));
    let a = x.abs();
    // One polynomial for both halves.
    let near_one = a > 0.5;
    let asin = asin_f64(if near_one { (0.5 - 0.5 * a).sqrt() } else { a });
    let angle = if near_one { 2.0 * asin } else { FRAC_PI_2 - asin };
    (if x < 0.0 { PI - angle } else { angle }) as f32
}

/// arcsin x of x clamped to [-1, 1], in [-π/2, π/2].
#[inline]
pub fn safe_asin(x: f32) -> f32 {
    let a = f64::from(x.abs().min(1.0));
    let angle = if a > 0.5 { FRAC_PI_2 - 2.0 * asin_f64((0.5 - 0.5 * a).sqrt()) } else { asin_f64(a) };
    if x.is_nan() { x } else { (angle as f32).copysign(x) }
}

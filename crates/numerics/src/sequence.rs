//! Uniform numbers as a function u(seed, pixel, sample, dimension): no state, no order, the same bits on every thread.
//!
//! Every [`Dim`] is a two-dimensional point set of its own, padded: independent of all other dimensions, but within it the first 2^m samples of
//! a pixel form a (0, m, 2)-net, so that each elementary interval of area 2^-m holds exactly one of them. For smooth integrands the variance
//! falls like N^-3 [Owen 1997], at worst like that of independent numbers.
//!
//! ```text
//! i' = shuffle_d(i),    x = scramble_x(φ(i')),    y = scramble_y(φ(P i'))                       [Burley 2020]
//! ```
//!
//! with the sample number i, the radical inverse φ (its bits mirrored), Pascal's matrix P modulo 2 (the second Sobol' dimension), and nested uniform
//! scrambling [Owen 1995] by hash [Laine, Karras 2011; constants of Vegdahl 2021]. P is the superset sum over bit positions (Lucas'
//! theorem), five shifts. Shuffling is scrambling of the mirrored index, so every aligned block of 2^m samples stays together: any number of
//! samples may be drawn, in any number of passes, and powers of two are best.
//!
//! [`Sampler::on_screen`] gives all pixels one sequence, in the order of the Z-curve [Ahmed, Wonka 2020]: neighbouring pixels then share a
//! net too, their errors cancel each other, and what noise there is looks fine-grained. Pixels that are sampled this way are not
//! independent; error bars come from independent seeds.

use crate::{Vec2, wide};

/// Which point set the numbers come from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SequenceKind {
    /// Independent uniform numbers.
    Independent,
    /// Jittered strata, as many as samples are announced, shuffled by dimension.
    Stratified,
    /// Owen-scrambled Sobol' points, padded by dimension pairs.
    #[default]
    Sobol,
}

/// The address of a random decision: which vertex of the path, and which decision there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Dim(pub u32);

impl Dim {
    /// Decisions that a vertex may make.
    pub const SLOTS: u32 = 16;

    /// Decision `slot` (below [`Dim::SLOTS`]) at path vertex `vertex`.
    #[inline]
    pub const fn at(vertex: u32, slot: u32) -> Self {
        Self(vertex * Self::SLOTS + slot)
    }
}

/// The numbers of one sample of one pixel.
#[derive(Clone, Copy, Debug)]
pub struct Sampler {
    kind: SequenceKind,
    key: u64,
    /// The sample number; mirrored for Sobol' points, for they only use it so.
    sample: u32,
    count: u32,
}

impl Sampler {
    /// Sample number `sample` of `count` at pixel or particle `index`, under `seed`. More than `count` may be drawn.
    #[inline]
    pub fn new(kind: SequenceKind, seed: u64, index: u64, sample: u32, count: u32) -> Self {
        let key = mix(seed ^ mix(index.wrapping_add(0x9e37_79b9_7f4a_7c15)));
        Self::keyed(kind, key, sample, count)
    }

    /// Sample number `sample` of `count` at pixel (x, y), under `seed`; for Sobol' points neighbouring pixels share a sequence.
    #[inline]
    pub fn on_screen(kind: SequenceKind, seed: u64, [x, y]: [u32; 2], sample: u32, count: u32) -> Self {
        let pixel = spread(x) | spread(y) << 1;
        if kind != SequenceKind::Sobol {
            return Self::new(kind, seed, pixel, sample, count);
        }
        // 32 bits of index: the sample number, and above it as much of the Z-curve as there is room for. The rest picks the key.
        let bits = count.max(1).checked_next_power_of_two().map_or(31, u32::trailing_zeros).min(31);
        let room = 32 - bits;
        let tile = pixel >> room;
        let index = (pixel << bits) as u32 | (sample & ((1 << bits) - 1));
        // Samples beyond the announced count start another sequence.
        let key = mix(seed
            ^ mix(tile.wrapping_add(0x632b_e59b_d9b4_e019))
            ^ u64::from(sample >> bits).wrapping_mul(0xd6e8_feb8_6659_fd93));
        Self::keyed(kind, key, index, count)
    }

    #[inline]
    fn keyed(kind: SequenceKind, key: u64, sample: u32, count: u32) -> Self {
        let sample = if kind == SequenceKind::Sobol { sample.reverse_bits() } else { sample };
        Self { kind, key, sample, count }
    }

    /// Number `i` of `n` samples into which this one is divided: over all samples they are one point set of n times as many, so that the
    /// parts of each sample are stratified, too. Dimensions that are drawn from the parts must not be drawn from the whole.
    #[inline]
    pub fn part(&self, i: u32, n: u32) -> Self {
        let mirrored = self.kind == SequenceKind::Sobol;
        let sample = if mirrored { self.sample.reverse_bits() } else { self.sample };
        let index = u64::from(sample) * u64::from(n) + u64::from(i);
        // What has no room in 32 bits goes on in another set.
        let key = if index >> 32 == 0 { self.key } else { mix(self.key ^ mix(index >> 32)) };
        Self::keyed(self.kind, key, index as u32, self.count.saturating_mul(n))
    }

    /// A uniform number in [0, 1). Not to be drawn together with [`Sampler::u2`] of the same dimension.
    #[inline]
    pub fn u1(&self, dim: Dim) -> f32 {
        match self.kind {
            SequenceKind::Sobol => {
                let keys = Keys::new(self.key, dim);
                unit(scramble(scramble(self.sample, keys.shuffle).reverse_bits(), keys.x).reverse_bits())
            }
            SequenceKind::Stratified => self.stratum(dim),
            SequenceKind::Independent => self.independent(dim).x,
        }
    }

    /// A uniform point in [0, 1)².
    #[inline]
    pub fn u2(&self, dim: Dim) -> Vec2 {
        match self.kind {
            SequenceKind::Sobol => Keys::new(self.key, dim).point(self.sample),
            SequenceKind::Stratified => self.strata(dim),
            SequenceKind::Independent => self.independent(dim),
        }
    }

    /// [`Sampler::u2`] of many samplers, the same bits: x and y of each. Sobol' points are made on lanes.
    pub fn u2_each<const N: usize>(samplers: &[Self], dim: Dim, x: &mut [f32; N], y: &mut [f32; N]) {
        let Some((first, rest)) = samplers.split_first() else { return };
        let alike = |s: &Self| s.kind == SequenceKind::Sobol && s.key == first.key;
        if samplers.len() <= N && N.is_multiple_of(wide::PAD) && alike(first) && rest.iter().all(alike) {
            let mut samples = [0; N];
            samplers.iter().zip(&mut samples).for_each(|(s, to)| *to = s.sample);
            wide::widest(Points { keys: Keys::new(first.key, dim), samples: &samples, count: samplers.len(), x, y });
        } else {
            for ((s, x), y) in samplers.iter().zip(x).zip(y) {
                let u = s.u2(dim);
                (*x, *y) = (u.x, u.y);
            }
        }
    }

    /// [`Sampler::u1`] of many samplers, the same bits.
    pub fn u1_each<const N: usize>(samplers: &[Self], dim: Dim, x: &mut [f32; N]) {
        if samplers.iter().all(|s| s.kind == SequenceKind::Sobol) {
            // The first coordinate of the point.
            return Self::u2_each(samplers, dim, x, &mut [0.0; N]);
        }
        for (s, x) in samplers.iter().zip(x) {
            *x = s.u1(dim);
        }
    }

    #[inline]
    fn independent(&self, dim: Dim) -> Vec2 {
        let bits = mix(self.key ^ mix(u64::from(self.sample) << 32 | u64::from(dim.0)));
        Vec2::new(unit(bits as u32), unit((bits >> 32) as u32))
    }

    /// One of `count` intervals, each met once in `count` samples, and a uniform place in it.
    fn stratum(&self, dim: Dim) -> f32 {
        let count = self.count.max(1);
        let cell = permute(self.sample % count, count, self.round_key(dim));
        ((cell as f32 + self.independent(dim).x) / count as f32).min(crate::math::ONE_MINUS_EPSILON)
    }

    /// One of the cells of a nearly square grid of at least `count` cells, and a uniform place in it.
    fn strata(&self, dim: Dim) -> Vec2 {
        let count = self.count.max(1);
        let columns = count.isqrt();
        let rows = count.div_ceil(columns);
        let cell = permute(self.sample % count, columns * rows, self.round_key(dim));
        let corner = Vec2::new((cell % columns) as f32, (cell / columns) as f32);
        ((corner + self.independent(dim)) / Vec2::new(columns as f32, rows as f32)).min(Vec2::splat(crate::math::ONE_MINUS_EPSILON))
    }

    /// Each round of `count` samples has its own order of strata.
    fn round_key(&self, dim: Dim) -> u64 {
        mix(self.key ^ mix((u64::from(self.sample / self.count.max(1)) << 32 | u64::from(dim.0)) ^ 0x5bd1_e995_7b7d_159d))
    }
}

/// Sobol' points of one dimension for samplers that share a key.
struct Points<'a, const N: usize> {
    keys: Keys,
    samples: &'a [u32; N],
    count: usize,
    x: &'a mut [f32; N],
    y: &'a mut [f32; N],
}

impl<const N: usize> wide::Job for Points<'_, N> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        for i in 0..self.count.next_multiple_of(wide::PAD).min(N) {
            let u = self.keys.point(self.samples[i]);
            (self.x[i], self.y[i]) = (u.x, u.y);
        }
    }
}

/// What one dimension is shuffled and scrambled by.
struct Keys {
    shuffle: u32,
    x: u32,
    y: u32,
}

impl Keys {
    #[inline]
    fn new(key: u64, dim: Dim) -> Self {
        let bits = mix(key ^ u64::from(dim.0).wrapping_mul(0x9e37_79b9_7f4a_7c15));
        let more = bits.wrapping_mul(0xd134_2543_de82_ef95);
        Self { shuffle: bits as u32, x: (bits >> 32) as u32, y: (more >> 32) as u32 }
    }

    /// The two-dimensional point of a sample's mirrored number.
    #[inline(always)]
    fn point(&self, sample: u32) -> Vec2 {
        let index = scramble(sample, self.shuffle).reverse_bits();
        let x = scramble(index, self.x).reverse_bits();
        let y = scramble(pascal(index), self.y).reverse_bits();
        Vec2::new(unit(x), unit(y))
    }
}

/// Nested uniform scrambling of a bit-mirrored number: whether a bit flips depends on the bits below it (those before it, once mirrored back).
#[inline]
pub(crate) fn scramble(mut x: u32, key: u32) -> u32 {
    x ^= x.wrapping_mul(0x3d20_adea);
    x = x.wrapping_add(key);
    x = x.wrapping_mul(key >> 16 | 1);
    x ^= x.wrapping_mul(0x0552_6c56);
    x ^ x.wrapping_mul(0x53a2_2864)
}

/// P i: bit j of the result is the sum modulo 2 of the bits k of i with C(k, j) odd, that is, of all k ⊇ j as sets of binary digits.
#[inline]
fn pascal(mut i: u32) -> u32 {
    i ^= (i >> 1) & 0x5555_5555;
    i ^= (i >> 2) & 0x3333_3333;
    i ^= (i >> 4) & 0x0f0f_0f0f;
    i ^= (i >> 8) & 0x00ff_00ff;
    i ^ (i >> 16)
}

/// Place `i` of a random order of 0..n: a keyed bijection of the next power of two, repeated until it lands below n [Black, Rogaway 2002].
#[inline]
fn permute(mut i: u32, n: u32, key: u64) -> u32 {
    let bits = u32::BITS - n.saturating_sub(1).leading_zeros();
    let mask = ((1u64 << bits) - 1) as u32;
    loop {
        for round in 0..4 {
            let k = (key >> (16 * round)) as u32;
            i = (i ^ k).wrapping_mul(0x2c1b_3c6d ^ (k << 8 & 0xffff_ff00)) & mask;
            i ^= i >> bits.div_ceil(2).max(1);
        }
        if i < n {
            return i;
        }
    }
}

/// A bijection of 64 bits that looks random (splitmix64's finaliser [Steele, Lea, Flood 2014]).
#[inline]
pub fn mix(mut x: u64) -> u64 {
    x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ (x >> 31)
}

/// 32 random bits as a number in [0, 1): the top 24 of them.
#[inline]
pub fn unit(bits: u32) -> f32 {
    (bits >> 8) as f32 * (1.0 / 16_777_216.0)
}

/// An endless stream of numbers in [0, 1) that follow from a seed (splitmix64 [Steele, Lea, Flood 2014]), where nothing asks for even ones.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stream(pub u64);

impl Stream {
    /// The next number.
    #[inline]
    pub fn u1(&mut self) -> f32 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        unit((mix(self.0) >> 32) as u32)
    }

    /// The next point in [0, 1)².
    #[inline]
    pub fn u2(&mut self) -> Vec2 {
        let x = self.u1();
        Vec2::new(x, self.u1())
    }
}

/// The bits of x, each followed by a zero: one coordinate of the Z-curve [Morton 1966].
#[inline]
fn spread(x: u32) -> u64 {
    let mut x = u64::from(x);
    x = (x | x << 16) & 0x0000_ffff_0000_ffff;
    x = (x | x << 8) & 0x00ff_00ff_00ff_00ff;
    x = (x | x << 4) & 0x0f0f_0f0f_0f0f_0f0f;
    x = (x | x << 2) & 0x3333_3333_3333_3333;
    (x | x << 1) & 0x5555_5555_5555_5555
}

//! Where samples go, and that no mean suffers from it: pixels of known distribution stand for a renderer.

use etendue_check::{Moments, Rng, rng, t_test};
use etendue_film::{Allocation, Replicates};

const SIZE: [u32; 2] = [32, 8];
const PIXELS: usize = (SIZE[0] * SIZE[1]) as usize;
const K: usize = Replicates::K;

fn place(i: usize) -> [u32; 2] {
    [i as u32 % SIZE[0], i as u32 / SIZE[0]]
}

/// A sample of pixel i.
type Source<'a> = dyn Fn(usize, &mut Rng) -> f32 + 'a;

/// Sums of a pixel: Σ w L, Σ w; and Σ L, Σ 1 for whoever weighs all alike.
type Sums = [f64; 4];

/// Renders so many rounds: the sums of each pixel, and the allocation of the last round.
fn rounds(source: &Source<'_>, count: u32, rng: &mut Rng) -> (Vec<Sums>, Allocation) {
    let (mut replicates, mut allocation) = (Replicates::new(SIZE), Allocation::new(SIZE));
    let mut sums = vec![[0.0; 4]; PIXELS];
    let mut pass = 0;
    for round in 0..count {
        if round > 0 {
            let picture: Vec<[f32; 3]> = sums.iter().map(|s| [(s[0] / s[1]) as f32; 3]).collect();
            allocation.advance(&replicates, &picture);
        }
        let end = 1 << round;
        while pass < end {
            for (i, sums) in sums.iter_mut().enumerate() {
                let weight = allocation.weight(place(i));
                for r in 0..K {
                    for _ in allocation.samples(place(i), r, pass) {
                        let l = source(i, rng);
                        replicates.add(r, i, [l * weight; 3]);
                        let (l, w) = (f64::from(l), f64::from(weight));
                        sums.iter_mut().zip([w * l, w, l, 1.0]).for_each(|(s, x)| *s += x);
                    }
                }
            }
            pass += 1;
        }
    }
    (sums, allocation)
}

/// 1 on average: a flash of 1/q with probability q, or nothing.
fn flash(q: f64, rng: &mut Rng) -> f32 {
    if rng.u1_f64() < q { (1.0 / q) as f32 } else { 0.0 }
}

/// Means over the picture of so many renders, each 1 if there is no bias: as the film weighs samples, and with all samples alike.
fn means(renders: u64, count: u32) -> [Moments; 2] {
    let mut means = [Moments::default(); 2];
    for seed in 0..renders {
        // In a quarter of the picture flashes are rare.
        let flashes = |i: usize, rng: &mut Rng| flash(if place(i)[0] < SIZE[0] / 4 { 0.02 } else { 0.5 }, rng);
        let (sums, _) = rounds(&flashes, count, &mut rng(seed));
        let mean = |of: &dyn Fn(&Sums) -> f64| sums.iter().map(of).sum::<f64>() / PIXELS as f64;
        means[0].add(mean(&|s| s[0] / s[1]));
        means[1].add(mean(&|s| s[2] / s[3]));
    }
    means
}

/// False alarms of the tests of means.
const ALPHA: f64 = 0.01;

/// Rare flashes are what counts that follow noise are led astray by: a pixel that met none looks clean. The mean stays the truth, to 1 %, and
/// the same test finds the bias of weighing all samples alike.
#[test]
fn means_do_not_suffer() {
    let [weighed, alike] = means(400, 5);
    let verdict = t_test(&weighed, 1.0).verdict(ALPHA, 0.01);
    assert!(verdict.passes(), "{verdict}");
    let saboteur = t_test(&alike, 1.0).verdict(ALPHA, 0.01);
    assert!(saboteur.fails(), "samples weighed alike: {saboteur}");
}

/// The textbook's mistake: each pixel stops when its own samples seem to vary little.
#[test]
fn pixels_that_stop_by_themselves_are_caught() {
    let stops = |rng: &mut Rng| {
        let mut pixel = Moments::default();
        while pixel.n < 16 || (pixel.n < 256 && pixel.standard_error() > 0.5 * pixel.mean) {
            for _ in 0..16 {
                pixel.add(f64::from(flash(0.02, rng)));
            }
        }
        pixel.mean
    };
    let means: Moments = (0..4000).map(|seed| stops(&mut rng(seed))).collect();
    let verdict = t_test(&means, 1.0).verdict(ALPHA, 0.1);
    assert!(verdict.fails() && means.mean < 0.95, "{verdict}");
}

/// Neyman's allocation: the left half has a quarter of the right half's standard deviation, both are 1 on average.
#[test]
fn samples_go_where_the_noise_is() {
    let right = |i: usize| i as u32 % SIZE[0] >= SIZE[0] / 2;
    let uneven = |i: usize, rng: &mut Rng| 1.0 + if right(i) { 0.8 } else { 0.2 } * (2.0 * rng.u1() - 1.0);
    let (_, allocation) = rounds(&uneven, 7, &mut rng(1));
    let taken = allocation.taken(K as u32 * 64);
    let mean = |columns: std::ops::Range<u32>| {
        let some: Moments = (0..PIXELS).filter(|i| columns.contains(&place(*i)[0])).map(|i| f64::from(taken[i])).collect();
        some.mean
    };
    let all = mean(0..SIZE[0]);
    assert!((all / (64 * K) as f64 - 1.0).abs() < 0.01, "{all} on average");
    // Beyond the reach of windows across the middle.
    let (left, right) = (mean(0..8), mean(24..32));
    // Two rounds of 16 are even: of 1024 samples 992 go by 1 : 4.
    assert!((right / left - 4.0).abs() < 0.6, "{left} and {right}");
}

/// One sample ten thousand times as bright as the even noise around it takes less than a third of all samples to itself and the 24 pixels around it; by its own variance
/// it would have all that there are, of what is not given to everyone. No pixel is left out.
#[test]
fn a_firefly_is_not_fed() {
    const FIREFLY: usize = 3 * SIZE[0] as usize + 16;
    let (mut replicates, mut allocation) = (Replicates::new(SIZE), Allocation::new(SIZE));
    for round in 0..8 {
        for i in 0..PIXELS {
            for r in 0..K {
                let noise = if (r + i) % 2 == 0 { 0.9 } else { 1.1 };
                let firefly = if (i, r, round) == (FIREFLY, 3, 0) { 1000.0 } else { 0.0 };
                replicates.add(r, i, [(noise + firefly) * if round == 0 { 1.0 } else { (1 << (round - 1)) as f32 }; 3]);
            }
        }
        let firefly = |i| if i == FIREFLY { 1000.0 / (K << round) as f32 } else { 0.0 };
        let picture: Vec<[f32; 3]> = (0..PIXELS).map(|i| [1.0 + firefly(i); 3]).collect();
        allocation.advance(&replicates, &picture);
    }
    let taken = allocation.taken(K as u32 * 128);
    let least = *taken.iter().min().expect("pixels");
    let near = |i: &usize| place(*i)[0].abs_diff(place(FIREFLY)[0]) <= 2 && place(*i)[1].abs_diff(place(FIREFLY)[1]) <= 2;
    let fed = (0..PIXELS).filter(near).map(|i| taken[i]).sum::<u32>();
    let all = taken.iter().sum::<u32>();
    assert!(least >= 256 && 3 * fed < all, "{least} at least, {fed} of {all}");
}

/// Each pixel takes the samples of each replicate in order; those of a round weigh as much as its passes; no pass is crowded.
#[test]
fn rounds_are_complete_and_passes_even() {
    let uneven = |i: usize, rng: &mut Rng| (i as f32) * (rng.u1() - 0.5) + 50.0;
    let (_, allocation) = rounds(&uneven, 6, &mut rng(1));
    let mut per_pass = [0usize; 16 * K];
    for i in 0..PIXELS {
        let weight = allocation.weight(place(i));
        for r in 0..K {
            let mut next = allocation.samples(place(i), r, 16).start;
            let first = next;
            for pass in 16..32 {
                let samples = allocation.samples(place(i), r, pass);
                assert_eq!(samples.start, next);
                next = samples.end;
                per_pass[(pass as usize - 16) * K + r] += samples.len();
            }
            assert!(((next - first) as f32 * weight - 16.0).abs() < 1e-3, "{first}..{next}");
        }
    }
    let (least, most) = (per_pass.iter().min().expect("passes"), per_pass.iter().max().expect("passes"));
    assert!(*most <= 2 * *least, "{least} to {most} samples a pass, {PIXELS} on average");
}

/// Nothing is noisy in the dark, and where all is as noisy there is nothing to win: all pixels are the same. Rare flashes look uneven, for they are met here and there; they are not
/// taken for it.
#[test]
fn what_is_even_stays_so() {
    let sources: [&Source<'_>; 3] = [&|_, _| 0.0, &|_, rng| rng.u1(), &|_, rng| flash(0.02, rng)];
    for (source, seed) in sources.into_iter().zip(1..) {
        let (_, allocation) = rounds(source, 5, &mut rng(seed));
        assert_eq!(allocation.taken(16 * K as u32), vec![16 * K as u32; PIXELS], "source {seed}");
        assert!(allocation.is_even());
    }
}

/// Of a large picture only some pixels are looked at; their neighbours get samples as they do.
#[test]
fn large_pictures_are_planned_from_the_pixels_that_are_tracked() {
    let size = [1280, 720];
    let (mut replicates, mut allocation) = (Replicates::new(size), Allocation::new(size));
    for _ in 0..2 {
        for (y, x) in (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| (y, x))) {
            let Some(slot) = replicates.slot([x, y]) else { continue };
            let noise = if x < 640 { 0.01 } else { 0.3 };
            (0..K).for_each(|r| replicates.add(r, slot, [1.0 + if r % 2 == 0 { noise } else { -noise }; 3]));
        }
        allocation.advance(&replicates, &vec![[1.0; 3]; 1280 * 720]);
    }
    let counts = |x: u32| (0..720).map(|y| 1.0 / f64::from(allocation.weight([x, y]))).sum::<f64>() / 720.0;
    assert!(counts(300) < 0.6 && counts(1000) > 1.2, "{} and {}", counts(300), counts(1000));
}

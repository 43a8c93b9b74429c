//! The film from outside: constants, energy, what is not finite, checkpoints.

use etendue_film::{Film, FilmShape, NonFinite, Splat};
use etendue_numerics::kernel::Kernel;
use etendue_numerics::{Spectrum, Vec2};

fn film(kernel: Kernel) -> Film {
    Film::new(FilmShape { size: [20, 37], kernel })
}

fn kernels() -> [Kernel; 6] {
    [
        Kernel::Box { radius: 0.5 },
        Kernel::Tent { radius: 1.0 },
        Kernel::Gaussian { stddev: 0.5 },
        Kernel::Mitchell { b: 1.0 / 3.0, c: 1.0 / 3.0 },
        Kernel::CatmullRom,
        Kernel::Lanczos { lobes: 3.0 },
    ]
}

/// A constant scene gives the constant, whatever the filter and the tiling.
#[test]
fn a_constant_is_reproduced_by_every_filter() {
    for kernel in kernels() {
        let film = film(kernel);
        let mut tile = film.tile();
        for (y0, y1) in [(0u32, 16u32), (16, 32), (32, 37)] {
            for (x0, x1) in [(0u32, 16u32), (16, 20)] {
                tile.begin([x0, y0], [x1, y1]);
                for y in y0..y1 {
                    for x in x0..x1 {
                        for s in 0..4 {
                            let at = Vec2::new(x as f32 + 0.25 + 0.5 * (s % 2) as f32, y as f32 + 0.25 + 0.5 * (s / 2) as f32);
                            tile.add(at, Spectrum::rgb(0.5, 2.0, 3.0), s);
                        }
                    }
                }
                film.add_tile(&tile);
            }
        }
        for pixel in film.develop() {
            for (p, want) in pixel.iter().zip([0.5, 2.0, 3.0]) {
                assert!((p - want).abs() < 1e-5, "{kernel:?} {pixel:?}");
            }
        }
    }
}

/// Splats keep their energy away from the border, and land where they are told.
#[test]
fn splats_keep_their_energy() {
    for kernel in kernels() {
        let film = film(kernel);
        film.start_particles(4);
        let value = Spectrum::rgb(8.0, 4.0, 1.0);
        film.add_splats(&[Splat { position: Vec2::new(10.3, 20.9), value, particle: 0 }]);
        let picture = film.develop();
        let sum: f64 = picture.iter().map(|p| f64::from(p[0])).sum();
        assert!((sum - 2.0).abs() < 1e-5, "{kernel:?}: {sum}");
        let brightest = picture.iter().enumerate().max_by(|a, b| a.1[0].total_cmp(&b.1[0])).map(|(i, _)| i);
        assert_eq!(brightest, Some(20 * 20 + 10), "{kernel:?}");
    }
}

/// Splats spread evenly over the film develop to a constant, at the border, too, and whatever fell beyond it.
#[test]
fn even_splats_are_a_constant() {
    for kernel in kernels() {
        let film = film(kernel);
        let per_side = 16;
        let mut splats = Vec::new();
        for (y, x) in (-5 * per_side..42 * per_side).flat_map(|y| (-5 * per_side..25 * per_side).map(move |x| (y, x))) {
            let position = (Vec2::new(x as f32, y as f32) + 0.5) / per_side as f32;
            splats.push(Splat { position, value: Spectrum::rgb(1.0, 2.0, 0.5), particle: 0 });
        }
        splats.chunks(1000).for_each(|some| film.add_splats(some));
        film.start_particles((per_side * per_side) as u64);
        for (i, pixel) in film.develop().iter().enumerate() {
            for (p, want) in pixel.iter().zip([1.0, 2.0, 0.5]) {
                assert!((p / want - 1.0).abs() < 2e-3, "{kernel:?}, pixel {i}: {pixel:?}");
            }
        }
    }
}

/// Splats have no order: all at once, one by one and from the last to the first they are the same bits, on a film of several bands and pieces, from
/// the faintest to the brightest.
#[test]
fn splats_have_no_order() {
    for kernel in kernels() {
        let film = || Film::new(FilmShape { size: [150, 37], kernel });
        let splats: Vec<Splat> = (0..400u32)
            .map(|i| {
                let position = Vec2::new((i * 37 % 1500) as f32 * 0.1, (i * 11 % 370) as f32 * 0.1);
                let value = Spectrum::rgb(1.0, -0.3, 7.1) * ((i * 7 % 90) as f32 - 45.0).exp2();
                Splat { position, value, particle: 0 }
            })
            .collect();
        let (at_once, one_by_one, backwards) = (film(), film(), film());
        at_once.add_splats(&splats);
        splats.iter().for_each(|s| one_by_one.add_splats(&[*s]));
        splats.iter().rev().for_each(|s| backwards.add_splats(&[*s]));
        assert!(at_once.sums() == one_by_one.sums() && at_once.sums() == backwards.sums(), "{kernel:?}");
    }
}

#[test]
fn particles_that_are_not_finite_are_told_by_pass_and_number() {
    let film = film(Kernel::Box { radius: 0.5 });
    let splat = |x: f32, particle| Splat { position: Vec2::new(x, 1.0), value: Spectrum::splat(f32::NAN), particle };
    film.add_splats(&[splat(3.0, 740 * 2 + 21), splat(f32::NAN, 0)]);
    let (count, which) = film.dropped();
    assert_eq!(count, 2);
    assert_eq!(which, [NonFinite { pixel: [0, 0], sample: 0 }, NonFinite { pixel: [1, 1], sample: 2 }]);
    film.start_particles(1);
    assert!(film.develop().iter().all(|p| *p == [0.0; 3]));
}

#[test]
fn a_checkpoint_restores_the_same_bits() {
    let a = film(Kernel::Gaussian { stddev: 0.5 });
    let mut tile = a.tile();
    tile.begin([0, 0], [16, 16]);
    for i in 0..100u32 {
        tile.add(Vec2::new((i * 7 % 160) as f32 * 0.1, (i * 13 % 160) as f32 * 0.1), Spectrum::splat(1.0 / (1.0 + i as f32)), i);
    }
    a.add_tile(&tile);
    a.add_splats(&[Splat { position: Vec2::new(3.3, 4.4), value: Spectrum::ONE, particle: 0 }]);
    a.start_particles(1);
    let b = film(Kernel::Gaussian { stddev: 0.5 });
    assert!(b.merge(&a.sums()));
    assert_eq!(a.develop(), b.develop());
    assert!(!Film::new(FilmShape { size: [3, 3], kernel: Kernel::CatmullRom }).merge(&a.sums()));
}

#[test]
fn values_that_are_not_finite_are_dropped_and_told() {
    let film = film(Kernel::Box { radius: 0.5 });
    let mut tile = film.tile();
    tile.begin([0, 0], [16, 16]);
    tile.add(Vec2::new(5.5, 6.5), Spectrum::splat(f32::NAN), 3);
    tile.add(Vec2::new(5.5, 6.5), Spectrum::splat(f32::INFINITY), 4);
    tile.add(Vec2::new(5.5, 6.5), Spectrum::ONE, 5);
    film.add_tile(&tile);
    let (count, which) = film.dropped();
    assert_eq!((count, which[0]), (2, NonFinite { pixel: [5, 6], sample: 3 }));
    assert_eq!(film.develop()[6 * 20 + 5], [1.0; 3]);
}

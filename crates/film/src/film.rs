//! The film: exact sums per pixel, in bands of rows that threads lock one at a time.

use crate::fixed::Fixed;
use crate::splat::{Splat, Stamp, shares};
use crate::tile::{KernelTable, Tile};
use etendue_numerics::kernel::Kernel;
use etendue_numerics::{Vec2, Vec4};
use serde::{Deserialize, Serialize};
use std::sync::{Mutex, PoisonError};

/// Rows of a band.
const BAND: usize = 16;

/// Size and filter of a film.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FilmShape {
    /// Pixels of the picture.
    pub size: [u32; 2],
    /// Reconstruction filter.
    pub kernel: Kernel,
}

/// A sample that was dropped because it was not finite.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct NonFinite {
    /// Its pixel.
    pub pixel: [u32; 2],
    /// Its number.
    pub sample: u32,
}

impl NonFinite {
    /// How many are remembered; all are counted.
    pub const KEPT: usize = 8;
}

/// The sums of a pixel: Σ k L over three channels, Σ k, and three channels of splats.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
struct Pixel {
    light: [Fixed; 3],
    weight: Fixed,
}

/// Everything that a film has measured, for checkpoints and merging.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Sums {
    size: [u32; 2],
    pixels: Vec<Pixel>,
    splats: Vec<[Fixed; 3]>,
    started: u64,
    dropped_count: u64,
    dropped: Vec<NonFinite>,
}

impl Sums {
    /// Pixels of the picture.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }
}

/// A film that many threads add to.
#[derive(Debug)]
pub struct Film {
    shape: FilmShape,
    kernel: KernelTable,
    bands: Vec<Mutex<Vec<Pixel>>>,
    /// Bands of splats; empty until the first splat falls there.
    splats: Vec<Mutex<Vec<[Fixed; 3]>>>,
    /// How much of each column's and each row's kernel lies within the film.
    shares: [Vec<f64>; 2],
    started: Mutex<u64>,
    dropped: Mutex<(u64, Vec<NonFinite>)>,
}

fn lock<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    // A thread that panicked while it held the lock has left whole pixels: sums are integers.
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Film {
    /// A blank film.
    pub fn new(shape: FilmShape) -> Self {
        let [width, height] = shape.size.map(|n| n as usize);
        let rows = |band: usize| BAND.min(height - band * BAND);
        let bands: Vec<_> = (0..height.div_ceil(BAND)).map(|b| Mutex::new(vec![Pixel::default(); width * rows(b)])).collect();
        let kernel = KernelTable::new(&shape.kernel);
        Self {
            shape,
            splats: bands.iter().map(|_| Mutex::default()).collect(),
            shares: [shares(&kernel, width), shares(&kernel, height)],
            kernel,
            bands,
            started: Mutex::default(),
            dropped: Mutex::default(),
        }
    }

    /// Bytes that a film of `size` takes, splats included.
    pub fn bytes(size: [u32; 2]) -> u64 {
        let pixel = size_of::<Pixel>() + size_of::<[Fixed; 3]>();
        u64::from(size[0]) * u64::from(size[1]) * pixel as u64
    }

    /// Size and filter.
    pub fn shape(&self) -> &FilmShape {
        &self.shape
    }

    /// An empty tile for a thread to fill again and again.
    pub fn tile(&self) -> Tile {
        Tile::new(self.kernel.clone(), self.shape)
    }

    /// Adds a tile's sums; what its border holds beyond the film is cut off.
    pub fn add_tile(&self, tile: &Tile) {
        let [width, height] = self.shape.size.map(|n| n as i32);
        let [x0, y0] = tile.origin;
        let columns = x0.max(0)..(x0 + tile.size[0]).min(width);
        let mut y = y0.max(0);
        let end = (y0 + tile.size[1]).min(height);
        while y < end {
            let band = y as usize / BAND;
            let mut pixels = lock(&self.bands[band]);
            while y < end && y as usize / BAND == band {
                let from = ((y - y0) * tile.size[0] + columns.start - x0) as usize;
                let to = (y as usize % BAND) * width as usize + columns.start as usize;
                let n = columns.len();
                for (pixel, sum) in pixels[to..to + n].iter_mut().zip(&tile.sums[from..from + n]) {
                    pixel.add(*sum);
                }
                y += 1;
            }
        }
        if tile.dropped_count > 0 {
            self.drop_samples(tile.dropped_count, &tile.dropped);
        }
    }

    /// Adds light paths' contributions through the kernel, scaled to integral 1. Positions beyond the film do not count: pixels are made of
    /// what falls on the film, as those of [`Film::add_tile`] are.
    pub fn add_splats(&self, splats: &[Splat]) {
        let [width, height] = self.shape.size;
        let pixels = u64::from(width) * u64::from(height);
        let mut landed = Vec::with_capacity(splats.len());
        for splat in splats {
            let Vec2 { x, y } = splat.position;
            if !splat.value.is_finite() || !splat.position.is_finite() {
                // Particles are numbered through the passes, one a pixel each.
                let (pass, place) = (splat.particle / pixels.max(1), (splat.particle % pixels.max(1)) as u32);
                self.drop_samples(1, &[NonFinite { pixel: [place % width, place / width], sample: pass as u32 }]);
            } else if x >= 0.0 && y >= 0.0 && x < width as f32 && y < height as f32 {
                landed.push(*splat);
            }
        }
        // From top to bottom, so that each band is locked once.
        landed.sort_unstable_by(|a, b| a.position.y.total_cmp(&b.position.y));
        let reach = self.kernel.border() as f32 + 1.0;
        for (b, band) in self.splats.iter().enumerate() {
            let (top, bottom) = ((b * BAND) as i32, ((b + 1) * BAND).min(height as usize) as i32);
            let first = landed.partition_point(|s| s.position.y < top as f32 - reach);
            let near = &landed[first..];
            let near = &near[..near.partition_point(|s| s.position.y < bottom as f32 + reach)];
            if !near.is_empty() {
                let mut pixels = lock(band);
                pixels.resize(width as usize * (bottom - top) as usize, [Fixed::ZERO; 3]);
                near.iter().for_each(|s| Stamp::new(s, &self.kernel).add(&mut pixels, width as i32, top..bottom));
            }
        }
    }

    /// Counts particles as started: splats are divided by their number.
    pub fn start_particles(&self, count: u64) {
        *lock(&self.started) += count;
    }

    fn drop_samples(&self, count: u64, which: &[NonFinite]) {
        let mut dropped = lock(&self.dropped);
        dropped.0 += count;
        dropped.1.extend_from_slice(which);
        // Which ones are remembered must not depend on which thread came first.
        dropped.1.sort_by_key(|d| (d.sample, d.pixel[1], d.pixel[0]));
        dropped.1.truncate(NonFinite::KEPT);
    }

    /// How many samples were dropped because they were not finite, and the first few of them.
    pub fn dropped(&self) -> (u64, Vec<NonFinite>) {
        lock(&self.dropped).clone()
    }

    /// The picture: linear Rec.709, rows from the top, three numbers a pixel. Pixels that no sample reached are black.
    pub fn develop(&self) -> Vec<[f32; 3]> {
        let mut picture = Vec::with_capacity(self.shape.size[0] as usize * self.shape.size[1] as usize);
        for band in &self.bands {
            picture.extend(lock(band).iter().map(Pixel::value));
        }
        let started = *lock(&self.started);
        let [columns, rows] = &self.shares;
        for (b, band) in self.splats.iter().enumerate().filter(|_| started > 0) {
            let first = b * BAND * columns.len();
            for (i, (splat, pixel)) in lock(band).iter().zip(picture.iter_mut().skip(first)).enumerate() {
                let share = columns[i % columns.len()] * rows[b * BAND + i / columns.len()];
                for (p, s) in pixel.iter_mut().zip(splat) {
                    *p += (s.to_f64() / (started as f64 * share)) as f32;
                }
            }
        }
        picture
    }

    /// Everything measured so far.
    pub fn sums(&self) -> Sums {
        let mut pixels = Vec::with_capacity(self.shape.size[0] as usize * self.shape.size[1] as usize);
        for band in &self.bands {
            pixels.extend_from_slice(&lock(band));
        }
        let (dropped_count, dropped) = self.dropped();
        let mut splats = Vec::new();
        if self.splats.iter().any(|band| !lock(band).is_empty()) {
            for (band, pixels) in self.splats.iter().zip(&self.bands) {
                splats.extend_from_slice(&lock(band));
                splats.resize(splats.len() + lock(pixels).len() - lock(band).len(), [Fixed::ZERO; 3]);
            }
        }
        Sums { size: self.shape.size, pixels, splats, started: *lock(&self.started), dropped_count, dropped }
    }

    /// Adds what another film of the same size measured: a checkpoint, a shard. `false`, and nothing added, where the sizes differ.
    pub fn merge(&self, sums: &Sums) -> bool {
        let count = self.shape.size[0] as usize * self.shape.size[1] as usize;
        let fits = sums.size == self.shape.size && sums.pixels.len() == count && [0, count].contains(&sums.splats.len());
        if !fits {
            return false;
        }
        let mut rest = sums.pixels.as_slice();
        for band in &self.bands {
            let mut pixels = lock(band);
            let (these, after) = rest.split_at(pixels.len());
            for (pixel, other) in pixels.iter_mut().zip(these) {
                pixel.merge(other);
            }
            rest = after;
        }
        let mut rest = sums.splats.as_slice();
        for (band, pixels) in self.splats.iter().zip(&self.bands).filter(|_| !sums.splats.is_empty()) {
            let mut splats = lock(band);
            let (these, after) = rest.split_at(lock(pixels).len());
            splats.resize(these.len(), [Fixed::ZERO; 3]);
            for (a, b) in splats.iter_mut().flatten().zip(these.iter().flatten()) {
                *a += *b;
            }
            rest = after;
        }
        self.start_particles(sums.started);
        self.drop_samples(sums.dropped_count, &sums.dropped);
        true
    }
}

impl Pixel {
    #[inline]
    fn add(&mut self, sum: Vec4) {
        for (channel, v) in self.light.iter_mut().zip([sum.x, sum.y, sum.z]) {
            *channel += Fixed::from_f32(v);
        }
        self.weight += Fixed::from_f32(sum.w);
    }

    fn merge(&mut self, other: &Self) {
        for (a, b) in self.light.iter_mut().zip(other.light) {
            *a += b;
        }
        self.weight += other.weight;
    }

    fn value(&self) -> [f32; 3] {
        let weight = self.weight.to_f64();
        if weight > 0.0 { self.light.map(|c| (c.to_f64() / weight) as f32) } else { [0.0; 3] }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use etendue_numerics::Spectrum;

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
            tile.add(
                Vec2::new((i * 7 % 160) as f32 * 0.1, (i * 13 % 160) as f32 * 0.1),
                Spectrum::splat(1.0 / (1.0 + i as f32)),
                i,
            );
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
}

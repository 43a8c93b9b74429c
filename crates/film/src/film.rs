//! The film: exact sums per pixel, in bands of rows that threads lock one at a time.

use crate::fixed::{Channels, Fixed};
use crate::splat::{Splat, Stamps, by_band, shares};
use crate::sums::{NonFinite, Pixel, Sums};
use crate::tile::{KernelTable, Tile};
use etendue_numerics::kernel::Kernel;
use etendue_numerics::{Vec2, wide};
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

/// A film that many threads add to.
#[derive(Debug)]
pub struct Film {
    shape: FilmShape,
    kernel: KernelTable,
    bands: Vec<Mutex<Vec<Pixel>>>,
    /// Bands of splats; empty until the first splat falls there.
    splats: Vec<Mutex<Vec<Channels>>>,
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
        let pixel = size_of::<Pixel>() + size_of::<Channels>();
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
        // Each band is locked once.
        let (landed, ranges) = by_band(&landed, &self.kernel, width as usize, BAND, self.splats.len());
        for (b, (band, range)) in self.splats.iter().zip(ranges).enumerate().filter(|(_, (_, range))| !range.is_empty()) {
            let (top, bottom) = ((b * BAND) as i32, ((b + 1) * BAND).min(height as usize) as i32);
            let mut pixels = lock(band);
            pixels.resize(width as usize * (bottom - top) as usize, Channels::default());
            let (kernel, pixels) = (&self.kernel, &mut pixels[..]);
            wide::widest(Stamps { splats: &landed[range], kernel, pixels, width: width as i32, rows: top..bottom });
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
                for (p, s) in pixel.iter_mut().zip(splat.get()) {
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
                splats.extend(lock(band).iter().map(Channels::get));
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
            splats.resize(these.len(), Channels::default());
            splats.iter_mut().zip(these).for_each(|(sum, other)| sum.add(other));
            rest = after;
        }
        self.start_particles(sums.started);
        self.drop_samples(sums.dropped_count, &sums.dropped);
        true
    }
}

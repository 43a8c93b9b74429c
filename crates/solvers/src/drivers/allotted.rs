//! Passes over pixels that take as many samples in each as it is allotted ([`etendue_film::Allocation`]), tile by tile.
//!
//! A sample weighs what makes its round count in every pixel alike. Walks are alone here: solvers whose walks share what neighbours find do so where all take as many samples, and
//! do not come here.

use super::Work;
use super::pixels::{CROWD, PixelSolver, SamplePlan, Tiling, set_out};
use crate::run::Run;
use crate::transport::{Context, Crowd};
use etendue_film::{Allocation, Tile};
use etendue_numerics::{Sampler, Spectrum};
use rayon::prelude::*;
use std::ops::Range;
use std::sync::PoisonError;
use std::sync::atomic::{AtomicUsize, Ordering};

/// A pass over some tiles.
pub(super) struct Pass<'a, S> {
    pub(super) solver: &'a S,
    pub(super) context: Context<'a>,
    pub(super) run: &'a Run<'a>,
    pub(super) plan: &'a SamplePlan,
    pub(super) tiling: &'a Tiling,
    pub(super) allocation: &'a Allocation,
    pub(super) work: &'a Work<'a>,
}

impl<S: PixelSolver> Pass<'_, S> {
    /// All that is to be done in these tiles.
    pub(super) fn over(&self, tiles: Range<usize>) {
        let (groups, next) = (self.groups(tiles), AtomicUsize::new(0));
        rayon::broadcast(|_| {
            let (mut tile, mut crowd) = (self.work.film.tile(), Crowd::default());
            while let Some(tiles) = groups.get(next.fetch_add(1, Ordering::Relaxed))
                && !(self.work.stop_now)()
            {
                self.fill(tiles, &mut crowd, &mut tile);
            }
        });
    }

    /// Which samples a pixel takes.
    #[inline]
    fn samples(&self, pixel: [u32; 2]) -> Range<u32> {
        self.allocation.samples(pixel, self.plan.replicate, self.plan.sample)
    }

    /// Tiles of about a crowd of walks together, fewer where there are too few to go round.
    fn groups(&self, tiles: Range<usize>) -> Vec<Range<usize>> {
        let walks = |tile: usize| self.tiling.pixels(tile).map(|pixel| self.samples(pixel).len()).sum();
        let counts: Vec<usize> = tiles.clone().into_par_iter().map(walks).collect();
        let enough = (counts.iter().sum::<usize>() / (4 * rayon::current_num_threads())).min(CROWD);
        let (mut groups, mut first, mut sum) = (Vec::new(), tiles.start, 0);
        for (tile, count) in tiles.clone().zip(counts) {
            if tile > first && sum + count > enough {
                groups.push(first..tile);
                (first, sum) = (tile, 0);
            }
            sum += count;
        }
        groups.push(first..tiles.end);
        groups
    }

    fn fill<'c>(&'c self, tiles: &Range<usize>, crowd: &mut Crowd<'c>, tile: &mut Tile) {
        let work = self.work;
        let todo = || tiles.clone().filter(|index| !work.units.is_done(*index));
        let of_pixel = |pixel: [u32; 2]| self.samples(pixel).map(move |sample| (pixel, sample));
        let samples: Vec<_> = todo().flat_map(|index| self.tiling.pixels(index)).flat_map(of_pixel).collect();
        let mut seen = Vec::with_capacity(samples.len());
        let mut rays = 0;
        let [left, top] = self.context.scene.views[self.run.view].film.crop_offset;
        // Where a tile is allotted many.
        let crowds = samples.len().div_ceil(2 * CROWD).max(1);
        for crowded in samples.chunks(samples.len().div_ceil(crowds).max(1)) {
            crowd.clear();
            let first = seen.len();
            let walk = |([x, y], sample): &([u32; 2], u32)| {
                let pixel = [x + left, y + top];
                (pixel, Sampler::on_screen(self.run.sequence, self.plan.seed, pixel, *sample, self.plan.count))
            };
            set_out(&self.context, self.run.view, crowded, walk, crowd, |position| seen.push((position, Spectrum::ZERO)));
            self.solver.radiances(&self.context, crowd, &mut rays);
            seen[first..].iter_mut().zip(crowd.collected()).for_each(|((_, l), collected)| *l = collected);
        }

        // What they collected, tile by tile.
        let mut collected = seen.iter();
        for index in todo() {
            let (low, high) = self.tiling.rectangle(index);
            tile.begin(low, high);
            let mut tracked = work.replicates.map(|r| r.lock().unwrap_or_else(PoisonError::into_inner));
            for pixel in self.tiling.pixels(index) {
                let weight = self.allocation.weight(pixel);
                let slot = tracked.as_ref().and_then(|sums| sums.slot(pixel));
                for (position, l) in collected.by_ref().take(self.samples(pixel).len()) {
                    tile.add_weighted(*position, *l, weight, self.plan.pass);
                    if let (Some(sums), Some(slot)) = (&mut tracked, slot) {
                        sums.add(self.plan.replicate, slot, (*l * weight).to_rgb());
                    }
                }
            }
            if let Some(sums) = &mut tracked {
                sums.add_tile(self.plan.replicate, tile);
            }
            drop(tracked);
            work.film.add_tile(tile);
            work.units.done(index);
            work.progress.tiles.fetch_add(1, Ordering::Relaxed);
        }
        work.progress.rays.fetch_add(rays, Ordering::Relaxed);
        work.progress.paths.fetch_add(samples.len() as u64, Ordering::Relaxed);
    }
}

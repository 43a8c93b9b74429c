//! Replicates of one solver's work.

use super::Grid;
use etendue_check::Moments;

/// Means of the areas of a picture over independent replicates.
#[derive(Clone, Debug)]
pub struct Sample {
    grid: Grid,
    areas: Vec<[Moments; 3]>,
}

impl Sample {
    /// No replicates yet.
    pub fn new(grid: Grid) -> Self {
        Self { grid, areas: vec![[Moments::default(); 3]; grid.len()] }
    }

    /// One replicate more: an independent picture of the same expectation and variance.
    pub fn add(&mut self, picture: &[[f32; 3]]) {
        self.add_means(self.grid.means(picture));
    }

    /// One replicate more, by the means of its areas, in the order of [`Grid::areas`].
    pub fn add_means(&mut self, means: impl IntoIterator<Item = [f64; 3]>) {
        for (area, means) in self.areas.iter_mut().zip(means) {
            area.iter_mut().zip(means).for_each(|(moments, mean)| moments.add(mean));
        }
    }

    /// The partition.
    pub fn grid(&self) -> Grid {
        self.grid
    }

    /// Replicates so far.
    pub fn count(&self) -> usize {
        self.areas[0][0].n
    }

    /// Moments of the areas, in the order of [`Grid::areas`], channel by channel.
    pub fn areas(&self) -> &[[Moments; 3]] {
        &self.areas
    }
}

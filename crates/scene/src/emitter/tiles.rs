//! A picture all around in tiles: which tile is one choice, which cell of it another, so that the first can be made anew for each place.
//!
//! ```text
//! P(cell) = P(tile) P(cell | tile)
//! ```
//!
//! Tiles are blocks of cells, as many as [`TILES`] across and down where the picture has so many.

use etendue_numerics::Vec2;
use etendue_numerics::math::ONE_MINUS_EPSILON;
use etendue_numerics::table::Table2D;

/// Across and down: 11° each.
const TILES: [usize; 2] = [32, 16];

/// The cells of a picture by tiles.
#[derive(Clone, Debug)]
pub(super) struct Tiles {
    /// Cells across and down, and tiles across and down.
    cells: [usize; 2],
    tiles: [usize; 2],
    within: Vec<Table2D>,
    weights: Vec<f32>,
    own: TileChoice,
}

impl Tiles {
    /// Of `width` × `height` cells with weights ≥ 0, row by row.
    pub fn new(weights: &[f32], width: usize, height: usize) -> Self {
        let (cells, tiles) = ([width, height], [width.min(TILES[0]), height.min(TILES[1])]);
        let mut within = Vec::with_capacity(tiles[0] * tiles[1]);
        for tile in 0..tiles[0] * tiles[1] {
            let at = [tile % tiles[0], tile / tiles[0]];
            let [columns, rows] = [0, 1].map(|a| begin(at[a], cells[a], tiles[a])..begin(at[a] + 1, cells[a], tiles[a]));
            let block: Vec<f32> = rows.clone().flat_map(|y| &weights[y * width..][columns.clone()]).copied().collect();
            within.push(Table2D::new(&block, columns.len(), rows.len()));
        }
        let weights: Vec<f32> = within.iter().map(|t| t.sum() as f32).collect();
        let own = TileChoice::new(&weights, tiles[0]);
        Self { cells, tiles, within, weights, own }
    }

    /// Σ of the weights of each tile's cells.
    pub fn weights(&self) -> &[f32] {
        &self.weights
    }

    /// How many tiles a row has.
    pub fn across(&self) -> usize {
        self.tiles[0]
    }

    /// The choice in proportion to the weights.
    pub fn own(&self) -> &TileChoice {
        &self.own
    }

    /// The probability of the cell in (column, row) if its tile is drawn by `choice`.
    #[inline]
    pub fn probability(&self, choice: &TileChoice, cell: [usize; 2]) -> f32 {
        let at = [0, 1].map(|a| ((cell[a] + 1) * self.tiles[a] - 1) / self.cells[a]);
        let [column, row] = [0, 1].map(|a| cell[a] - begin(at[a], self.cells[a], self.tiles[a]));
        let tile = at[1] * self.tiles[0] + at[0];
        choice.probability(tile) * self.within[tile].probability(column, row)
    }

    /// A cell, (column, row), its probability, and u stretched over it.
    #[inline]
    pub fn sample(&self, choice: &TileChoice, u: Vec2) -> ([usize; 2], f32, Vec2) {
        let (tile, p, u) = choice.sample(u);
        let (cell, p_within, rest) = self.sample_within(tile, u);
        (cell, p * p_within, rest)
    }

    /// The same within a tile.
    #[inline]
    pub fn sample_within(&self, tile: usize, u: Vec2) -> ([usize; 2], f32, Vec2) {
        let (column, row, p, rest) = self.within[tile].sample_discrete(u);
        let at = [tile % self.tiles[0], tile / self.tiles[0]];
        let [x, y] = [0, 1].map(|a| begin(at[a], self.cells[a], self.tiles[a]));
        ([x + column, y + row], p, rest)
    }
}

/// The first of `cells` in tile `i` of `tiles`.
#[inline]
fn begin(i: usize, cells: usize, tiles: usize) -> usize {
    i * cells / tiles
}

/// Probabilities of tiles: steps of the cumulative distribution over rows, then over each row's tiles.
#[derive(Clone, Debug)]
pub(super) struct TileChoice {
    across: usize,
    steps: Box<[f32]>,
}

impl TileChoice {
    /// In proportion to `weights`, `across` tiles a row; evenly where there are none.
    pub fn new(weights: &[f32], across: usize) -> Self {
        let rows = weights.chunks(across);
        let mut all = Vec::with_capacity((across + 2) * rows.len() + 1);
        let sums: Vec<f64> = rows.clone().map(|row| row.iter().map(|w| f64::from(*w)).sum()).collect();
        push_steps(&mut all, sums.into_iter());
        rows.for_each(|row| push_steps(&mut all, row.iter().map(|w| f64::from(*w))));
        Self { across, steps: all.into() }
    }

    #[inline]
    fn rows(&self) -> usize {
        (self.steps.len() - 1) / (self.across + 2)
    }

    #[inline]
    fn row(&self, row: usize) -> &[f32] {
        &self.steps[self.rows() + 1 + row * (self.across + 1)..][..=self.across]
    }

    /// P(tile).
    #[inline]
    pub fn probability(&self, tile: usize) -> f32 {
        let (row, column) = (tile / self.across, tile % self.across);
        let steps = self.row(row);
        (self.steps[row + 1] - self.steps[row]) * (steps[column + 1] - steps[column])
    }

    /// A tile, its probability, and u stretched over it.
    #[inline]
    pub fn sample(&self, u: Vec2) -> (usize, f32, Vec2) {
        let (row, p_row, y) = find(&self.steps[..=self.rows()], u.y);
        let (column, p_column, x) = find(self.row(row), u.x);
        (row * self.across + column, p_row * p_column, Vec2::new(x, y))
    }
}

/// Appends 0 and the partial sums of weights over their sum; the last step with weight ends at 1.
fn push_steps(all: &mut Vec<f32>, weights: impl ExactSizeIterator<Item = f64> + Clone) {
    let (n, from) = (weights.len(), all.len());
    let sum: f64 = weights.clone().sum();
    let mut below = 0.0;
    all.push(0.0);
    all.extend(weights.map(|w| {
        below += if sum > 0.0 { w / sum } else { 1.0 / n as f64 };
        below.min(1.0) as f32
    }));
    let top = all[from + n];
    all[from..].iter_mut().rev().take_while(|c| **c == top).for_each(|c| *c = 1.0);
}

/// The step that holds u in [0, 1), its height, and where in it u lies.
#[inline]
fn find(steps: &[f32], u: f32) -> (usize, f32, f32) {
    let i = steps[1..steps.len() - 1].partition_point(|c| *c <= u);
    let p = steps[i + 1] - steps[i];
    (i, p, ((u - steps[i]) / p).clamp(0.0, ONE_MINUS_EPSILON))
}

#[cfg(test)]
mod tests {
    use super::*;
    use etendue_check::rng;

    #[test]
    fn draws_have_the_probability_that_is_told_of_them_and_all_sum_to_one() {
        let mut r = rng(3);
        for [width, height] in [[1, 1], [2, 1], [7, 5], [33, 17], [100, 40]] {
            let weights: Vec<f32> = (0..width * height).map(|_| if r.u1() < 0.3 { 0.0 } else { r.u1() }).collect();
            let tiles = Tiles::new(&weights, width, height);
            let other: Vec<f32> = tiles.weights().iter().map(|w| if *w > 0.0 { r.u1() } else { 0.0 }).collect();
            for choice in [tiles.own(), &TileChoice::new(&other, tiles.across())] {
                let cells = || (0..height).flat_map(|y| (0..width).map(move |x| [x, y]));
                let sum: f64 = cells().map(|c| f64::from(tiles.probability(choice, c))).sum();
                assert!((sum - 1.0).abs() < 1e-4, "{width} x {height}: {sum}");
                for _ in 0..500 {
                    let ([x, y], p, rest) = tiles.sample(choice, r.u2());
                    assert!(x < width && y < height && rest.cmplt(Vec2::ONE).all() && rest.cmpge(Vec2::ZERO).all());
                    assert!(p > 0.0 && (p / tiles.probability(choice, [x, y]) - 1.0).abs() < 1e-4);
                }
            }
            // Its own choice is in proportion to the weights.
            let sum: f32 = weights.iter().sum();
            if sum > 0.0 {
                let fine = |([x, y], w): ([usize; 2], &f32)| (tiles.probability(tiles.own(), [x, y]) - w / sum).abs() < 1e-5;
                assert!((0..width * height).map(|i| [i % width, i / width]).zip(&weights).all(fine));
            }
        }
    }
}

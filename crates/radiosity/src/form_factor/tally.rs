//! Counting where weighted rays of one row land, replicate by replicate.
//!
//! With m_r the estimate of replicate r of 16, F = mean of m_r and SE² = (mean of m_r² - F²) / 15.

/// Independent scramblings of the same work.
pub const REPLICATES: u32 = 16;

/// The counts of one row over columns 0 … n - 1. Made once and used for many rows.
#[derive(Debug)]
pub(crate) struct Tally {
    total: Vec<f32>,
    /// Σ over finished replicates of the square of their weight.
    squares: Vec<f32>,
    /// Of the replicate that runs.
    within: Vec<f32>,
    touched: Vec<u32>,
    touched_within: Vec<u32>,
}

/// Rows side by side, in order.
#[derive(Debug, Default)]
pub(crate) struct Strip {
    pub lengths: Vec<usize>,
    pub columns: Vec<u32>,
    pub values: Vec<f32>,
    pub errors: Vec<f32>,
}

impl Tally {
    pub fn new(n: usize) -> Self {
        Self { total: vec![0.0; n], squares: vec![0.0; n], within: vec![0.0; n], touched: Vec::new(), touched_within: Vec::new() }
    }

    /// A ray of the replicate that runs has landed. Weights are above zero.
    #[inline]
    pub fn add(&mut self, column: u32, weight: f32) {
        let within = &mut self.within[column as usize];
        if *within == 0.0 {
            self.touched_within.push(column);
        }
        *within += weight;
    }

    /// The replicate ends.
    pub fn end_replicate(&mut self) {
        for column in self.touched_within.drain(..) {
            let k = column as usize;
            let w = std::mem::take(&mut self.within[k]);
            if self.total[k] == 0.0 {
                self.touched.push(column);
            }
            self.total[k] += w;
            self.squares[k] += w * w;
        }
    }

    /// The row ends: its entries go to `strip`, as parts of `sum`, the weight of all rays.
    pub fn end_row(&mut self, sum: f64, strip: &mut Strip, with_errors: bool) {
        self.touched.sort_unstable();
        strip.lengths.push(self.touched.len());
        for column in &self.touched {
            let k = *column as usize;
            let (total, squares) = (f64::from(std::mem::take(&mut self.total[k])), f64::from(std::mem::take(&mut self.squares[k])));
            let value = total / sum;
            strip.columns.push(*column);
            strip.values.push(value as f32);
            if with_errors {
                let r = f64::from(REPLICATES);
                // m_r = w_r R / sum
                let mean_square = squares * r / (sum * sum);
                strip.errors.push(((mean_square - value * value).max(0.0) / (r - 1.0)).sqrt() as f32);
            }
        }
        self.touched.clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_error_is_that_of_the_replicates() {
        let mut tally = Tally::new(3);
        let counts = [3, 5, 4, 4, 6, 2, 3, 5, 4, 4, 4, 4, 5, 3, 1, 7];
        for n in counts {
            (0..n).for_each(|_| tally.add(2, 1.0));
            (n..8).for_each(|_| tally.add(0, 1.0));
            tally.end_replicate();
        }
        let mut strip = Strip::default();
        tally.end_row(128.0, &mut strip, true);
        let mean = 4.0 / 8.0;
        let variance: f64 = counts.iter().map(|n| (f64::from(*n) / 8.0 - mean).powi(2)).sum::<f64>() / 15.0;
        let expected = (variance / 16.0).sqrt() as f32;
        assert_eq!((strip.columns.as_slice(), strip.values.as_slice()), ([0, 2].as_slice(), [0.5, 0.5].as_slice()));
        assert!(strip.errors.iter().all(|e| (e - expected).abs() < 1e-6), "{:?} {expected}", strip.errors);
        // The next row begins empty.
        tally.add(1, 1.0);
        tally.end_replicate();
        let mut next = Strip::default();
        tally.end_row(1.0, &mut next, false);
        assert_eq!((next.columns, next.values, next.lengths), (vec![1], vec![1.0], vec![1]));
    }
}

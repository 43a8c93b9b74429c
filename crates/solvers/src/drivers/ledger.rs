//! Units of work: the tiles of a pixels pass, the chunks of a particles pass.
//!
//! How a pass is cut up decides how f32 sums are grouped, so it depends on the picture's size alone and never on the threads. What a unit adds
//! is a pure function of (seed, k), and sums have no order: a stopped pass goes on later with the units that are left.

use std::sync::atomic::{AtomicBool, Ordering};

/// Which units of a pass are done.
#[derive(Debug)]
pub struct Ledger(Vec<AtomicBool>);

impl Ledger {
    /// So many units, none done.
    pub fn new(count: usize) -> Self {
        Self((0..count).map(|_| AtomicBool::new(false)).collect())
    }

    /// Number of units.
    pub fn len(&self) -> usize {
        self.0.len()
    }

    /// Whether there is nothing to do.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Whether a unit is done.
    pub fn is_done(&self, unit: usize) -> bool {
        self.0[unit].load(Ordering::Relaxed)
    }

    /// Notes that a unit is done.
    pub fn done(&self, unit: usize) {
        self.0[unit].store(true, Ordering::Relaxed);
    }

    /// Whether every unit is done.
    pub fn is_complete(&self) -> bool {
        self.0.iter().all(|d| d.load(Ordering::Relaxed))
    }

    /// Forgets what is done: a new pass begins.
    pub fn clear(&self) {
        self.0.iter().for_each(|d| d.store(false, Ordering::Relaxed));
    }

    pub(super) fn to_bools(&self) -> Vec<bool> {
        self.0.iter().map(|d| d.load(Ordering::Relaxed)).collect()
    }

    pub(super) fn set(&self, done: &[bool]) {
        self.0.iter().zip(done).for_each(|(d, x)| d.store(*x, Ordering::Relaxed));
    }
}

//! Subtrees that wait for their turn.

use std::mem::MaybeUninit;

/// A stack of `N` entries that starts without being cleared.
pub(super) struct Stack<T, const N: usize> {
    entries: [MaybeUninit<T>; N],
    count: usize,
}

impl<T: Copy, const N: usize> Stack<T, N> {
    #[inline(always)]
    pub fn new() -> Self {
        Self { entries: [const { MaybeUninit::uninit() }; N], count: 0 }
    }

    #[inline(always)]
    pub fn push(&mut self, entry: T) {
        debug_assert!(self.count < N);
        // SAFETY: N holds what the deepest tree that the build makes can leave behind.
        unsafe { self.entries.get_unchecked_mut(self.count) }.write(entry);
        self.count += 1;
    }

    #[inline(always)]
    pub fn pop(&mut self) -> Option<T> {
        if self.count == 0 {
            return None;
        }
        self.count -= 1;
        // SAFETY: below `count` every entry was written.
        Some(unsafe { self.entries.get_unchecked(self.count).assume_init() })
    }

    #[inline(always)]
    pub fn len(&self) -> usize {
        self.count
    }

    /// Pushes an entry: of those from `bottom` on, above what is `farther` and below the others.
    #[inline(always)]
    pub fn push_above(&mut self, bottom: usize, entry: T, farther: impl Fn(&T) -> bool) {
        let mut i = self.count;
        self.push(entry);
        // SAFETY: bottom ≤ i - 1 < i < count, all written.
        unsafe {
            while i > bottom && !farther(&self.entries.get_unchecked(i - 1).assume_init()) {
                *self.entries.get_unchecked_mut(i) = *self.entries.get_unchecked(i - 1);
                i -= 1;
            }
            self.entries.get_unchecked_mut(i).write(entry);
        }
    }
}

impl<const N: usize> Stack<u64, N> {
    /// Pushes two entries and those of the bits of `met`, farthest first; returns the nearest instead of pushing it.
    #[inline(always)]
    pub fn push_sorted(&mut self, first: u64, second: u64, mut met: u32, entry: impl Fn(u32) -> u64) -> u64 {
        let base = self.count;
        self.push(first.max(second));
        let mut nearest = first.min(second);
        while met != 0 {
            let mut new = entry(met.trailing_zeros());
            met &= met - 1;
            if new < nearest {
                std::mem::swap(&mut new, &mut nearest);
            }
            // smaller entries lie nearer the top
            self.push_above(base, new, |other| *other >= new);
        }
        nearest
    }
}

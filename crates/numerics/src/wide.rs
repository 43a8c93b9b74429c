//! Loops over many lanes, compiled for the widest vectors that this machine has.
//!
//! A [`Job`] is a loop in plain Rust whose iterations do not depend on each other, over arrays with one number a lane. The compiler makes
//! vectors of it: 16 lanes with AVX-512, 8 with AVX2, 4 without either. It may not reorder, fuse or approximate floating-point operations,
//! so every width gives the same bits, those of the loop as written.
//!
//! What makes such a loop: arrays of fixed size, a length that is a multiple of [`PAD`], choices between values instead of branches, no
//! calls that are not inlined, f32 apart from f64.
//!
//! This module alone may use `unsafe` here, for two things: calling a function that was compiled for instructions whose presence was asked
//! for at run time, and asking for memory ahead of its use ([`fetch`]).
#![allow(unsafe_code)]

/// Lanes are counted in multiples of this: what lies beyond the last one in use is computed and forgotten.
pub const PAD: usize = 16;

/// Lanes to be worked on where `count` of N are in use: whole vectors.
#[inline(always)]
pub fn padded<const N: usize>(count: usize) -> usize {
    count.next_multiple_of(PAD).min(N)
}

/// A loop over lanes.
pub trait Job {
    /// What it gives back.
    type Output;

    /// The loop. To be marked `#[inline(always)]`: only what is inlined is compiled for wide vectors.
    fn run(self) -> Self::Output;
}

/// How wide vectors are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Width {
    /// Whatever the program was compiled for.
    Plain,
    /// AVX2: 256 bits.
    Avx2,
    /// AVX-512: 512 bits.
    Avx512,
}

impl Width {
    /// All widths that this machine has, the widest last.
    pub fn available() -> impl Iterator<Item = Self> {
        [Self::Plain, Self::Avx2, Self::Avx512].into_iter().filter(|w| w.is_available())
    }

    /// The widest that this machine has.
    #[inline]
    pub fn best() -> Self {
        [Self::Avx512, Self::Avx2].into_iter().find(|w| w.is_available()).unwrap_or(Self::Plain)
    }

    #[inline]
    fn is_available(self) -> bool {
        match self {
            Self::Plain => true,
            #[cfg(target_arch = "x86_64")]
            Self::Avx2 => is_x86_feature_detected!("avx2") && is_x86_feature_detected!("bmi2"),
            #[cfg(target_arch = "x86_64")]
            Self::Avx512 => {
                Self::Avx2.is_available()
                    && is_x86_feature_detected!("avx512f")
                    && is_x86_feature_detected!("avx512bw")
                    && is_x86_feature_detected!("avx512dq")
                    && is_x86_feature_detected!("avx512vl")
            }
            #[cfg(not(target_arch = "x86_64"))]
            _ => false,
        }
    }

    /// Runs a loop at this width, or plainly where this machine does not have it.
    #[inline]
    pub fn run<J: Job>(self, job: J) -> J::Output {
        #[cfg(target_arch = "x86_64")]
        match self {
            // SAFETY: the instructions are there.
            Self::Avx512 if self.is_available() => return unsafe { avx512(job) },
            // SAFETY: the instructions are there.
            Self::Avx2 if self.is_available() => return unsafe { avx2(job) },
            _ => {}
        }
        job.run()
    }
}

/// Asks for the memory of `x`, so that it is near by when it is looked at. Of many places that lie far apart, those that are asked for first
/// arrive together; those that are looked at one after the other are waited for one after the other.
#[inline(always)]
pub fn fetch<T>(x: &T) {
    #[cfg(target_arch = "x86_64")]
    {
        use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        // SAFETY: a prefetch reads nothing.
        unsafe { _mm_prefetch::<_MM_HINT_T0>(std::ptr::from_ref(x).cast()) };
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = x;
}

/// Runs a loop at the greatest width that this machine has.
#[inline]
pub fn widest<J: Job>(job: J) -> J::Output {
    Width::best().run(job)
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512bw,avx512dq,avx512vl,avx2,bmi1,bmi2,lzcnt,popcnt")]
fn avx512<J: Job>(job: J) -> J::Output {
    job.run()
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt")]
fn avx2<J: Job>(job: J) -> J::Output {
    job.run()
}

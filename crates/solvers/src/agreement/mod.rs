//! Do two solvers find the same light? Statistics of agreement, for `verify`, `compare` and tests alike.
//!
//! Each solver renders K independent replicates of the same work: other seeds, the same sample count. The means over the areas of a
//! picture (the blocks of a grid, and the whole) in one replicate are one number each, nearly normal, and independent from replicate to
//! replicate, which neighbouring pixels and low-discrepancy points are not. Two solvers are compared area by area, channel by channel:
//!
//! ```text
//! t = (x̄ - ȳ) / √(s_x²/K_x + s_y²/K_y)            [Welch 1947]
//! level of one test = 1 - (1 - α)^(1/n)            n tests in the family [Šidák 1967]
//! ```
//!
//! | verdict | says |
//! | --- | --- |
//! | PASS | no difference seen, and one as large as the bound would have been: each confidence interval lies within its bound |
//! | FAIL | a difference that chance makes in fewer than α of all families where there is none |
//! | INCONCLUSIVE | no difference seen, but one as large as the bound could hide behind the noise |
//!
//! The bound is relative: to the mean of the whole picture in that channel, or to the block's mean (to half the picture's in blocks that are
//! darker). An area in which a solver's own standard error is above 10 % says nothing: means of few, rare, bright contributions are skewed, and
//! t would take that for a difference. A difference that rounding in f32 explains is none.
//!
//! [`Trial`] renders, a [`Sample`] gathers replicates, [`judge`] compares two samples or a sample and known means, a [`Panel`] does it for
//! every pair of several solvers.

mod grid;
mod judge;
mod panel;
mod sample;
mod trial;

pub use etendue_check::Moments;
pub use grid::{Area, Grid};
pub use judge::{Agreement, Expected, Finding, Standard, Verdict, judge, quantile_of_many};
pub use panel::{Candidate, Pair, Panel};
pub use sample::Sample;
pub use trial::{NoPicture, Renderer, Shot, Trial};

/// Replicates of every estimate, at least: fewer leave Student's t so wide that little can be seen.
pub const REPLICATES: u32 = 16;

//! Statistics over closures, for tests: the ruler that every sampler, estimator and quadrature here is held against.
//!
//! | question | tool |
//! | --- | --- |
//! | does `sample` draw from `pdf`? | [`ChiSquareTest`] over a [`Domain`] |
//! | does an estimator's mean hit a number, or another mean? | [`z_test`], [`t_test`], [`compare_means`], and their [`Verdict`] |
//! | does a density integrate to what it should? | [`integrate_sphere`], [`integrate_hemisphere`], [`integrate_square`], [`integrate_interval`] |
//! | how strict must one of n tests be? | [`family_wise`] |
//!
//! ```
//! use etendue_check::{ChiSquareTest, Hemisphere};
//! use glam::Vec3;
//!
//! // The cosine-weighted hemisphere: z = √u, p = cosθ/π.
//! let report = ChiSquareTest::new(Hemisphere).run(
//!     |[u, v, _]| {
//!         let (sin, cos) = (std::f32::consts::TAU * v).sin_cos();
//!         let r = (1.0 - u).sqrt();
//!         Some(Vec3::new(r * cos, r * sin, u.sqrt()))
//!     },
//!     |w| w.z.max(0.0) / std::f32::consts::PI,
//! );
//! assert!(report.passes(1e-3), "{report}");
//! ```
//!
//! The crate knows vectors and closures only, nothing of what it measures: a ruler must not be made of the thing it is laid against.
//! Everything is deterministic in its seeds. Uniform numbers come from [`rng`].

mod chi_square;
mod domain;
mod means;
mod quadrature;
mod rng;
mod special;

pub use chi_square::{Cells, ChiSquare, ChiSquareTest, WorstCell};
pub use domain::{Disk, Domain, Hemisphere, Interval, Rect, Sphere, Square, Triangle};
pub use means::{Interval as ConfidenceInterval, MeanTest, Moments, Verdict, compare_means, family_wise, t_test, z_test};
pub use quadrature::{integrate_hemisphere, integrate_interval, integrate_rect, integrate_sphere, integrate_square};
pub use rng::{Rng, rng};
pub use special::{chi_square_p, ln_gamma, normal_p, student_p, student_quantile};

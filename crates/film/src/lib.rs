//! Measurements: sums, weights, variance, splats, reconstruction filters.

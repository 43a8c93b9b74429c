//! Statistics over closures for tests: chi-square, t-test, z-test, wrong-on-purpose samplers.

//! Solvers of the rendering equation, and the drivers that run them.

//! Which paths count: by their number of edges between eye and light.

use etendue_scene::Integrator;

/// Limits on a path's edges. 1 edge: an emitter seen directly; 2: direct light; n: n - 1 bounces.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PathRules {
    /// Paths with fewer edges do not count.
    pub min_edges: u32,
    /// Paths with more edges do not count; `u32::MAX` is unbounded.
    pub max_edges: u32,
    /// The first vertex at which Russian roulette may end a walk; each solver has its own where nobody asks ([`PathRules::rr_depth_or`]).
    pub rr_depth: Option<u32>,
    /// Emitters seen directly by the camera do not count.
    pub hide_emitters: bool,
    /// Passing straight through a null or mask surface counts as an edge.
    pub null_counts: bool,
}

impl Default for PathRules {
    fn default() -> Self {
        Self { min_edges: 1, max_edges: u32::MAX, rr_depth: None, hide_emitters: false, null_counts: true }
    }
}

impl PathRules {
    /// The rules that a scene file asks for.
    pub fn of(integrator: &Integrator) -> Self {
        Self {
            min_edges: 1,
            max_edges: integrator.max_depth.unwrap_or(u32::MAX),
            rr_depth: integrator.rr_depth,
            hide_emitters: integrator.hide_emitters,
            null_counts: integrator.null_counts,
        }
    }

    /// Where roulette begins, and where it does if nobody asks.
    #[inline]
    pub fn rr_depth_or(&self, usual: u32) -> u32 {
        self.rr_depth.unwrap_or(usual)
    }

    /// Where roulette begins in most solvers.
    #[inline]
    pub fn rr_depth(&self) -> u32 {
        self.rr_depth_or(5)
    }

    /// The same rules for light of exactly `bounces` bounces (0 = emitters).
    pub fn with_bounces(self, bounces: std::ops::RangeInclusive<u32>) -> Self {
        Self { min_edges: bounces.start().saturating_add(1), max_edges: bounces.end().saturating_add(1), ..self }
    }

    /// Whether light that came along `edges` edges counts.
    #[inline]
    pub fn counts(&self, edges: u32) -> bool {
        (self.min_edges..=self.max_edges).contains(&edges) && !(self.hide_emitters && edges == 1)
    }

    /// How many null or mask surfaces a connection of `edges` edges may pass.
    #[inline]
    pub fn passes(&self, edges: u32) -> u32 {
        if self.null_counts { self.max_edges.saturating_sub(edges) } else { u32::MAX }
    }
}

//! Which paths count: by their number of edges between eye and light.

use etendue_scene::Integrator;

/// Limits on a path's edges. 1 edge: an emitter seen directly; 2: direct light; n: n - 1 bounces.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PathRules {
    /// Paths with fewer edges do not count.
    pub min_edges: u32,
    /// Paths with more edges do not count; `u32::MAX` is unbounded.
    pub max_edges: u32,
    /// Vertices before Russian roulette may end a walk; where it is [`PathRules::RR_DEPTH`], `path-mis` begins earlier.
    pub rr_depth: u32,
    /// Emitters seen directly by the camera do not count.
    pub hide_emitters: bool,
    /// Passing straight through a null or mask surface counts as an edge.
    pub null_counts: bool,
}

impl Default for PathRules {
    fn default() -> Self {
        Self { min_edges: 1, max_edges: u32::MAX, rr_depth: Self::RR_DEPTH, hide_emitters: false, null_counts: true }
    }
}

impl PathRules {
    /// Where roulette begins unless a scene file tells.
    pub const RR_DEPTH: u32 = 5;

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

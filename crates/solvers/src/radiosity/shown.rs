//! What a solution shows under the rules of a picture: fields of light that may be looked at.
//!
//! ```text
//! R = Σ b_m,  m = max(1, e₀ - 2) … e₁ - 2        light that was reflected, and is reflected once more at the point that the eye sees
//! H = F R                                        its irradiance
//! ```
//!
//! e₀ and e₁ are the least and the most edges of a path; without limits R = B - Be.

use crate::transport::PathRules;
use etendue_radiosity::patch::Vertices;
use etendue_radiosity::{Bounces, Energy, Exchange, Field, Patches, Solved};
use etendue_scene::Scene;
use glam::DVec3;

/// How indirect light is shown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Show {
    /// Interpolated.
    #[default]
    Smooth,
    /// From where one more ray ends.
    Gather,
    /// The patches.
    Patches,
}

impl Show {
    /// All, as users write them, in the order of the variants.
    pub const NAMES: &'static [&'static str] = &["smooth", "gather", "patches"];

    /// The one of a place in [`Show::NAMES`].
    pub fn nth(i: usize) -> Self {
        [Self::Smooth, Self::Gather, Self::Patches][i.min(2)]
    }
}

/// A solution, ready to be looked at.
#[derive(Clone, Debug, Default)]
pub struct Shown {
    pub(super) patches: Option<Patches>,
    pub(super) vertices: Vertices,
    /// H between patches, W/m²; while gathering, R.
    pub(super) field: Field,
    /// Radiance of each patch, W/(m² sr), where the patches themselves are shown.
    pub(super) raw: Vec<DVec3>,
    /// By surface: whether its own material tells its reflectance.
    pub(super) is_diffuse: Vec<bool>,
    pub(super) show: Show,
    /// The books.
    pub energy: Energy,
}

impl Shown {
    /// What of `solved` the rules let through.
    pub fn new(scene: &Scene, solved: &Solved, rules: &PathRules, show: Show) -> Self {
        let equation = solved.equation();
        let energy = equation.energy(&solved.solution.b);
        let mut is_diffuse = vec![true; scene.surfaces.len()];
        solved.patches.not_diffuse.iter().for_each(|n| is_diffuse[n.surface.index()] = false);
        let mut shown = Self { is_diffuse, show, energy, ..Self::default() };
        if show == Show::Patches {
            let of = between(solved, rules.min_edges - 1, rules.max_edges.saturating_sub(1));
            shown.raw = of.into_iter().map(|b| b / std::f64::consts::PI).collect();
        } else if rules.max_edges >= 3 {
            let reflected = between(solved, rules.min_edges.saturating_sub(2).max(1), rules.max_edges - 2);
            shown.vertices = solved.patches.vertices(scene);
            let values = if show == Show::Gather { reflected } else { solved.exchange.multiply(&reflected) };
            shown.field = Field::new(&solved.patches, &shown.vertices, &values);
        }
        shown.patches = Some(solved.patches.clone());
        shown
    }
}

/// Σ b_m from `first` to `last`.
fn between(solved: &Solved, first: u32, last: u32) -> Vec<DVec3> {
    // Limits beyond all light are none.
    if first <= 1 && last >= u32::MAX - 2 {
        let less = |(b, be): (&DVec3, DVec3)| if first == 1 { *b - be } else { *b };
        let be = solved.patches.patches.iter().map(|p| etendue_radiosity::solve::rgb(p.be));
        return solved.solution.b.iter().zip(be).map(less).collect();
    }
    let equation = solved.equation();
    let (scale, enough) = (equation.scale(), solved.solution.residual().max(1e-12));
    let mut sum = vec![DVec3::ZERO; equation.len()];
    for (m, b) in (0..=last).zip(Bounces::new(&equation)) {
        if m >= first {
            sum.iter_mut().zip(&b).for_each(|(s, b)| *s += *b);
            if equation.norm(&b) <= enough * scale.min(equation.norm(&sum)) {
                break;
            }
        }
    }
    sum
}

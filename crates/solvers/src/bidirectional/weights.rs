//! How the strategies share a path: multiple importance sampling over all (s, t) [Veach 1997, ch. 10].
//!
//! A path z_0 … z_k of n = k + 1 vertices, z_0 on the light and z_k on the lens, can be found in many ways: its first s vertices by a walk from the
//! light, the other t = n - s by a walk from the eye. With densities per area of all vertices,
//!
//! ```text
//! p_s = Π_{i<s} p⃗(z_i) · Π_{i≥s} p⃖(z_i)            p⃗: drawn from the light's side, p⃖: from the eye's
//! w_s = (n_s p_s)^β / Σ_i (n_i p_i)^β                β = 1 balance, 2 power heuristic
//!     = 1 / (1 + Σ_eye + Σ_light)
//! Σ_eye = r_s (c_s + r_{s+1} (c_{s+1} + r_{s+2} …)),  r_i = (p⃗(z_i) / p⃖(z_i))^β     strategies with more light vertices
//! ```
//!
//! and the like for Σ_light. c_i says whether the edge from z_i to the next vertex of that walk can be a connection: 0 where either end scatters into a
//! discrete direction. The bracket behind r_s depends on the connection through one number only, the density of the way back at the connected vertex, so
//! each vertex keeps the rest ([`Link`]) [after Georgiev 2012] and a weight costs O(1).
//!
//! | what | convention |
//! | --- | --- |
//! | s = 1 | the light point is drawn by the light sampler of z_1, of density p_N, not by emission, of density p_E: c = (p_N / p_E)^β there |
//! | t = 1 | a pass has `width · height` light paths and as many eye paths; of a crop only these: n_1 = ρ = crop / film, other n = 1 |
//! | t = 0 | left out: the lens is never hit by chance |
//! | s = 1, t = 1 | the emission sample itself is connected to the lens, surfaces only; w = 0, as the eye sees the same without noise |
//! | surroundings | z_0 is a direction, of density 1/sr; p⃗(z_1) is that of the disc before the scene, projected |
//! | points, single directions | discrete places of z_0; no eye path hits them: p_0 = 0 |
//! | Dirac scattering | p⃗ and p⃖ of the next vertices are taken per projected solid angle, with the same probability both ways: it cancels |
//! | roulette, null and mask surfaces | their probabilities are left out of all densities: weights need only be a function of the path |

use crate::transport::Heuristic;

/// Ratios beyond this are as good as infinite; keeps products of two finite.
pub(crate) const LARGE: f32 = 1e15;

/// r^β.
#[inline]
pub fn power(heuristic: Heuristic, numerator: f32, denominator: f32) -> f32 {
    if numerator <= 0.0 {
        return 0.0;
    }
    // A density of zero in the denominator belongs to a path that was never drawn, or to one beyond the range of f32.
    let r = if denominator > 0.0 { (numerator / denominator).min(LARGE) } else { LARGE };
    match heuristic {
        Heuristic::Balance => r,
        Heuristic::Power => r * r,
    }
}

/// What the weights need to know of how a walk came to a vertex v from the vertex u before it, and u from t before that.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Link {
    /// p(v) of this walk, 1/m²; 1/sr where v is a direction of the surroundings.
    pub density: f32,
    /// Turns the other walk's density at v of the direction to u, 1/sr, into its density of u over this walk's.
    pub back: f32,
    /// c: n^β of the strategy that connects u and v, times whatever makes it differ from the rule; 0 where it cannot.
    pub connect: f32,
    /// The bracket behind r_u: all strategies that connect before u, relative to the one that connects u and v, but for r_u.
    pub sums: f32,
}

impl Link {
    /// The bracket behind r_v: strategies that connect at v or before, where the other walk leaves v for u with the density `way_back`;
    /// `smooth`: v scatters by a density, not into a discrete direction.
    #[inline]
    pub fn bracket(&self, heuristic: Heuristic, way_back: f32, smooth: bool) -> f32 {
        let here = if smooth { self.connect } else { 0.0 };
        (here + power(heuristic, way_back * self.back, 1.0) * self.sums).min(LARGE * LARGE)
    }

    /// All strategies that give v to the other walk, which would have drawn it with the density `other`, 1/m².
    #[inline]
    pub fn others(&self, heuristic: Heuristic, other: f32, way_back: f32) -> f32 {
        power(heuristic, other, self.density) * self.bracket(heuristic, way_back, true)
    }
}

impl Link {
    /// Where v is on a light that an eye path hit: all strategies in which it is the light's own, which draws it with the density `position` and
    /// there the direction to u with `direction`, 1/sr.
    #[inline]
    pub fn emitted(&self, heuristic: Heuristic, position: f32, direction: f32) -> f32 {
        let before = power(heuristic, direction * self.back, 1.0) * self.sums;
        power(heuristic, position, self.density) * before.min(LARGE * LARGE)
    }

    /// The same for a light sample at u, with the density `pdf` in the measure of v's.
    #[inline]
    pub fn next_event(&self, heuristic: Heuristic, pdf: f32) -> f32 {
        power(heuristic, pdf, self.density) * self.connect
    }
}

/// What a walk remembers of the last vertex at which it turned.
#[derive(Clone, Copy, Debug)]
pub struct Trail {
    /// The vertex.
    pub p: glam::Vec3,
    /// Its unit geometric normal; zero where it has none.
    pub n: glam::Vec3,
    /// It is a direction or a plane at infinity: densities of the next vertex do not fall with distance.
    pub distant: bool,
    /// Its own density.
    pub density: f32,
    /// The density of the direction that was taken there, 1/sr; |cosθ| of a discrete one.
    pub pdf_w: f32,
    /// [`Link::connect`] of the next vertex.
    pub connect: f32,
    /// [`Link::sums`] of the next vertex.
    pub sums: f32,
}

impl Trail {
    /// |cosθ|/r² of the surface point y with normal n as seen from the last vertex along the unit direction `w`: from 1/sr there to 1/m² at y.
    #[inline]
    pub fn to_area(&self, y: glam::Vec3, n: glam::Vec3, w: glam::Vec3) -> f32 {
        let cos = n.dot(w).abs();
        if self.distant { cos } else { cos / self.p.distance_squared(y) }
    }

    /// The same the other way: from 1/sr at y to the measure of the last vertex.
    #[inline]
    pub fn from_area(&self, y: glam::Vec3, w: glam::Vec3) -> f32 {
        if self.distant { 1.0 } else { self.n.dot(w).abs() / self.p.distance_squared(y) }
    }

    /// The walk arrives at the surface point y.
    #[inline]
    pub fn arrive(&self, y: glam::Vec3, n: glam::Vec3, w: glam::Vec3) -> Link {
        let density = self.pdf_w * self.to_area(y, n, w);
        Link { density, back: self.back(self.from_area(y, w)), connect: self.connect, sums: self.sums }
    }

    /// The walk leaves the scene along `w`.
    #[inline]
    pub fn escape(&self, w: glam::Vec3) -> Link {
        Link { density: self.pdf_w, back: self.back(self.n.dot(w).abs()), connect: self.connect, sums: self.sums }
    }

    #[inline]
    fn back(&self, geometry: f32) -> f32 {
        // What no strategy needs may be without a density.
        if self.sums > 0.0 && self.density > 0.0 { (geometry / self.density).min(LARGE * LARGE) } else { 0.0 }
    }
}

//! Where light comes from around each place: a tree over places on surfaces that face one way, with a density over directions in each leaf
//! [Müller, Gross, Novák 2017, §4.1; taught by photons: Jensen 1995].
//!
//! ```text
//! Φ dA ~ L |cosθ| dwi dA:    p_g(wi) ∝ L |cosθ| = π f |cosθ| L / ρ    where the surface is Lambert's
//! ```
//!
//! Places are divided at the median along the longest side of their box until a leaf holds at most 256 photons. Surfaces are told apart by
//! the axis that their normals are nearest to, so that the two sides of a wall, or a wall and the floor, know nothing of each other.

use super::targets::Targets;
use etendue_numerics::{Bounds3, Vec3};
use serde::{Deserialize, Serialize};

/// Photons of a leaf at most.
const MOST: usize = 256;
/// 1 - a of a leaf of many photons, and how many equal ones are worth half of that. By measurement: more send too few walks where the guide is wrong.
const GUIDED: f32 = 0.35;
const HALF: f32 = 16.0;

/// Light that arrived at a surface.
#[derive(Clone, Copy, Debug)]
pub struct Photon {
    /// Where.
    pub p: Vec3,
    /// Where it came from.
    pub from: Vec3,
    /// The normal on that side, unit.
    pub n: Vec3,
    /// How much, of any unit.
    pub flux: f32,
}

/// What is known of the light around a place.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Leaf {
    /// p_g.
    pub guide: Targets,
    /// a: the share of the directions that the BSDF chooses.
    pub fraction: f32,
}

/// A division of places.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Node {
    axis: u32,
    /// Where along the axis the second half begins.
    split: f32,
    /// The halves.
    child: [u32; 2],
}

/// Marks the number of a leaf among those of nodes.
const LEAF: u32 = 1 << 31;

/// The leaves, by place and normal.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Field {
    /// One for each way that a surface may face.
    roots: [u32; 6],
    nodes: Vec<Node>,
    leaves: Vec<Leaf>,
}

/// The way that a surface of normal n faces: ±x, ±y, ±z.
#[inline]
fn facing(n: Vec3) -> usize {
    let a = n.abs();
    let axis = if a.x >= a.y && a.x >= a.z {
        0
    } else if a.y >= a.z {
        1
    } else {
        2
    };
    2 * axis + usize::from(n[axis] < 0.0)
}

impl Field {
    /// What `photons` tell.
    pub fn new(photons: &[Photon]) -> Self {
        let mut field = Self { roots: [0; 6], nodes: Vec::new(), leaves: Vec::new() };
        for side in 0..6 {
            let mut these: Vec<Photon> = photons.iter().filter(|p| facing(p.n) == side).copied().collect();
            field.roots[side] = field.grow(&mut these);
        }
        field
    }

    /// Adds what is known from `photons`; its number.
    fn grow(&mut self, photons: &mut [Photon]) -> u32 {
        let size = Bounds3::of(photons.iter().map(|p| p.p)).size();
        if photons.len() <= MOST || size.max_element() <= 0.0 {
            self.leaves.push(Leaf::new(photons));
            return LEAF + (self.leaves.len() - 1) as u32;
        }
        let axis = size.max_position();
        let (first, middle, _) = photons.select_nth_unstable_by(photons.len() / 2, |a, b| a.p[axis].total_cmp(&b.p[axis]));
        let (count, split) = (first.len(), middle.p[axis]);
        let id = self.nodes.len();
        self.nodes.push(Node { axis: axis as u32, split, child: [0; 2] });
        let (near, far) = photons.split_at_mut(count);
        self.nodes[id].child[0] = self.grow(near);
        self.nodes[id].child[1] = self.grow(far);
        id as u32
    }

    /// What is known at p on a surface that faces as n does.
    #[inline]
    pub fn at(&self, p: Vec3, n: Vec3) -> &Leaf {
        self.leaf(self.find(p, n))
    }

    /// The leaf of a number.
    #[inline]
    pub fn leaf(&self, number: u32) -> &Leaf {
        &self.leaves[number as usize]
    }

    /// The number of the leaf there.
    #[inline]
    pub fn find(&self, p: Vec3, n: Vec3) -> u32 {
        let mut node = self.roots[facing(n)];
        while node < LEAF {
            let half = &self.nodes[node as usize];
            node = half.child[usize::from(p[half.axis as usize] >= half.split)];
        }
        node - LEAF
    }
}

impl Leaf {
    fn new(photons: &[Photon]) -> Self {
        // As many equal photons would be as sure.
        let (sum, squares) = photons.iter().map(|p| p.flux).fold((0.0, 0.0), |(s, q), w| (s + w, q + w * w));
        let count = if squares > 0.0 { sum * sum / squares } else { 0.0 };
        let middle = photons.iter().map(|p| p.p).sum::<Vec3>() / photons.len().max(1) as f32;
        let left: Vec<(Vec3, f32)> = photons.iter().map(|p| (p.from, p.flux)).collect();
        Self { guide: Targets::new(&left, middle), fraction: 1.0 - GUIDED * count / (count + HALF) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use etendue_numerics::{Dim, Sampler, SequenceKind, Vec2};

    /// A floor lit from straight above at its left and along x at its right, and the underside of the same floor, lit from below.
    fn photons() -> Vec<Photon> {
        let u = |i| Sampler::new(SequenceKind::Independent, 1, 0, i, 4096);
        let place = |i| u(i).u2(Dim(0));
        let photon = |i: u32| {
            let p = Vec3::new(place(i).x, 0.0, place(i).y);
            let below = i.is_multiple_of(4);
            let wi = if below {
                -Vec3::Y
            } else if p.x < 0.5 {
                Vec3::Y
            } else {
                Vec3::new(0.8, 0.6, 0.0)
            };
            Photon { p, from: p + 9.0 * wi, n: if below { -Vec3::Y } else { Vec3::Y }, flux: 1.0 }
        };
        (0..4096).map(photon).collect()
    }

    #[test]
    fn each_place_and_side_has_its_light() {
        let field = Field::new(&photons());
        for (p, n, wi) in [
            (Vec3::new(0.1, 0.0, 0.3), Vec3::Y, Vec3::Y),
            (Vec3::new(0.9, 0.0, 0.6), Vec3::Y, Vec3::new(0.8, 0.6, 0.0)),
            (Vec3::new(0.5, 0.0, 0.5), -Vec3::Y, -Vec3::Y),
        ] {
            let leaf = field.at(p, n);
            assert!(
                leaf.fraction < 1.0 - 0.9 * GUIDED && leaf.guide.pdf(p, wi) > 50.0,
                "{p}: a {}, density {}",
                leaf.fraction,
                leaf.guide.pdf(p, wi)
            );
            let (found, pdf) = leaf.guide.sample(p, Vec2::new(0.3, 0.7));
            assert!(found.dot(wi) > 0.99 && (pdf / leaf.guide.pdf(p, found) - 1.0).abs() < 1e-3, "{found} for {wi}");
        }
    }

    /// A way that no photon came to is the BSDF's alone, and photons all at one place are no reason to divide for ever.
    #[test]
    fn what_nobody_taught() {
        assert_eq!(Field::new(&[]).at(Vec3::ZERO, Vec3::X).fraction, 1.0);
        let here = Photon { p: Vec3::ONE, from: Vec3::new(1.0, 1.0, 4.0), n: Vec3::Z, flux: 2.0 };
        let field = Field::new(&vec![here; 1000]);
        assert_eq!(field.leaves.len(), 6);
        assert!(field.at(Vec3::ZERO, Vec3::Z).fraction < 1.0 - 0.9 * GUIDED && field.at(Vec3::ZERO, -Vec3::Z).fraction == 1.0);
    }
}

//! What patches reflect and emit, as means over their area.
//!
//! ```text
//! ρ = 1/π ∫∫ f(wi, wo) cosθi cosθo dwi dwo       over directions on the patch's side: hemispherical reflectance for diffuse light
//! Be = π Le                                      W/m²
//! ```
//!
//! Of a diffuse surface f = ρ/π, and one sample tells. Any other material is taken for a diffuse one of its ρ, which is found by sampling; what it
//! transmits is lost. [`NotDiffuse`] tells how much that is.

use super::{NONE, Patches, Side};
use etendue_bsdf::{Event, Scatter};
use etendue_numerics::math::PI;
use etendue_numerics::sequence::{SequenceKind, unit};
use etendue_numerics::warp::square_to_cosine_hemisphere;
use etendue_numerics::{Dim, Sampler, Spectrum, Vec2, Vec3, Wavelengths};
use etendue_scene::{Interaction, Scene, SurfaceId, Texture};
use glam::DVec3;
use rayon::prelude::*;
use std::collections::HashMap;

/// Points on a patch at which textures are looked up.
const TEXTURE_POINTS: u32 = 16;

/// Directions from which a material that is not diffuse is looked at, for one mean.
const DIRECTIONS: u32 = 4096;

/// A surface that is not diffuse, and what was made of it.
#[derive(Clone, Copy, Debug)]
pub struct NotDiffuse {
    /// The surface.
    pub surface: SurfaceId,
    /// Its side.
    pub side: Side,
    /// The material's model.
    pub material: &'static str,
    /// ρ of the diffuse surface that took its place.
    pub reflected: Spectrum,
    /// What passes through it in truth, and is lost here.
    pub transmitted: Spectrum,
}

/// Means over some points.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Optics {
    pub rho: Spectrum,
    pub transmitted: Spectrum,
    pub be: Spectrum,
}

/// Whether any texture varies: if none does, a surface is the same all over.
fn is_textured(scene: &Scene) -> bool {
    scene.textures.iter().any(|t| !matches!(t, Texture::Color(_)))
}

/// Whether the material of a surface is Lambert's, or nothing but that.
fn is_diffuse(scene: &Scene, surface: SurfaceId) -> bool {
    let other = Event::TRANSMIT.with(Event::NULL).with(Event::DELTA).with(Event::GLOSSY);
    !scene.material(scene.surface(surface).material).events().intersects(other)
}

/// Directions that tell one material from another: where what they bring is the same to the bit, so is the rest.
const TELLING: usize = 16;

/// What is reflected and transmitted at the k-th of n points, by what the first directions bring there.
type Seen = HashMap<(u32, u32, [[u64; 6]; TELLING]), [DVec3; 2]>;

/// The mean over `points`, which are seen from `side`.
pub(super) fn mean(scene: &Scene, side: Side, points: &[Interaction]) -> Optics {
    mean_of(scene, side, points, &mut Seen::new())
}

/// The same, for surfaces that are `seen` again and again.
fn mean_of(scene: &Scene, side: Side, points: &[Interaction], seen: &mut Seen) -> Optics {
    let mut sums = [DVec3::ZERO; 3];
    for (k, x) in points.iter().enumerate() {
        let at = if is_diffuse(scene, x.surface) {
            from_direction(scene, side, x, Vec3::Z, (0.5, Vec2::splat(0.5)))
        } else {
            from_everywhere(scene, side, x, [k as u32, points.len() as u32], seen)
        };
        let be = if side == Side::Front { scene.le(x, &Wavelengths::Rgb) * PI } else { Spectrum::ZERO };
        sums[0] += at[0];
        sums[1] += at[1];
        sums[2] += rgb(be);
    }
    let [rho, transmitted, be] =
        sums.map(|s| (s / points.len().max(1) as f64).to_array().map(|x| x as f32)).map(|[r, g, b]| Spectrum::rgb(r, g, b));
    Optics { rho: rho.clamp(0.0, 1.0), transmitted, be }
}

/// The mean over directions at the k-th of n points.
fn from_everywhere(scene: &Scene, side: Side, x: &Interaction, [k, n]: [u32; 2], seen: &mut Seen) -> [DVec3; 2] {
    let each = (DIRECTIONS / n).max(TELLING as u32);
    let from = |i: u32| {
        let u = Sampler::new(SequenceKind::Sobol, 0, u64::from(k), i, each);
        let wo = square_to_cosine_hemisphere(u.u2(Dim(0))).normalize();
        from_direction(scene, side, x, wo, (u.u1(Dim(1)), u.u2(Dim(2))))
    };
    let telling = std::array::from_fn(|i| {
        let [r, t] = from(i as u32);
        [r.x, r.y, r.z, t.x, t.y, t.z].map(f64::to_bits)
    });
    *seen.entry((k, n, telling)).or_insert_with(|| {
        let sum = (0..each).map(from).fold([DVec3::ZERO; 2], |a, b| [a[0] + b[0], a[1] + b[1]]);
        sum.map(|s| s / f64::from(each))
    })
}

/// What one sample reflects and transmits of light to `wo`, a direction about the shading normal of the side.
fn from_direction(scene: &Scene, side: Side, x: &Interaction, wo: Vec3, (u1, u2): (f32, Vec2)) -> [DVec3; 2] {
    let local = wo * side.sign() as f32;
    let x = Interaction { wo: x.shading.to_world(local), ..*x };
    match scene.bsdf(&x, &Wavelengths::Rgb).sample(local, u1, u2) {
        Some(s) if s.wi.z * local.z > 0.0 && !s.event.transmits() => [rgb(s.weight), DVec3::ZERO],
        Some(s) => [DVec3::ZERO, rgb(s.weight)],
        None => [DVec3::ZERO; 2],
    }
}

fn rgb(s: Spectrum) -> DVec3 {
    DVec3::from_array(s.to_rgb().map(f64::from))
}

impl Patches {
    /// Points of patch i, `n` of them, as interactions: a Hammersley set [Niederreiter 1992, §3.2].
    fn points(&self, scene: &Scene, i: u32, n: u32) -> Vec<Interaction> {
        let u = |k: u32| Vec2::new((k as f32 + 0.5) / n as f32, unit(k.reverse_bits()) + 0.5 / n as f32);
        (0..n).map(|k| self.interaction(scene, i, self.sample(i, u(k)).st)).collect()
    }

    /// Fills in ρ and Be of all patches, of those that were there `before` by what they had.
    pub(super) fn look_up(&mut self, scene: &Scene, before: Option<&Self>) {
        let textured = is_textured(scene);
        let known = |i: u32| {
            let (before, patch) = (before?, self.get(i));
            let old = before.cells.get(patch.cell as usize)?.patches[usize::from(patch.side == Side::Back)];
            (old != NONE).then(|| before.get(old))
        };
        let optics: Vec<Optics> = if textured {
            (0..self.len() as u32)
                .into_par_iter()
                .map_init(Seen::new, |seen, i| match known(i) {
                    Some(old) => Optics { rho: old.rho, be: old.be, ..Optics::default() },
                    None => mean_of(scene, self.get(i).side, &self.points(scene, i, TEXTURE_POINTS), seen),
                })
                .collect()
        } else {
            // The same all over each side of a surface.
            let of_side = |object: &super::Object, side: Side| {
                let first = object.patches.clone().find(|i| self.get(*i).side == side)?;
                Some(mean(scene, side, &self.points(scene, first, 1)))
            };
            let sides: Vec<[Option<Optics>; 2]> =
                self.objects.iter().map(|o| [Side::Front, Side::Back].map(|side| of_side(o, side))).collect();
            let of = |p: &super::Patch| sides[p.object as usize][usize::from(p.side == Side::Back)].unwrap_or_default();
            self.patches.iter().map(of).collect()
        };
        for (patch, optics) in self.patches.iter_mut().zip(&optics) {
            (patch.rho, patch.be) = (optics.rho, optics.be);
        }
        // Surfaces are the same however they are cut.
        if before.is_none() {
            self.not_diffuse = self.list_what_is_not_diffuse(scene, &optics);
        }
    }

    /// A line for each side of each surface that is not diffuse, with means by area.
    fn list_what_is_not_diffuse(&self, scene: &Scene, optics: &[Optics]) -> Vec<NotDiffuse> {
        let mut list: Vec<NotDiffuse> = Vec::new();
        for object in self.objects.iter().filter(|o| !is_diffuse(scene, o.surface)) {
            for side in [Side::Front, Side::Back] {
                let mut sums = (0.0, DVec3::ZERO, DVec3::ZERO);
                for i in object.patches.clone().filter(|i| self.get(*i).side == side) {
                    let (area, o) = (self.get(i).area, &optics[i as usize]);
                    sums = (sums.0 + area, sums.1 + rgb(o.rho) * area, sums.2 + rgb(o.transmitted) * area);
                }
                let known = list.iter().any(|n| n.surface == object.surface && n.side == side);
                if sums.0 > 0.0 && !known {
                    let mean = |s: DVec3| {
                        let [r, g, b] = (s / sums.0).to_array().map(|x| x as f32);
                        Spectrum::rgb(r, g, b)
                    };
                    let material = scene.material(scene.surface(object.surface).material).name();
                    let (reflected, transmitted) = (mean(sums.1), mean(sums.2));
                    list.push(NotDiffuse { surface: object.surface, side, material, reflected, transmitted });
                }
            }
        }
        list
    }
}

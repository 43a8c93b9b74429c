//! Why is the picture black? Looks at a scene as a person would who has just rendered it and sees nothing.

use crate::scene::Scene;
use crate::sensor::CameraRay;
use crate::settings::View;
use etendue_bsdf::Scatter;
use etendue_numerics::{Vec2, Wavelengths};

/// Rays along each side of the picture.
const RAYS: u32 = 16;

/// What the rays of a view meet, in parts of all rays.
struct Seen {
    surface: f32,
    /// A surface from behind that neither scatters nor emits there.
    back: f32,
}

impl Scene {
    /// Likely reasons for a black picture, each a sentence; empty where there is none to be seen.
    pub fn diagnose(&self) -> Vec<String> {
        let mut reasons = Vec::new();
        let dark = self.emitters.iter().all(|e| e.power(self).is_zero());
        if self.emitters.is_empty() {
            reasons.push("nothing emits: the scene has no emitter".to_owned());
        } else if dark {
            reasons.push("nothing emits: every emitter has zero radiance or no area".to_owned());
        }
        if self.surfaces.is_empty() {
            reasons.push("the scene has no shapes".to_owned());
        }
        if self.views.is_empty() {
            reasons.push("nothing looks at the scene: it has no sensor".to_owned());
        }
        for (i, view) in self.views.iter().enumerate() {
            let seen = self.seen(view);
            let which = if self.views.len() > 1 { format!("sensor {i}") } else { "the sensor".to_owned() };
            if seen.surface == 0.0 && !self.surfaces.is_empty() && self.lights.environments().is_empty() {
                let center = view.sensor.sample_ray(Vec2::from(view.film.size.map(|n| 0.5 * n as f32)), Vec2::splat(0.5), 0.5).ray;
                let ahead = self.bounds.corners().iter().any(|c| (*c - center.o).dot(center.d) > 0.0);
                let place = if ahead { "beside its view or beyond its clipping planes" } else { "behind it" };
                reasons.push(format!("{which} sees no surface: everything is {place}"));
            }
            if seen.back > 0.9 {
                reasons.push(format!(
                    "{which} sees the backs of surfaces only, which reflect nothing: it may stand inside an object, or their normals point away from it \
                     (`twosided` makes both sides alike)"
                ));
            }
        }
        reasons
    }

    fn seen(&self, view: &View) -> Seen {
        let [offset, size] = [view.film.crop_offset, view.film.crop_size].map(|[x, y]| Vec2::new(x as f32, y as f32));
        let (mut surface, mut back) = (0, 0);
        for i in 0..RAYS * RAYS {
            let cell = Vec2::new((i % RAYS) as f32 + 0.5, (i / RAYS) as f32 + 0.5) / RAYS as f32;
            let CameraRay { ray, .. } = view.sensor.sample_ray(offset + cell * size, Vec2::splat(0.5), 0.5);
            let Some(hit) = self.intersect(&ray) else { continue };
            surface += 1;
            let x = self.interaction(&ray, &hit);
            // From behind, most materials scatter nothing at all.
            let scatters = self.bsdf(&x, &Wavelengths::Rgb).sample(x.wo_local(), 0.5, Vec2::splat(0.5)).is_some();
            let dark = !scatters && self.le(&x, &Wavelengths::Rgb).is_zero();
            back += u32::from(x.n.dot(x.wo) < 0.0 && dark);
        }
        let part = |n: u32| n as f32 / (RAYS * RAYS) as f32;
        Seen { surface: part(surface), back: part(back) }
    }
}

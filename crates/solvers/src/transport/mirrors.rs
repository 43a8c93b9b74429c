//! What the eye sees in mirrors and through smooth glass, no connection to the lens can find.

use super::Vertex;
use etendue_numerics::{Vec2, Wavelengths};
use etendue_scene::{Scene, View};

/// Camera rays along each side of the film.
const RAYS: u32 = 64;
/// Null and mask surfaces that a ray looks through.
const THROUGH: u32 = 16;

/// Whether a grid of camera rays finds a surface, perhaps behind null surfaces and masks, that reflects or refracts into a discrete direction. Smaller
/// ones than the grid's cells may be overlooked.
pub(crate) fn sees_mirrors(scene: &Scene, view: &View) -> bool {
    if !scene.materials.iter().any(|m| m.events().has_delta()) {
        return false;
    }
    let corner = Vec2::new(view.film.crop_offset[0] as f32, view.film.crop_offset[1] as f32);
    let size = Vec2::new(view.film.crop_size[0] as f32, view.film.crop_size[1] as f32);
    (0..RAYS).flat_map(|y| (0..RAYS).map(move |x| (x, y))).any(|(x, y)| {
        let within = (Vec2::new(x as f32, y as f32) + 0.5) / RAYS as f32;
        let mut ray = view.sensor.sample_ray(corner + within * size, Vec2::splat(0.5), 0.0).ray;
        for _ in 0..THROUGH {
            let Some(hit) = scene.intersect(&ray) else { return false };
            let vertex = Vertex::new(scene, scene.interaction(&ray, &hit), &Wavelengths::Rgb);
            let (mut mirror, mut passes) = (false, false);
            vertex.diracs(|d| if d.is_null { passes = true } else { mirror |= !d.weight.is_zero() });
            if mirror {
                return true;
            }
            if !passes {
                return false;
            }
            ray = vertex.x.spawn(ray.d);
        }
        false
    })
}

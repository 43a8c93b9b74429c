//! The rays of a scene, by kind, as renderers cast them.
//!
//! | kind | from | to | asks for |
//! | --- | --- | --- | --- |
//! | `camera` | the sensor, through a film of 256 x 256 points, row by row | the scene | the nearest hit |
//! | `bounce` | where those hit | a direction drawn by the cosine | the nearest hit |
//! | `occlusion` | there | the same, at most 3 % of the scene's diagonal away | any hit |
//! | `shadow` | there | a point of a light, drawn as path tracers draw it | any hit |

use etendue_numerics::sequence::Stream;
use etendue_numerics::warp::square_to_cosine_hemisphere;
use etendue_numerics::{Frame, Ray, Vec2, Wavelengths};
use etendue_scene::{LightReference, Scene, View};

/// Points across the film, and down.
const POINTS: u32 = 256;
/// The length of an occlusion ray, as a part of the scene's diagonal.
const NEAR: f32 = 0.03;

/// Rays of one kind.
#[derive(Clone, Debug)]
pub struct Kind {
    /// `camera`, `bounce`, `occlusion` or `shadow`.
    pub name: &'static str,
    /// Whether any hit will do.
    pub any: bool,
    /// The rays, in the order in which they are cast.
    pub rays: Vec<Ray>,
}

/// The scene's rays of all four kinds; the same at every call. A kind is empty where there are none (no light, nothing in view).
pub fn kinds(scene: &Scene, view: &View) -> [Kind; 4] {
    let (crop, offset) = (view.film.crop_size, view.film.crop_offset);
    let reach = NEAR * scene.bounds.size().length();
    let [mut camera, mut bounce, mut occlusion, mut shadow] = [const { Vec::new() }; 4];
    for point in 0..POINTS * POINTS {
        let mut u = Stream(u64::from(point) << 32);
        let place = Vec2::new((point % POINTS) as f32, (point / POINTS) as f32) + u.u2();
        let pixel = Vec2::from(offset.map(|x| x as f32)) + place / POINTS as f32 * Vec2::from(crop.map(|x| x as f32));
        let ray = view.sensor.sample_ray(pixel, u.u2(), 0.0).ray;
        camera.push(ray);

        let Some(hit) = scene.intersect(&ray) else { continue };
        let x = scene.interaction(&ray, &hit);
        let n = if x.n.dot(x.wo) < 0.0 { -x.n } else { x.n };
        let mut around = || Frame::from_normal(n).to_world(square_to_cosine_hemisphere(u.u2())).normalize();
        bounce.push(x.spawn(around()));
        occlusion.push(x.spawn(around()).until(reach));
        let light = scene.sample_light(&LightReference::reflecting(&x), u.u1(), u.u2(), &Wavelengths::Rgb);
        shadow.extend(light.and_then(|light| light.shadow_ray(&x)));
    }
    [("camera", camera), ("bounce", bounce), ("occlusion", occlusion), ("shadow", shadow)].map(|(name, rays)| Kind {
        name,
        any: matches!(name, "occlusion" | "shadow"),
        rays,
    })
}

//! The radius of density estimation, pass by pass.
//!
//! ```text
//! r²_{i+1} = r²_i (i + α)/(i + 1)  ~  r²_1 i^{α-1}              [Knaus, Zwicker 2011, eq. 20]
//! variance of the mean of N passes ~ N^{-α},  bias ~ N^{α-1}:  both parts of the error fall alike, like N^{-2/3}, for α = 2/3
//! ```
//!
//! The sequence does not look at the photons, so that every pass is a pure function of its number. The first radius is so many widths of a pixel at the
//! median distance that the eye sees: a disc then holds as many photons in a small picture as in a large one.

use etendue_numerics::Vec2;
use etendue_scene::{Scene, View};

/// r of pass `k`, counted from 0.
pub fn radius_of_pass(first: f32, alpha: f32, k: u32) -> f32 {
    let alpha = f64::from(alpha);
    let shrunk: f64 = (1..=k).map(|i| (f64::from(i) + alpha) / (f64::from(i) + 1.0)).product();
    (f64::from(first) * shrunk.sqrt()) as f32
}

/// Camera rays along each side of the film.
const RAYS: u32 = 32;
/// The first radius is at most this part of the scene's.
const MOST: f32 = 0.1;

/// `widths` times the width of a pixel where the eye sees the scene, m: the median over a grid of camera rays.
pub fn pixel_widths(scene: &Scene, view: &View, widths: f32) -> f32 {
    let corner = Vec2::new(view.film.crop_offset[0] as f32, view.film.crop_offset[1] as f32);
    let size = Vec2::new(view.film.crop_size[0] as f32, view.film.crop_size[1] as f32);
    let width = |(x, y): (u32, u32)| {
        let at = corner + size * (Vec2::new(x as f32, y as f32) + 0.5) / RAYS as f32;
        let ray = |pixel| view.sensor.sample_ray(pixel, Vec2::splat(0.5), 0.0).ray;
        let (here, beside) = (ray(at), ray(at + Vec2::X));
        scene.intersect(&here).map(|hit| here.at(hit.t).distance(beside.at(hit.t)))
    };
    let mut found: Vec<f32> = (0..RAYS).flat_map(|y| (0..RAYS).map(move |x| (x, y))).filter_map(width).collect();
    found.sort_by(f32::total_cmp);
    let most = MOST * scene.bounds.bounding_sphere().1;
    let radius = found.get(found.len() / 2).map_or(most, |median| (widths * median).min(most));
    // An empty scene has no size; any radius will do.
    if radius > 0.0 { radius } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// r²_k/r²_0 = Γ(k + 1 + α) / (Γ(1 + α) Γ(k + 2)), and falls like k^{α-1}.
    #[test]
    fn radii_shrink_as_told() {
        for alpha in [0.3f32, 2.0 / 3.0, 0.9] {
            assert_eq!(radius_of_pass(0.5, alpha, 0), 0.5);
            let once = f64::from(radius_of_pass(1.0, alpha, 1)).powi(2);
            assert!((once - (1.0 + f64::from(alpha)) / 2.0).abs() < 1e-6);
            let ratio = f64::from(radius_of_pass(1.0, alpha, 64_000) / radius_of_pass(1.0, alpha, 1000)).powi(2);
            assert!((ratio.ln() / 64f64.ln() - (f64::from(alpha) - 1.0)).abs() < 1e-3, "{alpha}");
        }
    }
}

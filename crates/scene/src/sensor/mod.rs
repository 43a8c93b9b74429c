//! We: the cameras.

use etendue_numerics::{Ray, Vec2};

/// A ray into the scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CameraRay {
    /// The ray; starts at the near plane and ends at the far plane.
    pub ray: Ray,
    /// We |cosθ| / pdf: 1 for the cameras here.
    pub weight: f32,
}

/// A camera.
#[derive(Clone, Debug)]
pub enum Sensor {}

impl Sensor {
    /// The ray through the film position `pixel` (full-film pixels) and the lens point `lens` in [0, 1)².
    pub fn sample_ray(&self, _pixel: Vec2, _lens: Vec2, _time: f32) -> CameraRay {
        match *self {}
    }
}

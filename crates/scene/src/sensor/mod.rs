//! We: the cameras, and the questions asked of them.
//!
//! ```text
//! I_j = ∫∫ h_j(q(x, w)) We(x, w) L(x, w) cosθ dA(x) dw,      We cosθ dA dw = d²q · (share of the lens)
//! ```
//!
//! I_j is a pixel's value, h_j its reconstruction filter with ∫ h_j d²q = 1, and q the place on the film in pixels of the full film, (0, 0) its upper
//! left corner. So ∫ We cosθ dA dw = 1 over the rays of any one pixel, and width · height over the whole film. A ray drawn
//! uniformly in q and over the lens has weight 1, and a particle that meets the lens adds β We … to the film at q, to be splat with a kernel of
//! integral 1 and divided by the particles started.
//!
//! | question | of a point that sees the lens | of rays that set out |
//! | --- | --- | --- |
//! | how much? | `we`, 1/(m² sr); 1/sr for a pinhole | the same We |
//! | how likely was that? | `SensorSample::pdf` | `pdf`: 1/m² and 1/sr, q uniform over the film |
//! | pick one | `sample_direction` → [`SensorSample`] | `sample_ray` → [`CameraRay`] |
//!
//! A pinhole is a discrete place and an orthographic camera a discrete direction, as points and distant lights are among emitters.
//! Cameras look along +z of their own coordinates, x grows to the left of the picture and y upwards.

mod orthographic;
mod perspective;
mod projection;
mod spherical;
mod thin_lens;

pub use orthographic::Orthographic;
pub use perspective::Perspective;
pub use projection::Projection;
pub use spherical::Spherical;
pub use thin_lens::ThinLens;

use crate::emitter::PositionPdf;
use crate::interaction::Interaction;
use etendue_numerics::{Pdf, Ray, Vec2, Vec3, wide};

/// A ray into the scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CameraRay {
    /// The ray; starts at the near plane and ends at the far plane.
    pub ray: Ray,
    /// We |cosθ| / density, for q uniform with density 1 a pixel: 1 for the cameras here.
    pub weight: f32,
}

/// Many of them, one array a number; what lies beyond those asked for is nothing.
#[derive(Clone, Debug)]
pub struct CameraRays<const N: usize> {
    o: [[f32; N]; 3],
    d: [[f32; N]; 3],
    end: [f32; N],
    weight: [f32; N],
}

impl<const N: usize> CameraRays<N> {
    /// None yet.
    pub const NONE: Self = Self { o: [[0.0; N]; 3], d: [[0.0; N]; 3], end: [0.0; N], weight: [0.0; N] };

    #[inline(always)]
    fn set(&mut self, i: usize, ray: &CameraRay) {
        let CameraRay { ray: Ray { o, d, t_max, .. }, weight } = ray;
        (self.o[0][i], self.o[1][i], self.o[2][i]) = (o.x, o.y, o.z);
        (self.d[0][i], self.d[1][i], self.d[2][i]) = (d.x, d.y, d.z);
        (self.end[i], self.weight[i]) = (*t_max, *weight);
    }

    /// Ray `i`, at a time, and its weight.
    #[inline(always)]
    pub fn get(&self, i: usize, time: f32) -> (Ray, f32) {
        let (o, d) = (Vec3::new(self.o[0][i], self.o[1][i], self.o[2][i]), Vec3::new(self.d[0][i], self.d[1][i], self.d[2][i]));
        (Ray { time, ..Ray::new(o, d).until(self.end[i]) }, self.weight[i])
    }
}

/// The rays of a pinhole through many places of the film, on lanes.
struct Pinhole<'a, const N: usize> {
    camera: &'a Perspective,
    places: &'a [[f32; N]; 2],
    rays: &'a mut CameraRays<N>,
    lanes: usize,
}

impl<const N: usize> wide::Job for Pinhole<'_, N> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { camera, places: [x, y], rays, lanes } = self;
        for i in 0..lanes.min(N) {
            rays.set(i, &camera.sample_ray(Vec2::new(x[i], y[i]), Vec2::ZERO, 0.0));
        }
    }
}

impl Sensor {
    /// [`Sensor::sample_ray`] through each of the first `count` places x, y of the film; `lens` tells the point on the lens.
    pub fn sample_rays<const N: usize>(
        &self,
        places: &[[f32; N]; 2],
        count: usize,
        lens: impl Fn(usize) -> Vec2,
        rays: &mut CameraRays<N>,
    ) {
        if let Self::Perspective(camera) = self {
            return wide::widest(Pinhole { camera, places, rays, lanes: count.next_multiple_of(wide::PAD) });
        }
        let [x, y] = places;
        for (i, (x, y)) in x.iter().zip(y).enumerate().take(count) {
            rays.set(i, &self.sample_ray(Vec2::new(*x, *y), lens(i), 0.0));
        }
    }
}

/// The lens as a point of the scene sees it: contribution = β f |cosθ| `we` / `pdf.value()`, splat at `pixel`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SensorSample {
    /// Unit direction towards the lens.
    pub wi: Vec3,
    /// Where the camera's ray would start, on the near plane: nothing beyond it is in the way.
    pub p: Vec3,
    /// We, 1/(m² sr); where the place or the direction is discrete We cosθ/r², 1/m², or We, 1/m².
    pub we: f32,
    /// Density of `wi`, 1/sr, or the probability of the discrete direction.
    pub pdf: Pdf,
    /// The place on the film, in pixels of the full film.
    pub pixel: Vec2,
}

impl SensorSample {
    /// The ray from `x` that must arrive unhindered.
    #[inline]
    pub fn shadow_ray(&self, x: &Interaction) -> Option<Ray> {
        x.spawn_to(self.p)
    }
}

/// A passage of light through the lens, from its front.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Passage {
    /// Where along the ray nothing can be in the way any more: on the near plane.
    pub t: f32,
    /// We of the camera's ray along the same line, 1/(m² sr).
    pub we: f32,
    /// Its place on the film, in pixels of the full film.
    pub pixel: Vec2,
}

/// What every camera answers.
pub trait Camera {
    /// We of the ray that leaves the lens point `p` in the unit direction `w`, per pixel and 1/(m² sr) (1/sr for a pinhole, whose `p` is
    /// not looked at); zero beyond the film, and where only one direction is possible.
    fn we(&self, p: Vec3, w: Vec3) -> f32;

    /// Where on the film the ray from the lens point `p` in the unit direction `w` comes from, in pixels of the full film; `None` beyond it.
    fn pixel(&self, p: Vec3, w: Vec3) -> Option<Vec2>;

    /// The densities of that ray under [`Camera::sample_ray`] with `pixel` uniform over the full film.
    fn pdf(&self, p: Vec3, w: Vec3) -> (PositionPdf, Pdf);

    /// The ray for a place on the film, in pixels of the full film, and a point `lens` of the unit square; `time` in [0, 1].
    fn sample_ray(&self, pixel: Vec2, lens: Vec2, time: f32) -> CameraRay;

    /// A point on the lens, drawn by `lens` in the unit square, as seen from `from`; `None` where it falls on no part of the film or `from`
    /// is not between the near and the far plane.
    fn sample_direction(&self, from: Vec3, lens: Vec2) -> Option<SensorSample>;

    /// Whether there is a lens of some size: whether [`Camera::passage`] ever finds anything.
    fn has_lens(&self) -> bool {
        false
    }

    /// Where `ray`, which light travels along, passes the lens from its front; `None` where it does not, falls on no part of the film, or does
    /// not start between the near and the far plane.
    fn passage(&self, _ray: &Ray) -> Option<Passage> {
        None
    }
}

macro_rules! sensors {
    ($($(#[$doc:meta])* $model:ident),* $(,)?) => {
        /// A camera of any model.
        #[derive(Clone, Debug)]
        pub enum Sensor {
            $($(#[$doc])* $model($model),)*
        }

        $(impl From<$model> for Sensor {
            fn from(model: $model) -> Self {
                Self::$model(model)
            }
        })*

        impl Sensor {
            /// The model's name.
            pub fn name(&self) -> &'static str {
                match self { $(Self::$model(_) => stringify!($model),)* }
            }

            /// We of the ray that leaves the lens point `p` in the unit direction `w`; see [`Camera::we`].
            #[inline]
            pub fn we(&self, p: Vec3, w: Vec3) -> f32 {
                match self { $(Self::$model(m) => m.we(p, w),)* }
            }

            /// The place on the film, in pixels of the full film, of that ray; see [`Camera::pixel`].
            #[inline]
            pub fn pixel(&self, p: Vec3, w: Vec3) -> Option<Vec2> {
                match self { $(Self::$model(m) => m.pixel(p, w),)* }
            }

            /// The densities of that ray; see [`Camera::pdf`].
            #[inline]
            pub fn pdf(&self, p: Vec3, w: Vec3) -> (PositionPdf, Pdf) {
                match self { $(Self::$model(m) => m.pdf(p, w),)* }
            }

            /// The ray through the film position `pixel` (full-film pixels) and the lens point `lens` in [0, 1)²; see [`Camera::sample_ray`].
            #[inline]
            pub fn sample_ray(&self, pixel: Vec2, lens: Vec2, time: f32) -> CameraRay {
                match self { $(Self::$model(m) => m.sample_ray(pixel, lens, time),)* }
            }

            /// A point on the lens as seen from `from`; see [`Camera::sample_direction`].
            #[inline]
            pub fn sample_direction(&self, from: Vec3, lens: Vec2) -> Option<SensorSample> {
                match self { $(Self::$model(m) => m.sample_direction(from, lens),)* }
            }

            /// Whether there is a lens of some size; see [`Camera::has_lens`].
            pub fn has_lens(&self) -> bool {
                match self { $(Self::$model(m) => m.has_lens(),)* }
            }

            /// Where light that travels along `ray` passes the lens; see [`Camera::passage`].
            #[inline]
            pub fn passage(&self, ray: &Ray) -> Option<Passage> {
                match self { $(Self::$model(m) => m.passage(ray),)* }
            }
        }
    };
}

sensors! {
    /// A pinhole.
    Perspective,
    /// A lens with depth of field.
    ThinLens,
    /// Parallel rays.
    Orthographic,
    /// All directions.
    Spherical,
}

//! Le: where light comes from, and the questions asked of it.
//!
//! | question | of a point that sees the light | of light that sets out |
//! | --- | --- | --- |
//! | how much? | `le`, `le_escaped`: radiance Le, W/(m² sr) | the same Le |
//! | how likely was that? | `pdf`, `pdf_escaped`, 1/sr | `pdf_emission`: 1/m² and 1/sr |
//! | pick one | `sample` → [`LightSample`] | `sample_emission` → [`EmissionSample`] |
//! | all in all | `extent`: bounds for the light sampler | `power`: flux Φ, W |
//!
//! Every model answers the questions of [`Light`], in this order. An emitter is made of *light primitives* ([`LightId`]): the
//! triangles of an emitting mesh, or one for the whole. [`Lights`] chooses among them; densities of single lights do not hold that choice,
//! those of `Lights` do. Discrete choices (the only direction to a point, the only direction of a distant light) are a variant of
//! the density's type, never a large number. Lights emit on the front of surfaces: the side that the geometric normal points to.

mod area;
mod constant;
mod directional;
mod directional_area;
mod envmap;
mod extent;
mod goniometric;
mod infinity;
mod lane;
mod lights;
mod lone;
mod octahedral;
mod point;
mod portal;
mod projector;
mod record;
mod spot;
mod tree;

pub use area::Area;
pub use constant::Constant;
pub use directional::Directional;
pub use directional_area::DirectionalArea;
pub use envmap::Environment;
pub use extent::{Extent, LightBounds};
pub use goniometric::Goniometric;
pub use lights::Lights;
pub use lone::{Lone, LonePoint};
pub use octahedral::Octahedral;
pub use point::Point;
pub use portal::Portal;
pub use projector::Projector;
pub use record::{EmissionPdf, EmissionSample, Escape, LightId, LightQuery, LightReference, LightSample, PositionPdf, Seen};
pub use spot::Spot;

use crate::interaction::Interaction;
use crate::scene::Scene;
use etendue_description::NodeId;
use etendue_numerics::{Spectrum, Vec2, Vec3, Wavelengths};

/// The wavelengths of query i.
#[inline]
fn of(wl: &[Wavelengths], i: usize) -> &Wavelengths {
    wl.get(i).unwrap_or(&Wavelengths::Rgb)
}

/// What every light answers. `id` is the light primitive that is asked; models of one piece look at its emitter only.
pub trait Light {
    /// Le(x → `x.wo`), W/(m² sr), of the emitting surface at x; zero for lights that are no surfaces.
    fn le(&self, _scene: &Scene, _x: &Interaction, _wl: &Wavelengths) -> Spectrum {
        Spectrum::ZERO
    }

    /// Le, W/(m² sr), of the surroundings seen from `p` in the unit direction `d`; zero for all other lights.
    fn le_escaped(&self, _p: Vec3, _d: Vec3, _wl: &Wavelengths) -> Spectrum {
        Spectrum::ZERO
    }

    /// The density, 1/sr at `from`, with which [`Light::sample`] draws the point `x` of the primitive.
    fn pdf(&self, _scene: &Scene, _from: &LightReference, _id: LightId, _x: &Interaction) -> f32 {
        0.0
    }

    /// The density, 1/sr at `from`, with which [`Light::sample`] draws the direction `wi` of the surroundings.
    fn pdf_escaped(&self, _from: &LightReference, _wi: Vec3) -> f32 {
        0.0
    }

    /// [`Light::le_escaped`] of many rays and [`Light::pdf_escaped`] where it is asked for; `found` hears of them in their order.
    fn escaped_each<'a>(&self, rays: impl Iterator<Item = Escape<'a>>, mut found: impl FnMut(&Escape<'a>, Seen)) {
        for ray in rays {
            let (o, d) = (ray.ray.o, ray.ray.d);
            let pdf = ray.from.map_or(0.0, |from| self.pdf_escaped(from, d));
            found(&ray, Seen { le: self.le_escaped(o, d, ray.wl), pdf });
        }
    }

    /// A point of the primitive, or a direction towards it, that sends light to `from`; `None` where none can.
    fn sample(&self, scene: &Scene, from: &LightReference, id: LightId, u: Vec2, wl: &Wavelengths) -> Option<LightSample>;

    /// [`Light::sample`] of many queries, each with its wavelengths (none where all are RGB); `found` hears of them in their order.
    fn sample_each(
        &self,
        scene: &Scene,
        id: LightId,
        queries: &[LightQuery],
        wl: &[Wavelengths],
        mut found: impl FnMut(usize, Option<LightSample>),
    ) {
        queries.iter().enumerate().for_each(|(i, q)| found(i, self.sample(scene, &q.from, id, q.u, of(wl, i))));
    }

    /// The densities of [`Light::sample_emission`] for light that leaves `x` towards `x.wo`: of the primitive's point x, and of the
    /// direction. Asked of emitting surfaces only.
    fn pdf_emission(&self, _scene: &Scene, _id: LightId, _x: &Interaction) -> EmissionPdf {
        EmissionPdf::ZERO
    }

    /// The same for the surroundings, for light that comes from the direction `wi`.
    fn pdf_emission_escaped(&self, _scene: &Scene, _wi: Vec3) -> EmissionPdf {
        EmissionPdf::ZERO
    }

    /// The same for points and single directions, for light that travels towards `w`.
    fn pdf_emission_discrete(&self, _scene: &Scene, _w: Vec3) -> EmissionPdf {
        EmissionPdf::ZERO
    }

    /// A ray that sets out from the primitive: `u_position` picks where, `u_direction` whereto.
    fn sample_emission(
        &self,
        scene: &Scene,
        id: LightId,
        u_position: Vec2,
        u_direction: Vec2,
        wl: &Wavelengths,
    ) -> Option<EmissionSample>;

    /// Flux Φ of a primitive, W: all that is emitted. Of lights at infinity: what passes through the disk that the scene's sphere
    /// fills, summed over directions.
    fn power_of(&self, scene: &Scene, primitive: u32) -> Spectrum;

    /// Flux Φ of all primitives, W.
    fn power(&self, scene: &Scene) -> Spectrum {
        let mut sum = [0f64; 4];
        for i in 0..self.primitive_count(scene) {
            let power = self.power_of(scene, i);
            sum.iter_mut().enumerate().for_each(|(lane, s)| *s += f64::from(power[lane]));
        }
        Spectrum(sum.map(|s| s as f32).into())
    }

    /// How many light primitives.
    fn primitive_count(&self, _scene: &Scene) -> u32 {
        1
    }

    /// What the light sampler knows of a primitive.
    fn extent(&self, scene: &Scene, primitive: u32) -> Extent;
}

macro_rules! models {
    ($($(#[$doc:meta])* $model:ident),* $(,)?) => {
        /// A light of any model.
        #[derive(Clone, Debug)]
        pub enum Model {
            $($(#[$doc])* $model($model),)*
        }

        $(impl From<$model> for Model {
            fn from(model: $model) -> Self {
                Self::$model(model)
            }
        })*

        impl Model {
            /// The model's name.
            pub fn name(&self) -> &'static str {
                match self { $(Self::$model(_) => stringify!($model),)* }
            }
        }

        impl Light for Model {
            #[inline]
            fn le(&self, scene: &Scene, x: &Interaction, wl: &Wavelengths) -> Spectrum {
                match self { $(Self::$model(m) => m.le(scene, x, wl),)* }
            }
            #[inline]
            fn le_escaped(&self, p: Vec3, d: Vec3, wl: &Wavelengths) -> Spectrum {
                match self { $(Self::$model(m) => m.le_escaped(p, d, wl),)* }
            }
            #[inline]
            fn pdf(&self, scene: &Scene, from: &LightReference, id: LightId, x: &Interaction) -> f32 {
                match self { $(Self::$model(m) => m.pdf(scene, from, id, x),)* }
            }
            #[inline]
            fn pdf_escaped(&self, from: &LightReference, wi: Vec3) -> f32 {
                match self { $(Self::$model(m) => m.pdf_escaped(from, wi),)* }
            }
            fn escaped_each<'a>(&self, rays: impl Iterator<Item = Escape<'a>>, found: impl FnMut(&Escape<'a>, Seen)) {
                match self { $(Self::$model(m) => m.escaped_each(rays, found),)* }
            }
            #[inline]
            fn sample(&self, scene: &Scene, from: &LightReference, id: LightId, u: Vec2, wl: &Wavelengths) -> Option<LightSample> {
                match self { $(Self::$model(m) => m.sample(scene, from, id, u, wl),)* }
            }
            fn sample_each(
                &self, scene: &Scene, id: LightId, queries: &[LightQuery], wl: &[Wavelengths], found: impl FnMut(usize, Option<LightSample>),
            ) {
                match self { $(Self::$model(m) => m.sample_each(scene, id, queries, wl, found),)* }
            }
            fn pdf_emission(&self, scene: &Scene, id: LightId, x: &Interaction) -> EmissionPdf {
                match self { $(Self::$model(m) => m.pdf_emission(scene, id, x),)* }
            }
            fn pdf_emission_escaped(&self, scene: &Scene, wi: Vec3) -> EmissionPdf {
                match self { $(Self::$model(m) => m.pdf_emission_escaped(scene, wi),)* }
            }
            fn pdf_emission_discrete(&self, scene: &Scene, w: Vec3) -> EmissionPdf {
                match self { $(Self::$model(m) => m.pdf_emission_discrete(scene, w),)* }
            }
            fn sample_emission(
                &self, scene: &Scene, id: LightId, u_position: Vec2, u_direction: Vec2, wl: &Wavelengths,
            ) -> Option<EmissionSample> {
                match self { $(Self::$model(m) => m.sample_emission(scene, id, u_position, u_direction, wl),)* }
            }
            fn power_of(&self, scene: &Scene, primitive: u32) -> Spectrum {
                match self { $(Self::$model(m) => m.power_of(scene, primitive),)* }
            }
            fn primitive_count(&self, scene: &Scene) -> u32 {
                match self { $(Self::$model(m) => m.primitive_count(scene),)* }
            }
            fn extent(&self, scene: &Scene, primitive: u32) -> Extent {
                match self { $(Self::$model(m) => m.extent(scene, primitive),)* }
            }
        }
    };
}

models! {
    /// The front of a surface, equally bright from all directions.
    Area,
    /// A point.
    Point,
    /// A point with a cone.
    Spot,
    /// Parallel light from infinity.
    Directional,
    /// Parallel light along a surface's normals.
    DirectionalArea,
    /// A picture all around.
    Environment,
    /// The same radiance from all around.
    Constant,
    /// A picture thrown from a point.
    Projector,
    /// A square picture all around, areas kept.
    Octahedral,
    /// A point with a measured intensity.
    Goniometric,
    /// Surroundings behind a rectangle.
    Portal,
}

/// A light of the scene.
#[derive(Clone, Debug)]
pub struct Emitter {
    /// What emits.
    pub model: Model,
    /// How often the light sampler chooses it, relative to what it would do; 0 leaves it to be found by scattered rays. Unitless, 1 by default.
    pub sampling_weight: f32,
    /// The node of the description that it came from.
    pub node: NodeId,
    /// Whether it is switched on; [`Scene::switch`] says which are.
    pub lit: bool,
}

impl Emitter {
    /// Le(x → `x.wo`), W/(m² sr).
    #[inline]
    pub fn le(&self, scene: &Scene, x: &Interaction, wl: &Wavelengths) -> Spectrum {
        if self.lit { self.model.le(scene, x, wl) } else { Spectrum::ZERO }
    }

    /// Le of the surroundings seen from `p` in the unit direction `d`, W/(m² sr).
    #[inline]
    pub fn le_escaped(&self, p: Vec3, d: Vec3, wl: &Wavelengths) -> Spectrum {
        self.model.le_escaped(p, d, wl)
    }

    /// Flux Φ, W.
    pub fn power(&self, scene: &Scene) -> Spectrum {
        if self.lit { self.model.power(scene) } else { Spectrum::ZERO }
    }

    /// How many light primitives send out light.
    pub fn primitive_count(&self, scene: &Scene) -> u32 {
        if self.lit { self.model.primitive_count(scene) } else { 0 }
    }

    /// Whether no ray can meet it: it is a point, shines in single directions, or is a surface that is not there.
    pub fn is_delta(&self) -> bool {
        match &self.model {
            Model::Area(area) => area.unseen,
            Model::Environment(_) | Model::Octahedral(_) | Model::Constant(_) | Model::Portal(_) => false,
            _ => true,
        }
    }
}

/// One number for a colour where light is only weighed against light: the mean size of the channels. Colours beyond Rec.709 have
/// channels below zero.
pub(crate) fn scalar(s: Spectrum) -> f32 {
    let [r, g, b] = s.to_rgb();
    (r.abs() + g.abs() + b.abs()) / 3.0
}

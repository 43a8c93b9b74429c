//! The only lamp of a scene, a rectangle of one radiance, asked for many points side by side.
//!
//! [`Lone::sample`] is [`crate::Scene::sample_light`] without branches for points from which the lamp is drawn by area, the same bits: a loop
//! over it can be made of vectors. Points nearby ([`Lone::is_near`]) ask the scene.

use super::{Lights, Model};
use crate::scene::Scene;
use crate::shape::FarRectangle;
use crate::texture::{Color, ColorSlot};
use etendue_numerics::ray::offset_origin;
use etendue_numerics::{Spectrum, Vec2, Vec3, Wavelengths};

/// The lamp, by value.
#[derive(Clone, Debug)]
pub struct Lone {
    rectangle: FarRectangle,
    /// Its radiance, linear Rec.709.
    pub le: Spectrum,
    /// The same at wavelengths.
    pub radiance: Color,
}

/// A point on it, as in a `LightSample`.
#[derive(Clone, Copy, Debug)]
pub struct LonePoint {
    /// Unit direction towards it.
    pub wi: Vec3,
    /// The point, clear of the lamp.
    pub p: Vec3,
    /// The lamp's unit normal there.
    pub n: Vec3,
    /// Density of `wi`, 1/sr.
    pub pdf: f32,
    /// Whether it sends light here.
    pub is_there: bool,
}

impl Lights {
    /// The only light, where it is such a lamp.
    pub fn lone(&self, scene: &Scene) -> Option<Lone> {
        let Model::Area(area) = &scene.emitter(self.alone()?.emitter).model else { return None };
        let ColorSlot::Constant(color) = &area.radiance else { return None };
        if area.two_sided || area.unseen || area.scale != 1.0 {
            return None;
        }
        let rectangle = FarRectangle::of(scene.surface(area.surface).shape.mesh()?)?;
        Some(Lone { rectangle, le: color.at(&Wavelengths::Rgb), radiance: color.clone() })
    }
}

impl Lone {
    /// Whether `from` is so near that the scene must be asked.
    #[inline(always)]
    pub fn is_near(&self, from: Vec3) -> bool {
        self.rectangle.is_near(from)
    }

    /// A point for `from`.
    #[inline(always)]
    pub fn sample(&self, from: Vec3, u: Vec2) -> LonePoint {
        let (p, p_error, n, pdf) = self.rectangle.sample(from, u);
        let d = from - p;
        let distance = d.length();
        let is_there = (pdf > 0.0) & (n.dot(d) > 0.0) & (distance != 0.0);
        LonePoint { wi: -d / distance, p: offset_origin(p, p_error, n, d), n, pdf, is_there }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{CompileOptions, LightReference, compile};
    use etendue_description::Diagnostics;

    #[test]
    fn the_lamp_answers_as_the_scene_does() {
        let text = r#"<scene version="3.0.0"><shape type="rectangle">
            <transform name="to_world"><rotate x="1" angle="70"/><scale x="0.7" y="1.3"/><translate x="0.1" y="2" z="-0.3"/></transform>
            <emitter type="area"><rgb name="radiance" value="3, 2, 1"/></emitter></shape></scene>"#;
        let (description, _) = etendue_formats::read_str("lamp.xml", text, &etendue_formats::ReadOptions::default());
        let scene = compile(&description, &CompileOptions::default(), &mut Diagnostics::default()).expect("a scene");
        let lone = scene.lights.lone(&scene).expect("a lone lamp");
        let (mut near, mut far, mut behind) = (0, 0, 0);
        for k in 0..4000u32 {
            let digit = |i: u32| etendue_numerics::sequence::unit(etendue_numerics::sequence::mix(u64::from(k * 8 + i)) as u32);
            let from = 8.0 * (Vec3::new(digit(0), digit(1), digit(2)) - 0.5);
            let u = Vec2::new(digit(3), digit(4));
            if lone.is_near(from) {
                near += 1;
                continue;
            }
            let (got, want) = (lone.sample(from, u), scene.sample_light(&LightReference::point(from), 0.0, u, &Wavelengths::Rgb));
            assert_eq!(got.is_there, want.is_some());
            let Some(want) = want else {
                behind += 1;
                continue;
            };
            far += 1;
            assert_eq!((got.wi, got.p, got.n, got.pdf, lone.le), (want.wi, want.p, want.n, want.pdf.value(), want.le));
        }
        assert!(near > 100 && far > 1000 && behind > 500, "{near} {far} {behind}");
    }
}

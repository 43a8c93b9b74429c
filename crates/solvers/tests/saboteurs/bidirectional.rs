//! Bidirectional path tracing with one deliberate fault at a time.

use etendue_film::Splat;
use etendue_numerics::{Dim, Sampler, Spectrum, Vec2, Wavelengths};
use etendue_scene::Scene;
use etendue_solvers::bidirectional::{Bidirectional, Found, Joint, Paths};
use etendue_solvers::solver::{CannotGoOn, Needs};
use etendue_solvers::transport::{PathState, slot};
use etendue_solvers::{Run, Solver, Work};

faults! {
    /// The weights leave a place for next event estimation, and nobody takes it.
    NoNextEvent,
    /// The same of connections to the lens.
    NoLens,
    /// The same of lamps that the eye's walk hits.
    NoHits,
    /// What next event estimation finds counts in full.
    MisOffForTheLight,
    /// What connections of inner vertices find counts in full.
    MisOffWithin,
    /// Splats are divided by twice the particles started.
    SplatsNotNormalised,
    /// Inner connections without 1/r².
    LostDistance,
    /// Inner connections without the cosine at the light's side.
    LostCosine,
}

/// bidirectional, with a fault; one thread does a pass.
pub struct Saboteur(pub Fault);

impl Saboteur {
    /// What a path adds to the picture.
    fn share(&self, f: &Found<'_>) -> Spectrum {
        let mut value = f.value * f.weight;
        match (self.0, f.joint) {
            (NoNextEvent, Joint::Light(..)) | (NoLens, Joint::Lens(..)) => return Spectrum::ZERO,
            (NoHits, Joint::Hit(Some(_), _)) => return Spectrum::ZERO,
            (MisOffForTheLight, Joint::Light(..)) | (MisOffWithin, Joint::Inner(..)) => value = f.value,
            (LostDistance, Joint::Inner(y, z)) => value *= (y.vertex.x.p - z.vertex.x.p).length_squared(),
            (LostCosine, Joint::Inner(y, z)) => {
                let w = (y.vertex.x.p - z.vertex.x.p).normalize_or_zero();
                value *= 1.0 / z.vertex.x.n.dot(w).abs().max(0.05);
            }
            _ => (),
        }
        value
    }
}

impl Solver for Saboteur {
    type State = ();

    fn needs(&self) -> Needs {
        Needs::default()
    }

    fn units(&self, _: [u32; 2]) -> usize {
        1
    }

    fn prepare(&self, _: &Scene, _: &Run<'_>) {}

    fn pass(&self, scene: &Scene, run: &Run<'_>, (): &mut (), k: u32, work: &Work<'_>) -> Result<(), CannotGoOn> {
        let all = Bidirectional::default().strategies(scene, run);
        let [width, height] = work.film.shape().size;
        let (mut tile, mut splats, mut paths) = (work.film.tile(), Vec::new(), Paths::default());
        tile.begin([0, 0], [width, height]);
        for (y, x) in (0..height).flat_map(|y| (0..width).map(move |x| (y, x))) {
            let u = Sampler::on_screen(run.sequence, run.seed, [x, y], k, run.planned_samples());
            let at = Vec2::new(x as f32, y as f32) + u.u2(Dim::at(0, slot::PIXEL));
            let ray = all.view.sensor.sample_ray(at, u.u2(Dim::at(0, slot::LENS)), 0.0);
            let eye = PathState::start(ray.ray, Spectrum::splat(ray.weight), Wavelengths::Rgb);
            let mut l = Spectrum::ZERO;
            all.sample(eye, &u, &mut paths, &mut |f, _, _| match f.pixel {
                None => l += self.share(f),
                Some(position) => splats.push(Splat { position, value: self.share(f), particle: 0 }),
            });
            tile.add(at, l, k);
        }
        work.film.add_tile(&tile);
        work.film.add_splats(&splats);
        let twice = if self.0 == SplatsNotNormalised { 2 } else { 1 };
        work.film.start_particles(twice * u64::from(width) * u64::from(height));
        work.units.done(0);
        Ok(())
    }
}

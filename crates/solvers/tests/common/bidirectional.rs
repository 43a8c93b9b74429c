//! A pass of bidirectional paths as its pseudocode has it: one sample after the other, one thread.

use etendue_film::Splat;
use etendue_numerics::{Dim, Sampler, Spectrum, Vec2, Wavelengths};
use etendue_solvers::bidirectional::{Found, Paths, Strategies};
use etendue_solvers::transport::{PathState, slot};
use etendue_solvers::{Run, Work};

/// The pass, in which each path found adds its `share`. Returns how many particles started.
pub fn one_by_one(all: &Strategies<'_>, run: &Run<'_>, k: u32, work: &Work<'_>, share: impl Fn(&Found<'_>) -> Spectrum) -> u64 {
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
            None => l += share(f),
            Some(position) => splats.push(Splat { position, value: share(f), particle: 0 }),
        });
        tile.add(at, l, k);
    }
    let started = u64::from(width) * u64::from(height);
    work.film.add_tile(&tile);
    work.film.add_splats(&splats);
    work.film.start_particles(started);
    work.units.done(0);
    started
}

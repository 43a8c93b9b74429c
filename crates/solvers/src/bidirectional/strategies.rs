//! Each strategy's picture on its own, weighted and not: the pyramid of [Veach 1997, fig. 10.2].
//!
//! ```text
//! unweighted: E[C_{s,t}],     weighted: E[w_{s,t} C_{s,t}],     Σ_{s,t} weighted = the picture
//! ```
//!
//! Where nothing scatters into discrete directions, all unweighted pictures of the same s + t with t ≥ 1 have the same mean: the light of s + t - 1 edges (but
//! s = t = 1 sees surfaces only, and s = 0 no points).

use super::{Bidirectional, Paths};
use crate::drivers::pixels::{SamplePlan, Tiling, camera_ray};
use crate::run::Run;
use etendue_film::{Film, FilmShape, Splat};
use etendue_numerics::Vec2;
use etendue_scene::Scene;
use rayon::prelude::*;

/// A strategy's pictures: linear Rec.709, rows from the top.
#[derive(Clone, Debug)]
pub struct StrategyPicture {
    /// Vertices from the light's side.
    pub s: u32,
    /// Vertices from the eye's side, the lens included.
    pub t: u32,
    /// What it finds alone.
    pub unweighted: Vec<[f32; 3]>,
    /// Its share of the whole picture.
    pub weighted: Vec<[f32; 3]>,
}

/// The pictures of all strategies with s + t ≤ `vertices`, in the order of s + t and then of s, after `passes` passes, fewer where it was asked to
/// stop.
pub fn pictures<'a>(solver: &Bidirectional, scene: &'a Scene, run: &Run<'_>, passes: u32, vertices: u32) -> Vec<StrategyPicture> {
    let all = solver.strategies(scene, run);
    let film = &all.view.film;
    let names: Vec<(u32, u32)> = (2..=vertices).flat_map(|n| (0..n).map(move |s| (s, n - s))).collect();
    let place = |s: u32, t: u32| ((s + t) * (s + t - 1) / 2 - 1 + s) as usize;
    let blank = || Film::new(FilmShape { size: film.crop_size, kernel: film.filter });
    let films: Vec<[Film; 2]> = names.iter().map(|_| [blank(), blank()]).collect();

    let corner = Vec2::new(film.crop_offset[0] as f32, film.crop_offset[1] as f32);
    let pixels = (film.crop_size[0] as f32) * (film.crop_size[1] as f32);
    let tiling = Tiling::new(film.crop_size);
    let mut done = 0;
    for k in 0..passes {
        if run.cancel.is_cancelled() {
            break;
        }
        done = k + 1;
        let plan = SamplePlan::new(run, k);
        let tile = |paths: &mut Paths<'a>, unit: usize| {
            let mut splats: Vec<[Vec<Splat>; 2]> = vec![Default::default(); names.len()];
            let (low, high) = tiling.rectangle(unit);
            for (y, x) in (low[1]..high[1]).flat_map(|y| (low[0]..high[0]).map(move |x| (y, x))) {
                let u = plan.sampler(run, x + film.crop_offset[0], y + film.crop_offset[1]);
                let (own, eye) = camera_ray(&all.c, run, film, [x, y], &u);
                let wl = eye.wl;
                all.sample(eye, &u, paths, &mut |f, _, _| {
                    if f.s + f.t > vertices {
                        return;
                    }
                    // A sample of a pixel counts for that pixel alone, a particle for all of them.
                    let seen = wl.to_rgb(f.value);
                    let (position, value) = f.pixel.map_or((own, seen * pixels), |p| (p - corner, seen));
                    let splat = |value| Splat { position, value, particle: 0 };
                    let [unweighted, weighted] = &mut splats[place(f.s, f.t)];
                    unweighted.push(splat(value));
                    weighted.push(splat(value * f.weight));
                });
            }
            for (films, splats) in films.iter().zip(&splats) {
                films.iter().zip(splats).for_each(|(film, splats)| film.add_splats(splats));
            }
        };
        run.pool.install(|| (0..tiling.len()).into_par_iter().for_each_init(Paths::default, tile));
    }

    let started = u64::from(done) * u64::from(film.crop_size[0]) * u64::from(film.crop_size[1]);
    let developed = |film: &Film| {
        film.start_particles(started);
        film.develop()
    };
    let picture = |((s, t), [unweighted, weighted]): (&(u32, u32), &[Film; 2])| StrategyPicture {
        s: *s,
        t: *t,
        unweighted: developed(unweighted),
        weighted: developed(weighted),
    };
    names.iter().zip(&films).map(picture).collect()
}

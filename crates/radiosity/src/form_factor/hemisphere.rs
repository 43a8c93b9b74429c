//! `hemisphere`: cosine-distributed rays from points of each patch; F_ij is the part of them that meets patch j first.
//!
//! ```text
//! x uniform on i,  w with density cosθ/π:        F_ij = E[ RT(x, w) on j ]
//! ```
//!
//! | parameter | meaning | default |
//! | --- | --- | --- |
//! | `rays` | rays a patch, in 16 scramblings; 16 · 2^k is best | 4096 |
//! | `share` | how patches have part in them ([`Share`]) | all alike |
//! | `errors` | the standard error of each entry, from the scramblings; 4 bytes an entry | true |
//! | `seed` | of the scramblings | 0 |
//!
//! Point and direction are one point in four dimensions ([`Net4`]). Rows close by construction: what meets no patch is counted as escaped or
//! absorbed. Where parameters are not in step with area the rays have weights, and F is a ratio of their sums.

use super::tally::{REPLICATES, Strip, Tally};
use super::{Cancelled, FormFactors, Matrix, Watch};
use crate::patch::{NONE, PatchPoint, Patches};
use etendue_numerics::warp::square_to_cosine_hemisphere;
use etendue_numerics::{Frame, Net4, Vec2, Vec3};
use etendue_scene::Scene;
use rayon::prelude::*;

/// Parameters of the method.
#[derive(Clone, Copy, Debug)]
pub struct Hemisphere {
    /// Rays a patch.
    pub rays: u32,
    /// How patches have part in them.
    pub share: Share,
    /// Whether each entry gets its standard error.
    pub errors: bool,
    /// Of the scramblings.
    pub seed: u64,
}

impl Default for Hemisphere {
    fn default() -> Self {
        Self { rays: 4096, share: Share::Even, errors: true, seed: 0 }
    }
}

/// How many of the rays a patch has.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Share {
    /// All of them.
    #[default]
    Even,
    /// In proportion to its area: all at `whole` m² and beyond, and one in sixteen of them at least. Light between two patches is then known equally well from both ends.
    ByArea {
        /// m².
        whole: f64,
    },
}

/// One in so many rays is left to the smallest of patches.
const LEAST: u32 = 16;

impl Share {
    /// So many of `rays` for a patch of this area, m².
    pub fn of(self, rays: u32, area: f64) -> u32 {
        match self {
            Self::Even => rays,
            Self::ByArea { whole } => ((f64::from(rays) * area / whole) as u32).clamp(rays / LEAST, rays),
        }
        .max(1)
    }
}

/// Where a ray ends.
pub(crate) enum Landing {
    Patch(u32),
    Absorbed,
    Escaped,
}

/// The column of the object list's two extra places: what is absorbed, and what escapes.
const LOST: [u32; 2] = [0, 1];

/// Rows a task works on.
const ROWS: usize = 64;

/// The form factors by casting rays.
pub fn hemisphere(scene: &Scene, patches: &Patches, method: &Hemisphere, watch: &Watch) -> Result<FormFactors, Cancelled> {
    let n = patches.len();
    let each = |i: usize| method.share.of(method.rays, patches.patches[i].area).div_ceil(REPLICATES);
    let mut matrix = Gathered::new(n, n, method.errors);
    let mut objects = Gathered::new(n, patches.objects.len() + LOST.len(), true);
    let tasks: Vec<std::ops::Range<usize>> = (0..n).step_by(ROWS).map(|i| i..(i + ROWS).min(n)).collect();
    // A few hundred tasks at a time: their rows are put in place in order, and stand twice in memory only that long.
    for batch in tasks.chunks(256) {
        let strips: Vec<[Strip; 2]> = batch
            .par_iter()
            .map_init(
                || [Tally::new(n), Tally::new(patches.objects.len() + LOST.len())],
                |tallies, rows| {
                    let mut strips = [Strip::default(), Strip::default()];
                    rows.clone().for_each(|i| row(scene, patches, method, i as u32, each(i), tallies, &mut strips));
                    strips
                },
            )
            .collect();
        for [strip, of_objects] in strips {
            matrix.append(strip);
            objects.append(of_objects);
        }
        if !watch(matrix.rows(), n) {
            return Err(Cancelled);
        }
    }
    let lost = patches.objects.len();
    let objects = objects.finish();
    let part = |i: usize, k: usize| objects.rows.get(i, lost + k).map_or(0.0, |f| f64::from(*f));
    let (absorbed, escaped) = ((0..n).map(|i| part(i, 0)).collect(), (0..n).map(|i| part(i, 1)).collect());
    let rays = (0..n).map(|i| f64::from(each(i) * REPLICATES)).collect();
    Ok(FormFactors { absorbed, escaped, rays, to_objects: Some(objects), ..FormFactors::new(matrix.finish()) })
}

/// One row: the rays of patch i.
fn row(
    scene: &Scene,
    patches: &Patches,
    method: &Hemisphere,
    i: u32,
    each: u32,
    tallies: &mut [Tally; 2],
    strips: &mut [Strip; 2],
) {
    let [patch_tally, object_tally] = tallies;
    let lost = patches.objects.len() as u32;
    let mut sum = 0.0;
    for replicate in 0..REPLICATES {
        let net = Net4::new(method.seed, u64::from(i) * u64::from(REPLICATES) + u64::from(replicate));
        for [u, v, s, t] in net.take(each as usize) {
            let x = patches.sample(i, Vec2::new(s, t));
            let weight = x.weight as f32;
            sum += x.weight;
            let w = Frame::from_normal(x.n.as_vec3()).to_world(square_to_cosine_hemisphere(Vec2::new(u, v)));
            match land(scene, patches, i, &x, w) {
                Landing::Patch(j) => {
                    patch_tally.add(j, weight);
                    object_tally.add(patches.get(j).object, weight);
                }
                Landing::Absorbed => object_tally.add(lost + LOST[0], weight),
                Landing::Escaped => object_tally.add(lost + LOST[1], weight),
            }
        }
        patch_tally.end_replicate();
        object_tally.end_replicate();
    }
    patch_tally.end_row(sum, &mut strips[0], method.errors);
    object_tally.end_row(sum, &mut strips[1], true);
}

/// Surfaces without substance that a ray passes at most.
const PASSES: usize = 64;

/// What a ray from x on patch i meets, past surfaces that are not there.
pub(crate) fn land(scene: &Scene, patches: &Patches, i: u32, x: &PatchPoint, w: Vec3) -> Landing {
    if let Some(j) = patches.touching_at(i, x.p) {
        return Landing::Patch(j);
    }
    let mut ray = patches.spawn(i, x, w);
    for _ in 0..PASSES {
        let Some(hit) = scene.intersect(&ray) else { return Landing::Escaped };
        if let Some(place) = patches.locate(&ray, &hit) {
            let met = place.patch.and_then(|j| patches.behind_contact(j, (ray.o + ray.d * hit.t).as_dvec3()));
            return met.map_or(Landing::Absorbed, Landing::Patch);
        }
        if !patches.objects[patches.object_of(&hit) as usize].is_clear {
            return Landing::Absorbed;
        }
        ray = scene.interaction(&ray, &hit).spawn(ray.d);
    }
    Landing::Absorbed
}

/// Whether the scene is closed, as far as `rays` rays from each patch that `counts` can tell: none escapes or is absorbed by what is no patch.
pub(super) fn probe(scene: &Scene, patches: &Patches, rays: usize, counts: impl Fn(u32) -> bool + Sync) -> bool {
    (0..patches.len() as u32).into_par_iter().filter(|i| counts(*i)).all(|i| {
        Net4::new(0, u64::from(i)).take(rays).all(|[u, v, s, t]| {
            let x = patches.sample(i, Vec2::new(s, t));
            let w = Frame::from_normal(x.n.as_vec3()).to_world(square_to_cosine_hemisphere(Vec2::new(u, v)));
            matches!(land(scene, patches, i, &x, w), Landing::Patch(_))
        })
    })
}

/// Rows as they come in, one block after the other.
struct Gathered {
    begins: Vec<usize>,
    columns: Vec<u32>,
    values: Vec<f32>,
    errors: Vec<f32>,
    shape: (usize, usize),
    with_errors: bool,
}

impl Gathered {
    fn new(rows: usize, columns: usize, with_errors: bool) -> Self {
        let shape = (rows, columns);
        Self { begins: vec![0], columns: Vec::new(), values: Vec::new(), errors: Vec::new(), shape, with_errors }
    }

    fn rows(&self) -> usize {
        self.begins.len() - 1
    }

    fn append(&mut self, strip: Strip) {
        // Room for all rows at once, as soon as there is something to guess it by.
        if self.rows() > 0 && self.columns.capacity() < self.columns.len() + strip.columns.len() {
            let more = (self.columns.len() as f64 / self.rows() as f64 * (self.shape.0 - self.rows()) as f64 * 1.05) as usize
                + strip.columns.len();
            self.columns.reserve_exact(more);
            self.values.reserve_exact(more);
            if self.with_errors {
                self.errors.reserve_exact(more);
            }
        }
        let mut end = self.columns.len();
        for length in strip.lengths {
            end += length;
            self.begins.push(end);
        }
        self.columns.extend(strip.columns);
        self.values.extend(strip.values);
        self.errors.extend(strip.errors);
    }

    fn finish(self) -> Matrix {
        debug_assert!(self.columns.iter().all(|c| *c != NONE));
        Matrix { rows: super::Rows::new(self.shape, self.begins, self.columns, self.values), errors: self.errors }
    }
}

//! Many directions at once, a direction a lane: the bits of `Light::le_escaped`, `pdf_escaped` and `sample` of each.
//!
//! What looks things up goes from lane to lane, and is asked for ahead; what computes is a loop over lanes that the compiler makes vectors of
//! ([`etendue_numerics::wide`]).

use super::{Environment, across, azimuth, below, down, height, toward};
use crate::emitter::infinity::{outside, scene_sphere};
use crate::emitter::lane::{Lane, Lane3, MANY, get, set};
use crate::emitter::{Escape, LightId, LightQuery, LightSample, Seen, of};
use crate::scene::Scene;
use crate::texture::{Role, TexelLanes};
use etendue_numerics::table::Cells;
use etendue_numerics::{Pdf, Spectrum, Vec2, Vec3, Wavelengths, wide};

/// Places in the picture: a cell, and where in it.
struct Places {
    count: usize,
    column: Lane<i32>,
    row: Lane<i32>,
    x: Lane,
    y: Lane,
    /// Le there, linear Rec.709.
    le: Lane3,
}

impl Places {
    const NONE: Self = Self { count: 0, column: [0; MANY], row: [0; MANY], x: [0.0; MANY], y: [0.0; MANY], le: [[0.0; MANY]; 3] };

    #[inline(always)]
    fn cell(&self, i: usize) -> (usize, usize) {
        (self.column[i] as usize, self.row[i] as usize)
    }
}

impl Environment {
    /// What many rays see, and p_w where it is asked for.
    pub(super) fn seen_each<'a>(&self, mut rays: impl Iterator<Item = Escape<'a>>, mut found: impl FnMut(&Escape<'a>, Seen)) {
        let (mut some, mut d, mut places) = (Vec::with_capacity(MANY), [[0.0; MANY]; 3], Places::NONE);
        loop {
            some.clear();
            some.extend(rays.by_ref().take(MANY));
            if some.is_empty() {
                return;
            }
            some.iter().enumerate().for_each(|(i, ray)| set(&mut d, i, ray.ray.d));
            places.count = some.len();
            wide::widest(Find { sky: self, d: &d, places: &mut places });
            for (i, ray) in some.iter().enumerate() {
                let (column, row) = places.cell(i);
                self.fetch(column, row);
                if let Some(from) = ray.from {
                    self.sampled(from).fetch(column, row);
                }
            }
            self.look(&mut places);
            for (i, ray) in some.iter().enumerate() {
                let pdf = ray.from.map_or(0.0, |from| self.density_of(self.sampled(from), places.cell(i)));
                found(ray, Seen { le: self.le(&places, i, ray.wl), pdf });
            }
        }
    }

    /// Light samples for many points. Of those below the horizon nobody asks how bright they are.
    pub(super) fn drawn_each(
        &self,
        scene: &Scene,
        id: LightId,
        queries: &[LightQuery],
        wl: &[Wavelengths],
        mut found: impl FnMut(usize, Option<LightSample>),
    ) {
        let (mut v, mut drawn, mut places) = (Draws::NONE, Cells::default(), Places::NONE);
        let mut first = 0;
        while let Some(query) = queries.get(first) {
            // Together as long as they are drawn from the same cells.
            let alike = |q: &&LightQuery| q.from.shared == query.from.shared;
            let some = &queries[first..][..queries[first..].iter().take(MANY).take_while(alike).count()];
            let cells = self.sampled(&query.from);
            if cells.sum() <= 0.0 {
                (0..some.len()).for_each(|i| found(first + i, None));
                first += some.len();
                continue;
            }
            v.count = some.len();
            for (i, query) in some.iter().enumerate() {
                (v.u[0][i], v.u[1][i]) = (query.u.x, query.u.y);
                set(&mut v.p, i, query.from.p);
                set(&mut v.n, i, query.from.n);
                v.one_sided[i] = u32::from(query.from.one_sided);
            }
            cells.sample_discrete_each(v.count, &v.u, &mut drawn);
            for i in 0..v.count {
                let row = drawn.row[i] as usize;
                ([v.top[i], v.per_sr[i]], v.bottom[i]) = (self.rows[row], self.rows[row + 1][0]);
            }
            wide::widest(Aim { sky: self, drawn: &drawn, v: &mut v });

            // Those that are of use stand close together.
            places.count = 0;
            for i in 0..v.count {
                let k = places.count;
                (places.column[k], places.row[k]) = (drawn.column[i] as i32, drawn.row[i] as i32);
                (places.x[k], v.cos[k]) = (drawn.rest[0][i], v.cos[i]);
                if v.faces[i] != 0 {
                    let (column, row) = places.cell(k);
                    self.fetch(column, row);
                    places.count += 1;
                }
            }
            wide::widest(Rest { sky: self, sphere: scene_sphere(scene), v: &mut v, places: &mut places });
            self.look(&mut places);
            let mut k = 0;
            for i in 0..v.count {
                let sample = (v.faces[i] != 0).then(|| {
                    let le = self.le(&places, k, of(wl, first + i));
                    k += 1;
                    LightSample {
                        wi: get(&v.wi, i),
                        p: get(&v.far, i),
                        distance: f32::INFINITY,
                        le,
                        pdf: Pdf::SolidAngle(v.pdf[i]),
                        emitter: id.emitter,
                        primitive: 0,
                        n: Vec3::ZERO,
                    }
                });
                found(first + i, sample);
            }
            first += some.len();
        }
    }

    /// Looks up Le of places in the picture.
    fn look(&self, places: &mut Places) {
        let mut texels = [[[0.0; MANY]; 3]; 4];
        let last = self.texels.height() - 1;
        let around = |i: usize| {
            let (column, row) = places.cell(i);
            let right = if column + 1 == self.width { 0 } else { column + 1 };
            let (above, below) = (row.min(last), (row + 1).min(last));
            [[column, above], [right, above], [column, below], [right, below]]
        };
        self.texels.read_each(places.count, around, &mut texels);
        wide::widest(Between { scale: self.scale, texels: &texels, places });
    }

    /// Le of a place that was looked up, as the lanes of a walk have it.
    #[inline(always)]
    fn le(&self, places: &Places, i: usize, wl: &Wavelengths) -> Spectrum {
        if self.hue_apart && !wl.is_rgb() {
            let (column, row) = places.cell(i);
            return self.radiance((column, row, Vec2::new(places.x[i], places.y[i])), wl);
        }
        let [r, g, b] = &places.le;
        Role::Emission.spectrum(Spectrum::rgb(r[i], g[i], b[i]), wl)
    }
}

/// [`Environment::cell`].
struct Find<'a> {
    sky: &'a Environment,
    d: &'a Lane3,
    places: &'a mut Places,
}

impl wide::Job for Find<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { sky, d, places } = self;
        let (width, height, axes, lanes) = (sky.width, sky.height, sky.axes, wide::padded::<MANY>(places.count));
        for i in 0..lanes {
            (places.column[i], places.x[i]) = across(width, axes.to_local(get(d, i)));
        }
        for i in 0..lanes {
            (places.row[i], places.y[i]) = down(height, axes.to_local(get(d, i)));
        }
    }
}

/// The interpolation of [`Environment::radiance`].
struct Between<'a> {
    scale: f32,
    texels: &'a TexelLanes<4, MANY>,
    places: &'a mut Places,
}

impl wide::Job for Between<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { scale, texels: [t00, t10, t01, t11], places } = self;
        let lanes = wide::padded::<MANY>(places.count);
        let light = |v: f32| if v > 0.0 { v } else { 0.0 } * scale;
        let lerp = |t: f32, a: f32, b: f32| a * (1.0 - t) + b * t;
        for channel in 0..3 {
            let [t00, t10, t01, t11] = [&t00[channel], &t10[channel], &t01[channel], &t11[channel]];
            let le = &mut places.le[channel];
            for i in 0..lanes {
                let (x, y) = (places.x[i], places.y[i]);
                le[i] = lerp(y, lerp(x, light(t00[i]), light(t10[i])), lerp(x, light(t01[i]), light(t11[i])));
            }
        }
    }
}

/// Light samples in the making.
struct Draws {
    count: usize,
    u: [Lane; 2],
    /// Where light is asked for.
    p: Lane3,
    n: Lane3,
    one_sided: Lane<u32>,
    /// cosθ above and below the cell, and 1/Ω.
    top: Lane,
    bottom: Lane,
    per_sr: Lane,
    phi: Lane,
    cos: Lane,
    wi: Lane3,
    far: Lane3,
    pdf: Lane,
    /// Whether the light may be scattered.
    faces: Lane<u32>,
}

impl Draws {
    const NONE: Self = {
        let (one, three, flags) = ([0.0; MANY], [[0.0; MANY]; 3], [0; MANY]);
        Self {
            count: 0,
            u: [one; 2],
            p: three,
            n: three,
            one_sided: flags,
            top: one,
            bottom: one,
            per_sr: one,
            phi: one,
            cos: one,
            wi: three,
            far: three,
            pdf: one,
            faces: flags,
        }
    };
}

/// [`Environment::direction`], in the world.
struct Aim<'a> {
    sky: &'a Environment,
    drawn: &'a Cells<MANY>,
    v: &'a mut Draws,
}

impl wide::Job for Aim<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { sky, drawn, v } = self;
        let (width, axes, lanes) = (sky.width, sky.axes, wide::padded::<MANY>(v.count));
        for i in 0..lanes {
            v.phi[i] = azimuth(width, drawn.column[i] as i32 as f32, drawn.rest[0][i]);
            v.cos[i] = height(v.top[i], v.bottom[i], drawn.rest[1][i]);
            v.pdf[i] = drawn.probability[i] * v.per_sr[i];
        }
        for i in 0..lanes {
            let wi = axes.to_world(toward(v.phi[i], v.cos[i]));
            set(&mut v.wi, i, wi);
        }
        for i in 0..lanes {
            let (wi, n) = (get(&v.wi, i), get(&v.n, i));
            let free = (v.one_sided[i] == 0) | ((n.x == 0.0) & (n.y == 0.0) & (n.z == 0.0));
            v.faces[i] = u32::from(free | (n.dot(wi) > 0.0));
        }
    }
}

/// What is computed while texels are on their way: points far outside, and where in their rows of cells the places of use are.
struct Rest<'a> {
    sky: &'a Environment,
    sphere: (Vec3, f32),
    v: &'a mut Draws,
    places: &'a mut Places,
}

impl wide::Job for Rest<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { sky, sphere, v, places } = self;
        for i in 0..wide::padded::<MANY>(places.count) {
            places.y[i] = below(sky.height, places.row[i] as f32, v.cos[i]);
        }
        for i in 0..wide::padded::<MANY>(v.count) {
            set(&mut v.far, i, outside(sphere, get(&v.p, i), get(&v.wi, i)));
        }
    }
}

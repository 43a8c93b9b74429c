//! Many directions at once, a direction a lane: the bits of `Light::le_escaped`, `pdf_escaped` and `sample` of each.

use super::{Octahedral, texel_of};
use crate::emitter::infinity::{outside, scene_sphere};
use crate::emitter::lane::{Lane, Lane3, MANY, get, set};
use crate::emitter::{Escape, LightId, LightQuery, LightSample, Seen, of};
use crate::scene::Scene;
use etendue_numerics::table::Cells;
use etendue_numerics::warp::square_to_equal_area_sphere;
use etendue_numerics::{Pdf, Spectrum, Vec2, Vec3, Wavelengths, wide};

/// Directions, and the texels that are seen there.
struct Looks {
    count: usize,
    /// In the world.
    d: Lane3,
    column: Lane<i32>,
    row: Lane<i32>,
    /// As stored, decoded.
    texel: [Lane3; 1],
}

impl Looks {
    const NONE: Self = Self { count: 0, d: [[0.0; MANY]; 3], column: [0; MANY], row: [0; MANY], texel: [[[0.0; MANY]; 3]; 1] };

    #[inline(always)]
    fn at(&self, i: usize) -> (usize, usize) {
        (self.column[i] as usize, self.row[i] as usize)
    }

    #[inline(always)]
    fn texel(&self, i: usize) -> Spectrum {
        let Vec3 { x, y, z } = get(&self.texel[0], i);
        Spectrum::rgb(x, y, z)
    }
}

impl Octahedral {
    /// What many rays see, and p_w where it is asked for.
    pub(super) fn seen_each<'a>(&self, mut rays: impl Iterator<Item = Escape<'a>>, mut found: impl FnMut(&Escape<'a>, Seen)) {
        let (mut some, mut looks) = (Vec::with_capacity(MANY), Looks::NONE);
        loop {
            some.clear();
            some.extend(rays.by_ref().take(MANY));
            if some.is_empty() {
                return;
            }
            some.iter().enumerate().for_each(|(i, ray)| set(&mut looks.d, i, ray.ray.d));
            looks.count = some.len();
            wide::widest(Find { sky: self, looks: &mut looks });
            self.look(&mut looks, |i| some[i].from.is_some());
            for (i, ray) in some.iter().enumerate() {
                let pdf = ray.from.map_or(0.0, |_| self.density(looks.at(i)));
                found(ray, Seen { le: self.light(looks.texel(i), ray.wl), pdf });
            }
        }
    }

    /// Light samples for many points.
    pub(super) fn drawn_each(
        &self,
        scene: &Scene,
        id: LightId,
        queries: &[LightQuery],
        wl: &[Wavelengths],
        mut found: impl FnMut(usize, Option<LightSample>),
    ) {
        if self.cells.sum() <= 0.0 {
            return (0..queries.len()).for_each(|i| found(i, None));
        }
        let (mut u, mut drawn, mut looks) = ([[0.0; MANY]; 2], Cells::default(), Looks::NONE);
        let sphere = scene_sphere(scene);
        for (group, queries) in queries.chunks(MANY).enumerate() {
            looks.count = queries.len();
            queries.iter().enumerate().for_each(|(i, query)| (u[0][i], u[1][i]) = query.u.into());
            self.cells.sample_discrete_each(looks.count, &u, &mut drawn);
            wide::widest(Aim { sky: self, drawn: &drawn, looks: &mut looks });
            self.look(&mut looks, |_| true);
            for (i, query) in queries.iter().enumerate() {
                let pdf = self.density(looks.at(i));
                let sample = || {
                    let (n, wi) = (group * MANY + i, get(&looks.d, i));
                    let (p, le) = (outside(sphere, query.from.p, wi), self.light(looks.texel(i), of(wl, n)));
                    let pdf = Pdf::SolidAngle(pdf);
                    LightSample { wi, p, distance: f32::INFINITY, le, pdf, emitter: id.emitter, primitive: 0, n: Vec3::ZERO }
                };
                found(group * MANY + i, (pdf > 0.0).then(sample));
            }
        }
    }

    /// Looks up texels, and asks for the memory of the densities that will be looked at.
    fn look(&self, looks: &mut Looks, asks: impl Fn(usize) -> bool) {
        for i in 0..looks.count {
            let (column, row) = looks.at(i);
            self.texels.fetch(column, row);
            if asks(i) {
                self.cells.fetch(column, row);
            }
        }
        let mut texel = [[[0.0; MANY]; 3]; 1];
        self.texels.read_each(looks.count, |i| [looks.at(i).into()], &mut texel);
        looks.texel = texel;
    }
}

/// The texels of directions.
struct Find<'a> {
    sky: &'a Octahedral,
    looks: &'a mut Looks,
}

impl wide::Job for Find<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { sky, looks } = self;
        let (axes, size) = (sky.axes, sky.size());
        for i in 0..wide::padded::<MANY>(looks.count) {
            (looks.column[i], looks.row[i]) = texel_of(size, axes.to_local(get(&looks.d, i)));
        }
    }
}

/// The directions of places in texels, and the texels that are seen there.
struct Aim<'a> {
    sky: &'a Octahedral,
    drawn: &'a Cells<MANY>,
    looks: &'a mut Looks,
}

impl wide::Job for Aim<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { sky, drawn, looks } = self;
        let (axes, size, lanes) = (sky.axes, sky.size(), wide::padded::<MANY>(looks.count));
        let mut local = [[0.0; MANY]; 3];
        for i in 0..lanes {
            let cell = Vec2::new(drawn.column[i] as i32 as f32, drawn.row[i] as i32 as f32);
            let uv = (cell + Vec2::new(drawn.rest[0][i], drawn.rest[1][i])) / Vec2::new(size[0] as f32, size[1] as f32);
            set(&mut local, i, square_to_equal_area_sphere(uv).normalize());
        }
        for i in 0..lanes {
            (looks.column[i], looks.row[i]) = texel_of(size, get(&local, i));
            set(&mut looks.d, i, axes.to_world(get(&local, i)));
        }
    }
}

//! A point y seen from the first vertices of a block, on lanes: a of each, and the rays between.

use crate::transport::Context;
use etendue_accel::Hit;
use etendue_numerics::math::FRAC_1_PI;
use etendue_numerics::ray::offset_origin;
use etendue_numerics::{Ray, Vec2, Vec3, wide};
use etendue_scene::interaction::SHADOW_EPSILON;
use etendue_scene::{Interaction, NO_INSTANCE, SurfaceFrame, SurfaceId};

/// Vertices that are looked at together.
pub(super) const LANES: usize = wide::PAD;

/// A number of each first vertex, and of a few beyond the last one.
#[derive(Default)]
struct Numbers([Vec<f32>; 3]);

impl Numbers {
    fn resize(&mut self, len: usize) {
        self.0.iter_mut().for_each(|x| {
            x.clear();
            x.resize(len, 0.0);
        });
    }

    #[inline(always)]
    fn set(&mut self, i: usize, v: Vec3) {
        (self.0[0][i], self.0[1][i], self.0[2][i]) = (v.x, v.y, v.z);
    }

    /// From number `first` on.
    #[inline(always)]
    fn lanes(&self, first: usize) -> [[f32; LANES]; 3] {
        let mut lanes = [[0.0; LANES]; 3];
        for (to, from) in lanes.iter_mut().zip(&self.0) {
            to.copy_from_slice(&from[first..first + LANES]);
        }
        lanes
    }
}

/// A second vertex y, as far as first ones look at it: `Interaction` tells what the fields are.
pub(super) struct Second {
    pub p: Vec3,
    pub p_error: Vec3,
    pub n: Vec3,
    /// Shading normal.
    pub ns: Vec3,
    pub wo: Vec3,
    pub time: f32,
}

impl Second {
    /// Where `ray` meets a surface of Lambert's: no tangents are made that nobody looks at.
    #[inline(always)]
    pub fn lambert(c: &Context<'_>, ray: &Ray, hit: &Hit) -> Self {
        let shape = &c.scene.surface(SurfaceId(hit.geometry)).shape;
        let Some(mesh) = shape.mesh().filter(|_| hit.instance == NO_INSTANCE) else {
            return Self::from(&c.scene.interaction(ray, hit));
        };
        let SurfaceFrame { p, p_error, n, shading } = mesh.triangle(hit.primitive).surface(Vec2::new(hit.u, hit.v));
        Self { p, p_error, n, ns: shading.n, wo: -ray.d, time: ray.time }
    }
}

impl From<&Interaction> for Second {
    #[inline(always)]
    fn from(y: &Interaction) -> Self {
        Self { p: y.p, p_error: y.p_error, n: y.n, ns: y.shading.n, wo: y.wo, time: y.time }
    }
}

#[inline(always)]
fn at([x, y, z]: &[[f32; LANES]; 3], i: usize) -> Vec3 {
    Vec3::new(x[i], y[i], z[i])
}

/// Where the first vertices are.
#[derive(Default)]
pub(super) struct Places {
    p: Numbers,
    p_error: Numbers,
    n: Numbers,
    ns: Numbers,
}

impl Places {
    pub fn reset(&mut self, walks: usize) {
        for numbers in [&mut self.p, &mut self.p_error, &mut self.n, &mut self.ns] {
            numbers.resize(walks + LANES);
        }
    }

    #[inline(always)]
    pub fn set(&mut self, i: usize, p: Vec3, p_error: Vec3, n: Vec3, ns: Vec3) {
        self.p.set(i, p);
        self.p_error.set(i, p_error);
        self.n.set(i, n);
        self.ns.set(i, ns);
    }
}

/// a of some vertices, Σ a and Σ a².
pub(super) struct Guess {
    pub a: [f32; LANES],
    pub sum: f32,
    pub squares: f32,
}

impl Guess {
    /// Of the first `count`.
    #[inline(always)]
    fn of(mut a: [f32; LANES], count: usize) -> Self {
        let mut squares = [0.0; LANES];
        for (i, (a, square)) in a.iter_mut().zip(&mut squares).enumerate() {
            *a = if i < count { *a } else { 0.0 };
            *square = *a * *a;
        }
        Self { a, sum: total(a), squares: total(squares) }
    }
}

/// Σ x, half by half: what vectors can do.
#[inline(always)]
fn total(mut x: [f32; LANES]) -> f32 {
    let mut half = LANES / 2;
    while half > 0 {
        for i in 0..half {
            x[i] += x[i + half];
        }
        half /= 2;
    }
    x[0]
}

/// |cosθ_x| |cosθ_y| / (π r²) of `count` vertices from number `first` on, as if all were Lambert's; zero where y or x is seen from its other side, and where nobody shares.
pub(super) struct Densities<'a> {
    pub places: &'a Places,
    pub first: usize,
    pub count: usize,
    pub y: &'a Second,
}

impl wide::Job for Densities<'_> {
    type Output = Guess;

    #[inline(always)]
    fn run(self) -> Guess {
        let (p, ns, y) = (self.places.p.lanes(self.first), self.places.ns.lanes(self.first), self.y);
        let front = y.ns.dot(y.wo) > 0.0;
        let mut a = [0.0; LANES];
        for (i, a) in a.iter_mut().enumerate() {
            let d = y.p - at(&p, i);
            let r2 = d.length_squared();
            let seen = at(&ns, i).dot(d) * y.n.dot(d).abs() / (r2 * r2) * FRAC_1_PI;
            let same_side = (y.ns.dot(d) < 0.0) == front;
            *a = if same_side & (seen > 0.0) { seen } else { 0.0 };
        }
        Guess::of(a, self.count)
    }
}

/// cosθ_x/π of the direction w, else the same.
pub(super) struct Cosines<'a> {
    pub places: &'a Places,
    pub first: usize,
    pub count: usize,
    pub w: Vec3,
}

impl wide::Job for Cosines<'_> {
    type Output = Guess;

    #[inline(always)]
    fn run(self) -> Guess {
        let ns = self.places.ns.lanes(self.first);
        let mut a = [0.0; LANES];
        for (i, a) in a.iter_mut().enumerate() {
            *a = (at(&ns, i).dot(self.w) * FRAC_1_PI).max(0.0);
        }
        Guess::of(a, self.count)
    }
}

/// Rays from y to the vertices from number `first` on: origins, directions and ends, [`Interaction::spawn_between`] in other words.
pub(super) struct Aim<'a> {
    pub places: &'a Places,
    pub first: usize,
    pub y: &'a Second,
}

/// What [`Aim`] finds.
pub(super) struct Aimed {
    o: [[f32; LANES]; 3],
    d: [[f32; LANES]; 3],
    end: [f32; LANES],
}

impl wide::Job for Aim<'_> {
    type Output = Aimed;

    #[inline(always)]
    fn run(self) -> Aimed {
        let Self { places, first, y } = self;
        let (p, p_error, n) = (places.p.lanes(first), places.p_error.lanes(first), places.n.lanes(first));
        let mut all = Aimed { o: [[0.0; LANES]; 3], d: [[0.0; LANES]; 3], end: [0.0; LANES] };
        for i in 0..LANES {
            let goal = offset_origin(at(&p, i), at(&p_error, i), at(&n, i), y.p - at(&p, i));
            let o = offset_origin(y.p, y.p_error, y.n, goal - y.p);
            let d = goal - o;
            let distance = d.length();
            (all.o[0][i], all.o[1][i], all.o[2][i]) = (o.x, o.y, o.z);
            let d = d / distance;
            (all.d[0][i], all.d[1][i], all.d[2][i]) = (d.x, d.y, d.z);
            all.end[i] = distance * (1.0 - SHADOW_EPSILON);
        }
        all
    }
}

impl Aimed {
    /// Whether the two points of lane i are apart.
    #[inline(always)]
    pub fn is_there(&self, i: usize) -> bool {
        self.end[i] > 0.0 && self.end[i].is_finite()
    }

    /// The ray of lane i.
    #[inline(always)]
    pub fn ray(&self, i: usize, time: f32) -> Ray {
        Ray { time, ..Ray::new(at(&self.o, i), at(&self.d, i)).until(self.end[i]) }
    }
}

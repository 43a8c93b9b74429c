//! Vertices on Lambert's surfaces, side by side: one array a number, one place a walk.

use crate::transport::{PathState, ShadowQuery, Throughput};
use etendue_numerics::{Frame, Pdf, Ray, Sampler, Spectrum, Vec3, wide};
use etendue_scene::{Interaction, LightReference, LightSample};

/// Walks that are worked on together: as many as stay near by while they are.
pub(super) const LANES: usize = 256;
const _: () = assert!(LANES.is_multiple_of(wide::PAD));

/// A number of each vertex.
pub(super) type Lane<T = f32> = [T; LANES];

/// A vector, or a colour, of each vertex.
#[derive(Clone, Copy)]
pub(super) struct Lane3([Lane; 3]);

impl Lane3 {
    const ZERO: Self = Self([[0.0; LANES]; 3]);

    #[inline(always)]
    pub fn get(&self, i: usize) -> Vec3 {
        Vec3::new(self.0[0][i], self.0[1][i], self.0[2][i])
    }

    #[inline(always)]
    pub fn set(&mut self, i: usize, v: Vec3) {
        (self.0[0][i], self.0[1][i], self.0[2][i]) = (v.x, v.y, v.z);
    }

    /// As a colour: the fourth lane of a spectrum is zero.
    #[inline(always)]
    pub fn spectrum(&self, i: usize) -> Spectrum {
        Spectrum::rgb(self.0[0][i], self.0[1][i], self.0[2][i])
    }

    #[inline(always)]
    fn set_spectrum(&mut self, i: usize, s: Spectrum) {
        (self.0[0][i], self.0[1][i], self.0[2][i]) = (s.0.x, s.0.y, s.0.z);
    }
}

/// Choices are numbers, 0 or 1.
pub(super) type Flags = Lane<u32>;

/// A ray of each vertex.
pub(super) struct Rays {
    pub o: Lane3,
    pub d: Lane3,
}

/// The light sample of each vertex.
pub(super) struct Lights {
    pub wi: Lane3,
    pub p: Lane3,
    pub le: Lane3,
    pub pdf: Lane,
    /// Whether its direction is a discrete choice.
    pub is_delta: Flags,
    /// Whether the shadow ray ends at `p`.
    pub is_near: Flags,
    pub is_there: Flags,
}

/// The vertices: what is known of the surface, then what each stage finds.
pub(super) struct Vertices {
    count: usize,
    /// The number of the walk.
    pub walk: Lane<u32>,
    pub samplers: Vec<Sampler>,
    pub from: Vec<LightReference>,
    pub times: Lane,

    // The surface.
    pub p: Lane3,
    pub p_error: Lane3,
    pub n: Lane3,
    pub s: Lane3,
    pub t: Lane3,
    pub ns: Lane3,
    pub wo: Lane3,
    /// ρ.
    pub rho: Lane3,
    /// Whether the back is looked at as if it were a front.
    pub is_turned: Flags,

    // The walk.
    pub beta: Lane3,
    pub eta_scale: Lane,

    // Random numbers, x and y.
    pub u_light: Lane,
    pub u_point: [Lane; 2],
    pub u_lobe: [Lane; 2],
    pub u_bsdf: [Lane; 2],

    // The connection to a light.
    pub light: Lights,
    pub shadow: Rays,
    pub shadow_end: Lane,
    pub contribution: Lane3,
    pub is_lit: Flags,

    // The next ray.
    pub ray: Rays,
    pub pdf: Lane,
    pub goes_on: Flags,
}

impl Vertices {
    pub fn new() -> Box<Self> {
        let rays = || Rays { o: Lane3::ZERO, d: Lane3::ZERO };
        let (three, one, flags) = (Lane3::ZERO, [0.0; LANES], [0; LANES]);
        Box::new(Self {
            count: 0,
            walk: flags,
            samplers: Vec::with_capacity(LANES),
            from: Vec::with_capacity(LANES),
            times: one,
            p: three,
            p_error: three,
            n: three,
            s: three,
            t: three,
            ns: three,
            wo: three,
            rho: three,
            is_turned: flags,
            beta: three,
            eta_scale: one,
            u_light: one,
            u_point: [one; 2],
            u_lobe: [one; 2],
            u_bsdf: [one; 2],
            light: Lights { wi: three, p: three, le: three, pdf: one, is_delta: flags, is_near: flags, is_there: flags },
            shadow: rays(),
            shadow_end: one,
            contribution: three,
            is_lit: flags,
            ray: rays(),
            pdf: one,
            goes_on: flags,
        })
    }

    pub fn clear(&mut self) {
        self.count = 0;
        self.samplers.clear();
        self.from.clear();
    }

    #[inline(always)]
    pub fn count(&self) -> usize {
        self.count
    }

    pub fn is_full(&self) -> bool {
        self.count == LANES
    }

    /// Lanes to be worked on: whole vectors.
    #[inline(always)]
    pub fn lanes(&self) -> usize {
        self.count.next_multiple_of(wide::PAD).min(LANES)
    }

    /// Adds a walk's vertex at x, on a surface of reflectance `rho`, `is_turned` where the back is looked at as if it were a front.
    #[inline(always)]
    pub fn push(&mut self, walk: u32, state: &PathState, u: &Sampler, x: &Interaction, rho: Spectrum, is_turned: bool) {
        let i = self.count;
        self.count += 1;
        self.walk[i] = walk;
        self.samplers.push(*u);
        self.from.push(LightReference::reflecting(x));
        self.times[i] = x.time;
        self.p.set(i, x.p);
        self.p_error.set(i, x.p_error);
        self.n.set(i, x.n);
        self.s.set(i, x.shading.s);
        self.t.set(i, x.shading.t);
        self.ns.set(i, x.shading.n);
        self.wo.set(i, x.wo);
        self.rho.set_spectrum(i, rho);
        self.is_turned[i] = u32::from(is_turned);
        self.beta.set_spectrum(i, state.beta.carry(Spectrum::ONE));
        self.eta_scale[i] = state.eta_scale;
    }

    /// Notes the light sample of vertex i.
    #[inline(always)]
    pub fn set_light(&mut self, i: usize, sample: Option<&LightSample>) {
        let light = &mut self.light;
        light.is_there[i] = u32::from(sample.is_some());
        if let Some(sample) = sample {
            light.wi.set(i, sample.wi);
            light.p.set(i, sample.p);
            light.le.set_spectrum(i, sample.le);
            light.pdf[i] = sample.pdf.value();
            light.is_delta[i] = u32::from(sample.pdf.is_delta());
            light.is_near[i] = u32::from(sample.distance.is_finite());
        }
    }

    /// The connection of vertex i to its light sample, part of a path of `edges` edges.
    #[inline(always)]
    pub fn shadow(&self, i: usize, edges: u32) -> Option<ShadowQuery> {
        let ray = Ray { time: self.times[i], ..Ray::new(self.shadow.o.get(i), self.shadow.d.get(i)).until(self.shadow_end[i]) };
        (self.is_lit[i] != 0).then(|| ShadowQuery { ray, contribution: self.contribution.spectrum(i), edges })
    }

    /// Sends the walk of vertex i on its way.
    #[inline(always)]
    pub fn store(&self, i: usize, state: &mut PathState) {
        state.ray = Ray { time: self.times[i], ..Ray::new(self.ray.o.get(i), self.ray.d.get(i)) };
        state.beta = Throughput::ONE;
        state.beta.scatter(self.beta.spectrum(i));
        state.pdf = Pdf::SolidAngle(self.pdf[i]);
        state.from = self.from[i];
        state.edges += 1;
        state.vertex += 1;
    }

    #[inline(always)]
    pub fn frame(&self, i: usize) -> Frame {
        Frame { s: self.s.get(i), t: self.t.get(i), n: self.ns.get(i) }
    }
}

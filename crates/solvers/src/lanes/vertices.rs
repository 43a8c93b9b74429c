//! Vertices on Lambert's surfaces, side by side: one array a number, one place a walk.

use crate::transport::{PathState, ShadowQuery, Throughput};
use etendue_numerics::{Frame, Pdf, Ray, Sampler, Spectrum, Vec2, Vec3, Wavelengths, wide};
use etendue_scene::{Interaction, LightReference, LightSample, SurfaceFrame, Triangle, shape::Mesh};

/// Walks that are worked on together: as many as stay near by while they are.
pub(super) const LANES: usize = 256;
const _: () = assert!(LANES.is_multiple_of(wide::PAD));

/// A number of each vertex.
pub(super) type Lane<T = f32> = [T; LANES];

/// A vector of each vertex.
#[derive(Clone, Copy)]
pub(super) struct Lane3([Lane; 3]);

impl Lane3 {
    pub const ZERO: Self = Self([[0.0; LANES]; 3]);

    #[inline(always)]
    pub fn get(&self, i: usize) -> Vec3 {
        Vec3::new(self.0[0][i], self.0[1][i], self.0[2][i])
    }

    #[inline(always)]
    pub fn set(&mut self, i: usize, v: Vec3) {
        (self.0[0][i], self.0[1][i], self.0[2][i]) = (v.x, v.y, v.z);
    }
}

/// A colour of each vertex.
#[derive(Clone, Copy)]
pub(super) struct Colours([Lane; 4]);

impl Colours {
    pub const ZERO: Self = Self([[0.0; LANES]; 4]);

    #[inline(always)]
    pub fn get(&self, i: usize) -> [f32; 4] {
        [self.0[0][i], self.0[1][i], self.0[2][i], self.0[3][i]]
    }

    #[inline(always)]
    pub fn set(&mut self, i: usize, [x, y, z, w]: [f32; 4]) {
        (self.0[0][i], self.0[1][i], self.0[2][i], self.0[3][i]) = (x, y, z, w);
    }

    /// The three lanes of an RGB colour.
    #[inline(always)]
    pub fn rgb(&self, i: usize) -> Vec3 {
        Vec3::new(self.0[0][i], self.0[1][i], self.0[2][i])
    }

    #[inline(always)]
    pub fn spectrum(&self, i: usize) -> Spectrum {
        Spectrum(self.get(i).into())
    }

    #[inline(always)]
    pub fn set_spectrum(&mut self, i: usize, s: Spectrum) {
        self.set(i, s.0.into());
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
    pub le: Colours,
    pub pdf: Lane,
    /// Whether its direction is a discrete choice.
    pub is_delta: Flags,
    /// Whether the shadow ray ends at `p`.
    pub is_near: Flags,
    pub is_there: Flags,
}

/// What a guide says of the next direction of each vertex.
pub(super) struct Guides {
    /// Whether the direction is the guide's.
    pub is_chosen: Flags,
    /// a and p_g.
    pub a: Lane,
    pub pdf: Lane,
}

/// The triangle that each vertex lies on, and where.
pub(super) struct Triangles {
    corners: [Lane3; 3],
    normals: [Lane3; 3],
    uvs: [[Lane; 2]; 3],
    n: Lane3,
    error: Lane,
    has_uv: Flags,
    flipped: Flags,
    bary: [Lane; 2],
    /// Whether there is none: the surface is known already.
    placed: Flags,
}

/// The vertices: what is known of the surface, then what each stage finds.
pub(super) struct Vertices {
    count: usize,
    /// The number of the walk.
    pub walk: Lane<u32>,
    pub samplers: Vec<Sampler>,
    /// The wavelengths; none where all are RGB.
    pub wl: Vec<Wavelengths>,
    pub times: Lane,
    triangles: Triangles,

    // The surface.
    pub p: Lane3,
    pub p_error: Lane3,
    pub n: Lane3,
    pub s: Lane3,
    pub t: Lane3,
    pub ns: Lane3,
    pub wo: Lane3,
    /// The shading normal on the side of `wo`: what light sampling knows.
    pub from_n: Lane3,
    /// ρ.
    pub rho: Colours,
    /// Whether the back is a front as well.
    pub two_sided: Flags,
    /// Whether such a back is looked at.
    pub is_turned: Flags,

    // The walk.
    pub beta: Colours,
    pub roulette_scale: Lane,

    // Random numbers, x and y.
    pub u_light: Lane,
    pub u_point: [Lane; 2],
    pub u_lobe: [Lane; 2],
    pub u_bsdf: [Lane; 2],

    // The connection to a light.
    pub light: Lights,
    pub shadow: Rays,
    pub shadow_end: Lane,
    pub contribution: Colours,
    pub is_lit: Flags,

    // The next ray.
    pub guide: Guides,
    pub ray: Rays,
    pub pdf: Lane,
    pub goes_on: Flags,
}

impl Vertices {
    pub fn new() -> Box<Self> {
        let rays = || Rays { o: Lane3::ZERO, d: Lane3::ZERO };
        let (three, colours, one, flags) = (Lane3::ZERO, Colours::ZERO, [0.0; LANES], [0; LANES]);
        Box::new(Self {
            count: 0,
            walk: flags,
            samplers: Vec::with_capacity(LANES),
            wl: Vec::new(),
            times: one,
            triangles: Triangles {
                corners: [three; 3],
                normals: [three; 3],
                uvs: [[one; 2]; 3],
                n: three,
                error: one,
                has_uv: flags,
                flipped: flags,
                bary: [one; 2],
                placed: flags,
            },
            p: three,
            p_error: three,
            n: three,
            s: three,
            t: three,
            ns: three,
            wo: three,
            from_n: three,
            rho: colours,
            two_sided: flags,
            is_turned: flags,
            beta: colours,
            roulette_scale: one,
            u_light: one,
            u_point: [one; 2],
            u_lobe: [one; 2],
            u_bsdf: [one; 2],
            light: Lights { wi: three, p: three, le: colours, pdf: one, is_delta: flags, is_near: flags, is_there: flags },
            shadow: rays(),
            shadow_end: one,
            contribution: colours,
            is_lit: flags,
            guide: Guides { is_chosen: flags, a: one, pdf: one },
            ray: rays(),
            pdf: one,
            goes_on: flags,
        })
    }

    pub fn clear(&mut self) {
        self.count = 0;
        self.samplers.clear();
        self.wl.clear();
    }

    /// Sets the number of vertices: those below it may be set one by one, in any order, each as the last.
    #[inline(always)]
    pub fn set_count(&mut self, count: usize) {
        self.count = count;
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

    /// Adds a walk's vertex on a surface of reflectance `rho`, whose back is a front as well if it is `two_sided`; where it is comes next.
    #[inline(always)]
    pub fn push(&mut self, walk: u32, state: &PathState, u: &Sampler, rho: Spectrum, two_sided: bool) {
        let i = self.count;
        self.count += 1;
        self.walk[i] = walk;
        self.samplers.push(*u);
        if !state.wl.is_rgb() {
            self.wl.push(state.wl);
        }
        self.times[i] = state.ray.time;
        self.wo.set(i, -state.ray.d);
        self.rho.set_spectrum(i, rho);
        self.two_sided[i] = u32::from(two_sided);
        self.beta.set_spectrum(i, state.beta.carry(Spectrum::ONE));
        self.roulette_scale[i] = state.roulette_scale;
    }

    /// Places the last vertex on a triangle.
    #[inline(always)]
    pub fn place_on(&mut self, mesh: &Mesh, triangle: u32, bary: Vec2) {
        let (i, t) = (self.count - 1, &mut self.triangles);
        let index = mesh.indices[triangle as usize];
        // Numbers by reference: an array that moves is stored in pieces, and waited for.
        for (corner, k) in t.corners.iter_mut().zip(&index) {
            corner.set(i, mesh.positions[*k as usize]);
        }
        let (n, error) = mesh.face(triangle);
        if error < 0.0 {
            for (normal, k) in t.normals.iter_mut().zip(&index) {
                normal.set(i, mesh.normals[*k as usize]);
            }
        }
        let has_uv = !mesh.uvs.is_empty();
        if has_uv {
            for ([u, v], k) in t.uvs.iter_mut().zip(&index) {
                (u[i], v[i]) = mesh.uvs[*k as usize].into();
            }
        }
        t.n.set(i, n);
        t.error[i] = error;
        (t.has_uv[i], t.flipped[i], t.placed[i]) = (u32::from(has_uv), u32::from(mesh.flip_normals), 0);
        (t.bary[0][i], t.bary[1][i]) = (bary.x, bary.y);
    }

    /// Places the last vertex at x.
    #[inline(always)]
    pub fn place_at(&mut self, x: &Interaction) {
        let i = self.count - 1;
        self.triangles.placed[i] = 1;
        self.set_surface(i, &SurfaceFrame { p: x.p, p_error: x.p_error, n: x.n, shading: x.shading });
    }

    /// The triangle of vertex i, and where on it; nothing to the point where it is placed already.
    #[inline(always)]
    pub fn triangle(&self, i: usize) -> (Triangle, Vec2) {
        let t = &self.triangles;
        let uv = |k: usize| Vec2::new(t.uvs[k][0][i], t.uvs[k][1][i]);
        let triangle = Triangle {
            corners: [t.corners[0].get(i), t.corners[1].get(i), t.corners[2].get(i)],
            normals: [t.normals[0].get(i), t.normals[1].get(i), t.normals[2].get(i)],
            uvs: [uv(0), uv(1), uv(2)],
            n: t.n.get(i),
            error: t.error[i],
            has_uv: t.has_uv[i] != 0,
            flipped: t.flipped[i] != 0,
        };
        (triangle, Vec2::new(t.bary[0][i], t.bary[1][i]))
    }

    #[inline(always)]
    pub fn is_placed(&self, i: usize) -> bool {
        self.triangles.placed[i] != 0
    }

    #[inline(always)]
    pub fn surface(&self, i: usize) -> SurfaceFrame {
        SurfaceFrame { p: self.p.get(i), p_error: self.p_error.get(i), n: self.n.get(i), shading: self.frame(i) }
    }

    #[inline(always)]
    pub fn set_surface(&mut self, i: usize, x: &SurfaceFrame) {
        self.p.set(i, x.p);
        self.p_error.set(i, x.p_error);
        self.n.set(i, x.n);
        self.s.set(i, x.shading.s);
        self.t.set(i, x.shading.t);
        self.ns.set(i, x.shading.n);
    }

    /// What light sampling may know of vertex i.
    #[inline(always)]
    pub fn from(&self, i: usize) -> LightReference {
        LightReference { p: self.p.get(i), n: self.from_n.get(i), one_sided: true, shared: true }
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

    /// The connection of vertex i to its light sample, where it is lit; part of a path of `edges` edges.
    #[inline(always)]
    pub fn shadow(&self, i: usize, edges: u32) -> ShadowQuery {
        let ray = Ray { time: self.times[i], ..Ray::new(self.shadow.o.get(i), self.shadow.d.get(i)).until(self.shadow_end[i]) };
        ShadowQuery { ray, contribution: self.contribution.spectrum(i), edges }
    }

    /// Sends the walk of vertex i on its way, with κ of roulette.
    #[inline(always)]
    pub fn store(&self, i: usize, state: &mut PathState, hope: f32) {
        state.ray = Ray { time: self.times[i], ..Ray::new(self.ray.o.get(i), self.ray.d.get(i)) };
        state.beta = Throughput::ONE;
        state.beta.scatter(self.beta.spectrum(i));
        state.pdf = Pdf::SolidAngle(self.pdf[i]);
        state.from = self.from(i);
        state.edges += 1;
        state.vertex += 1;
        state.roulette_scale = self.roulette_scale[i];
        state.relate(hope);
    }

    #[inline(always)]
    pub fn frame(&self, i: usize) -> Frame {
        Frame { s: self.s.get(i), t: self.t.get(i), n: self.ns.get(i) }
    }
}

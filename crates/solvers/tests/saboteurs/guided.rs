//! A path tracer with a guide that has learnt nothing true, right and with one deliberate fault at a time.

use etendue_accel::Hit;
use etendue_numerics::math::PI;
use etendue_numerics::{Dim, Pdf, Sampler, SequenceKind, Vec3, warp};
use etendue_solvers::path_guided::field::{Field, Photon};
use etendue_solvers::path_guided::walk::Guided;
use etendue_solvers::transport::{Context, Crowd, PathSolver, PathState, Step, Vertex, VertexSample, slot};

faults! {
    /// Directions of the guide weighed by its own density, as if the BSDF never chose them.
    GuidesDensityAlone,
    /// Directions of the BSDF weighed by its own density, as if the guide never chose them.
    BsdfsDensityAlone,
    /// The guide's density over the square of directions instead of per sr.
    SquareInsteadOfSphere,
    /// The densities added without the shares of either.
    SharesForgotten,
    /// The density of the leaf of another place.
    AnotherLeaf,
}

/// path, by a guide, with a fault.
pub struct Crooked {
    pub fault: Fault,
    pub field: Field,
}

/// What photons from anywhere teach: nothing that is true.
pub fn nonsense() -> Field {
    taught(|p, n, wi| p + if wi.dot(n) < 0.0 { -wi } else { wi })
}

/// That all light comes from a dark corner.
pub fn astray() -> Field {
    taught(|_, _, _| Vec3::new(0.9, -0.9, 0.9))
}

/// What photons teach that come to places p, of normal n, from where `from` says, which may use any direction.
fn taught(from: impl Fn(Vec3, Vec3, Vec3) -> Vec3) -> Field {
    let photon = |i| {
        let u = Sampler::new(SequenceKind::Independent, 5, 0, i, 1 << 14);
        let (xy, z, towards) = (u.u2(Dim(0)), u.u2(Dim(2)), u.u2(Dim(4)));
        let p = 2.0 * Vec3::new(xy.x, xy.y, z.x) - Vec3::ONE;
        let axis = [Vec3::X, Vec3::Y, Vec3::Z][i as usize % 3];
        let n = if z.y < 0.5 { -axis } else { axis };
        let wi = warp::square_to_equal_area_sphere(towards * towards);
        Photon { p, from: from(p, n, wi), n, flux: 1.0 + 10.0 * z.x }
    };
    Field::new(&(0..1 << 14).map(photon).collect::<Vec<_>>())
}

impl Crooked {
    fn sample(&self, vertex: &Vertex<'_>, state: &PathState, u: &Sampler) -> Option<VertexSample> {
        let n = if vertex.x.n.dot(vertex.x.wo) < 0.0 { -vertex.x.n } else { vertex.x.n };
        let leaf = self.field.at(vertex.x.p, n);
        let (a, u_lobe, u) = (leaf.fraction, u.u2(state.dim(slot::LOBE)), u.u2(state.dim(slot::BSDF)));
        let by_bsdf = u_lobe.x < a;
        let wi = if by_bsdf { vertex.sample(u_lobe.x / a, u)?.wi } else { leaf.guide.sample(vertex.x.p, u).0 };
        let (f_cos, p_b) = vertex.eval(wi);
        let p_g = match self.fault {
            SquareInsteadOfSphere => 4.0 * PI * leaf.guide.pdf(vertex.x.p, wi),
            AnotherLeaf => self.field.at(-vertex.x.p, n).guide.pdf(vertex.x.p, wi),
            _ => leaf.guide.pdf(vertex.x.p, wi),
        };
        let p = match self.fault {
            GuidesDensityAlone if !by_bsdf => p_g,
            BsdfsDensityAlone if by_bsdf => p_b,
            SharesForgotten => p_b + p_g,
            _ => a * p_b + (1.0 - a) * p_g,
        };
        let sample = vertex.sample(0.5, u)?;
        (p_b > 0.0).then(|| VertexSample { wi, weight: f_cos / p, pdf: Pdf::SolidAngle(p), ..sample })
    }
}

impl PathSolver for Crooked {
    fn scatter(&self, c: &Context<'_>, state: &mut PathState, hit: Option<Hit>, u: &Sampler) -> Step {
        let Some(hit) = hit else { return Step::END };
        let x = c.scene.interaction(&state.ray, &hit);
        state.collect(&c.rules, c.scene.le(&x, &state.wl));
        let vertex = state.vertex(c.scene, x);
        let sample = self.sample(&vertex, state, u);
        Step { shadow: None, goes_on: state.turn(&c.rules, &vertex, sample, u.u2(state.dim(slot::LOBE)).y) }
    }
}

/// Guided walks whose neighbours part what they find as if the BSDFs alone had sent them there.
pub struct Forgetful<'a>(pub Guided<'a>);

impl PathSolver for Forgetful<'_> {
    fn scatter(&self, c: &Context<'_>, state: &mut PathState, hit: Option<Hit>, u: &Sampler) -> Step {
        self.0.scatter(c, state, hit, u)
    }

    fn block(&self) -> u32 {
        self.0.block()
    }

    fn meet<'a>(&self, c: &Context<'a>, crowd: &mut Crowd<'a>) -> u64 {
        self.0.mis.meet(c, crowd)
    }
}

//! Stochastic progressive photon mapping [Hachisuka, Jensen 2009; Knaus, Zwicker 2011]: light is shot into the scene, and the eye sees the density
//! with which it lands.
//!
//! ```text
//! L(x, wo) = Le(x, wo) + ∫_walked f L |cosθ| dwi + lim_{r → 0} Σ_p f Φ_p K_r(x_p - x)
//! ```
//!
//! A pass shoots a particle for each pixel, keeps what lands as photons, and sends a walk from the eye through each pixel. At every vertex the sphere of
//! directions is divided: into those that the material scatters into with a density of `gloss` or more, mirrors and smooth glass among them, the walk
//! goes on; light from all the others is what photons bring. Each direction belongs to one of the two, so nothing is counted twice, however glossy and
//! rough lobes are mixed. Light that only photons can bring (points and single directions) is theirs in any case. Shadow rays, where direct light is theirs,
//! share the walked directions with the walk by multiple importance sampling.
//!
//! The radius shrinks from pass to pass, and the mean of all passes tends to the truth: it is biased at any number of them, and what a noise target
//! looks at is the noise without the bias. Memory is that of one pass: about 150 bytes a photon, of which a particle leaves
//! two to six (measured: 360 bytes a particle in `cornell-box`, 660 in `ajar`, 860 in a furnace of albedo 0.8).
//!
//! | what | where |
//! | --- | --- |
//! | r of each pass | [`radius`] |
//! | photons, and their index | [`photons`], [`crate::transport::VertexIndex`] |
//! | the sum over photons | `density.rs` |
//! | the sum from its definition | [`literal`] |
//!
//! | parameter | meaning | default |
//! | --- | --- | --- |
//! | `radius` | r of the first pass, m; 0 takes `pixels` | 0 |
//! | `pixels` | r of the first pass in widths of a pixel at the median distance | 4 |
//! | `alpha` | α: the larger, the slower the radius shrinks | 2/3 |
//! | `photons` | particles per pass; 0 is one for each pixel | 0 |
//! | `gloss` | density, 1/sr, from which on directions are walked | 1 |
//! | `direct` | who brings direct light: `photons`, or shadow `rays` | `rays` |
//! | `show` | `all`; `caustic`: photons that came by mirrors and glass alone; `global`: all the rest | `all` |

mod density;
pub mod literal;
pub mod photons;
pub mod radius;

use crate::drivers::pixels::{self, PixelSolver, Tiling};
use crate::drivers::{Balance, Books, Work};
use crate::parameters::{Parameter, Slot};
use crate::run::Run;
use crate::solver::{CannotGoOn, Estimates, Needs, Solver};
use crate::transport::{Came, Context, Crowd, Heuristic, PathState, VertexSample, arrives, emission, mis_weight, next_event, slot};
use etendue_numerics::{Pdf, Sampler, Spectrum};
use etendue_scene::{Interaction, Scene};
use photons::Photons;
use serde::{Deserialize, Serialize};

/// Bytes that a particle leaves behind: about 150 of each photon, of which there are two to six.
const PER_PARTICLE: u64 = 4 * 150;

/// The solver `photon-map`.
#[derive(Clone, Copy, Debug)]
pub struct PhotonMap {
    /// r of the first pass, m; 0 takes `pixels`.
    pub radius: f32,
    /// r of the first pass in widths of a pixel.
    pub pixels: f32,
    /// α.
    pub alpha: f32,
    /// Particles per pass; 0 is one for each pixel.
    pub photons: u32,
    /// Density, 1/sr, from which on directions are walked.
    pub gloss: f32,
    /// Place in [`DIRECT`].
    pub direct: usize,
    /// Place in [`SHOW`].
    pub show: usize,
}

/// Who brings direct light.
pub const DIRECT: &[&str] = &["photons", "rays"];
/// What is shown.
pub const SHOW: &[&str] = &["all", "caustic", "global"];

impl Default for PhotonMap {
    fn default() -> Self {
        Self { radius: 0.0, pixels: 4.0, alpha: 2.0 / 3.0, photons: 0, gloss: 1.0, direct: 1, show: 0 }
    }
}

impl PhotonMap {
    /// What users may set.
    pub const PARAMETERS: &[Parameter<Self>] = &[
        Parameter {
            name: "radius",
            summary: "radius of the first pass, m; 0 takes `pixels`",
            slot: |s| Slot::Number(&mut s.radius, 0.0..=f32::MAX),
        },
        Parameter {
            name: "pixels",
            summary: "radius of the first pass in widths of a pixel at the median distance",
            slot: |s| Slot::Number(&mut s.pixels, 0.01..=1000.0),
        },
        Parameter {
            name: "alpha",
            summary: "the larger, the slower the radius shrinks: r² falls like N^(alpha - 1)",
            slot: |s| Slot::Number(&mut s.alpha, 0.01..=0.99),
        },
        Parameter {
            name: "photons",
            summary: "particles per pass; 0 is one for each pixel",
            slot: |s| Slot::Count(&mut s.photons, 0..=1 << 28),
        },
        Parameter {
            name: "gloss",
            summary: "density, 1/sr, from which on the eye's walk follows directions itself",
            slot: |s| Slot::Number(&mut s.gloss, 0.0..=f32::MAX),
        },
        Parameter {
            name: "direct",
            summary: "who brings direct light: photons, or shadow rays",
            slot: |s| Slot::Choice(&mut s.direct, DIRECT),
        },
        Parameter {
            name: "show",
            summary: "all, caustic (photons that came by mirrors and glass alone), or global (all the rest)",
            slot: |s| Slot::Choice(&mut s.show, SHOW),
        },
    ];

    /// Particles of a pass over a picture of this size.
    fn particles(&self, [width, height]: [u32; 2]) -> u64 {
        if self.photons == 0 { u64::from(width) * u64::from(height) } else { u64::from(self.photons) }
    }

    /// Whether shadow rays bring direct light.
    fn direct_by_rays(&self) -> bool {
        DIRECT[self.direct] == "rays"
    }

    /// Whether photons that came so are shown.
    fn shows(&self, came: Came) -> bool {
        match SHOW[self.show] {
            "caustic" => came == Came::Specular,
            "global" => came != Came::Specular,
            _ => true,
        }
    }

    /// Whether the eye's walk goes on into a sampled direction, where photons do not count.
    fn walks(&self, s: &VertexSample) -> bool {
        s.pdf.is_delta() || s.pdf.value() >= self.gloss
    }
}

/// What one pass hands to the next: the books; and memory.
#[derive(Debug, Default, Serialize, Deserialize)]
pub struct State {
    books: Books,
    /// Passes whose books are among them.
    booked: u32,
    /// r of the first pass.
    radius: f32,
    #[serde(skip)]
    map: Photons,
}

impl Solver for PhotonMap {
    type State = State;

    fn needs(&self) -> Needs {
        Needs { both_ways: true, ..Needs::default() }
    }

    fn estimates(&self) -> Estimates {
        let other = |words| Estimates::Other { words, diffuse: None };
        match SHOW[self.show] {
            "caustic" => other("it shows light that came to a surface by mirrors and glass alone"),
            "global" => other("it shows all light but that which came to a surface by mirrors and glass alone"),
            _ => Estimates::InTheLimit,
        }
    }

    fn splats(&self) -> bool {
        false
    }

    fn units(&self, size: [u32; 2]) -> usize {
        Tiling::new(size).len()
    }

    fn holds(&self, size: [u32; 2]) -> u64 {
        self.particles(size) * PER_PARTICLE
    }

    fn books(&self, state: &State) -> Option<Balance> {
        Some(state.books.balance())
    }

    fn prepare(&self, scene: &Scene, run: &Run<'_>) -> State {
        let by_pixels = || radius::pixel_widths(scene, &scene.views[run.view], self.pixels);
        State { radius: if self.radius > 0.0 { self.radius } else { by_pixels() }, ..State::default() }
    }

    fn pass(&self, scene: &Scene, run: &Run<'_>, state: &mut State, k: u32, work: &Work<'_>) -> Result<(), CannotGoOn> {
        let r = radius::radius_of_pass(state.radius, self.alpha, k);
        let Some(books) = state.map.shoot(self, scene, run, k, r, work) else { return Ok(()) };
        // A pass that was stopped among its tiles shoots the same photons again.
        if state.booked <= k {
            state.books = state.books.merged(&books);
            state.booked = k + 1;
        }
        pixels::pass(&Eye { solver: self, map: &state.map }, scene, run, k, work);
        Ok(())
    }
}

/// The walks from the eye. They have the wavelengths of the photons.
struct Eye<'a> {
    solver: &'a PhotonMap,
    map: &'a Photons,
}

impl Eye<'_> {
    /// Le where the walk ends, weighed against the shadow ray that might have found it.
    #[inline]
    fn met(&self, c: &Context<'_>, state: &PathState, x: Option<&Interaction>) -> Spectrum {
        let (le, pdf_light) = emission(c, state, x);
        match state.pdf {
            Pdf::SolidAngle(pdf) if self.solver.direct_by_rays() => le * mis_weight(Heuristic::Power, pdf, pdf_light),
            _ => le,
        }
    }
}

impl PixelSolver for Eye<'_> {
    fn radiances<'a>(&self, c: &Context<'a>, crowd: &mut Crowd<'a>, rays: &mut u64) {
        for (walk, u) in crowd.walks.iter_mut().zip(&crowd.samplers) {
            walk.wl = self.map.wl;
            walk.l = self.radiance(c, *walk, u, rays);
        }
    }

    fn radiance(&self, c: &Context<'_>, mut state: PathState, u: &Sampler, rays: &mut u64) -> Spectrum {
        let shows_direct = self.solver.shows(Came::Straight);
        loop {
            // Light that the walk meets.
            *rays += 1;
            let hit = c.scene.intersect(&state.ray);
            let x = hit.map(|hit| c.scene.interaction(&state.ray, &hit));
            if shows_direct {
                let le = self.met(c, &state, x.as_ref());
                state.collect(&c.rules, le);
            }
            let Some(x) = x.filter(|_| !c.ends(&state)) else { return state.l };
            let vertex = state.vertex(c.scene, x);

            // Light from all directions that it does not take.
            if vertex.is_smooth() {
                if shows_direct && self.solver.direct_by_rays() {
                    // The walk finds lamps as well, but only along directions that it takes.
                    let share = |p, pdf: f32| if pdf < self.solver.gloss { 1.0 } else { mis_weight(Heuristic::Power, p, pdf) };
                    if let Some(query) = next_event(c, &state, &vertex, u, share) {
                        *rays += 1;
                        state.l += arrives(c, &query, &state.wl);
                    }
                }
                let l = self.solver.gather(c, self.map, &state, &vertex, u, rays);
                state.l += state.beta.carry(l);
            }

            // The next direction.
            let u_lobe = state.choices(&c.rules, &vertex, u);
            let sample = vertex.sample(u_lobe.x, u.u2(state.dim(slot::BSDF))).filter(|s| self.solver.walks(s));
            if !state.turn(&c.rules, &vertex, sample, u_lobe.y) {
                return state.l;
            }
        }
    }
}

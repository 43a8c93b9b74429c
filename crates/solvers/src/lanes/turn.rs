//! The next direction, on lanes: `Vertex::sample` and `PathState::turn` for Lambert's surfaces.
//!
//! ```text
//! wi ~ cosθ/π,    β ← β ρ,    roulette: q = min(max β η², 0.95), β ← β/q
//! ```

use super::vertices::{LANES, Vertices};
use crate::transport::roulette_survival;
use etendue_numerics::math::FRAC_1_PI;
use etendue_numerics::ray::offset_origin;
use etendue_numerics::warp::{disk_to_cosine_hemisphere, square_to_disk};
use etendue_numerics::{Vec2, Vec3, wide};

/// Turns the walks into sampled directions.
pub(super) struct Turn<'a> {
    pub vertices: &'a mut Vertices,
    /// Whether the walks are long enough for roulette.
    pub roulette: bool,
}

impl wide::Job for Turn<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        aim(self.vertices);
        weaken(self.vertices);
        if self.roulette {
            survive(self.vertices);
        }
    }
}

/// Directions as the BSDF has them.
#[inline(always)]
pub(super) fn aim(v: &mut Vertices) {
    let [disk_x, disk_y] = &mut [[0.0; LANES]; 2];
    for i in 0..v.lanes() {
        let disk = square_to_disk(Vec2::new(v.u_bsdf[0][i], v.u_bsdf[1][i]));
        (disk_x[i], disk_y[i]) = (disk.x, disk.y);
    }
    for i in 0..v.lanes() {
        let frame = v.frame(i);
        let turned = v.is_turned[i] != 0;
        let wo = frame.n.dot(v.wo.get(i));
        let above = if turned { wo < 0.0 } else { wo > 0.0 };
        let local = disk_to_cosine_hemisphere(Vec2::new(disk_x[i], disk_y[i]));
        let wi = frame.to_world(Vec3::new(local.x, local.y, if turned { -local.z } else { local.z }));
        v.ray.d.set(i, wi);
        v.ray.o.set(i, offset_origin(v.p.get(i), v.p_error.get(i), v.n.get(i), wi));
        v.pdf[i] = local.z.max(0.0) * FRAC_1_PI;
        v.goes_on[i] = u32::from(above);
    }
}

/// What is lost there.
#[inline(always)]
fn weaken(v: &mut Vertices) {
    for i in 0..v.lanes() {
        let (b, rho) = (v.beta.get(i), v.rho.get(i));
        let beta = [b[0] * rho[0], b[1] * rho[1], b[2] * rho[2], b[3] * rho[3]];
        let alive = (beta[0] != 0.0) | (beta[1] != 0.0) | (beta[2] != 0.0) | (beta[3] != 0.0);
        v.beta.set(i, beta);
        v.goes_on[i] &= u32::from(alive);
    }
}

/// `PathState::relate` after the first turn.
pub(super) fn relate(v: &mut Vertices, hope: f32) {
    for i in 0..v.lanes() {
        let [x, y, z, w] = v.beta.get(i);
        let first = x.max(y).max(z).max(w);
        v.roulette_scale[i] *= if first > 0.0 { hope / first } else { 1.0 };
    }
}

/// Russian roulette.
#[inline(always)]
pub(super) fn survive(v: &mut Vertices) {
    for i in 0..v.lanes() {
        let [x, y, z, w] = v.beta.get(i);
        let q = roulette_survival(x.max(y).max(z).max(w), v.roulette_scale[i]);
        v.beta.set(i, [x / q, y / q, z / q, w / q]);
        v.goes_on[i] &= u32::from(v.u_lobe[1][i] < q);
    }
}

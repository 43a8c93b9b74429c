//! The walk between boundary and ground.

use super::Layered;
use etendue_numerics::math::ln;
use etendue_numerics::sequence::{Stream, mix};
use etendue_numerics::{Spectrum, Vec3};

/// Numbers that follow from the bits of two directions.
pub(super) fn stream(wo: Vec3, wi: Vec3) -> Stream {
    let bits = [wo.x, wo.y, wo.z, wi.x, wi.y, wi.z].map(|x| u64::from(x.to_bits()));
    Stream(bits.into_iter().fold(0x243f_6a88_85a3_08d3, |seed, x| mix(seed.rotate_left(17) ^ x)))
}

/// w(a, b) of the power heuristic.
fn power(a: f32, b: f32) -> f32 {
    let (a, b) = (a * a, b * b);
    if a + b > 0.0 { a / (a + b) } else { 0.0 }
}

impl Layered {
    /// One walk's estimate of what enters along `wo` and leaves along `wi`, without 1/η².
    pub(super) fn walk(&self, wo: Vec3, wi: Vec3, u: &mut Stream) -> Option<Spectrum> {
        let Self { boundary, medium, base, .. } = self;
        let exit = boundary.enter(wi, u.u2())?;
        let entry = boundary.enter(wo, u.u2())?;
        let mut sum = Spectrum::ZERO;
        let (mut d, mut beta, mut z) = (entry.d, Spectrum::splat(entry.weight), medium.thickness);
        let hazy = !medium.albedo.is_zero();
        // Leaves along `exit`, backwards: light travels up along -exit.d.
        let leave = |z: f32| medium.through(medium.thickness - z, exit.d) * exit.weight;
        // Leaves along the direction that was drawn with density `p`.
        let follow = |d: Vec3, z: f32, p: Option<f32>| {
            let (f, pdf) = boundary.entering(wi, -d);
            let w = p.map_or(1.0, |p| power(p, pdf));
            medium.through(medium.thickness - z, d) * f * w
        };
        for depth in 0..self.max_depth {
            // A walk that carries little goes on by chance.
            if depth > 3 && beta.max_lane() < 0.25 {
                let q = beta.max_lane();
                if u.u1() >= q {
                    break;
                }
                beta *= 1.0 / q;
            }
            if hazy {
                let next = z - ln(1.0 - u.u1()) * d.z;
                if next > 0.0 && next < medium.thickness {
                    z = next;
                    beta *= medium.albedo;
                    let phase = medium.phase(d, -exit.d);
                    let w = exit.pdf.map_or(1.0, |p| power(p, phase));
                    sum += beta * (phase * leave(z) * w);
                    let to = medium.scatter(d, u.u2());
                    let p = medium.phase(d, to);
                    d = to;
                    if d.z > 0.0 {
                        sum += beta * follow(d, z, Some(p));
                    }
                    if d.z == 0.0 {
                        break;
                    }
                    continue;
                }
            } else {
                beta *= medium.through(medium.thickness, d);
            }
            if d.z > 0.0 {
                let Some((back, weight)) = boundary.send_back(d, u.u2()) else { break };
                (d, z) = (back, medium.thickness);
                beta *= weight;
            } else {
                z = 0.0;
                let (f, p) = base.f(-d, -exit.d);
                let w = exit.pdf.map_or(1.0, |q| power(q, p));
                sum += beta * f * (leave(z) * w);
                let Some((to, weight, p)) = base.bounce(-d, u.u2()) else { break };
                d = to;
                beta *= weight;
                sum += beta * follow(d, z, p);
            }
            if beta.is_zero() {
                break;
            }
        }
        Some(sum)
    }
}

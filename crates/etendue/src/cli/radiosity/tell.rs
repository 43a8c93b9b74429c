//! What is said of a solution.

use super::super::output;
use etendue::radiosity::Report;

/// The numbers that everyone should see.
pub fn tell(r: &Report) {
    if r.patches == 0 {
        output::message("note: the scene has no surface that can be cut into patches");
        return;
    }
    let sum = |x: [f64; 3]| x.iter().sum::<f64>();
    let noise = if r.moved_by_noise > 0.0 {
        format!(", where the noise of the rays alone is expected to move {:.2} %", 100.0 * r.moved_by_noise)
    } else {
        String::new()
    };
    let now = match r.rows {
        "reciprocal" => "pairs to 0: the scene is open, and what rows lack is lost".to_owned(),
        "losses" => format!("to {:.1e} and 0, with what rays found lost", r.closure_after),
        _ => format!("to {:.1e} and 0", r.closure_after),
    };
    output::message(&match r.error_bound {
        Some(bound) => format!(
            "{} patches, {} links by `{}` of {} rays a patch in {} MiB; rows closed to {:.1e}, pairs to 0; error of B below {:.1} % of all reflected light{}",
            r.patches,
            r.factors,
            r.method,
            r.rays_per_patch,
            r.factor_bytes >> 20,
            r.closure_after,
            100.0 * bound,
            if r.error_reached { "" } else { ", not as low as asked: more rays no longer lowered it, or would not fit" },
        ),
        None => format!(
            "{} patches, {} factors above zero by `{}` in {} MiB; before repair rows closed to {:.1e} and pairs to {:.1e}, now {now}; that moved {:.2} % of the light{noise}",
            r.patches,
            r.factors,
            r.method,
            r.factor_bytes >> 20,
            r.closure_before,
            r.reciprocity_before,
            100.0 * r.moved_by_repair
        ),
    });
    let (sweeps, last) = (r.residuals.len() - 1, r.residuals.last().copied().unwrap_or(0.0));
    let end = if r.converged { "" } else { ": stopped before the residual asked for" };
    output::message(&format!("{}: residual {last:.1e} after {sweeps} sweeps, {:.1} s{end}", r.solve, r.seconds));
    output::message(&format!(
        "light in W over channels: emitted {:.6} + from elsewhere {:.6} = absorbed {:.6} + escaped {:.6} + residual {:.1e}",
        sum(r.emitted),
        sum(r.arrived).max(0.0),
        sum(r.absorbed),
        sum(r.escaped),
        sum(r.residual)
    ));
    let three = |x: [f32; 3]| x.map(|x| format!("{x:.3}")).join(", ");
    for n in &r.not_diffuse {
        let lost = if n.transmitted == [0.0; 3] {
            String::new()
        } else {
            format!("; {} that passes through is lost", three(n.transmitted))
        };
        output::message(&format!(
            "note: `{}`, {}: {} stands as a diffuse surface of reflectance {}{lost}",
            n.surface,
            n.side,
            n.material,
            three(n.reflectance)
        ));
    }
    etendue::surfaces::words(&r.defects).iter().for_each(|words| output::message(words));
}

//! The battery: every model, in many parameterisations, from both sides and at grazing angles, against what its contract says.
//!
//! | claim | test |
//! | --- | --- |
//! | what has a formula meets it | `closed_forms` |
//! | smooth samples are distributed by `pdf`, and ∫pdf is their share | `chi_square` |
//! | E[weight g] = ∫ f g cosθ for several g | `moments` |
//! | `weight`, `pdf` and `eval` of one sample agree | `consistency` |
//! | f(wo, wi) = η² f(wi, wo) | `reciprocity` |
//! | no more light leaves than arrives; none is lost where nothing absorbs | `energy` |
//! | any parameter, any direction, u = 0 and u = 1 - ulp: finite and not negative | `robustness` |
//! | many at once are each alone, bit for bit | `together` |
//! | the tests see faults | `saboteurs` |
//!
//! Seeds are fixed. Statistical tests are made at a level that gives, were the seeds drawn anew, one false alarm in a thousand runs for
//! each of `chi_square` and `moments` as a whole.

mod chi_square;
mod closed_forms;
mod consistency;
mod energy;
mod models;
mod moments;
mod reciprocity;
mod robustness;
mod saboteurs;
mod tabulated;
mod together;

use etendue_numerics::Vec3;

/// One false alarm of a whole family of tests in so many runs.
const FALSE_ALARMS: f64 = 1e-3;

/// Where light comes from: normal incidence, oblique, grazing, extremely grazing, and two from below.
fn directions() -> [Vec3; 6] {
    [
        Vec3::Z,
        Vec3::new(0.36, -0.48, 0.8),
        Vec3::new(-0.9, 0.3, 0.25).normalize(),
        Vec3::new(0.4, 0.9, 0.015).normalize(),
        Vec3::new(0.5, 0.1, -0.8).normalize(),
        Vec3::new(-0.2, 0.9, -0.1).normalize(),
    ]
}

//! What is said about patches and form factors.

use super::Selection;
use crate::memory;
use etendue_radiosity::Patches;
use etendue_radiosity::form_factor::TooLarge;
use etendue_radiosity::patch::TooMany;

/// Refuses more patches than are allowed.
pub(super) fn too_many(e: &TooMany) -> String {
    let help = match e.size {
        Some(size) => format!("patches of {size:.3} m would be few enough: --patch-size {size:.3}"),
        None => "the scene has more pieces than that before any is cut".to_owned(),
    };
    format!("the scene would be cut into {} patches, and {} are allowed\n  help: {help}", e.patches, e.most)
}

/// Refuses a scene that does not fit.
pub(super) fn too_large(e: &TooLarge, method: &str, room: u64) -> String {
    let why = match e.pairs {
        Some(pairs) => format!("{pairs} pairs"),
        None => format!("{}, and {} can be had", memory::human(e.bytes), memory::human(room)),
    };
    let help = match e.fits {
        Some(other) if other != method => format!("--method {other} fits"),
        Some(_) => "fewer --samples fit".to_owned(),
        None => "larger patches are fewer: --patch-size".to_owned(),
    };
    format!("{} patches are too many for the method `{method}`: it would take {why}\n  help: {help}", e.patches)
}

/// Why nothing goes from one selection to another.
pub(super) fn why_zero(patches: &Patches, from: &Selection, to: &Selection) -> &'static str {
    // Whether anything of patch j rises above the plane of patch i.
    let in_front = |i: u32, j: u32| {
        let patch = patches.get(i);
        let height = |p: etendue_numerics::DVec3| (p - patch.p).dot(patch.n);
        let (middle, radius) = patches.ball(j);
        let highest = match patches.polygon(j) {
            Some(corners) => corners.iter().map(|p| height(*p)).fold(f64::NEG_INFINITY, f64::max),
            None => height(middle) + radius,
        };
        !patches.geometry(i).1.is_flat() || highest > 1e-6 * radius
    };
    let facing = from.patches.iter().any(|i| to.patches.iter().any(|j| in_front(*i, *j) && in_front(*j, *i)));
    if facing {
        "no ray between their fronts gets through"
    } else {
        "their fronts face away from each other (--two-sided counts backs, too)"
    }
}

//! Roots of the quadratics that round shapes lead to.

/// The smallest t in (0, `t_max`) with a t² - 2 b t + c = 0 that `accept` accepts, given the reduced discriminant b² - a c. The root with the
/// larger magnitude is computed without cancellation, the other from the product of the two [Press et al. 2007, §5.6].
///
/// `t_max` is compared after rounding to f32, as the accelerator does.
#[inline]
pub(crate) fn nearest_root(a: f64, b: f64, c: f64, discriminant: f64, t_max: f32, accept: impl Fn(f64) -> bool) -> Option<f32> {
    // Written so that a NaN ends here.
    if !(discriminant >= 0.0 && a > 0.0) {
        return None;
    }
    let q = b + discriminant.sqrt().copysign(b);
    let (far, near) = (q / a, if q == 0.0 { 0.0 } else { c / q });
    let usable = |t: f64| (t as f32 > 0.0 && (t as f32) < t_max && accept(t)).then_some(t as f32);
    usable(near.min(far)).or_else(|| usable(near.max(far)))
}

#[cfg(test)]
mod tests {
    use super::nearest_root;

    #[test]
    fn roots_come_in_order_and_only_from_ahead() {
        let root = |low: f64, high: f64, t_max: f32| {
            let (b, c) = (0.5 * (low + high), low * high);
            nearest_root(1.0, b, c, b * b - c, t_max, |_| true)
        };
        assert_eq!(root(1.0, 3.0, f32::INFINITY), Some(1.0));
        assert_eq!(root(-1.0, 3.0, f32::INFINITY), Some(3.0));
        assert_eq!(root(-3.0, -1.0, f32::INFINITY), None);
        assert_eq!(root(2.0, 3.0, 2.0), None);
        assert_eq!(root(-2.0, 3.0, 2.5), None);
        assert_eq!(nearest_root(1.0, 0.0, 1.0, -1.0, f32::INFINITY, |_| true), None);
        assert_eq!(nearest_root(1.0, 2.0, 3.0, 1.0, f32::INFINITY, |t| t > 2.0), Some(3.0));
        assert_eq!(nearest_root(f64::NAN, 2.0, 3.0, 1.0, f32::INFINITY, |_| true), None);
    }

    #[test]
    fn small_roots_keep_their_digits() {
        // 1e-9 beside 1e9: the textbook formula loses it altogether.
        let (b, c) = (0.5 * (1e9 + 1e-9), 1.0);
        let t = nearest_root(1.0, b, c, b * b - c, f32::INFINITY, |_| true).expect("a root");
        assert!((t - 1e-9).abs() < 1e-15);
    }
}

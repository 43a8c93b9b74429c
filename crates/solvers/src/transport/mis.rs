//! Multiple importance sampling of two techniques, one sample each [Veach, Guibas 1995].

/// How techniques share a contribution.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Heuristic {
    /// w = p / (p + q) [Veach, Guibas 1995, eq. 12].
    Balance,
    /// w = p² / (p² + q²) [Veach, Guibas 1995, eq. 14, β = 2].
    #[default]
    Power,
}

/// The weight of a sample of density `p` when the other technique has density `q` there, both in the same measure.
#[inline]
pub fn mis_weight(heuristic: Heuristic, p: f32, q: f32) -> f32 {
    // In terms of the ratio, so that neither p² nor q² can overflow.
    match heuristic {
        _ if p <= 0.0 => 0.0,
        Heuristic::Balance => 1.0 / (1.0 + q / p),
        Heuristic::Power => 1.0 / (1.0 + (q / p) * (q / p)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_sum_to_one_and_never_overflow() {
        for heuristic in [Heuristic::Balance, Heuristic::Power] {
            for (p, q) in [(1.0, 2.0), (1e30, 1e-30), (1e-30, 1e30), (3e38, 3e38), (0.0, 1.0), (1.0, f32::INFINITY)] {
                let sum = mis_weight(heuristic, p, q) + mis_weight(heuristic, q, p);
                assert!((sum - 1.0).abs() < 1e-6 || q.is_infinite(), "{heuristic:?} {p} {q}: {sum}");
            }
        }
    }
}

//! The methods by name, what they need, and which of them fits.

use super::{Cancelled, FormFactors, Hemisphere, Pairs, Watch, analytic, by_area, hemisphere};
use crate::patch::Patches;
use etendue_scene::Scene;

/// A way to find form factors, with its parameters.
#[derive(Clone, Copy, Debug)]
pub enum Method {
    /// Closed forms between polygons, less the sampled part that is blocked.
    Analytic(Pairs),
    /// Cosine-distributed rays from each patch.
    Hemisphere(Hemisphere),
    /// The double integral by quadrature.
    Area,
}

/// A scene that is too large for a method.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TooLarge {
    /// Patches.
    pub patches: usize,
    /// Bytes that it would take.
    pub bytes: u64,
    /// Pairs that the method would go through, where they are too many.
    pub pairs: Option<u64>,
    /// A method that fits, if any.
    pub fits: Option<&'static str>,
}

/// Pairs beyond which going from one to the next would take hours.
const MOST_PAIRS: u64 = 200_000_000;

impl Method {
    /// Their names.
    pub const NAMES: [&'static str; 3] = ["analytic", "hemisphere", "area"];

    /// Its name.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Analytic(_) => "analytic",
            Self::Hemisphere(_) => "hemisphere",
            Self::Area => "area",
        }
    }

    /// The most bytes held at one time while `n` patches go through the method and a repair.
    pub fn bytes(&self, n: usize) -> u64 {
        let n = n as u64;
        match self {
            // A row has as many entries as rays at the most. A column and a value of each, those of the transposed, and those of both joined.
            Self::Hemisphere(h) => n * n.min(u64::from(h.rays)) * 4 * if h.errors { 8 } else { 3 } * 8 / 6,
            Self::Analytic(_) | Self::Area => n * n * (12 + 24 + 24),
        }
    }

    /// Refuses what cannot fit into `room` bytes, or would take hours.
    pub fn check(&self, n: usize, room: u64) -> Result<(), TooLarge> {
        let pairs = match self {
            Self::Hemisphere(_) => 0,
            Self::Analytic(_) | Self::Area => n as u64 * n as u64 / 2,
        };
        let bytes = self.bytes(n);
        if bytes <= room && pairs <= MOST_PAIRS {
            return Ok(());
        }
        let sparse = |rays: u32| Self::Hemisphere(Hemisphere { rays, errors: false, ..Hemisphere::default() });
        let fits = [4096, 1024, 256].into_iter().any(|rays| sparse(rays).bytes(n) <= room).then_some("hemisphere");
        Err(TooLarge { patches: n, bytes, pairs: (pairs > MOST_PAIRS).then_some(pairs), fits })
    }

    /// The form factors.
    pub fn run(&self, scene: &Scene, patches: &Patches, watch: &Watch) -> Result<FormFactors, Cancelled> {
        match self {
            Self::Analytic(pairs) => analytic(scene, patches, pairs, watch),
            Self::Hemisphere(rays) => hemisphere(scene, patches, rays, watch),
            Self::Area => by_area(scene, patches, watch),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_too_large_is_refused_with_what_fits() {
        let analytic = Method::Analytic(Pairs::default());
        assert_eq!(analytic.check(3000, 4 << 30), Ok(()));
        let refused = analytic.check(100_000, 4 << 30).expect_err("too large");
        assert_eq!((refused.pairs, refused.fits), (Some(5_000_000_000), Some("hemisphere")));
        let rays = Hemisphere { rays: 1024, errors: false, ..Hemisphere::default() };
        assert_eq!(Method::Hemisphere(rays).check(100_000, 4 << 30), Ok(()));
        assert_eq!(Method::Hemisphere(rays).check(100_000_000, 4 << 30).expect_err("too large").fits, None);
    }
}

//! The microfacets that rough models share: `distribution` (default `beckmann`), `alpha` (default 0.1) or both `alpha_u` and `alpha_v`,
//! `sample_visible` (default true), `masking` (default `separable`; `correlated` for GGX), `remap_roughness` (default false: α = √alpha where it is true).

use super::Site;
use crate::texture::ScalarSlot;
use etendue_bsdf::Ndf;

/// Distribution and width of microfacet normals.
#[derive(Clone, Debug)]
pub struct Roughness {
    /// The distribution's shape.
    pub ndf: Ndf,
    /// α along the surface's s and t, above 0; the root mean square slope is α/√2.
    pub alpha: [ScalarSlot; 2],
    /// Draw only normals that the given direction sees.
    pub sample_visible: bool,
    /// α is the square root of what the slots hold.
    pub remap: bool,
}

impl Roughness {
    /// α along s and t.
    #[inline]
    pub(super) fn at(&self, at: &Site) -> [f32; 2] {
        let alpha = self.alpha.map(|a| at.scalar(&a));
        if self.remap { alpha.map(|a| a.max(0.0).sqrt()) } else { alpha }
    }
}

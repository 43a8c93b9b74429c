//! `diffusetransmission`: a thin sheet that scatters diffusely to both sides. Parameters `reflectance` and `transmittance` (default 0.25), `scale` on
//! both (default 1).

use super::{Single, Site};
use crate::texture::ColorSlot;
use etendue_bsdf::{
    Event, Lobe,
    lobes::{self, DiffuseTransmissionParams},
};

/// Paper, leaves.
#[derive(Clone, Debug)]
pub struct DiffuseTransmission {
    /// ρ.
    pub reflectance: ColorSlot,
    /// τ.
    pub transmittance: ColorSlot,
    /// A factor on both.
    pub scale: f32,
}

impl Single for DiffuseTransmission {
    fn events(&self) -> Event {
        Event::REFLECT.with(Event::TRANSMIT).with(Event::DIFFUSE)
    }

    fn lobe(&self, at: &Site) -> Lobe<'_> {
        let [reflectance, transmittance] =
            [&self.reflectance, &self.transmittance].map(|c| at.color(c).clamp(0.0, 1.0) * self.scale);
        lobes::DiffuseTransmission::new(DiffuseTransmissionParams { reflectance, transmittance }).into()
    }
}

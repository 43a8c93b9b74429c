//! `null`: light passes as if there were no surface. No parameters.

use super::{Single, Site};
use etendue_bsdf::{Event, Lobe, lobes};

/// Nothing there.
#[derive(Clone, Debug)]
pub struct Null;

impl Single for Null {
    fn events(&self) -> Event {
        Event::NULL.with(Event::DELTA)
    }

    fn lobe(&self, _at: &Site) -> Lobe<'_> {
        lobes::Null.into()
    }
}

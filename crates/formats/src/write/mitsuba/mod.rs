//! Mitsuba 3 scenes. The description's words are Mitsuba's with extensions, so a scene is written in two steps: [`plain`] puts Mitsuba's
//! words in the place of étendue's own, [`xml`] prints what there is.

mod lights;
mod materials;
mod plain;
mod xml;

use super::beside::Beside;
use super::{Notes, WriteOptions};
use etendue_description::Description;

/// The text of a scene.
pub(super) fn write(d: &Description, options: &WriteOptions, beside: &mut Beside, notes: &mut Notes) -> String {
    let mut plain = d.clone();
    plain::plain(&mut plain, options.own_words, beside, notes);
    xml::print(&plain, d, options, beside, notes)
}

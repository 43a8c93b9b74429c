//! `.spd`: a spectrum as a text, lines of a wavelength in nm and a value.

use crate::mitsuba::shortened;
use etendue_description::{Diagnostics, Sources, Span};
use std::path::Path;

/// Lines of a wavelength in nm and a value; `#` begins a comment.
pub(crate) fn read(
    path: &Path,
    content: &str,
    named: Span,
    sources: &mut Sources,
    diagnostics: &mut Diagnostics,
) -> Option<Vec<(f64, f64)>> {
    let mut samples: Vec<(f64, f64)> = Vec::new();
    for (i, line) in content.lines().enumerate() {
        let data = line.split('#').next().unwrap_or("");
        let words: Vec<&str> = data.split(|c: char| c == ',' || c.is_whitespace()).filter(|w| !w.is_empty()).collect();
        // The word at fault, or the whole line.
        let wrong = match words[..] {
            [] => continue,
            [nm, value] => match (nm.parse::<f64>(), value.parse::<f64>()) {
                (Ok(x), Ok(y)) if x.is_finite() && y.is_finite() => {
                    let before = samples.last().map(|s| s.0);
                    samples.push((x, y));
                    before
                        .filter(|before| x <= *before)
                        .map(|before| (nm, format!("wavelengths must rise: {x} nm follows {before} nm")))
                }
                (Ok(x), _) if x.is_finite() => Some((value, format!("`{}` is no finite number", shortened(value)))),
                _ => Some((nm, format!("`{}` is no finite number", shortened(nm)))),
            },
            _ => Some((data, format!("a line has a wavelength and a value, found {} words", words.len()))),
        };
        if let Some((word, message)) = wrong {
            let source = sources.add_excerpt(path, line, i + 1);
            let start = (word.as_ptr() as usize - line.as_ptr() as usize) as u32;
            let span = Span { source, start, end: start + word.len() as u32 };
            diagnostics.error(span, message).label(named, "the file is named here");
            return None;
        }
    }
    if samples.len() < 2 {
        diagnostics.error(named, format!("`{}` holds {} samples, a spectrum has at least two", path.display(), samples.len()));
        return None;
    }
    Some(samples)
}

//! Parameters of solvers, typed: each solver declares its own beside itself, and they are set by name from words.
//!
//! A declaration names a field: what may be written there is said by [`Slot`], the value that a fresh solver holds is the default.
//!
//! ```
//! use etendue_solvers::{AnySolver, ParameterError};
//! let mut solver = AnySolver::new("distribution", &Default::default()).unwrap();
//! assert_eq!(solver.set("gloss_samples", "16"), Ok(()));
//! assert!(matches!(solver.set("gloss_samples", "many"), Err(ParameterError::Invalid { .. })));
//! assert!(matches!(solver.set("colour", "red"), Err(ParameterError::Unknown { .. })));
//! ```

use etendue_numerics::Spectrum;
use std::fmt;
use std::ops::RangeInclusive;

/// A field of the solver `S` that users may set.
#[derive(Debug)]
pub struct Parameter<S> {
    /// Its name.
    pub name: &'static str,
    /// What it means, in a line.
    pub summary: &'static str,
    /// The field, and what it may hold.
    pub slot: fn(&mut S) -> Slot<'_>,
}

/// Where a value is kept, and what it may be.
#[derive(Debug)]
pub enum Slot<'a> {
    /// A whole number.
    Count(&'a mut u32, RangeInclusive<u32>),
    /// A number.
    Number(&'a mut f32, RangeInclusive<f32>),
    /// Radiance, W/(m² sr): one number for all channels, or linear Rec.709.
    Radiance(&'a mut Spectrum),
    /// One of several words: its place among them.
    Choice(&'a mut usize, &'static [&'static str]),
}

/// A parameter in words.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ParameterInfo {
    /// Its name.
    pub name: &'static str,
    /// What it means.
    pub summary: &'static str,
    /// What it may be.
    pub domain: String,
    /// Its value.
    pub value: String,
}

/// Why a parameter was not set.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ParameterError {
    /// The solver has no such parameter.
    Unknown {
        /// What was asked for.
        name: String,
        /// Those that it has.
        known: Vec<&'static str>,
    },
    /// The value is not one of those that the parameter may have.
    Invalid {
        /// The parameter.
        name: &'static str,
        /// What was given.
        value: String,
        /// What it may be.
        domain: String,
    },
}

impl fmt::Display for ParameterError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unknown { name, known } if known.is_empty() => {
                write!(f, "the solver has no parameter `{name}`, nor any other")
            }
            Self::Unknown { name, known } => write!(f, "the solver has no parameter `{name}`; it has {}", known.join(", ")),
            Self::Invalid { name, value, domain } => write!(f, "`{name}` is {domain}, not `{value}`"),
        }
    }
}

impl std::error::Error for ParameterError {}

/// Most samples of one kind at a hit.
pub(crate) const MOST_SAMPLES: u32 = 4096;

/// All declared parameters with their values.
pub(crate) fn list<S>(solver: &mut S, declared: &[Parameter<S>]) -> Vec<ParameterInfo> {
    let info = |p: &Parameter<S>, slot: Slot<'_>| ParameterInfo {
        name: p.name,
        summary: p.summary,
        domain: slot.domain(),
        value: slot.to_string(),
    };
    declared.iter().map(|p| info(p, (p.slot)(solver))).collect()
}

/// Sets the parameter `name` to what `value` says.
pub(crate) fn set<S>(solver: &mut S, declared: &[Parameter<S>], name: &str, value: &str) -> Result<(), ParameterError> {
    let Some(parameter) = declared.iter().find(|p| p.name == name) else {
        return Err(ParameterError::Unknown { name: name.to_owned(), known: declared.iter().map(|p| p.name).collect() });
    };
    let mut slot = (parameter.slot)(solver);
    slot.write(value).ok_or_else(|| ParameterError::Invalid {
        name: parameter.name,
        value: value.to_owned(),
        domain: slot.domain(),
    })
}

impl Slot<'_> {
    /// What may stand here, in words.
    fn domain(&self) -> String {
        match self {
            Self::Count(_, range) => format!("a whole number from {} to {}", range.start(), range.end()),
            Self::Number(_, range) => format!("a number from {} to {}", range.start(), range.end()),
            Self::Radiance(_) => "a radiance (one number, or R,G,B; none below 0)".to_owned(),
            Self::Choice(_, words) => format!("one of {}", words.join(", ")),
        }
    }

    /// Writes the value that `text` tells, if it may stand here.
    fn write(&mut self, text: &str) -> Option<()> {
        match self {
            Self::Count(to, range) => **to = text.trim().parse().ok().filter(|x| range.contains(x))?,
            Self::Number(to, range) => **to = text.trim().parse().ok().filter(|x| range.contains(x))?,
            Self::Choice(to, words) => **to = words.iter().position(|w| *w == text.trim())?,
            Self::Radiance(to) => {
                let lane = |t: &str| t.trim().parse::<f32>().ok().filter(|x| (0.0..=f32::MAX).contains(x));
                let lanes = text.split(',').map(lane).collect::<Option<Vec<_>>>()?;
                **to = match lanes[..] {
                    [x] => Spectrum::rgb(x, x, x),
                    [r, g, b] => Spectrum::rgb(r, g, b),
                    _ => return None,
                };
            }
        }
        Some(())
    }
}

/// The value, as it can be read back.
impl fmt::Display for Slot<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Count(x, _) => write!(f, "{x}"),
            Self::Number(x, _) => write!(f, "{x}"),
            Self::Choice(at, words) => f.write_str(words.get(**at).unwrap_or(&"")),
            Self::Radiance(l) => match l.to_rgb() {
                [r, g, b] if r == g && g == b => write!(f, "{r}"),
                [r, g, b] => write!(f, "{r},{g},{b}"),
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{AnySolver, SOLVERS};
    use etendue_scene::Integrator;

    fn solver(name: &str) -> AnySolver {
        AnySolver::new(name, &Integrator::default()).expect("a solver of the list")
    }

    /// What a solver says of itself can be given back to it, and what it says it cannot be is refused with the words of its domain.
    #[test]
    fn values_are_read_back_and_others_refused() {
        for info in SOLVERS {
            let mut s = solver(info.name);
            for p in s.parameters() {
                assert_eq!(s.set(p.name, &p.value), Ok(()), "{}: {}", info.name, p.name);
                for bad in ["", "-1", "nan", "inf", "1,2", "x", "1e99", "0x10", "1,2,-3"] {
                    let refused = s.set(p.name, bad);
                    let want = ParameterError::Invalid { name: p.name, value: bad.to_owned(), domain: p.domain.clone() };
                    assert_eq!(refused, Err(want), "{}: {} = {bad}", info.name, p.name);
                }
                assert!(s.parameters().contains(&p), "{}: a refused value left {} as it was", info.name, p.name);
            }
        }
    }

    #[test]
    fn values_arrive_in_their_field() {
        let mut s = solver("whitted");
        for (given, kept) in [("0.25", "0.25"), ("0.1,0.2,0.3", "0.1,0.2,0.3"), (" 1 , 1 , 1 ", "1")] {
            assert_eq!(s.set("ambient", given), Ok(()));
            assert_eq!(s.parameters()[0].value, kept);
        }
        for out_of_range in ["4097", "99999999999", "1.5"] {
            assert!(solver("distribution").set("shadow_samples", out_of_range).is_err());
        }
        let words = s.set("ambiant", "1").expect_err("no such name").to_string();
        assert_eq!(words, "the solver has no parameter `ambiant`; it has ambient");
        assert!(solver("path").set("x", "1").expect_err("none").to_string().ends_with("nor any other"));
    }
}

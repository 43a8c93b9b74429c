//! Words of the command line into values; a refusal here is wrong usage.

use etendue::Spread;
use etendue_image::Format;
use etendue_numerics::SequenceKind;
use etendue_solvers::aov::Quantity;
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// `NAME=VALUE`.
pub fn define(text: &str) -> Result<(String, String), String> {
    let (name, value) = text.split_once('=').ok_or_else(|| format!("`{text}` is not of the form NAME=VALUE"))?;
    Ok((name.to_owned(), value.to_owned()))
}

/// `--max-depth`: `None` is unbounded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Depth(pub Option<u32>);

/// -1, or a number of edges.
pub fn depth(text: &str) -> Result<Depth, String> {
    match text.parse::<i64>() {
        Ok(-1) => Ok(Depth(None)),
        Ok(n) if (0..=i64::from(u32::MAX)).contains(&n) => Ok(Depth(Some(n as u32))),
        _ => Err(format!("`{text}` is no number of edges; expected -1 (unbounded) or 0, 1, 2, …")),
    }
}

/// `A..B` with both ends in it, `A..` without an end, or one number.
pub fn bounces(text: &str) -> Result<RangeInclusive<u32>, String> {
    let number = |t: &str| t.trim().parse::<u32>().map_err(|_| format!("`{t}` is no number of bounces"));
    let (a, b) = text.split_once("..").unwrap_or((text, text));
    let b = b.trim_start_matches('=');
    let range = number(a)?..=if b.is_empty() { u32::MAX } else { number(b)? };
    if range.is_empty() { Err(format!("{text} holds no number")) } else { Ok(range) }
}

/// A finite number above zero.
pub fn positive(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(x) if x > 0.0 && x.is_finite() => Ok(x),
        _ => Err(format!("`{text}` is not a number above 0")),
    }
}

/// A time in seconds.
pub fn seconds(text: &str) -> Result<Duration, String> {
    Duration::try_from_secs_f64(positive(text)?).map_err(|_| format!("`{text}` s is too long"))
}

/// A point set.
pub fn sequence(text: &str) -> Result<SequenceKind, String> {
    match text {
        "sobol" => Ok(SequenceKind::Sobol),
        "stratified" => Ok(SequenceKind::Stratified),
        "independent" => Ok(SequenceKind::Independent),
        _ => Err("expected sobol, stratified or independent".to_owned()),
    }
}

/// How samples are spread.
pub fn spread(text: &str) -> Result<Spread, String> {
    match text {
        "adaptive" => Ok(Spread::Adaptive),
        "uniform" => Ok(Spread::Uniform),
        _ => Err("expected adaptive or uniform".to_owned()),
    }
}

/// A layer.
pub fn quantity(text: &str) -> Result<Quantity, String> {
    let names = || Quantity::ALL.map(|(_, name, ..)| name).join(", ");
    Quantity::from_name(text).ok_or_else(|| format!("expected one of {}", names()))
}

/// A solver that is known by name, there yet or not.
pub fn solver(text: &str) -> Result<String, String> {
    etendue::check_solver_name(text).map(|()| text.to_owned()).map_err(|e| e.to_string())
}

/// A picture to be written.
pub fn picture(text: &str) -> Result<PathBuf, String> {
    let path = PathBuf::from(text);
    let known = Format::of_path(Path::new(text)).is_some_and(Format::can_write);
    if known { Ok(path) } else { Err("a picture's name ends in .exr, .hdr, .pfm, .png or .jpg".to_owned()) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_of_bounces() {
        assert_eq!(bounces("1..3"), Ok(1..=3));
        assert_eq!(bounces("2..=2"), Ok(2..=2));
        assert_eq!(bounces("0"), Ok(0..=0));
        assert_eq!(bounces("2.."), Ok(2..=u32::MAX));
        for bad in ["", "..", "..3", "3..1", "a..b", "-1", "1.5"] {
            assert!(bounces(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn times_and_depths() {
        assert_eq!(seconds("0.5"), Ok(Duration::from_millis(500)));
        for bad in ["0", "-1", "nan", "inf", "1e30", "s"] {
            assert!(seconds(bad).is_err(), "{bad}");
        }
        assert_eq!(depth("-1"), Ok(Depth(None)));
        assert_eq!(depth("7"), Ok(Depth(Some(7))));
        assert!(depth("-2").is_err() && depth("4294967296").is_err() && depth("x").is_err());
    }
}

//! Numbers and words as files have them.

/// The shortest text that reads back as the same number.
pub(super) fn number(x: f64) -> String {
    plain(format!("{x:?}"))
}

/// The shortest text that reads back as the same number in single precision.
pub(super) fn single(x: f32) -> String {
    plain(format!("{x:?}"))
}

fn plain(mut text: String) -> String {
    if text.ends_with(".0") {
        text.truncate(text.len() - 2);
    }
    text
}

/// Numbers with `between` them.
pub(super) fn numbers(list: &[f64], between: &str) -> String {
    list.iter().map(|x| number(*x)).collect::<Vec<_>>().join(between)
}

/// A text within an attribute of XML.
pub(super) fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            // A dollar begins the name of a parameter.
            '$' => out.push_str("\\$"),
            c if c.is_control() => out.push_str(&format!("&#{};", u32::from(c))),
            c => out.push(c),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short_and_come_back() {
        for (x, text) in [(1.0, "1"), (0.1, "0.1"), (-2.5e-7, "-2.5e-7"), (1e300, "1e300"), (0.0, "0"), (123456.0, "123456")] {
            assert_eq!(number(x), text);
            assert_eq!(text.parse::<f64>().unwrap(), x);
        }
        assert_eq!(single(0.1), "0.1");
        let third = 1.0 / 3.0;
        assert_eq!(number(third).parse::<f64>().unwrap().to_bits(), third.to_bits());
        assert_eq!(single(third as f32).parse::<f32>().unwrap(), third as f32);
    }
}

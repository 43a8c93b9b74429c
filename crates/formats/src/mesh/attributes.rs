//! Which properties of a PLY element are which: coordinates, and named attributes by Mitsuba's rule.
//!
//! `r g b` (or `red green blue`) are the attribute `color`. Other attributes have one or three properties in a row, `prefix_p`, where the
//! letters p begin one of the sequences `xyz`, `rgb`, `012`, `123`; the attribute is called `prefix`, or `prefix_color` for `rgb`.
//! The element's name stands before: `vertex_color`, `face_id`. Properties that fit no rule are left aside.

/// A named attribute and the properties that hold its channels.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Named {
    /// The name, with its `vertex_` or `face_` prefix.
    pub name: String,
    /// A property for each channel.
    pub properties: Vec<usize>,
}

/// The positions of the names of the first set that is there as a whole.
pub(super) fn find<const N: usize>(names: &[&str], sets: &[[&str; N]]) -> Option<[usize; N]> {
    sets.iter().find_map(|set| {
        let found = set.map(|wanted| names.iter().position(|name| *name == wanted));
        found.iter().all(Option::is_some).then(|| found.map(Option::unwrap_or_default))
    })
}

/// The attributes among the properties that are not `taken`.
pub(super) fn named(element: &str, names: &[&str], taken: &[usize]) -> Vec<Named> {
    let mut out = Vec::new();
    let mut used = taken.to_vec();
    if let Some(rgb) = find(names, &[["r", "g", "b"], ["red", "green", "blue"]]) {
        out.push(Named { name: format!("{element}_color"), properties: rgb.to_vec() });
        used.extend(rgb);
    }

    let mut at = 0;
    while at < names.len() {
        let run = run(names, at, &used);
        // Three channels or one; a run of another length is no attribute.
        if let Some((prefix, colour, length)) = run
            && matches!(length, 1 | 3)
        {
            let name = format!("{element}_{prefix}{}", if colour { "_color" } else { "" });
            if !out.iter().any(|other| other.name == name) {
                out.push(Named { name, properties: (at..at + length).collect() });
            }
        }
        at += run.map_or(1, |(_, _, length)| length);
    }
    out
}

/// The attribute that begins at property `at`: its prefix, whether its letters are `rgb`, its length.
fn run<'n>(names: &[&'n str], at: usize, used: &[usize]) -> Option<(&'n str, bool, usize)> {
    const SEQUENCES: [&str; 4] = ["xyzw", "rgba", "0123", "1234"];
    let split = |i: usize| {
        let (prefix, letter) = names.get(i).filter(|_| !used.contains(&i))?.rsplit_once('_')?;
        Some((prefix, letter)).filter(|(prefix, letter)| !prefix.is_empty() && letter.len() == 1)
    };
    let (prefix, first) = split(at)?;
    let sequence = SEQUENCES.iter().find(|s| s.starts_with(first))?;
    let fits = |k: usize| split(at + k).is_some_and(|(p, l)| p == prefix && sequence[k..].starts_with(l));
    let length = (1..4).take_while(|&k| fits(k)).count() + 1;
    Some((prefix, sequence.starts_with('r'), length))
}

#[cfg(test)]
mod tests {
    use super::named;

    fn names(properties: &str) -> Vec<(String, usize)> {
        let properties: Vec<&str> = properties.split(' ').collect();
        named("vertex", &properties, &[]).into_iter().map(|a| (a.name, a.properties.len())).collect()
    }

    #[test]
    fn the_names_are_those_that_mitsuba_gives() {
        let one = |name: &str, n: usize| vec![(name.to_owned(), n)];
        assert_eq!(names("r g b"), one("vertex_color", 3));
        assert_eq!(names("red green blue alpha"), one("vertex_color", 3));
        assert_eq!(names("foo_r foo_g foo_b"), one("vertex_foo_color", 3));
        assert_eq!(names("foo_x foo_y foo_z"), one("vertex_foo", 3));
        assert_eq!(names("color_0 color_1 color_2"), one("vertex_color", 3));
        assert_eq!(names("foo_a_1 foo_a_2 foo_a_3"), one("vertex_foo_a", 3));
        assert_eq!(names("r foo_1 g b"), [("vertex_color".to_owned(), 3), ("vertex_foo".to_owned(), 1)]);
        assert_eq!(names("foo_0 bar_1 foo_1 foo_2"), [("vertex_foo".to_owned(), 1), ("vertex_bar".to_owned(), 1)]);
        assert_eq!(names("foo_1 foo_2"), []);
        assert_eq!(names("foo_0 foo_1 foo_2 foo_3"), []);
        assert_eq!(names("foo confidence _0 foo_bar"), []);
    }
}

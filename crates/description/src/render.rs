//! Messages as text, the way compilers print them.
//!
//! The first line of a message is `file:line:col: error: what is wrong`, so that editors jump to it; under it stand the source line with
//! the word marked, other places that matter, the chain of includes, and help. The output depends on the messages alone.

use crate::diagnostic::{Diagnostic, Severity};
use crate::source::{SourceId, Sources, Span, floor_char_boundary};
use annotate_snippets::{AnnotationKind, Group, Level, Renderer, Snippet};
use std::borrow::Cow;
use std::fmt::Write as _;

/// Columns of text; longer source lines are cut around the word.
const WIDTH: usize = 120;
/// Source lines beyond this many bytes are cut before they are laid out.
const LONG_LINE: usize = 4096;
/// Messages beyond this number are counted and not printed: by then something is wrong with the file as a whole.
const MANY: usize = 100;

/// The messages, one after the other.
pub(crate) fn render<'a>(list: impl Iterator<Item = &'a Diagnostic>, sources: &Sources, coloured: bool) -> String {
    let mut out = String::new();
    let mut unsaid = 0;
    for (i, diagnostic) in list.enumerate() {
        if i < MANY {
            one(&mut out, diagnostic, sources, coloured);
        } else {
            unsaid += 1;
        }
    }
    if unsaid > 0 {
        let _ = writeln!(out, "and {unsaid} more of the kind");
    }
    out
}

fn one(out: &mut String, diagnostic: &Diagnostic, sources: &Sources, coloured: bool) {
    headline(out, diagnostic, sources, coloured);

    // The word at fault in its line, then the other places.
    let mut group = Group::with_level(level(diagnostic.severity));
    let mut pictures = 0;
    let own = diagnostic.span.into_iter().map(|span| (span, None));
    for (span, words) in own.chain(diagnostic.labels.iter().map(|(span, words)| (*span, Some(words)))) {
        if sources.text(span.source).trim().is_empty() {
            continue;
        }
        let line = Line::of(sources, span);
        let mut snippet = Snippet::source(line.text.to_owned()).line_start(line.number);
        let kind = if words.is_none() { AnnotationKind::Primary } else { AnnotationKind::Context };
        let mut mark = kind.span(line.mark);
        if let Some(words) = words {
            mark = mark.label(clean(words));
            snippet = snippet.path(clean(&sources.path(span.source).display().to_string()).into_owned());
        }
        group = group.element(snippet.annotation(mark));
        pictures += 1;
    }
    for text in &diagnostic.help {
        group = group.element(Level::HELP.message(clean(text)));
    }
    for text in include_chain(sources, diagnostic.span.map(|s| s.source)) {
        group = group.element(Level::NOTE.message(clean(&text).into_owned()));
    }

    if pictures > 0 {
        let renderer = if coloured { Renderer::styled() } else { Renderer::plain() };
        out.push_str(&renderer.term_width(WIDTH).render(&[group]));
        out.push('\n');
    } else {
        for text in &diagnostic.help {
            let _ = writeln!(out, "   = help: {}", clean(text));
        }
    }
    out.push('\n');
}

/// `file:line:col: error: message`.
fn headline(out: &mut String, diagnostic: &Diagnostic, sources: &Sources, coloured: bool) {
    if let Some(span) = diagnostic.span {
        let _ = write!(out, "{}: ", clean(&sources.place(span)));
    }
    let word = diagnostic.severity.name();
    let message = clean(&diagnostic.message);
    if coloured {
        let colour = match diagnostic.severity {
            Severity::Error => 91,
            Severity::Warning => 93,
            Severity::Note => 92,
        };
        let _ = writeln!(out, "\x1b[1;{colour}m{word}\x1b[0m\x1b[1m: {message}\x1b[0m");
    } else {
        let _ = writeln!(out, "{word}: {message}");
    }
}

/// A text in one line without control characters, which a file's words may hold and a terminal would obey.
fn clean(text: &str) -> Cow<'_, str> {
    if !text.contains(|c: char| c.is_control()) {
        return Cow::Borrowed(text);
    }
    Cow::Owned(text.chars().map(|c| if c.is_control() { c.escape_default().to_string() } else { c.to_string() }).collect())
}

fn level(severity: Severity) -> Level<'static> {
    match severity {
        Severity::Note => Level::NOTE,
        Severity::Warning => Level::WARNING,
        Severity::Error => Level::ERROR,
    }
}

/// Who included the file, outwards.
fn include_chain(sources: &Sources, source: Option<SourceId>) -> Vec<String> {
    let mut chain = Vec::new();
    let mut parent = source.and_then(|id| sources.parent(id));
    while let Some(span) = parent {
        chain.push(format!("included from {}", sources.place(span)));
        parent = sources.parent(span.source);
    }
    chain
}

/// The line that a span begins in, and the marked part of it.
struct Line<'a> {
    number: usize,
    text: &'a str,
    mark: std::ops::Range<usize>,
}

impl<'a> Line<'a> {
    fn of(sources: &'a Sources, span: Span) -> Self {
        let text = sources.text(span.source);
        let at = floor_char_boundary(text, span.start as usize);
        let (number, mut start) = sources.line_start(span.source, span.start);
        let mut end = text[at..].find('\n').map_or(text.len(), |i| at + i);
        if end > at && text.as_bytes()[end - 1] == b'\r' {
            end -= 1;
        }
        if end - start > LONG_LINE {
            start = start.max(floor_char_boundary(text, at.saturating_sub(WIDTH)));
            end = end.min(floor_char_boundary(text, at + LONG_LINE));
        }
        // A span over several lines is marked to the end of its first.
        let mark_end = floor_char_boundary(text, span.end as usize).clamp(at, end);
        Self { number, text: &text[start..end], mark: at - start..mark_end - start }
    }
}

#[cfg(test)]
mod tests {
    use crate::{Diagnostics, Sources, Span};

    fn span(sources: &Sources, source: crate::SourceId, word: &str) -> Span {
        let start = sources.text(source).find(word).expect("the word is there") as u32;
        Span { source, start, end: start + word.len() as u32 }
    }

    #[test]
    fn a_message_shows_line_caret_help_and_chain() {
        let mut sources = Sources::default();
        let outer = sources.add("scene.xml", "<scene>\n  <include filename=\"lamp.xml\"/>\n</scene>\n");
        let at = span(&sources, outer, "lamp.xml");
        let inner = sources.add_included("lamp.xml", "<scene>\n  <float nome=\"größe\" value=\"1\"/>\n", at);
        let mut diagnostics = Diagnostics::default();
        diagnostics.error(span(&sources, inner, "nome"), "unknown attribute `nome`").suggest("nome", ["name", "value"]);
        let expected = "\
lamp.xml:2:10: error: unknown attribute `nome`
  |
2 |   <float nome=\"größe\" value=\"1\"/>
  |          ^^^^
  |
  = help: did you mean `name`?
  = note: included from scene.xml:2:22

";
        assert_eq!(diagnostics.render(&sources), expected);
        assert!(diagnostics.render_coloured(&sources).contains("\x1b[1;91merror\x1b[0m"));
    }

    #[test]
    fn a_second_place_is_shown_with_its_words() {
        let mut sources = Sources::default();
        let id = sources.add("a.xml", "<bsdf id=\"x\"/>\n\n\n<bsdf id=\"x\"/>\n");
        let mut diagnostics = Diagnostics::default();
        let (first, second) = (Span { source: id, start: 10, end: 11 }, Span { source: id, start: 27, end: 28 });
        diagnostics.error(second, "the id `x` is given twice").label(first, "first given here");
        let text = diagnostics.render(&sources);
        assert!(text.starts_with("a.xml:4:11: error: the id `x` is given twice\n"), "{text}");
        assert!(text.contains("a.xml:1:11") && text.contains("- first given here"), "{text}");
    }

    #[test]
    fn a_message_without_a_place_and_a_line_without_an_end() {
        let mut sources = Sources::default();
        let long = format!("<a v=\"{}\" oops=\"\"/>", "1 ".repeat(100_000));
        let id = sources.add("long.xml", long);
        let mut diagnostics = Diagnostics::default();
        diagnostics.error(None, "no such file").help("look again");
        diagnostics.error(span(&sources, id, "oops"), "unknown attribute `oops`");
        let text = diagnostics.render(&sources);
        assert!(text.starts_with("error: no such file\n   = help: look again\n\nlong.xml:1:200009: error: "), "{text}");
        assert!(text.lines().all(|l| l.chars().count() <= super::WIDTH), "{text}");
    }

    #[test]
    fn words_of_a_file_do_not_command_the_terminal() {
        let mut sources = Sources::default();
        let id = sources.add("a\nb.xml", "<x id=\"\x1b[31m\"/>");
        let mut diagnostics = Diagnostics::default();
        let span = span(&sources, id, "\x1b[31m");
        diagnostics.error(span, "nothing has the id `\x1b[31m`").help("\x07").label(span, "\r");
        let text = diagnostics.render(&sources);
        assert!(text.starts_with("a\\nb.xml:1:8: error: nothing has the id `\\u{1b}[31m`\n"), "{text}");
        assert!(!text.contains(['\x1b', '\x07', '\r']), "{text:?}");
    }

    #[test]
    fn too_many_messages_are_counted() {
        let mut diagnostics = Diagnostics::default();
        for i in 0..super::MANY + 7 {
            diagnostics.error(None, format!("{i}"));
        }
        assert!(diagnostics.render(&Sources::default()).ends_with("and 7 more of the kind\n"));
    }
}

//! What stands behind a directive: names, numbers, and parameter lists.

use super::directives::DIRECTIVES;
use super::tokens::{Token, Tokens, shortened};
use super::values::{Entry, Type, Values};
use super::{MAX_MISTAKES, Reader};
use etendue_description::{SourceId, Span};

impl Reader<'_> {
    /// A quoted string.
    pub(super) fn quoted(&mut self, t: &mut Tokens, source: SourceId, directive: Span, what: &str) -> Option<(String, Span)> {
        match t.peek() {
            Ok(Token::Quoted(r)) => {
                let _ = t.next();
                let span = self.span(source, r.clone());
                match super::tokens::unescaped(&t.text[r]) {
                    Ok(text) => Some((text, span)),
                    Err(why) => {
                        self.diagnostics.error(span, why);
                        None
                    }
                }
            }
            Err(mistake) => {
                let _ = t.next();
                self.stray(source, mistake);
                None
            }
            Ok(_) => {
                self.mistakes += 1;
                self.diagnostics.error(directive, format!("{what} must follow"));
                None
            }
        }
    }

    /// All quoted strings that follow, and the place of the last.
    pub(super) fn names(&mut self, t: &mut Tokens, source: SourceId, directive: Span) -> (Vec<String>, Span) {
        let (mut names, mut place) = (Vec::new(), directive);
        while let Ok(Token::Quoted(_)) = t.peek() {
            let Some((name, at)) = self.quoted(t, source, directive, "a name") else { break };
            names.push(name);
            place = at;
        }
        (names, place)
    }

    /// `N` numbers, with or without brackets.
    pub(super) fn numbers<const N: usize>(&mut self, t: &mut Tokens, source: SourceId, directive: Span) -> Option<[f64; N]> {
        let mut values = Type::Float.empty(false);
        let bracketed = matches!(t.peek(), Ok(Token::Open(_)));
        for _ in 0..if bracketed { 1 } else { N } {
            if matches!(t.peek(), Ok(Token::Word(r)) if t.text[r.clone()].starts_with(|c: char| c.is_ascii_uppercase())) {
                break;
            }
            if let Err(mistake) = t.values(&mut values) {
                let _ = t.next();
                self.stray(source, mistake);
                return None;
            }
        }
        let Values::Doubles(list) = values else { return None };
        let found = list.len();
        let numbers = list.try_into().ok();
        if numbers.is_none() {
            self.mistakes += 1;
            self.diagnostics.error(directive, format!("{N} numbers must follow, found {found}"));
        }
        numbers
    }

    /// Parameters, as many as follow; `None` where the values of one could not be read, which is told and is enough about their owner.
    pub(super) fn entries(&mut self, t: &mut Tokens, source: SourceId) -> Option<Vec<Entry>> {
        let mut entries: Vec<Entry> = Vec::new();
        let mut sound = true;
        loop {
            let declaration = match t.peek() {
                Ok(Token::Quoted(r)) => {
                    let _ = t.next();
                    r
                }
                Err(mistake) => {
                    let _ = t.next();
                    self.stray(source, mistake);
                    return None;
                }
                Ok(_) => return sound.then_some(entries),
            };
            let declared = self.span(source, declaration.clone());
            let text = &t.text[declaration];
            let mut words = text.split_ascii_whitespace();
            let kind = match (words.next(), words.next(), words.next()) {
                (Some(kind), Some(name), None) => match Type::named(kind) {
                    Some(found) => {
                        if kind == "color" {
                            self.diagnostics.error(declared, "the type `color` is one of pbrt-v3").help("in pbrt-v4 it is `rgb`");
                        }
                        Some((found, name))
                    }
                    None => {
                        let error = self.diagnostics.error(declared, format!("unknown type `{}` of a parameter", shortened(kind)));
                        match kind {
                            "xyz" => drop(error.help("pbrt-v4 has no XYZ colours: give `rgb` or `spectrum`")),
                            _ => drop(error.suggest(kind, Type::names())),
                        }
                        None
                    }
                },
                _ => {
                    let text = format!("\"{}\" declares no parameter", shortened(text));
                    self.diagnostics
                        .error(declared, text)
                        .help("a parameter is declared by \"type name\", such as \"float radius\"");
                    None
                }
            };
            let is_text = matches!(kind, Some((Type::Spectrum, _))) && spectrum_is_text(t);
            let mut values = match kind {
                Some((kind, _)) => kind.empty(is_text),
                None if spectrum_is_text(t) => Type::Text.empty(false),
                None => Type::Float.empty(false),
            };
            match t.values(&mut values) {
                Ok(range) => {
                    let Some((kind, name)) = kind else { continue };
                    if let Some(first) = entries.iter().position(|e| e.name == name) {
                        let first = entries.remove(first).declared;
                        self.diagnostics
                            .warning(declared, format!("parameter `{name}` is given twice: this one counts"))
                            .label(first, "first given here");
                    }
                    let span = self.span(source, range);
                    entries.push(Entry::new(kind, name.to_owned(), declared, span, values));
                }
                Err(mistake) => {
                    // The rest of this list is lost, and the directive goes on behind it.
                    sound = false;
                    if kind.is_some() {
                        self.broken = true;
                        let span = self.span(source, mistake.range);
                        self.diagnostics.error(span, mistake.message);
                        self.mistakes += usize::from(!skip_list(t));
                    } else {
                        skip_list(t);
                    }
                    if self.mistakes >= MAX_MISTAKES {
                        return None;
                    }
                }
            }
        }
    }
}

/// Whether the values that follow begin with a string.
fn spectrum_is_text(t: &mut Tokens) -> bool {
    let at = t.at;
    let mut token = t.next();
    if matches!(token, Ok(Token::Open(_))) {
        token = t.next();
    }
    t.at = at;
    matches!(token, Ok(Token::Quoted(_)))
}

/// Behind a broken list: past its closing bracket. `false` where a directive comes first.
fn skip_list(t: &mut Tokens) -> bool {
    loop {
        match t.peek() {
            Ok(Token::End) => return false,
            Ok(Token::Close(_)) => {
                let _ = t.next();
                return true;
            }
            Ok(Token::Word(r)) if DIRECTIVES.contains(&&t.text[r.clone()]) => return false,
            Ok(Token::Quoted(r)) if t.text[r.clone()].split_ascii_whitespace().next().and_then(Type::named).is_some() => {
                return true;
            }
            _ => drop(t.next()),
        }
    }
}

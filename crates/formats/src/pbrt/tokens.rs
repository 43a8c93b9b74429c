//! Words of a text: directives, quoted strings, brackets, numbers. Nothing is copied but what is kept.

use super::values::{Numbers, Values};
use std::ops::Range;

/// Strings and words beyond this many bytes are refused; a name or a path is far shorter.
const LONGEST_STRING: usize = 1 << 14;
/// Numbers beyond this many bytes are refused.
const LONGEST_NUMBER: usize = 256;

/// The text and how far it is read.
pub(super) struct Tokens<'t> {
    pub text: &'t str,
    bytes: &'t [u8],
    pub at: usize,
}

/// What comes next; ranges are bytes of the text.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Token {
    /// A word without quotes: a directive, a number, a truth value.
    Word(Range<usize>),
    /// A quoted string: what stands within the quotes.
    Quoted(Range<usize>),
    /// `[`, and its place.
    Open(usize),
    /// `]`, and its place.
    Close(usize),
    /// The end of the text.
    End,
}

/// A mistake in the words themselves.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Mistake {
    pub range: Range<usize>,
    pub message: String,
}

fn mistake<T>(range: Range<usize>, message: impl Into<String>) -> Result<T, Mistake> {
    Err(Mistake { range, message: message.into() })
}

/// Whether a word ends before this byte.
#[inline]
fn ends_word(b: u8) -> bool {
    matches!(b, b' ' | b'\n' | b'\t' | b'\r' | b'"' | b'[' | b']' | b'#')
}

impl<'t> Tokens<'t> {
    pub fn new(text: &'t str) -> Self {
        Self { text, bytes: text.as_bytes(), at: 0 }
    }

    /// To the next byte that is neither blank nor in a comment.
    #[inline]
    fn skip(&mut self) {
        while let Some(&b) = self.bytes.get(self.at) {
            match b {
                b' ' | b'\n' | b'\t' | b'\r' => self.at += 1,
                b'#' => {
                    let rest = &self.bytes[self.at..];
                    self.at = memchr::memchr(b'\n', rest).map_or(self.bytes.len(), |i| self.at + i + 1);
                }
                _ => break,
            }
        }
    }

    /// The next token.
    pub fn next(&mut self) -> Result<Token, Mistake> {
        self.skip();
        let start = self.at;
        let Some(&b) = self.bytes.get(start) else { return Ok(Token::End) };
        match b {
            b'[' => {
                self.at += 1;
                Ok(Token::Open(start))
            }
            b']' => {
                self.at += 1;
                Ok(Token::Close(start))
            }
            b'"' => self.quoted(),
            _ => {
                let length = self.bytes[start..].iter().position(|&b| ends_word(b)).unwrap_or(self.bytes.len() - start);
                self.at = start + length;
                if length > LONGEST_STRING {
                    return mistake(start..start + 40, format!("a word of {length} bytes; none is longer than {LONGEST_STRING}"));
                }
                Ok(Token::Word(start..self.at))
            }
        }
    }

    /// The next token, which stays.
    pub fn peek(&mut self) -> Result<Token, Mistake> {
        self.skip();
        let at = self.at;
        let token = self.next();
        self.at = at;
        token
    }

    fn quoted(&mut self) -> Result<Token, Mistake> {
        let start = self.at + 1;
        let mut end = start;
        loop {
            let found = memchr::memchr3(b'"', b'\n', b'\\', &self.bytes[end..]);
            match found.map(|i| (end + i, self.bytes[end + i])) {
                Some((i, b'"')) if i - start <= LONGEST_STRING => {
                    self.at = i + 1;
                    return Ok(Token::Quoted(start..i));
                }
                Some((i, b'"')) => {
                    self.at = i + 1;
                    let text = format!("a string of {} bytes; none is longer than {LONGEST_STRING}", i - start);
                    return mistake(start - 1..start + 40, text);
                }
                Some((i, b'\\')) => end = (i + 2).min(self.bytes.len()),
                other => {
                    // Read on behind the line, where the next directive may begin.
                    let i = other.map_or(self.bytes.len(), |(i, _)| i);
                    self.at = i;
                    return mistake(start - 1..i.min(start + 40), "this string is missing its closing quote");
                }
            }
        }
    }

    /// Fills `values` up to the closing bracket, or with one value where there is no bracket; the answer is where they stand.
    pub fn values(&mut self, values: &mut Values) -> Result<Range<usize>, Mistake> {
        match self.peek()? {
            Token::Open(start) => {
                self.at = start + 1;
                match values {
                    Values::Singles(list) => self.numbers(list)?,
                    Values::Doubles(list) => self.numbers(list)?,
                    Values::Integers(list) => self.numbers(list)?,
                    Values::Bools(_) | Values::Texts(_) => loop {
                        if let Token::Close(at) = self.peek()? {
                            self.at = at + 1;
                            break;
                        }
                        self.single(values)?;
                    },
                }
                Ok(start..self.at)
            }
            Token::Word(r) | Token::Quoted(r) => {
                self.single(values)?;
                Ok(r.start..self.at)
            }
            Token::Close(at) => mistake(at..at + 1, "a value must stand here"),
            Token::End => mistake(self.bytes.len()..self.bytes.len(), "the file ends where a value must stand"),
        }
    }

    /// One value.
    fn single(&mut self, values: &mut Values) -> Result<(), Mistake> {
        let token = self.next()?;
        match (values, token) {
            (Values::Singles(list), Token::Word(r)) => self.number_in(r, list),
            (Values::Doubles(list), Token::Word(r)) => self.number_in(r, list),
            (Values::Integers(list), Token::Word(r)) => self.number_in(r, list),
            (Values::Bools(list), Token::Word(r) | Token::Quoted(r)) => match &self.text[r.clone()] {
                "true" => {
                    list.push(true);
                    Ok(())
                }
                "false" => {
                    list.push(false);
                    Ok(())
                }
                word => mistake(r, format!("`{}` is no truth value, expected true or false", shortened(word))),
            },
            (Values::Texts(list), Token::Quoted(r)) => {
                let text = unescaped(&self.text[r.clone()]).map_err(|message| Mistake { range: r.clone(), message })?;
                list.push((text, r));
                Ok(())
            }
            (Values::Texts(_), Token::Word(r)) => {
                let word = shortened(&self.text[r.clone()]);
                mistake(r, format!("`{word}` stands where a string must, in quotes"))
            }
            (_, Token::Quoted(r)) => {
                let word = shortened(&self.text[r.clone()]);
                mistake(r, format!("the string \"{word}\" stands where a number must"))
            }
            (_, Token::Open(at)) => mistake(at..at + 1, "brackets cannot stand within brackets"),
            (_, Token::Close(at)) => mistake(at..at + 1, "a value must stand here"),
            (_, Token::End) => mistake(self.bytes.len()..self.bytes.len(), "the file ends where a value must stand"),
        }
    }

    fn number_in<N: Numbers>(&self, range: Range<usize>, list: &mut Vec<N>) -> Result<(), Mistake> {
        match N::parse(&self.bytes[range.clone()]) {
            Some((x, length)) if length == range.len() && x.is_sane() => {
                list.push(x);
                Ok(())
            }
            _ => self.no_number::<N>(range),
        }
    }

    fn no_number<N: Numbers>(&self, range: Range<usize>) -> Result<(), Mistake> {
        let word = &self.text[range.clone()];
        if word.len() > LONGEST_NUMBER {
            return mistake(range.start..range.start + 40, format!("a number of {} bytes", word.len()));
        }
        match word.parse::<f64>() {
            Ok(x) if !x.is_finite() || !(x as f32).is_finite() => mistake(range, format!("`{word}` is not finite")),
            Ok(_) => mistake(range, format!("`{word}` is no {}", N::WHAT)),
            Err(_) => mistake(range, format!("`{}` is no {}", shortened(word), N::WHAT)),
        }
    }

    /// Numbers up to the closing bracket: where the bytes of a scene are.
    fn numbers<N: Numbers>(&mut self, list: &mut Vec<N>) -> Result<(), Mistake> {
        loop {
            self.skip();
            let rest = &self.bytes[self.at..];
            match rest.first() {
                Some(b']') => {
                    self.at += 1;
                    return Ok(());
                }
                None => return mistake(self.bytes.len()..self.bytes.len(), "this list is missing its closing bracket"),
                _ => {}
            }
            match N::parse(&rest[..rest.len().min(LONGEST_NUMBER + 1)]) {
                Some((x, length)) if rest.get(length).is_none_or(|&b| ends_word(b)) && x.is_sane() && length <= LONGEST_NUMBER => {
                    list.push(x);
                    self.at += length;
                }
                _ => {
                    // The word as a whole, for its message.
                    return match self.next()? {
                        Token::Word(r) if self.text[r.clone()].starts_with(|c: char| c.is_ascii_uppercase()) => {
                            self.at = r.start;
                            mistake(r, "this list is missing its closing bracket before here")
                        }
                        Token::Word(r) => self.no_number::<N>(r),
                        Token::Quoted(r) => {
                            let word = shortened(&self.text[r.clone()]);
                            mistake(r, format!("the string \"{word}\" stands where a number must"))
                        }
                        _ => mistake(self.at - 1..self.at, "brackets cannot stand within brackets"),
                    };
                }
            }
        }
    }
}

/// A word short enough for a message.
pub(super) fn shortened(word: &str) -> String {
    const LONGEST: usize = 60;
    if word.chars().count() <= LONGEST {
        return word.to_owned();
    }
    word.chars().take(LONGEST).chain("...".chars()).collect()
}

/// A string with its escapes resolved.
pub(super) fn unescaped(text: &str) -> Result<String, String> {
    if !text.contains('\\') {
        return Ok(text.to_owned());
    }
    let mut out = String::with_capacity(text.len());
    let mut chars = text.chars();
    while let Some(c) = chars.next() {
        if c != '\\' {
            out.push(c);
            continue;
        }
        out.push(match chars.next() {
            Some('n') => '\n',
            Some('t') => '\t',
            Some('r') => '\r',
            Some('b') => '\u{8}',
            Some('f') => '\u{c}',
            Some(c @ ('\\' | '"' | '\'')) => c,
            Some(c) => return Err(format!("`\\{c}` is no escape; a backslash is written `\\\\`")),
            None => return Err("a backslash cannot stand last".to_owned()),
        });
    }
    Ok(out)
}

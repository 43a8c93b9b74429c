//! `<default>`, `-D` and `$name`.
//!
//! A `$` in an attribute is replaced by the value of the parameter whose name follows: the longest one that fits, so that `$spp2` means
//! `spp2` if there is one, and else `spp` followed by a 2. `\$` is a dollar.

use super::text::{Text, shortened};
use etendue_description::{Diagnostics, Span, nearest};

/// A value may grow to this many bytes; parameters made of parameters could fill any memory.
const LONGEST: usize = 1 << 20;

/// The parameters known so far.
#[derive(Default)]
pub(super) struct Parameters {
    list: Vec<Parameter>,
}

struct Parameter {
    name: String,
    value: String,
    /// From the command line, or a `<default>`.
    given: bool,
    /// Whether a `<default>` or a `$` names it.
    known: bool,
}

impl Parameters {
    /// Those of the command line; the latter of two counts.
    pub fn new(defines: &[(String, String)]) -> Self {
        let mut out = Self::default();
        for (name, value) in defines {
            out.list.retain(|p| p.name != *name);
            out.list.push(Parameter { name: name.clone(), value: value.clone(), given: true, known: false });
        }
        out
    }

    /// A `<default>`: counts where nothing was given before.
    pub fn set_default(&mut self, name: String, value: String) {
        match self.list.iter_mut().find(|p| p.name == name) {
            Some(parameter) => parameter.known = true,
            None => self.list.push(Parameter { name, value, given: false, known: true }),
        }
    }

    /// Puts the parameters into a text; false if one is not known.
    pub fn substitute(&mut self, text: &mut Text, diagnostics: &mut Diagnostics) -> bool {
        if !text.value.contains('$') {
            return true;
        }
        let written = std::mem::take(&mut text.value);
        let mut out = String::new();
        let mut sound = true;
        let mut at = 0;
        while let Some(i) = written[at..].find('$').map(|i| at + i).filter(|_| out.len() <= LONGEST) {
            if written[at..i].ends_with('\\') {
                out.push_str(&written[at..i - 1]);
                out.push('$');
                at = i + 1;
                continue;
            }
            out.push_str(&written[at..i]);
            let rest = &written[i + 1..];
            let fits = self
                .list
                .iter_mut()
                .filter(|p| !p.name.is_empty() && rest.starts_with(p.name.as_str()))
                .max_by_key(|p| p.name.len());
            match fits {
                Some(parameter) => {
                    parameter.known = true;
                    out.push_str(&parameter.value);
                    let giver = if parameter.given { "-D" } else { "<default>" };
                    text.origins.push(format!("`${}` is `{}` here, by {giver}", parameter.name, shortened(&parameter.value)));
                    at = i + 1 + parameter.name.len();
                }
                None => {
                    let end = rest.find(|c: char| !(c.is_alphanumeric() || c == '_')).unwrap_or(rest.len());
                    self.undefined(&rest[..end], text.place(i..i + 1 + end), diagnostics);
                    sound = false;
                    at = i + 1 + end;
                }
            }
        }
        out.push_str(&written[at..]);
        if out.len() > LONGEST {
            diagnostics.error(text.span, format!("with its parameters put in, this value has more than {LONGEST} bytes"));
            return false;
        }
        text.value = out;
        text.exact = false;
        sound
    }

    fn undefined(&self, name: &str, span: Span, diagnostics: &mut Diagnostics) {
        let error = diagnostics.error(span, format!("parameter `${name}` is not defined here"));
        if let Some(near) = nearest(name, self.names()) {
            error.help(format!("did you mean `${near}`?"));
        } else if name.is_empty() {
            error.help("a dollar as such is written `\\$`");
        } else {
            error.help(format!(
                "define it before with <default name=\"{name}\" value=\"...\"/>, or on the command line with -D {name}=..."
            ));
        }
    }

    fn names(&self) -> impl Iterator<Item = &str> {
        self.list.iter().filter(|p| p.known).map(|p| p.name.as_str())
    }

    /// Reports what was given on the command line and is named nowhere.
    pub fn finish(&self, diagnostics: &mut Diagnostics) {
        for parameter in self.list.iter().filter(|p| p.given && !p.known) {
            let name = &parameter.name;
            let error = diagnostics.error(None, format!("`-D {name}={}`: the scene has no parameter `{name}`", parameter.value));
            match nearest(name, self.names()) {
                Some(near) => error.help(format!("did you mean `{near}`?")),
                None => {
                    let names: Vec<&str> = self.names().collect();
                    let known = if names.is_empty() { "none".to_owned() } else { names.join(", ") };
                    error.help(format!("the scene's parameters: {known}"))
                }
            };
        }
    }
}

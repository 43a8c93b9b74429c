//! Enums whose variants users choose by name.

/// An enum whose variants have names and a line of help: listed once.
macro_rules! choices {
    ($(#[$about:meta])* $type:ident { $($(#[$default:meta])* $variant:ident = $name:literal, $help:literal;)+ }) => {
        $(#[$about])*
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
        pub enum $type {
            $($(#[$default])* #[doc = $help] $variant,)+
        }

        impl $type {
            /// All, in the order of the variants.
            pub const ALL: &'static [Self] = &[$(Self::$variant),+];
            /// Their names, as users write them.
            pub const NAMES: &'static [&'static str] = &[$($name),+];

            /// The one of a place in [`Self::NAMES`]; the last for one beyond.
            pub fn nth(i: usize) -> Self {
                Self::ALL[i.min(Self::ALL.len() - 1)]
            }

            /// The one of a name.
            pub fn named(name: &str) -> Option<Self> {
                Self::NAMES.iter().position(|n| *n == name).map(Self::nth)
            }

            /// As users write it.
            pub fn name(self) -> &'static str {
                Self::NAMES[self as usize]
            }

            /// What it is, in a line.
            pub fn help(self) -> &'static str {
                [$($help),+][self as usize]
            }
        }
    };
}

pub(crate) use choices;

//! Enumerations whose values are words: in options, files and messages.

use std::fmt;

/// Gives an enumeration its words: `ALL`, `WORDS`, `name`, `Display`, and `FromStr` with [`UnknownWord`]. A value that
/// holds another is written with it, as in `OpenLoop(Weighting::Cva) = "cva"`.
#[macro_export]
macro_rules! words {
    ($name:ident { $($value:ident $(($inner:path))? = $word:literal),+ $(,)? }) => {
        impl $name {
            /// All of them.
            pub const ALL: [Self; [$($word),+].len()] = [$(Self::$value $(($inner))?),+];

            /// Their words with `|` between them.
            pub const WORDS: &'static str = $crate::words!(@joined $($word),+);

            /// The word in options, files and messages.
            #[must_use]
            pub fn name(self) -> &'static str {
                match self {
                    $(Self::$value $(($inner))? => $word,)+
                }
            }
        }

        impl ::std::fmt::Display for $name {
            fn fmt(&self, f: &mut ::std::fmt::Formatter<'_>) -> ::std::fmt::Result {
                f.write_str(self.name())
            }
        }

        impl ::std::str::FromStr for $name {
            type Err = $crate::UnknownWord;

            fn from_str(text: &str) -> Result<Self, Self::Err> {
                let unknown = || $crate::UnknownWord::new(&[$($word),+]);
                Self::ALL.into_iter().find(|value| value.name() == text).ok_or_else(unknown)
            }
        }
    };
    (@joined $first:literal $(, $word:literal)*) => {
        concat!($first $(, "|", $word)*)
    };
}

/// A text that is none of the words of an enumeration.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct UnknownWord {
    words: Vec<&'static str>,
}

impl UnknownWord {
    /// Of these words.
    #[must_use]
    pub fn new(words: &[&'static str]) -> Self {
        Self { words: words.to_vec() }
    }

    /// With another word before these.
    #[must_use]
    pub fn or(mut self, word: &'static str) -> Self {
        self.words.insert(0, word);
        self
    }

    /// The words that it may be, as [`alternatives`].
    #[must_use]
    pub fn expected(&self) -> String {
        alternatives(&self.words)
    }
}

/// Words as `a, b or c`.
#[must_use]
pub fn alternatives<W: AsRef<str>>(words: &[W]) -> String {
    let words: Vec<&str> = words.iter().map(AsRef::as_ref).collect();
    match words.split_last() {
        Some((last, [])) => (*last).into(),
        Some((last, first)) => format!("{} or {last}", first.join(", ")),
        None => "nothing".into(),
    }
}

impl fmt::Display for UnknownWord {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "expected {}", self.expected())
    }
}

impl std::error::Error for UnknownWord {}

#[cfg(test)]
mod tests {
    use crate::Intersample;

    #[test]
    fn words_are_read_and_an_unknown_one_lists_them() {
        for behaviour in Intersample::ALL {
            assert_eq!(behaviour.to_string().parse(), Ok(behaviour));
        }
        assert_eq!(Intersample::WORDS, "zoh|foh|bl");
        let unknown = "Zoh".parse::<Intersample>().unwrap_err();
        assert_eq!(unknown.to_string(), "expected zoh, foh or bl");
        assert_eq!(unknown.or("auto").expected(), "auto, zoh, foh or bl");
    }
}

//! The types of settings: from text, and to the typed value of a manifest.

use holo_core::{GridSize, ParseGridSizeError};
use holo_io::ManifestValue;

/// A text that is no value of a setting: the message says what is accepted.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct Malformed(String);

impl<T: Into<String>> From<T> for Malformed {
    fn from(message: T) -> Self {
        Self(message.into())
    }
}

/// What a setting holds.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub enum Kind {
    /// Yes or no; a command line gives its name alone.
    Flag,
    /// An integer.
    Integer,
    /// A number.
    Number,
    /// Any text.
    Text,
    /// Rows and columns; in text `COLUMNSxROWS`, or one number for both.
    Size,
    /// One of some words.
    Word(&'static [Word]),
    /// A list of some words.
    Words(&'static [Word]),
    /// A smaller and a larger number; in text `MIN,MAX`.
    Range,
    /// Another value: the text in the form of the setting, or the type in Python that becomes such a text.
    Other(&'static str),
}

/// A word that a setting takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Word {
    /// The word.
    pub name: &'static str,
    /// What it means.
    pub help: &'static str,
}

/// The type of a setting.
pub trait SettingType: Sized {
    /// What it holds.
    const KIND: Kind;

    /// Parses a value. The error says what is accepted.
    ///
    /// # Errors
    /// A message for any other text.
    fn parse(text: &str) -> Result<Self, Malformed>;

    /// Returns the typed value for a manifest, from whose text the same value is parsed.
    fn value(&self) -> ManifestValue;
}

impl Kind {
    /// What is accepted, for messages.
    pub(super) fn expected(self) -> String {
        match self {
            Self::Flag => "give true or false".into(),
            Self::Integer => "give an integer".into(),
            Self::Number => "give a number".into(),
            Self::Size => ParseGridSizeError.to_string(),
            Self::Range => "write MIN,MAX, such as -2,2.5, the smaller first".into(),
            Self::Word(words) | Self::Words(words) => {
                let names: Vec<&str> = words.iter().map(|word| word.name).collect();
                format!("give one of {}", names.join(", "))
            }
            Self::Text | Self::Other(_) => "not a valid value".into(),
        }
    }
}

/// Returns the text from which the value of a setting is parsed; `None` for a missing value.
pub(crate) fn text(value: &ManifestValue) -> Option<String> {
    Some(match value {
        ManifestValue::Bool(flag) => flag.to_string(),
        ManifestValue::Integer(number) => number.to_string(),
        ManifestValue::Float(number) => number.to_string(),
        ManifestValue::Text(text) => text.clone(),
        ManifestValue::List(values) => values.iter().map(text).collect::<Option<Vec<_>>>()?.join(","),
        ManifestValue::Table(size) => format!("{}x{}", text(size.get("columns")?)?, text(size.get("rows")?)?),
        _ => return None,
    })
}

/// Parses a finite number above 0.
///
/// # Errors
/// A message with the accepted values, for any other text.
pub fn positive(text: &str) -> Result<f64, Malformed> {
    text.parse().ok().filter(|x: &f64| *x > 0.0 && x.is_finite()).ok_or_else(|| "give a number above 0".into())
}

/// Parses a finite number that is not negative.
///
/// # Errors
/// A message with the accepted values, for any other text.
pub fn not_negative(text: &str) -> Result<f64, Malformed> {
    text.parse().ok().filter(|x: &f64| *x >= 0.0 && x.is_finite()).ok_or_else(|| "give a number from 0 up".into())
}

/// Parses a share: a number above 0, or a percentage such as `2%`.
///
/// # Errors
/// A message with the accepted values, for any other text.
pub fn share(text: &str) -> Result<f64, Malformed> {
    let parsed = match text.strip_suffix('%') {
        Some(percent) => positive(percent.trim_end()).map(|percent| percent / 100.0),
        None => positive(text),
    };
    parsed.map_err(|_| "give a share above 0, such as 0.02 or 2%".into())
}

/// Parses a range `MIN,MAX` of finite numbers, the smaller first.
///
/// # Errors
/// A message with the accepted values, for any other text.
pub fn range(text: &str) -> Result<(f64, f64), Malformed> {
    SettingType::parse(text)
}

macro_rules! integers {
    ($($type:ty),*) => {$(
        impl SettingType for $type {
            const KIND: Kind = Kind::Integer;

            fn parse(text: &str) -> Result<Self, Malformed> {
                text.parse().map_err(|_| format!("give an integer from 0 to {}", Self::MAX).into())
            }

            fn value(&self) -> ManifestValue {
                // JSON has no larger integers than i64 here; a text keeps them.
                i64::try_from(*self).map_or_else(|_| self.to_string().into(), ManifestValue::Integer)
            }
        }
    )*};
}

integers!(u8, u32, u64);

impl SettingType for bool {
    const KIND: Kind = Kind::Flag;

    fn parse(text: &str) -> Result<Self, Malformed> {
        text.parse().map_err(|_| Self::KIND.expected().into())
    }

    fn value(&self) -> ManifestValue {
        (*self).into()
    }
}

impl SettingType for f64 {
    const KIND: Kind = Kind::Number;

    fn parse(text: &str) -> Result<Self, Malformed> {
        text.parse().ok().filter(|x: &Self| x.is_finite()).ok_or_else(|| Self::KIND.expected().into())
    }

    fn value(&self) -> ManifestValue {
        (*self).into()
    }
}

impl SettingType for String {
    const KIND: Kind = Kind::Text;

    fn parse(text: &str) -> Result<Self, Malformed> {
        Ok(text.to_owned())
    }

    fn value(&self) -> ManifestValue {
        self.as_str().into()
    }
}

impl SettingType for GridSize {
    const KIND: Kind = Kind::Size;

    fn parse(text: &str) -> Result<Self, Malformed> {
        text.parse().map_err(|why: ParseGridSizeError| why.to_string().into())
    }

    fn value(&self) -> ManifestValue {
        (*self).into()
    }
}

impl SettingType for (f64, f64) {
    const KIND: Kind = Kind::Range;

    fn parse(text: &str) -> Result<Self, Malformed> {
        let ends = text.split_once(',').and_then(|(min, max)| Some((f64::parse(min).ok()?, f64::parse(max).ok()?)));
        ends.filter(|(min, max)| min < max).ok_or_else(|| Self::KIND.expected().into())
    }

    fn value(&self) -> ManifestValue {
        vec![self.0, self.1].into()
    }
}

/// A list of words in any order, each once.
impl<T: SettingType + Ord> SettingType for Vec<T> {
    const KIND: Kind = match T::KIND {
        Kind::Word(words) => Kind::Words(words),
        other => other,
    };

    fn parse(text: &str) -> Result<Self, Malformed> {
        text.split(',').filter(|part| !part.is_empty()).map(|part| T::parse(part.trim())).collect()
    }

    /// In the order of the type, so that equal sets have equal values.
    fn value(&self) -> ManifestValue {
        let mut sorted: Vec<&T> = self.iter().collect();
        sorted.sort_unstable();
        sorted.dedup();
        match sorted.is_empty() {
            true => ManifestValue::None,
            false => ManifestValue::List(sorted.into_iter().map(T::value).collect()),
        }
    }
}

//! Typed access to untrusted JSON: every wrong type, range or index is an error with its JSON path.

use std::ops::RangeInclusive;

use serde_json::{Map, Value};

use crate::Error;

/// 2^53: f64 does not represent all larger integers.
const LARGEST_EXACT_INTEGER: f64 = 9_007_199_254_740_992.0;

/// The error for a violation of the rules of glTF.
pub(super) fn bad(at: impl Into<String>, what: impl Into<String>) -> Error {
    Error::BadFile { at: at.into(), what: what.into() }
}

/// The error for an unsupported feature.
pub(super) fn unsupported(at: impl Into<String>, what: impl Into<String>) -> Error {
    Error::Unsupported { at: at.into(), what: what.into() }
}

/// A JSON object with its path in the file.
#[derive(Clone, Debug)]
pub(super) struct Object<'a> {
    map: &'a Map<String, Value>,
    at: String,
}

impl<'a> Object<'a> {
    /// The whole file.
    pub(super) fn root(value: &'a Value) -> Result<Self, Error> {
        Self::new(value, String::new())
    }

    fn new(value: &'a Value, at: String) -> Result<Self, Error> {
        match value {
            Value::Object(map) => Ok(Self { map, at }),
            _ if at.is_empty() => Err(bad("glTF", "the JSON is not an object")),
            _ => Err(bad(at, "must be a JSON object")),
        }
    }

    /// The object's own path, such as `nodes[3]`.
    pub(super) fn path(&self) -> &str {
        &self.at
    }

    /// The path of a field.
    pub(super) fn at(&self, key: &str) -> String {
        if self.at.is_empty() { key.to_owned() } else { format!("{}.{key}", self.at) }
    }

    pub(super) fn has(&self, key: &str) -> bool {
        self.map.contains_key(key)
    }

    /// Calls `visit` with every field.
    pub(super) fn each(&self, mut visit: impl FnMut(&'a str, &'a Value)) {
        self.map.iter().for_each(|(key, value)| visit(key, value));
    }

    /// The error for a missing field.
    pub(super) fn missing(&self, key: &str) -> Error {
        bad(self.at(key), "is missing")
    }

    pub(super) fn object(&self, key: &str) -> Result<Option<Object<'a>>, Error> {
        self.map.get(key).map(|value| Self::new(value, self.at(key))).transpose()
    }

    /// The object of an extension.
    pub(super) fn extension(&self, name: &str) -> Result<Option<Object<'a>>, Error> {
        Ok(match self.object("extensions")? {
            Some(extensions) => extensions.object(name)?,
            None => None,
        })
    }

    /// A list; a missing one is empty.
    pub(super) fn list(&self, key: &str) -> Result<&'a [Value], Error> {
        match self.map.get(key) {
            None => Ok(&[]),
            Some(Value::Array(list)) => Ok(list),
            Some(_) => Err(bad(self.at(key), "must be a JSON array")),
        }
    }

    /// A list of objects; a missing one is empty.
    pub(super) fn objects(&self, key: &str) -> Result<Vec<Object<'a>>, Error> {
        let list = self.list(key)?;
        list.iter().enumerate().map(|(k, value)| Self::new(value, format!("{}[{k}]", self.at(key)))).collect()
    }

    /// An entry of a list of objects.
    pub(super) fn object_at(&self, key: &str, k: usize) -> Result<Option<Object<'a>>, Error> {
        self.list(key)?.get(k).map(|value| Self::new(value, format!("{}[{k}]", self.at(key)))).transpose()
    }

    pub(super) fn string(&self, key: &str) -> Result<Option<&'a str>, Error> {
        match self.map.get(key) {
            None => Ok(None),
            Some(Value::String(text)) => Ok(Some(text)),
            Some(_) => Err(bad(self.at(key), "must be a string")),
        }
    }

    /// The name of the object; empty if it has none.
    pub(super) fn name(&self) -> Result<&'a str, Error> {
        Ok(self.string("name")?.unwrap_or_default())
    }

    pub(super) fn boolean(&self, key: &str) -> Result<Option<bool>, Error> {
        match self.map.get(key) {
            None => Ok(None),
            Some(Value::Bool(value)) => Ok(Some(*value)),
            Some(_) => Err(bad(self.at(key), "must be true or false")),
        }
    }

    /// A non-negative integer; `3.0` is accepted, because some exporters write it.
    pub(super) fn unsigned(&self, key: &str) -> Result<Option<u64>, Error> {
        let Some(value) = self.map.get(key) else { return Ok(None) };
        unsigned(value).map(Some).ok_or_else(|| bad(self.at(key), "must be a non-negative integer"))
    }

    /// An index into a list of `length` entries.
    pub(super) fn index(&self, key: &str, list: &str, length: usize) -> Result<Option<usize>, Error> {
        let Some(value) = self.map.get(key) else { return Ok(None) };
        index(value, || self.at(key), list, length).map(Some)
    }

    /// A list of indices into a list of `length` entries; a missing one is empty.
    pub(super) fn indices(&self, key: &str, list: &str, length: usize) -> Result<Vec<usize>, Error> {
        let values = self.list(key)?.iter().enumerate();
        values.map(|(k, value)| index(value, || format!("{}[{k}]", self.at(key)), list, length)).collect()
    }

    pub(super) fn number(&self, key: &str) -> Result<Option<f64>, Error> {
        let Some(value) = self.map.get(key) else { return Ok(None) };
        value.as_f64().map(Some).ok_or_else(|| bad(self.at(key), "must be a number"))
    }

    /// A number within a range, as f32.
    pub(super) fn within(&self, key: &str, range: RangeInclusive<f32>) -> Result<Option<f32>, Error> {
        let Some(x) = self.number(key)? else { return Ok(None) };
        single(x, &range).map(Some).ok_or_else(|| bad(self.at(key), outside(&x, &range)))
    }

    /// Exactly `N` numbers within a range, as f32.
    pub(super) fn all_within<const N: usize>(
        &self,
        key: &str,
        range: RangeInclusive<f32>,
    ) -> Result<Option<[f32; N]>, Error> {
        let Some(numbers) = self.numbers::<N>(key)? else { return Ok(None) };
        let mut singles = [0.0; N];
        for (out, x) in singles.iter_mut().zip(numbers) {
            *out = single(x, &range).ok_or_else(|| bad(self.at(key), outside(&numbers, &range)))?;
        }
        Ok(Some(singles))
    }

    /// The application-specific `extras`; `None` if they are not an object.
    pub(super) fn extras(&self) -> Result<Option<Object<'a>>, Error> {
        if matches!(self.map.get("extras"), Some(Value::Object(_))) { self.object("extras") } else { Ok(None) }
    }

    /// Exactly `N` numbers.
    pub(super) fn numbers<const N: usize>(&self, key: &str) -> Result<Option<[f64; N]>, Error> {
        if !self.has(key) {
            return Ok(None);
        }
        let list = self.list(key)?;
        if list.len() != N {
            return Err(bad(self.at(key), format!("has {} numbers instead of {N}", list.len())));
        }
        let mut numbers = [0.0; N];
        for (k, (number, value)) in numbers.iter_mut().zip(list).enumerate() {
            *number = value.as_f64().ok_or_else(|| bad(format!("{}[{k}]", self.at(key)), "must be a number"))?;
        }
        Ok(Some(numbers))
    }
}

/// Rounding is monotonic, so a number within the range stays within it as f32.
fn single(x: f64, range: &RangeInclusive<f32>) -> Option<f32> {
    (f64::from(*range.start())..=f64::from(*range.end())).contains(&x).then_some(x as f32)
}

fn outside(is: &dyn std::fmt::Debug, range: &RangeInclusive<f32>) -> String {
    let bound = |x: f32| if x.abs() > 1e6 { format!("{x:e}") } else { x.to_string() };
    format!("is {is:?}; it must lie between {} and {}", bound(*range.start()), bound(*range.end()))
}

fn unsigned(value: &Value) -> Option<u64> {
    value.as_u64().or_else(|| {
        let number = value.as_f64()?;
        let exact = number.fract() == 0.0 && (0.0..LARGEST_EXACT_INTEGER).contains(&number);
        exact.then_some(number as u64)
    })
}

fn index(value: &Value, at: impl Fn() -> String, list: &str, length: usize) -> Result<usize, Error> {
    let index = unsigned(value).ok_or_else(|| bad(at(), format!("must be an index into {list}")))?;
    match usize::try_from(index) {
        Ok(index) if index < length => Ok(index),
        _ => Err(bad(at(), format!("refers to {list}[{index}], but the file has {length} {list}"))),
    }
}

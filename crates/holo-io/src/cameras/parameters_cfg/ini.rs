//! Reader and writer of the INI dialect of Python's `configparser`, as far as `parameters.cfg` needs it.

use std::collections::BTreeMap;
use std::path::Path;

use crate::Error;

/// The values of a file by section and key, each with its line number.
pub(super) struct Ini<'a> {
    path: &'a Path,
    values: BTreeMap<(String, String), (usize, String)>,
}

impl<'a> Ini<'a> {
    pub(super) fn parse(text: &str, path: &'a Path) -> Result<Self, Error> {
        let mut ini = Self { path, values: BTreeMap::new() };
        let mut section = None;
        // The key that an indented line would continue.
        let mut current: Option<(String, String)> = None;
        let text = text.strip_prefix('\u{feff}').unwrap_or(text);
        for (index, line) in text.split(['\n', '\r']).enumerate() {
            // A line end of two characters counts as two lines, so line numbers are right for files with `\n` only.
            let number = index + 1;
            let clean: String = line.chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
            let content = clean.trim();
            if content.is_empty() || content.starts_with(['#', ';']) {
                continue;
            }
            if let Some((_, value)) =
                current.as_ref().filter(|_| clean.starts_with(' ')).and_then(|key| ini.values.get_mut(key))
            {
                if !value.is_empty() {
                    value.push(' ');
                }
                value.push_str(content);
                continue;
            }
            current = None;
            if let Some(rest) = content.strip_prefix('[') {
                let name = rest.split_once(']').map_or("", |(name, _)| name);
                if name.is_empty() {
                    return Err(ini.broken(number, "a section needs a name in square brackets"));
                }
                section = Some(name.to_owned());
                continue;
            }
            let Some((key, value)) = content.split_once('=') else {
                return Err(ini.broken(number, "neither a [section] nor key = value"));
            };
            let (key, value) = (key.trim().to_lowercase(), value.trim());
            let Some(section) = &section else {
                return Err(ini.broken(number, "a key before the first [section]"));
            };
            if key.is_empty() {
                return Err(ini.broken(number, "a value without a key"));
            }
            let name = (section.clone(), key);
            if ini.values.insert(name.clone(), (number, value.to_owned())).is_some() {
                return Err(ini.broken(number, &format!("the key {} occurs twice in [{}]", name.1, name.0)));
            }
            current = Some(name);
        }
        Ok(ini)
    }

    fn broken(&self, line: usize, what: &str) -> Error {
        Error::broken(self.path, "parameters.cfg", format!("line {line}: {what}"))
    }

    /// Removes and returns a text, with `%%` replaced by `%`.
    pub(super) fn text(&mut self, section: &str, key: &str) -> Option<String> {
        let (_, value) = self.values.remove(&(section.to_owned(), key.to_owned()))?;
        Some(value.replace("%%", "%"))
    }

    /// Removes and returns a number.
    pub(super) fn number(&mut self, section: &str, key: &str) -> Result<Option<f64>, Error> {
        self.parsed(section, key, "a number", |text| text.parse().ok())
    }

    /// Removes and returns an integer.
    pub(super) fn integer(&mut self, section: &str, key: &str) -> Result<Option<i64>, Error> {
        self.parsed(section, key, "a whole number", |text| text.parse().ok())
    }

    /// Removes and returns a count; `9.0` is accepted.
    pub(super) fn count(&mut self, section: &str, key: &str) -> Result<Option<u64>, Error> {
        self.parsed(section, key, "a whole number that is not negative", |text| {
            // Above 2^53 an `f64` no longer identifies a single integer.
            let from_float = |value: f64| {
                (value.fract() == 0.0 && (0.0..=9_007_199_254_740_992.0).contains(&value)).then_some(value as u64)
            };
            text.parse().ok().or_else(|| text.parse().ok().and_then(from_float))
        })
    }

    fn parsed<T>(
        &mut self,
        section: &str,
        key: &str,
        kind: &str,
        parse: impl Fn(&str) -> Option<T>,
    ) -> Result<Option<T>, Error> {
        match self.values.remove(&(section.to_owned(), key.to_owned())) {
            None => Ok(None),
            Some((line, value)) => match parse(&value) {
                Some(parsed) => Ok(Some(parsed)),
                None => Err(self.broken(line, &format!("{key} = {value:?} is not {kind}"))),
            },
        }
    }

    /// The error for a required key that is missing.
    pub(super) fn missing(&self, section: &str, key: &str) -> Error {
        Error::broken(self.path, "parameters.cfg", format!("[{section}] has no {key}"))
    }

    /// Returns the values that were not removed.
    pub(super) fn rest(self) -> BTreeMap<(String, String), String> {
        self.values.into_iter().map(|(name, (_, value))| (name, value.replace("%%", "%"))).collect()
    }
}

/// Writer of sections and keys, in the order of the calls.
pub(super) struct IniWriter<'a> {
    path: &'a Path,
    text: String,
    /// Offset of the current section in the text.
    section_start: usize,
}

impl<'a> IniWriter<'a> {
    pub(super) fn new(path: &'a Path) -> Self {
        Self { path, text: String::new(), section_start: 0 }
    }

    pub(super) fn section(&mut self, name: &str) -> Result<(), Error> {
        if name.is_empty() || name.contains(']') || name.contains(char::is_control) {
            return Err(Error::bad_input(self.path, format!("{name:?} cannot be the name of a section")));
        }
        self.section_start = self.text.len();
        self.text.push_str(&format!("[{name}]\n"));
        Ok(())
    }

    pub(super) fn end_section(&mut self) {
        self.text.push('\n');
    }

    pub(super) fn text(&mut self, key: &str, value: &str) -> Result<(), Error> {
        if value.contains(char::is_control) {
            return Err(Error::bad_input(
                self.path,
                format!("{key}: {value:?} has a control character, such as a line feed"),
            ));
        }
        // Python's reader interprets a single percent sign as the start of a reference to another key.
        self.text.push_str(&format!("{key} = {}\n", value.trim().replace('%', "%%")));
        Ok(())
    }

    pub(super) fn number(&mut self, key: &str, value: f64) {
        // The shortest text with a decimal point that parses to the same number, as Python writes it.
        self.text.push_str(&format!("{key} = {value:?}\n"));
    }

    pub(super) fn integer(&mut self, key: &str, value: impl std::fmt::Display) {
        self.text.push_str(&format!("{key} = {value}\n"));
    }

    /// Writes a key of [`ParametersCfg::other`](super::ParametersCfg::other), whose name is checked.
    pub(super) fn other(&mut self, key: &str, value: &str) -> Result<(), Error> {
        let plain = key == key.trim().to_lowercase()
            && !key.is_empty()
            && !key.starts_with(['#', ';', '['])
            && !key.contains('=')
            && !key.contains(char::is_control);
        if !plain {
            return Err(Error::bad_input(self.path, format!("{key:?} cannot be the name of a key")));
        }
        let written = self.text[self.section_start..].lines().filter_map(|line| line.split_once(" = "));
        if written.into_iter().any(|(written, _)| written == key) {
            return Err(Error::bad_input(self.path, format!("the key {key} is written already")));
        }
        self.text(key, value)
    }

    pub(super) fn finish(self) -> String {
        self.text
    }
}

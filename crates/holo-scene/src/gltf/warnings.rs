//! Warnings, one line per kind of warning.

/// Collects warnings during loading.
#[derive(Clone, Debug, Default)]
pub(super) struct Warnings {
    kinds: Vec<Kind>,
}

#[derive(Clone, Debug)]
struct Kind {
    text: String,
    first: String,
    count: usize,
}

impl Warnings {
    /// Adds an occurrence of the warning `text`; the location of the first one is kept.
    pub(super) fn note(&mut self, text: &str, place: impl FnOnce() -> String) {
        match self.kinds.iter_mut().find(|kind| kind.text == text) {
            Some(kind) => kind.count += 1,
            None => self.kinds.push(Kind { text: text.to_owned(), first: place(), count: 1 }),
        }
    }

    /// Appends the warnings of another part of the file.
    pub(super) fn append(&mut self, other: Self) {
        for kind in other.kinds {
            match self.kinds.iter_mut().find(|mine| mine.text == kind.text) {
                Some(mine) => mine.count += kind.count,
                None => self.kinds.push(kind),
            }
        }
    }

    /// The lines, in the order in which the warnings first occurred.
    pub(super) fn into_lines(self) -> Vec<String> {
        let line = |kind: Kind| match (kind.count, kind.first.is_empty()) {
            (_, true) => kind.text,
            (1, false) => format!("{}: {}", kind.first, kind.text),
            (n, false) => format!("{} and {} more: {}", kind.first, n - 1, kind.text),
        };
        self.kinds.into_iter().map(line).collect()
    }
}

//! Warnings, one line per kind of warning.

/// The kinds of warnings that are listed. Messages of decoders may differ from image to image.
const MAX_KINDS: usize = 200;
const MORE: &str = "further warnings are not listed";

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
        let text =
            if self.kinds.len() < MAX_KINDS || self.kinds.iter().any(|kind| kind.text == text) { text } else { MORE };
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_list_has_an_end() {
        let mut warnings = Warnings::default();
        for k in 0..10_000 {
            warnings.note(&format!("kind {k}"), || "place".into());
        }
        warnings.note("kind 7", String::new);
        let lines = warnings.into_lines();
        assert_eq!(lines.len(), MAX_KINDS + 1);
        assert_eq!(lines[7], "place and 1 more: kind 7");
        assert_eq!(lines[MAX_KINDS], format!("place and {} more: {MORE}", 10_000 - MAX_KINDS - 1));
    }
}

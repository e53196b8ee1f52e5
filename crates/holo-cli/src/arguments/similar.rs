//! The value that was meant, in the error of one that does not exist.

use clap::error::{ContextKind, ContextValue, ErrorKind};

/// Adds to the error of an unknown value the one that it resembles most, where clap has found none: `h5` for `hdf5`,
/// `shading-normal` for `normals`.
pub fn with_similar_value(mut error: clap::Error) -> clap::Error {
    if error.kind() == ErrorKind::InvalidValue
        && error.get(ContextKind::SuggestedValue).is_none()
        && let Some(ContextValue::String(given)) = error.get(ContextKind::InvalidValue)
        && let Some(ContextValue::Strings(valid)) = error.get(ContextKind::ValidValue)
        && let Some(similar) = most_similar(given, valid)
    {
        let similar = ContextValue::String(similar.to_owned());
        error.insert(ContextKind::SuggestedValue, similar);
    }
    error
}

/// The word that has the largest part of its letters in common with `given`, in their order: at least half of both.
fn most_similar<'a>(given: &str, valid: &'a [String]) -> Option<&'a str> {
    let part = |word: &str| 2.0 * common_letters(given, word) as f64 / (given.len() + word.len()).max(1) as f64;
    let parts = valid.iter().map(|word| (part(word), word.as_str())).filter(|(part, _)| *part >= 0.5);
    parts.max_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, word)| word)
}

/// The length of the longest common subsequence.
fn common_letters(a: &str, b: &str) -> usize {
    let mut lengths = vec![0; b.len() + 1];
    for x in a.bytes() {
        let mut diagonal = 0;
        for (k, y) in b.bytes().enumerate() {
            let above = lengths[k + 1];
            lengths[k + 1] = if x == y { diagonal + 1 } else { above.max(lengths[k]) };
            diagonal = above;
        }
    }
    lengths[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_similar_by_their_letters() {
        assert_eq!(common_letters("normals", "shading-normal"), 6);
        assert_eq!(common_letters("", "el"), 0);
        let valid = ["color", "depth", "geometric-normal", "shading-normal", "h5"].map(String::from);
        for (given, found) in [("hdf5", Some("h5")), ("normals", Some("shading-normal")), ("xyz", None), ("", None)] {
            assert_eq!(most_similar(given, &valid), found, "{given}");
        }
    }
}

//! URIs in a glTF file: data URIs, and relative paths below the folder of the file.

use std::path::PathBuf;

use super::json::{bad, unsupported};
use crate::Error;

/// The target of a URI.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Target {
    /// The bytes of a data URI.
    Data(Vec<u8>),
    /// A path relative to the folder of the glTF file, without `..`.
    File(PathBuf),
}

/// Decodes a data URI, or turns a relative URI into a safe relative path. `at` is the JSON path of the URI.
///
/// # Errors
/// Network and absolute addresses, paths that leave the folder, broken base64.
pub(super) fn resolve(uri: &str, at: &str) -> Result<Target, Error> {
    match scheme(uri) {
        Some(scheme) if scheme.eq_ignore_ascii_case("data") => data(uri, at).map(Target::Data),
        Some(_) => {
            let what = format!("the address '{}' (copy what it points to next to the glTF file)", shorten(uri));
            Err(unsupported(at, what))
        }
        None => relative_path(uri, at).map(Target::File),
    }
}

/// The scheme of an absolute URI. `C:` counts as one, too, so drive letters are rejected with it.
fn scheme(uri: &str) -> Option<&str> {
    let (scheme, _) = uri.split_once(':')?;
    let mut letters = scheme.bytes();
    let first = letters.next()?;
    let rest = letters.all(|b| b.is_ascii_alphanumeric() || b"+-.".contains(&b));
    (first.is_ascii_alphabetic() && rest).then_some(scheme)
}

fn relative_path(uri: &str, at: &str) -> Result<PathBuf, Error> {
    let refuse = |why: &str| Err(bad(at, format!("the path '{}' {why}", shorten(uri))));
    let Ok(path) = String::from_utf8(percent_decode(uri)) else { return refuse("is not UTF-8") };
    if path.contains('\0') {
        return refuse("contains a NUL");
    }
    // Backslashes separate folders on Windows; they are treated so on all systems, so that a file is equally safe
    // everywhere.
    if path.starts_with(['/', '\\']) || scheme(&path).is_some() {
        return refuse("is absolute; only files below the folder of the glTF file are read");
    }
    let mut parts: Vec<&str> = Vec::new();
    for part in path.split(['/', '\\']) {
        match part {
            "" | "." => {}
            ".." if parts.pop().is_none() => {
                return refuse("leads out of the folder of the glTF file; copy the file below that folder");
            }
            ".." => {}
            name => parts.push(name),
        }
    }
    if parts.is_empty() {
        return refuse("names no file");
    }
    Ok(parts.iter().collect())
}

fn data(uri: &str, at: &str) -> Result<Vec<u8>, Error> {
    let Some((head, body)) = uri.split_once(',') else {
        return Err(bad(at, "the data URI has no comma"));
    };
    if head.rsplit(';').next().is_some_and(|last| last.trim().eq_ignore_ascii_case("base64")) {
        base64(body).ok_or_else(|| bad(at, "the data URI is not base64"))
    } else {
        Ok(percent_decode(body))
    }
}

/// Decodes percent escapes; a `%` without two hexadecimal digits is kept (exporters forget to escape it).
pub(super) fn percent_decode(text: &str) -> Vec<u8> {
    let bytes = text.as_bytes();
    let mut decoded = Vec::with_capacity(bytes.len());
    let mut k = 0;
    while k < bytes.len() {
        let digits = (bytes[k] == b'%').then(|| bytes.get(k + 1..k + 3)).flatten();
        let value = digits.and_then(|d| Some(hexadecimal(d[0])? * 16 + hexadecimal(d[1])?));
        decoded.push(value.unwrap_or(bytes[k]));
        k += if value.is_some() { 3 } else { 1 };
    }
    decoded
}

fn hexadecimal(digit: u8) -> Option<u8> {
    char::from(digit).to_digit(16).and_then(|d| u8::try_from(d).ok())
}

/// Decodes base64 of either alphabet, with or without padding; `None` for anything else.
pub(super) fn base64(text: &str) -> Option<Vec<u8>> {
    let text = text.trim_end_matches('=').as_bytes();
    if text.len() % 4 == 1 {
        return None;
    }
    let mut decoded = Vec::with_capacity(text.len() / 4 * 3 + 2);
    for group in text.chunks(4) {
        let mut bits = 0_u32;
        for &letter in group {
            bits = bits << 6 | u32::from(sextet(letter)?);
        }
        bits <<= 6 * (4 - group.len());
        let [_, bytes @ ..] = bits.to_be_bytes();
        decoded.extend_from_slice(&bytes[..group.len() - 1]);
    }
    Some(decoded)
}

fn sextet(letter: u8) -> Option<u8> {
    Some(match letter {
        b'A'..=b'Z' => letter - b'A',
        b'a'..=b'z' => letter - b'a' + 26,
        b'0'..=b'9' => letter - b'0' + 52,
        b'+' | b'-' => 62,
        b'/' | b'_' => 63,
        _ => return None,
    })
}

/// Text of a file for use in messages.
pub(super) fn shorten(text: &str) -> String {
    holo_core::shown(text).into_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(uri: &str) -> Option<PathBuf> {
        match resolve(uri, "uri") {
            Ok(Target::File(path)) => Some(path),
            _ => None,
        }
    }

    #[test]
    fn paths_stay_below_the_folder() {
        assert_eq!(file("a%20b.bin"), Some(PathBuf::from("a b.bin")));
        assert_eq!(file("50%.bin"), Some(PathBuf::from("50%.bin")));
        assert_eq!(file("./x/../y/z.png"), Some(PathBuf::from("y").join("z.png")));
        let refused =
            ["../x", "x/../../y", "%2e%2e/x", "..\\x", "/etc/passwd", "%2Fetc", "\\\\host\\x", "C:\\x", "C%3A/x"];
        let addresses = ["http://host/x", "file:///etc/passwd", "", ".", "a/..", "a%00b"];
        for uri in refused.into_iter().chain(addresses) {
            assert_eq!(file(uri), None, "{uri}");
        }
    }

    #[test]
    fn messages_show_short_harmless_text() {
        assert_eq!(shorten("caf\u{e9}"), "caf\u{e9}");
        assert_eq!(shorten("\u{1b}[2J"), "\\u{1b}[2J");
        assert!(shorten(&"x".repeat(60_000)).len() < 130);
    }

    #[test]
    fn data_uris_are_decoded() {
        let decoded = |uri: &str| match resolve(uri, "uri") {
            Ok(Target::Data(bytes)) => Some(bytes),
            _ => None,
        };
        assert_eq!(decoded("data:application/octet-stream;base64,AAEC/w=="), Some(vec![0, 1, 2, 255]));
        assert_eq!(decoded("data:;base64,AAEC_w"), Some(vec![0, 1, 2, 255]));
        assert_eq!(decoded("DATA:text/plain,a%20b"), Some(b"a b".to_vec()));
        assert_eq!(decoded("data:;base64,"), Some(vec![]));
        assert_eq!(decoded("data:;base64,A"), None);
        assert_eq!(decoded("data:;base64,AA*A"), None);
        assert_eq!(decoded("data:;base64"), None);
    }
}

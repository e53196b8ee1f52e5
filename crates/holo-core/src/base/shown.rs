//! Text of files in messages and in other files: visible, of one line, and not longer than a line.

use std::borrow::Cow;

/// Characters that are shown of one text.
const SHOWN: usize = 120;

/// Returns text of a file for a terminal, for a message or for a line of another file: control characters, line breaks
/// and invisible marks that change the direction of text as escapes such as `\u{1b}`, and of a long text the first 120
/// characters with `...`.
///
/// A terminal takes control characters for commands, and formats of lines take line breaks for their own. What a format
/// itself needs, such as `&lt;` in XML, comes in addition.
///
/// # Examples
///
/// ```
/// assert_eq!(holo_core::shown("café 20x20"), "café 20x20");
/// assert_eq!(holo_core::shown("a\u{1b}[2J\nb"), "a\\u{1b}[2J\\nb");
/// assert!(holo_core::shown(&"x".repeat(60_000)).len() < 130);
/// ```
#[must_use]
pub fn shown(text: &str) -> Cow<'_, str> {
    let end = text.char_indices().nth(SHOWN).map_or(text.len(), |(at, _)| at);
    let visible = visible(&text[..end]);
    if end == text.len() { visible } else { Cow::Owned(format!("{visible}...")) }
}

/// Returns the whole text of a file, with control characters as in [`shown`]: for values that must not be shortened.
#[must_use]
pub fn visible(text: &str) -> Cow<'_, str> {
    if !text.chars().any(is_hidden) {
        return Cow::Borrowed(text);
    }
    let mut escaped = String::with_capacity(text.len() + 16);
    for character in text.chars() {
        if is_hidden(character) {
            escaped.extend(character.escape_default());
        } else {
            escaped.push(character);
        }
    }
    Cow::Owned(escaped)
}

/// Returns lines for a terminal that may contain text of files, such as errors of a parser: with their line breaks, and
/// other characters as in [`shown`]. Lines that are longer than any message of this project are cut.
#[must_use]
pub fn shown_lines(message: &str) -> Cow<'_, str> {
    /// Characters of a line of a message.
    const LINE: usize = 2_000;
    let is_plain = |line: &str| line.len() <= LINE && !line.chars().any(is_hidden);
    if message.split('\n').all(is_plain) {
        return Cow::Borrowed(message);
    }
    let cut = |line: &str| match line.char_indices().nth(LINE) {
        Some((at, _)) => format!("{}...", visible(&line[..at])),
        None => visible(line).into_owned(),
    };
    Cow::Owned(message.split('\n').map(cut).collect::<Vec<_>>().join("\n"))
}

/// Returns lines of any length for standard output, which may go to a terminal or to a program: line breaks and tabs stay,
/// other control characters are escaped. JSON, in which there are none, stays as it is.
#[must_use]
pub fn shown_output(lines: &str) -> Cow<'_, str> {
    let is_hidden = |c: char| c.is_control() && !matches!(c, '\n' | '\t');
    if !lines.chars().any(is_hidden) {
        return Cow::Borrowed(lines);
    }
    let mut escaped = String::with_capacity(lines.len() + 16);
    for character in lines.chars() {
        match is_hidden(character) {
            true => escaped.extend(character.escape_default()),
            false => escaped.push(character),
        }
    }
    Cow::Owned(escaped)
}

/// Whether a character is not shown as itself: control characters, separators of lines, and marks of direction, by which a
/// name reads as another.
fn is_hidden(character: char) -> bool {
    character.is_control()
        || matches!(
            character,
            '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}' | '\u{feff}'
        )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hidden_characters_are_escaped_and_others_stay() {
        for (text, expected) in [
            ("", ""),
            ("schöne Szene \\ 1", "schöne Szene \\ 1"),
            ("a\tb\r\n", "a\\tb\\r\\n"),
            ("\u{1b}]0;title\u{7}", "\\u{1b}]0;title\\u{7}"),
            ("\u{9b}2J", "\\u{9b}2J"),
            ("gnp.\u{202e}exe", "gnp.\\u{202e}exe"),
            ("a\u{2028}b", "a\\u{2028}b"),
        ] {
            assert_eq!(shown(text), expected);
            assert_eq!(visible(text), expected);
        }
    }

    #[test]
    fn long_texts_are_shortened_between_characters() {
        assert_eq!(shown(&"ä".repeat(120)), "ä".repeat(120));
        assert_eq!(shown(&"ä".repeat(121)), format!("{}...", "ä".repeat(120)));
        assert_eq!(visible(&"ä".repeat(500)).len(), 1000);
    }

    #[test]
    fn messages_keep_their_lines() {
        assert_eq!(shown_lines("a\nb"), "a\nb");
        assert_eq!(shown_lines("a\n\u{1b}[2Jb"), "a\n\\u{1b}[2Jb");
        assert_eq!(shown_lines(&"x".repeat(60_000)).len(), 2_003);
        assert_eq!(shown_output("{\"a\":\t\"\u{202e}\"}\n"), "{\"a\":\t\"\u{202e}\"}\n");
        assert_eq!(shown_output("\u{1b}[2J\r"), "\\u{1b}[2J\\r");
    }
}

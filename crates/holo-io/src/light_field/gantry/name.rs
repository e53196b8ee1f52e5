//! The name of one view: `out_ROW_COLUMN_Y_X.png`.

use super::GantryPosition;

/// The contents of a file name.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Name {
    pub(super) row: usize,
    pub(super) column: usize,
    pub(super) position: GantryPosition,
}

impl Name {
    /// Parses a file name; `None` for other files.
    pub(super) fn parse(name: &str) -> Option<Self> {
        let (stem, extension) = name.rsplit_once('.')?;
        if !extension.eq_ignore_ascii_case("png") {
            return None;
        }
        let rest = stem.strip_prefix("out_")?;
        let mut parts = rest.strip_suffix('_').unwrap_or(rest).split('_');
        let (row, column) = (index(parts.next()?)?, index(parts.next()?)?);
        let (y, x) = (coordinate(parts.next()?)?, coordinate(parts.next()?)?);
        parts.next().is_none().then_some(Self { row, column, position: GantryPosition { y, x } })
    }
}

/// Parses digits; `parse` alone would accept a sign.
fn index(text: &str) -> Option<usize> {
    text.bytes().all(|byte| byte.is_ascii_digit()).then(|| text.parse().ok()).flatten()
}

/// Parses a decimal number; `parse` alone would accept words such as `nan`.
fn coordinate(text: &str) -> Option<f64> {
    let plain = text.bytes().all(|byte| byte.is_ascii_digit() || b"+-.eE".contains(&byte));
    plain.then(|| text.parse().ok()).flatten().filter(|value: &f64| value.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_names_of_the_archive_are_parsed() {
        for (name, row, column, y, x) in [
            ("out_00_00_-381.909271_1103.376221.png", 0, 0, -381.909271, 1103.376221),
            ("out_00_10_-383.248383_1017.387878.png", 0, 10, -383.248383, 1017.387878),
            ("out_00_10_-399.770660_770.764648_.png", 0, 10, -399.77066, 770.764648),
            ("out_16_3_5_0_.PNG", 16, 3, 5.0, 0.0),
            ("out_100_3_-1e2_.5.png", 100, 3, -100.0, 0.5),
        ] {
            assert_eq!(Name::parse(name), Some(Name { row, column, position: GantryPosition { y, x } }), "{name}");
        }
    }

    #[test]
    fn other_names_are_not() {
        for name in [
            "out_00_00.png",
            "out_00_00_1.png",
            "out_00_00_1_.png",
            "out_00_00_1_2_3.png",
            "out_00_00_1_2__.png",
            "out_-1_00_1_2.png",
            "out_+1_00_1_2.png",
            "out__00_1_2.png",
            "out_00_00_nan_2.png",
            "out_00_00_inf_2.png",
            "out_00_00_1e999_2.png",
            "out_00_00_1_2.jpg",
            "img_00_00_1_2.png",
            "OUT_00_00_1_2.png",
            "out_99999999999999999999_00_1_2.png",
            "",
        ] {
            assert_eq!(Name::parse(name), None, "{name}");
        }
    }
}

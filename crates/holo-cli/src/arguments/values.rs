//! Values that are more than a number: sizes, positions, ranges, and words that stand for a number.

use std::path::PathBuf;
use std::str::FromStr;

use holo_core::GridSize;
use holo_dataset::settings::positive;

/// Column and row, from 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Pair {
    pub column: usize,
    pub row: usize,
}

/// Columns and rows of a grid, each from 0: one place or several.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Places {
    pub columns: Span,
    pub rows: Span,
}

/// Some indices of an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Span {
    All,
    /// From the first to the last, which is one of them if the step meets it.
    Steps {
        first: usize,
        last: usize,
        step: usize,
    },
}

/// A part of an image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Crop {
    pub left: usize,
    pub top: usize,
    pub size: GridSize,
}

/// A path whose ending is one of these. Another ending would contradict what is written; none, as of `/dev/null`, does not.
fn ending_in(text: &str, endings: &[&str], advice: &str) -> Result<PathBuf, String> {
    let path = PathBuf::from(text);
    match path.extension() {
        Some(ending) if !endings.iter().any(|known| ending.eq_ignore_ascii_case(known)) => Err(advice.into()),
        _ => Ok(path),
    }
}

/// The name of a PNG.
pub fn png(text: &str) -> Result<PathBuf, String> {
    ending_in(text, &["png"], "only PNG is written here; end the name in .png")
}

/// A file of numpy.
pub fn npy(text: &str) -> Result<PathBuf, String> {
    ending_in(text, &["npy"], "an array of numpy is written; end the name in .npy")
}

/// The name of a PNG, a PFM or a TIFF.
pub fn png_or_pfm(text: &str) -> Result<PathBuf, String> {
    ending_in(text, &["png", "pfm", "tif", "tiff"], "end the name in .png, .tif, or .pfm for floats")
}

/// The name of an animation, or of the images of one.
pub fn animation(text: &str) -> Result<PathBuf, String> {
    let endings = ["png", "gif", "mp4", "pfm", "tif", "tiff"];
    ending_in(text, &endings, "end the name in .png, .gif or .mp4; with --frames in .png, .tif, or .pfm for floats")
}

/// The name of a drawing.
pub fn svg(text: &str) -> Result<PathBuf, String> {
    ending_in(text, &["svg"], "curves are drawn; end the name in .svg")
}

/// The name of a page.
pub fn html(text: &str) -> Result<PathBuf, String> {
    ending_in(text, &["html", "htm"], "a page is written; end the name in .html")
}

/// Several seeds.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Seeds(pub Vec<u64>);

/// No more images than this by one command.
const MOST_SEEDS: usize = 10_000;

impl FromStr for Seeds {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let number = |text: &str| text.trim().parse::<u64>().map_err(|_| "write seeds as 0-4, or as 1,5,9".to_owned());
        let seeds: Vec<u64> = match text.split_once('-') {
            Some((first, last)) => {
                let (first, last) = (number(first)?, number(last)?);
                if last < first {
                    return Err(format!("no seed is from {first} to {last}; write the smaller one first"));
                }
                (first..=last).take(MOST_SEEDS + 1).collect()
            }
            None => text.split(',').map(number).collect::<Result<_, _>>()?,
        };
        if seeds.len() > MOST_SEEDS {
            return Err(format!("these are more than {MOST_SEEDS} seeds; give fewer"));
        }
        match seeds.iter().enumerate().find(|(k, seed)| seeds[..*k].contains(seed)) {
            Some((_, seed)) => Err(format!("seed {seed} is there twice")),
            None => Ok(Self(seeds)),
        }
    }
}

/// Any finite number.
pub fn finite(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(number) if number.is_finite() => Ok(number),
        _ => Err("write a number, such as -0.5".into()),
    }
}

/// A number of cameras in one row, or columns x rows.
pub fn cameras(text: &str) -> Result<GridSize, String> {
    let count = match text.parse::<usize>() {
        Ok(columns) => Some(GridSize::new(1, columns)),
        Err(_) => GridSize::from_str(text).ok(),
    };
    let few = count.filter(|count| (1..=100_000).contains(&count.count()));
    few.ok_or_else(|| "give a number of cameras, or columns x rows, such as 17x3; at most 100000".into())
}

/// One distance for both axes, or two.
pub fn spacing(text: &str) -> Result<[f64; 2], String> {
    let (x, y) = text.split_once(',').unwrap_or((text, text));
    match (positive(x), positive(y)) {
        (Ok(x), Ok(y)) => Ok([x, y]),
        _ => Err("give a distance above 0 in meters, or two: X,Y".into()),
    }
}

/// A point in space.
pub fn point(text: &str) -> Result<[f64; 3], String> {
    let parts: Result<Vec<f64>, String> = text.split(',').map(|part| finite(part.trim())).collect();
    let point = parts.ok().and_then(|parts| <[f64; 3]>::try_from(parts).ok());
    point.ok_or_else(|| "write X,Y,Z in meters, such as 0,0.5,-1".into())
}

/// A distance in meters, or `inf`.
pub fn distance(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(number) if number > 0.0 => Ok(number),
        _ => Err("give a distance above 0 in meters, or inf".into()),
    }
}

/// `A,B,N`.
pub fn stack(text: &str) -> Result<(f64, f64, usize), String> {
    let parts: Vec<&str> = text.split(',').collect();
    let parsed = match parts[..] {
        [first, last, count] => finite(first).ok().zip(finite(last).ok()).zip(count.parse::<usize>().ok()),
        _ => None,
    };
    match parsed {
        Some(((first, last), count @ 1..=100_000)) => Ok((first, last, count)),
        _ => Err("write A,B,N, such as -1,1,21: 21 images from -1 to 1 px".into()),
    }
}

/// `S,T`: column and row of a viewpoint.
pub fn viewpoint(text: &str) -> Result<[f64; 2], String> {
    let parts = text.split_once(',').and_then(|(s, t)| finite(s).ok().zip(finite(t).ok()));
    parts.map(|(s, t)| [s, t]).ok_or_else(|| "write S,T, such as 1.5,1: a column and a row of views from 0".into())
}

/// `R,U`: angles to the right and up, degrees.
pub fn tilt(text: &str) -> Result<[f64; 2], String> {
    let angle = |text: &str| finite(text).ok().filter(|angle| angle.abs() < 90.0);
    let parts = text.split_once(',').and_then(|(right, up)| angle(right).zip(angle(up)));
    parts.map(|(right, up)| [right, up]).ok_or_else(|| "write R,U, such as 10,0: two angles between -90 and 90".into())
}

/// A place among pixels and one among views, from 0.
pub fn row_of_pixels(text: &str) -> Result<Pair, String> {
    let numbers = text.split_once(',').and_then(|(a, b)| Some((a.parse().ok()?, b.parse().ok()?)));
    let (column, row) = numbers.ok_or("write two numbers from 0, such as 20,4: the pixels' and the views'")?;
    Ok(Pair { column, row })
}

/// `X,Y,WxH`.
pub fn crop(text: &str) -> Result<Crop, String> {
    let parts: Vec<&str> = text.split(',').collect();
    let parsed = match parts[..] {
        [left, top, extent] => left.parse().ok().zip(top.parse().ok()).zip(extent.parse::<GridSize>().ok()),
        _ => None,
    };
    let ((left, top), size) = parsed.ok_or("write X,Y,WxH, such as 10,0,64x48: the left top pixel and the size")?;
    Ok(Crop { left, top, size })
}

/// `NEAR,FAR` in meters.
pub fn depths(text: &str) -> Result<(f64, f64), String> {
    let ends = text.split_once(',').and_then(|(near, far)| Some((positive(near).ok()?, distance(far).ok()?)));
    ends.filter(|(near, far)| near < far)
        .ok_or_else(|| "give NEAR,FAR in meters, such as 2,6 or 0.5,inf, the smaller first".into())
}

/// Frames per second, as an animated PNG stores them.
pub fn frame_rate(text: &str) -> Result<f64, String> {
    positive(text).ok().filter(|rate| (0.01..=600.0).contains(rate)).ok_or_else(|| "give 0.01 to 600".into())
}

impl Places {
    /// Whether it names one place, not a set that may happen to have one.
    pub fn is_one(self) -> bool {
        let one = |span| matches!(span, Span::Steps { first, last, .. } if first == last);
        one(self.columns) && one(self.rows)
    }
}

impl Span {
    /// The indices it means of an axis that has `count`; those beyond are left to whoever looks there.
    pub fn indices(self, count: usize) -> impl Iterator<Item = usize> + Clone {
        let (first, last, step) = match self {
            Self::All => (0, count.saturating_sub(1), 1),
            Self::Steps { first, last, step } => (first, last, step),
        };
        (first..=last).step_by(step)
    }
}

impl FromStr for Span {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let text = text.trim();
        if text == "all" {
            return Ok(Self::All);
        }
        let number = |part: &str| part.parse::<usize>().ok();
        let (ends, step) = text.split_once(':').unwrap_or((text, "1"));
        let (first, last) = ends.split_once('-').unwrap_or((ends, ends));
        match (number(first), number(last), number(step)) {
            (Some(first), Some(last), Some(step @ 1..)) if first <= last => Ok(Self::Steps { first, last, step }),
            _ => Err(format!("'{text}' is none of: 3 (from 0), 2-8, 0-90:10, all")),
        }
    }
}

impl FromStr for Places {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text.split_once(',') {
            Some((columns, rows)) => Ok(Self { columns: columns.parse()?, rows: rows.parse()? }),
            None if text.trim() == "all" => Ok(Self { columns: Span::All, rows: Span::All }),
            None => Err("give COLUMN,ROW, both from 0, or all".into()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_png_is_promised() {
        assert!(png("a/b.png").is_ok() && png("a.PNG").is_ok() && png("/dev/null").is_ok());
        assert!(png("view.jpg").unwrap_err().contains(".png"));
        assert!(html("a.html").is_ok() && html("a.HTM").is_ok() && html("/dev/stdout").is_ok());
        assert!(html("page.png").unwrap_err().contains(".html"));
    }

    #[test]
    fn words_and_numbers() {
        assert_eq!(row_of_pixels("3,4"), Ok(Pair { column: 3, row: 4 }));
        assert_eq!(depths("2,inf"), Ok((2.0, f64::INFINITY)));
        assert!(depths("6,2").is_err() && depths("0,2").is_err() && depths("2").is_err());
        assert_eq!(crop("1,2,30x20"), Ok(Crop { left: 1, top: 2, size: GridSize::new(20, 30) }));
        assert!(crop("1,2,0x3").is_err() && crop("1,2").is_err() && crop("-1,2,3x3").is_err());
        assert!(frame_rate("0").is_err() && frame_rate("601").is_err() && frame_rate("12.5").is_ok());
    }

    #[test]
    fn places_are_one_some_or_all() {
        let all = |text: &str, count| text.parse::<Span>().unwrap().indices(count).collect::<Vec<_>>();
        assert_eq!(all("all", 3), [0, 1, 2]);
        assert_eq!(all("2-8:3", 100), [2, 5, 8]);
        assert_eq!(all("7", 3), [7]);
        for bad in ["", "8-2", "1-3:0", "a", "-1", "1-", "1:2:3"] {
            assert!(bad.parse::<Span>().is_err(), "{bad}");
        }
        assert!("3,4".parse::<Places>().unwrap().is_one());
        assert!(!"3,all".parse::<Places>().unwrap().is_one() && !"all".parse::<Places>().unwrap().is_one());
        assert!("3".parse::<Places>().is_err());
    }
}

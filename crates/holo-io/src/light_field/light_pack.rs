//! Light fields of Stanford's LightPack (1996). A text, `NAME.lid`, describes a plane of cameras and a plane of images, together a
//! *slab*; every camera has an image, `NAME.U.V.rgb`.
//!
//! ```text
//! SLAB 0 images/lion                # images/lion.0.0.rgb, images/lion.0.1.rgb ...
//! SLAB_UV  -2 -2 2 1 0 0  ...       # four corners of the plane of cameras: x, y, z, w, and the place u, v from 0 to 1
//! SLAB_ST  -1 -1 0 1 0 0  ...       # the same of the plane of images, with s and t
//! SAMPLES_UV 16 16                  # cameras along u and v
//! SAMPLES_ST 256 256                # pixels along s and t
//! ```
//!
//! The coordinate t of an image points up. Views have the order of this crate where u runs to the left, or v down, too: by
//! the corners.
//!
//! # Source
//!
//! *lifauth: Light Field Authoring* and its file `dragon8.lid` (`graphics.stanford.edu/software/lightpack`). No images of it
//! were available for a test.

use std::path::{Path, PathBuf};

use holo_core::{GridSize, LightFieldShape, ViewOrder};

use super::options::ReadOptions;
use super::reader::{LightFieldFormat, LightFieldReader};
use super::source::Source;
use crate::Error;
use crate::files::folder::Folder;
use crate::files::limits::read_small_file;
use crate::images::image_file::read_image_info;

/// The name of the format in messages.
const FORMAT: &str = "LightPack file";

/// More than any description has.
const MAX_BYTES: u64 = 1 << 20;

/// The endings of images: LightPack's own, then those of images that were converted.
const ENDINGS: [&str; 5] = ["rgb", "sgi", "tif", "tiff", "png"];

/// The least cosine between directions that count as the same.
const LEAST_COSINE: f64 = 0.5;

/// Opens the images that a `.lid` file describes; they lie below its folder.
pub(super) fn open(path: &Path, options: &ReadOptions) -> Result<LightFieldReader, Error> {
    let broken = |why: String| Error::broken(path, FORMAT, why);
    let text = read_small_file(path, MAX_BYTES)?;
    let slab = Slab::parse(&String::from_utf8_lossy(&text)).map_err(broken)?;
    let shape = LightFieldShape::new(slab.cameras, slab.pixels).map_err(|error| Error::core(path, error))?;
    let files = slab.files(&Folder::beside(path)?)?;
    let found = read_image_info(&files[0])?.size;
    if found != slab.pixels {
        let (first, pixels) = (files[0].display(), slab.pixels);
        return Err(broken(format!("SAMPLES_ST has images of {pixels} pixels, but {first} has {found}")));
    }
    let source = Source::Images { files, order: ViewOrder::RowMajor };
    Ok(LightFieldReader::new(path, options, LightFieldFormat::LightPack, shape, source))
}

/// What a file describes.
#[derive(Debug, PartialEq)]
struct Slab {
    /// The name of all images, below the folder of the file.
    name: String,
    cameras: GridSize,
    pixels: GridSize,
    /// Whether u runs to the right of the images, and v up.
    is_along: [bool; 2],
}

impl Slab {
    fn parse(text: &str) -> Result<Self, String> {
        let lines = text.lines().map(|line| line.split('#').next().unwrap_or_default());
        let words: Vec<&str> = lines.flat_map(str::split_whitespace).collect();
        let count = words.iter().filter(|&&word| word == "SLAB").count();
        if count != 1 {
            return Err(format!("it has {count} slabs; keep the lines of one in a copy of the file"));
        }
        let after = |key: &str| {
            let at = words.iter().position(|&word| word == key).ok_or_else(|| format!("it has no {key}"))?;
            Ok::<_, String>(&words[at + 1..])
        };
        let corners = |key: &str| {
            let numbers: Vec<f64> = after(key)?.iter().take(24).map_while(|word| word.parse().ok()).collect();
            let is_whole = numbers.len() == 24 && numbers.iter().all(|x| x.is_finite());
            is_whole.then_some(numbers).ok_or_else(|| format!("{key} is not followed by 4 corners of 6 numbers"))
        };
        let size = |key: &str| {
            let numbers: Vec<usize> = after(key)?.iter().take(2).map_while(|word| word.parse().ok()).collect();
            match numbers[..] {
                [columns, rows] if columns > 0 && rows > 0 => Ok(GridSize::new(rows, columns)),
                _ => Err(format!("{key} is not followed by two numbers above 0")),
            }
        };
        let name = after("SLAB")?.get(1).ok_or("SLAB is not followed by a number and the name of the images")?;
        let [u, v] = axes(&corners("SLAB_UV")?);
        let [s, t] = axes(&corners("SLAB_ST")?);
        let cosines = [cosine(u, s), cosine(v, t)];
        if !cosines.iter().all(|cosine| cosine.abs() >= LEAST_COSINE) {
            return Err("the sides of SLAB_UV are not parallel to those of SLAB_ST".into());
        }
        Ok(Self {
            name: (*name).to_owned(),
            cameras: size("SAMPLES_UV")?,
            pixels: size("SAMPLES_ST")?,
            is_along: cosines.map(|cosine| cosine > 0.0),
        })
    }

    /// The images, view row by view row from above.
    fn files(&self, folder: &Folder) -> Result<Vec<PathBuf>, Error> {
        let name = |u: usize, v: usize, ending: &str| format!("{}.{u}.{v}.{ending}", self.name);
        let ending = ENDINGS.into_iter().find(|ending| folder.has_file(&name(0, 0, ending))).unwrap_or(ENDINGS[0]);
        let GridSize { rows, columns } = self.cameras;
        let [right, up] = self.is_along;
        let mut files = Vec::new();
        for row in 0..rows {
            let v = if up { rows - 1 - row } else { row };
            for column in 0..columns {
                let u = if right { column } else { columns - 1 - column };
                files.push(folder.regular_path(&name(u, v, ending))?);
            }
        }
        Ok(files)
    }
}

/// The directions of both coordinates of a plane, by the places of its corners. Of a plane at infinity (w = 0) these are
/// directions themselves.
fn axes(corners: &[f64]) -> [[f64; 3]; 2] {
    let corners = || corners.chunks_exact(6);
    [4, 5].map(|k| {
        let middle = corners().map(|corner| corner[k]).sum::<f64>() / 4.0;
        [0, 1, 2].map(|axis| corners().map(|corner| (corner[k] - middle) * corner[axis]).sum())
    })
}

/// The cosine of the angle between directions; NaN if one has no length.
fn cosine(a: [f64; 3], b: [f64; 3]) -> f64 {
    let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    dot(a, b) / (dot(a, a) * dot(b, b)).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The corners of a square about a place, with the sides of these lengths along x and y; below 0: the other way.
    fn square(key: &str, z: f64, w: f64, [x, y]: [f64; 2]) -> String {
        let corners = [[0, 0], [1, 0], [1, 1], [0, 1]].map(|[a, b]| {
            let [at_x, at_y] = [(f64::from(a) - 0.5) * x, (f64::from(b) - 0.5) * y];
            format!("{at_x} {at_y} {z} {w} {a} {b}")
        });
        format!("{key} {}\n", corners.join("\n  "))
    }

    fn described(uv: &str, st: &str) -> String {
        format!("# LIF1.0\nSLAB 0 data/lion # name\n{uv}{st}SAMPLES_UV 4 3\nSAMPLES_ST 20 10\nFORMAT RGB\n")
    }

    #[test]
    fn planes_say_where_the_first_view_is() {
        let st = square("SLAB_ST", 0.0, 1.0, [1.0, 1.0]);
        for (w, sides, is_along) in [
            (1.0, [4.0, 2.0], [true, true]),
            (1.0, [-4.0, 2.0], [false, true]),
            (0.0, [2000.0, -2000.0], [true, false]),
        ] {
            let slab = Slab::parse(&described(&square("SLAB_UV", 2.0, w, sides), &st)).unwrap();
            let expected = Slab {
                name: "data/lion".into(),
                cameras: GridSize::new(3, 4),
                pixels: GridSize::new(10, 20),
                is_along,
            };
            assert_eq!(slab, expected);
        }
    }

    #[test]
    fn what_is_no_slab_is_refused() {
        let st = square("SLAB_ST", 0.0, 1.0, [1.0, 1.0]);
        let uv = square("SLAB_UV", 2.0, 1.0, [4.0, 2.0]);
        let good = described(&uv, &st);
        for (text, words) in [
            (String::new(), "0 slabs"),
            (good.clone() + &good, "2 slabs"),
            (good.replace("SAMPLES_UV 4 3", ""), "no SAMPLES_UV"),
            (good.replace("SAMPLES_UV 4 3", "SAMPLES_UV 4 0"), "above 0"),
            (good.replace("SAMPLES_ST 20 10", "SAMPLES_ST 20"), "SAMPLES_ST is not followed"),
            (described(&uv, &st.replace(" 0 1 ", " 0 inf ")), "SLAB_ST is not followed"),
            (described(&square("SLAB_UV", 2.0, 1.0, [0.0, 1.0]), &st), "parallel"),
        ] {
            let why = Slab::parse(&text).unwrap_err();
            assert!(why.contains(words), "{why}: {text}");
        }
    }
}

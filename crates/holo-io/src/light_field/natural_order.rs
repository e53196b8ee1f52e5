//! The images of a folder in natural order.

use std::cmp::Ordering;
use std::fs;
use std::path::{Path, PathBuf};

use crate::Error;
use crate::files::names::OWN_IMAGES;
use crate::light_field::views::check_regular;

/// Lists the PNGs and TIFFs of a folder, by file extension, in natural order: digits in their names compare as numbers, so
/// `view9.png` is before `view10.png`. Images that this project writes beside a light field, such as `scene_el.png`, are no
/// views and are left out.
///
/// # Errors
///
/// [`Error::Io`] if the folder cannot be listed, or one of the images is a link or no file.
pub fn list_images(folder: impl AsRef<Path>) -> Result<Vec<PathBuf>, Error> {
    let folder = folder.as_ref();
    let failed = |source| Error::io("list", folder, source);
    let mut images = Vec::new();
    for entry in fs::read_dir(folder).map_err(failed)? {
        let entry = entry.map_err(failed)?;
        let path = entry.path();
        if is_image_name(&path) && !is_own_image(&path) && !entry.file_type().map_err(failed)?.is_dir() {
            check_regular(&path)?;
            images.push(path);
        }
    }
    images.sort_by(|a, b| natural_order(&a.to_string_lossy(), &b.to_string_lossy()));
    Ok(images)
}

fn natural_order(a: &str, b: &str) -> Ordering {
    let (a_runs, b_runs) = (runs(a), runs(b));
    let mut order = a_runs.iter().zip(&b_runs).map(|(a, b)| match (is_number(a), is_number(b)) {
        (true, true) => {
            let (x, y) = (a.trim_start_matches('0'), b.trim_start_matches('0'));
            x.len().cmp(&y.len()).then_with(|| x.cmp(y))
        }
        _ => a.cmp(b),
    });
    let first = order.find(|order| order.is_ne()).unwrap_or(Ordering::Equal);
    first.then(a_runs.len().cmp(&b_runs.len())).then_with(|| a.cmp(b))
}

fn is_number(run: &str) -> bool {
    run.starts_with(|c: char| c.is_ascii_digit())
}

/// Splits a text into runs of digits and runs of other characters.
fn runs(text: &str) -> Vec<&str> {
    let mut runs = Vec::new();
    let mut rest = text;
    while let Some(first) = rest.chars().next() {
        let digits = first.is_ascii_digit();
        let end = rest.find(|c: char| c.is_ascii_digit() != digits).unwrap_or(rest.len());
        let (run, after) = rest.split_at(end);
        runs.push(run);
        rest = after;
    }
    runs
}

/// Whether a file has a name of this project.
fn is_own_image(path: &Path) -> bool {
    path.file_name().and_then(|name| name.to_str()).is_some_and(|name| OWN_IMAGES.contains(&name))
}

/// Whether a file may be the image of a view, by its extension.
fn is_image_name(path: &Path) -> bool {
    let has = |ending: &&str| path.extension().is_some_and(|found| found.eq_ignore_ascii_case(ending));
    ["png", "tif", "tiff"].iter().any(has)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn digits_compare_as_numbers() {
        let mut names = ["v10.png", "v9.png", "v1_12.png", "v1_2.png", "v007.png", "a.png", "v1.png"];
        names.sort_by(|a, b| natural_order(a, b));
        assert_eq!(names, ["a.png", "v1.png", "v1_2.png", "v1_12.png", "v007.png", "v9.png", "v10.png"]);
        let long = ["x99999999999999999999999", "x100000000000000000000000"];
        assert_eq!(natural_order(long[0], long[1]), Ordering::Less);
    }
}

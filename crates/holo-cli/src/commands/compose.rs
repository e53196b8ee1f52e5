//! `holo compose`: pictures of single views become a raw image.

use std::cmp::Ordering;
use std::path::{Path, PathBuf};

use holo_core::ViewOrder;
use holo_io::Limits;

use super::remap;
use crate::arguments::{ComposeOptions, OrderArgument};
use crate::failure::Failure;

pub fn run(options: &ComposeOptions) -> Result<(), Failure> {
    let order = match options.order {
        OrderArgument::RowMajor => ViewOrder::RowMajor,
        OrderArgument::Serpentine => ViewOrder::Serpentine,
    };
    let to = remap::output_layout(options.to, &options.out, None)?;
    let (images, from) = match &options.images[..] {
        [folder] if folder.is_dir() => (pictures_in(folder)?, folder.clone()),
        images => (images.to_vec(), PathBuf::from("the list of pictures")),
    };
    if images.len() != options.views.count() {
        return Err(Failure::Usage(format!(
            "{} has {} pictures, but {} x {} views need {}",
            from.display(),
            images.len(),
            options.views.columns,
            options.views.rows,
            options.views.count()
        )));
    }
    let field = holo_io::read_views(&images, options.views, order, &Limits::default())?;
    remap::write_grid(field.try_into()?, to, &options.out, &from)
}

/// The PNGs of a folder, ordered by name.
fn pictures_in(folder: &Path) -> Result<Vec<PathBuf>, Failure> {
    let failed = |why| Failure::Failed(format!("cannot list {}: {why}", folder.display()));
    let mut pictures = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(failed)? {
        let path = entry.map_err(failed)?.path();
        if path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("png")) {
            pictures.push(path);
        }
    }
    pictures.sort_by(|a, b| by_numbers(&a.to_string_lossy(), &b.to_string_lossy()));
    Ok(pictures)
}

/// `view9` before `view10`: runs of digits count as numbers.
fn by_numbers(a: &str, b: &str) -> Ordering {
    let (a_runs, b_runs) = (runs(a), runs(b));
    let pairs = a_runs.iter().zip(&b_runs);
    let mut order = pairs.map(|(a, b)| match (is_number(a), is_number(b)) {
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

/// Digits and what is between them.
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_in_names_are_numbers() {
        let mut names = ["v10.png", "v9.png", "v1_12.png", "v1_2.png", "v007.png", "a.png", "v1.png"];
        names.sort_by(|a, b| by_numbers(a, b));
        assert_eq!(names, ["a.png", "v1.png", "v1_2.png", "v1_12.png", "v007.png", "v9.png", "v10.png"]);
        let long = ["x99999999999999999999999", "x100000000000000000000000"];
        assert_eq!(by_numbers(long[0], long[1]), Ordering::Less);
    }
}

//! The grid of views that the names of a folder of images tell.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use holo_core::GridSize;

/// The grid of images that are named by row and column, such as `IMG_0001_02_03.png`, with the files row by row; or the
/// square of images that are numbered as views of the HCI benchmark. `None`: the names do not tell one.
pub(super) fn grid_of_names(files: &[PathBuf]) -> Option<(GridSize, Vec<PathBuf>)> {
    let stem = |file: &'_ Path| file.file_stem().map(|stem| stem.to_string_lossy().into_owned());
    let names: Vec<String> = files.iter().map(|file| stem(file)).collect::<Option<_>>()?;
    if names.iter().all(|name| name.to_ascii_lowercase().starts_with("input_cam")) {
        let side = files.len().isqrt();
        return (side > 1 && side * side == files.len()).then(|| (GridSize::new(side, side), files.to_vec()));
    }
    let mut grid = BTreeMap::new();
    for (name, file) in names.iter().zip(files) {
        let numbers: Vec<u32> =
            name.split(|c: char| !c.is_ascii_digit()).filter_map(|digits| digits.parse().ok()).collect();
        let &[.., row, column] = &numbers[..] else { return None };
        if grid.insert((row, column), file.clone()).is_some() {
            return None;
        }
    }
    let count = |of: fn(&(u32, u32)) -> u32| -> Option<usize> {
        let mut numbers: Vec<u32> = grid.keys().map(of).collect();
        numbers.sort_unstable();
        numbers.dedup();
        // Without gaps, from 0 or 1.
        let is_whole = *numbers.first()? < 2 && numbers.windows(2).all(|pair| pair[1] == pair[0] + 1);
        (is_whole && numbers.len() > 1).then_some(numbers.len())
    };
    let views = GridSize::new(count(|key| key.0)?, count(|key| key.1)?);
    (views.count() == files.len()).then(|| (views, grid.into_values().collect()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(format: impl Fn(usize, usize) -> String, rows: usize, columns: usize) -> Vec<PathBuf> {
        (0..rows * columns).map(|k| PathBuf::from(format(k / columns, k % columns))).collect()
    }

    #[test]
    fn names_tell_grids() {
        let found = grid_of_names(&names(|t, s| format!("IMG_0012_{:03}_{:02}_{:02}.png", 9 * t + s, t, s), 2, 3));
        assert_eq!(
            found.map(|(views, files)| (views, files[4].clone())),
            Some((GridSize::new(2, 3), "IMG_0012_010_01_01.png".into(),))
        );
        // From 1, in an order of the list that is not that of the numbers.
        let mut files = names(|t, s| format!("{}_{}.png", t + 1, s + 1), 3, 12);
        files.reverse();
        let (views, sorted) = grid_of_names(&files).unwrap();
        assert_eq!((views, sorted[1].to_str()), (GridSize::new(3, 12), Some("1_2.png")));
        let (views, _) = grid_of_names(&names(|t, s| format!("input_Cam{:03}.png", 9 * t + s), 9, 9)).unwrap();
        assert_eq!(views, GridSize::new(9, 9));
        for other in [
            names(|t, s| format!("view{}.png", 3 * t + s), 3, 3),
            names(|t, s| format!("{t}_{}.png", 2 * s), 3, 3),
            names(|t, s| format!("{}_{s}.png", t + 2), 3, 3),
            names(|_, s| format!("0_{s}.png"), 1, 3),
            names(|t, s| format!("input_Cam{:03}.png", 5 * t + s), 2, 5),
            names(|t, s| format!("{t}_{s}.png"), 3, 3)[..8].to_vec(),
            vec!["a.png".into()],
        ] {
            assert_eq!(grid_of_names(&other), None, "{other:?}");
        }
    }
}

//! Folders of the Stanford Lego gantry: names, order, missing views.

use std::fs;
use std::path::Path;

use holo_core::{DynImage, DynLightField, GridSize, LightField};
use holo_io::{ColorEncoding, Compression, Error, GantryFolder, GantryPosition, Limits, write_png};
use ndarray::{Array3, Array5};

const STEP_X: f64 = -8.598834;

fn name(row: usize, column: usize, end: &str) -> String {
    format!(
        "out_{row:02}_{column:02}_{:.6}_{:.6}{end}.png",
        -381.909271 + row as f64 * 8.5,
        1103.376221 + column as f64 * STEP_X
    )
}

/// A view whose samples contain its row and column.
fn view(row: usize, column: usize) -> Array3<u8> {
    Array3::from_shape_fn((3, 4, 3), |(v, u, c)| (row * 60 + column * 20 + v * 4 + u + c) as u8)
}

fn write(path: &Path, image: &Array3<u8>) {
    write_png(path, image.view(), ColorEncoding::Srgb, Compression::Fast).unwrap();
}

fn folder(rows: &[usize], columns: &[usize], end: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for &row in rows {
        for &column in columns {
            write(&folder.path().join(name(row, column, end)), &view(row, column));
        }
    }
    folder
}

#[test]
fn both_kinds_of_names_are_read_in_the_order_of_their_indices() {
    // Eleven columns, so that the order of the numbers is not that of the text.
    let columns: Vec<usize> = (0..11).collect();
    for end in ["", "_"] {
        let folder = folder(&[0, 1], &columns, end);
        fs::write(folder.path().join("readme.txt"), b"x").unwrap();
        let opened = GantryFolder::open(folder.path()).unwrap();
        assert_eq!((opened.views(), opened.path()), (GridSize::new(2, 11), folder.path()));
        assert_eq!(opened.position(0, 0), Some(GantryPosition { y: -381.909271, x: 1103.376221 }));
        let corner = opened.position(1, 10).unwrap();
        assert!((corner.y - -373.409271).abs() < 1e-6 && (corner.x - 1017.387881).abs() < 1e-6, "{corner:?}");
        assert_eq!((opened.position(2, 0), opened.position(0, 11)), (None, None));
        let expected = Array5::from_shape_fn((3, 4, 2, 11, 3), |(v, u, t, s, c)| view(t, s)[[v, u, c]]);
        let read = opened.read(&Limits::default()).unwrap();
        assert_eq!(read, DynLightField::U8(LightField::new(expected).unwrap()));
        assert_eq!(opened.read_view(1, 10, &Limits::default()).unwrap(), DynImage::U8(view(1, 10)));
        assert!(matches!(opened.read_view(2, 0, &Limits::default()), Err(Error::Core { .. })));
    }
}

#[test]
fn a_subset_is_a_grid_too() {
    let folder = folder(&[1, 3], &[2, 3], "");
    let opened = GantryFolder::open(folder.path()).unwrap();
    assert_eq!(opened.views(), GridSize::new(2, 2));
    assert_eq!(opened.read_view(1, 0, &Limits::default()).unwrap(), DynImage::U8(view(3, 2)));
}

#[test]
fn missing_and_duplicate_views_are_named() {
    let message = |folder: &Path| GantryFolder::open(folder).unwrap_err().to_string();
    let hole = folder(&[0, 1, 2], &[0, 1, 2], "");
    fs::remove_file(hole.path().join(name(1, 2, ""))).unwrap();
    let text = message(hole.path());
    assert!(text.contains("there is no out_01_02_*.png, but other files make a grid of 3 x 3 views"), "{text}");

    let rows = folder(&[0, 1, 3], &[0, 1], "");
    assert!(message(rows.path()).contains("there is no row between 1 and 3, but others are 1 apart"));

    let double = folder(&[0, 1], &[0, 1], "");
    write(&double.path().join("out_00_01_0.5_0.5.png"), &view(0, 1));
    assert!(message(double.path()).contains("is the same view"));

    let empty = tempfile::tempdir().unwrap();
    assert!(message(empty.path()).contains("there is no file named like out_00_00_"));
    let file = empty.path().join("file");
    fs::write(&file, b"x").unwrap();
    assert!(matches!(GantryFolder::open(&file), Err(Error::Io { .. })));
}

#[test]
fn views_that_differ_from_the_first_are_refused() {
    let folder = folder(&[0, 1], &[0, 1], "");
    let opened = GantryFolder::open(folder.path()).unwrap();
    let last = folder.path().join(name(1, 1, ""));
    write(&last, &Array3::zeros((3, 5, 3)));
    let error = opened.read(&Limits::default()).unwrap_err();
    assert_eq!(error.path(), last);
    assert!(error.to_string().contains("it is 5 x 3 pixels of RGB in 8 bits, but out_00_00_"), "{error}");
    let deep: Array3<u16> = Array3::zeros((3, 4, 3));
    write_png(&last, deep.view(), ColorEncoding::Srgb, Compression::Fast).unwrap();
    assert!(matches!(opened.read(&Limits::default()), Err(Error::Broken { .. })));
    fs::remove_file(&last).unwrap();
    assert!(matches!(opened.read(&Limits::default()), Err(Error::Io { .. })));
    let error = opened.read(&Limits { max_bytes: 143 }).unwrap_err();
    assert!(matches!(error, Error::TooLarge { needed: 144, .. }), "{error}");
}

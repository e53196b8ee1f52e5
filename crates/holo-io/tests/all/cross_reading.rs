//! Files of other programs are read exactly: a table of format, program, sample type and size.
//!
//! `peers/write_files.py` writes the files with every program that `HOLO_PYTHON` (or `python3`) has; both sides compute
//! the numbers by the same formulas. The opposite direction is tested in `peer_readers.rs`, `mat_peers.rs`,
//! `mat_v73.rs`, `mat_octave.rs` and `hdf5.rs`.

use crate::python;
use std::collections::BTreeMap;
use std::path::Path;

use holo_core::{DynImage, DynLightField, GridSize, ViewOrder};
use holo_io::{Limits, read_exr, read_mat_light_field, read_png, read_views};
use ndarray::{Array3, Array5};

/// The numbers of `image` in the script.
fn image(size: &str, channels: usize, top: usize) -> Array3<usize> {
    let (rows, columns) = size.split_once('x').unwrap();
    let shape = (rows.parse().unwrap(), columns.parse().unwrap(), channels);
    Array3::from_shape_fn(shape, |(row, column, channel)| (row * 8191 + column * 523 + channel * 97) % top)
}

/// The numbers of `light_field` in the script.
fn light_field(size: &str) -> Array5<f64> {
    let counts: Vec<usize> = size.split('x').map(|count| count.parse().unwrap()).collect();
    let shape = <[usize; 5]>::try_from(counts).unwrap();
    Array5::from_shape_fn(shape, |(v, u, t, s, c)| ((v * 97 + u * 31 + t * 11 + s * 5 + c * 3) % 256) as f64)
}

fn assert_png(path: &Path, size: &str, channels: &str, bits: &str) {
    let top = if bits == "8" { 256 } else { 65_536 };
    let expected = image(size, channels.parse().unwrap(), top);
    match (read_png(path, &Limits::default()).unwrap(), bits) {
        (DynImage::U8(read), "8") => assert_eq!(read.mapv(usize::from), expected, "{}", path.display()),
        (DynImage::U16(read), "16") => assert_eq!(read.mapv(usize::from), expected, "{}", path.display()),
        (read, _) => panic!("{}: {:?}", path.display(), read.dim()),
    }
}

/// An SGI image as the one view of a light field, which drops alpha.
fn assert_sgi(path: &Path, size: &str, channels: usize) {
    let read = read_views(&[path.to_owned()], GridSize::new(1, 1), ViewOrder::RowMajor, &Limits::default()).unwrap();
    let DynLightField::U8(field) = read else { panic!("{}: not of 8 bits", path.display()) };
    let read = field.view(0, 0).unwrap().mapv(usize::from);
    let expected = image(size, channels, 256);
    assert_eq!(read, expected.slice_axis(ndarray::Axis(2), (..channels.min(3)).into()), "{}", path.display());
}

fn assert_exr(path: &Path, size: &str) {
    let expected = image(size, 3, 2048);
    let read = read_exr(path, &Limits::default()).unwrap();
    for (channel, name) in ["R", "G", "B"].into_iter().enumerate() {
        let plane = read.channel(name).unwrap();
        let wanted = expected.index_axis(ndarray::Axis(2), channel).mapv(|value| value as f32);
        assert_eq!(plane, wanted, "{} {name}", path.display());
    }
}

fn assert_light_field(path: &Path, read: DynLightField, size: &str, kind: &str) {
    let (numbers, found) = match read {
        DynLightField::U8(field) => (field.samples().mapv(f64::from), "uint8"),
        DynLightField::U16(field) => (field.samples().mapv(f64::from), "uint16"),
        DynLightField::F32(field) => (field.samples().mapv(f64::from), "float32"),
        DynLightField::F64(field) => (field.samples().to_owned(), "float64"),
    };
    assert_eq!(found, kind, "{}", path.display());
    assert_eq!(numbers, light_field(size), "{}", path.display());
}

#[test]
fn files_of_other_programs_are_read_exactly() {
    let folder = tempfile::tempdir().unwrap();
    let Some(text) = python::run_file("write_files.py", [folder.path()]) else { return };
    let mut table = BTreeMap::<(String, String, String), usize>::new();
    for line in text.lines() {
        let (name, program) = line.split_once('\t').unwrap();
        let path = folder.path().join(name);
        let (stem, ending) = name.rsplit_once('.').unwrap();
        let words: Vec<&str> = stem.split('_').collect();
        let kind = match (words[..].iter().as_slice(), ending) {
            (&[_, size, channels, bits], "png") => {
                assert_png(&path, size, channels, bits);
                format!("{bits} bit, {channels} channels")
            }
            (&[_, size, channels], "rgb") => {
                assert_sgi(&path, size, channels.parse().unwrap());
                format!("8 bit, {channels} channels")
            }
            (&[_, size, coding, kind], "exr") => {
                assert_exr(&path, size);
                format!("{kind}, {coding}")
            }
            (&[_, size, kind, coding], "mat") => {
                assert_light_field(
                    &path,
                    read_mat_light_field(&path, &Limits::default()).unwrap().light_field,
                    size,
                    kind,
                );
                format!("{kind}, version 5, {coding}")
            }
            #[cfg(feature = "hdf5")]
            (&[_, size, kind], "mat") => {
                assert_light_field(
                    &path,
                    read_mat_light_field(&path, &Limits::default()).unwrap().light_field,
                    size,
                    kind,
                );
                format!("{kind}, version 7.3")
            }
            #[cfg(feature = "hdf5")]
            (&[_, size, kind, coding], "h5") => {
                let file = holo_io::Hdf5LightField::open(&path, &Limits::default()).unwrap();
                assert_light_field(&path, file.read().unwrap(), size, kind);
                format!("{kind}, {coding}")
            }
            #[cfg(not(feature = "hdf5"))]
            (&[_, _, _], "mat") | (&[_, _, _, _], "h5") => continue,
            _ => panic!("{name}"),
        };
        *table.entry((ending.to_owned(), program.to_owned(), kind)).or_default() += 1;
    }
    assert!(!table.is_empty(), "the script wrote nothing");
    println!("format | written by | samples | sizes read equal");
    for ((ending, program, kind), count) in table {
        println!("{ending} | {program} | {kind} | {count}");
    }
}

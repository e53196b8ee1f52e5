//! HDF5 files with valid structure and arbitrary attributes: the input determines their names, types and values.
//!
//! The C library is responsible for damaged bytes, as the documentation of `holo_io` states. This target tests how the
//! reader handles everything that the library can return.

use hdf5::types::{VarLenAscii, VarLenUnicode};
use hdf5::{Container, File, H5Type};
use holo_io::{Hdf5LightField, Limits};
use ndarray::{Array1, ArrayD, IxDyn};

use crate::bytes::Bytes;

const NAMES: [&str; 10] = [
    "axes",
    "views",
    "lenses",
    "baseline_m",
    "focal_length_mm",
    "sensor_size_mm",
    "focus_distance_m",
    "projection",
    "format",
    "MATLAB_class",
];

const WORDS: [&str; 8] =
    ["vutsc", "tsvuc", "perspective", "orthographic", "", "vuts", "uint8", "holo light field 1, with a longer text"];

impl Bytes<'_> {
    /// Small whole numbers, and any others.
    fn number(&mut self) -> f64 {
        match self.next() {
            small @ 0..200 => f64::from(small) / 4.0,
            200..220 => f64::NAN,
            220..230 => f64::INFINITY,
            230..240 => -1.0,
            _ => f64::from_le_bytes([0; 8].map(|_: u8| self.next())),
        }
    }
}

/// HDF5: writes a file from the input, and reads it or returns an error.
///
/// # Panics
///
/// If a property does not hold.
pub fn hdf5(data: &[u8]) {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("fuzz.h5");
    let mut bytes = Bytes(data);
    let file = File::create(&path).expect("a file");
    let shape: Vec<usize> = (0..3 + bytes.below(4)).map(|_| bytes.below(4)).collect();
    write(&file, "H", &shape, &mut bytes);
    if bytes.next() > 200 {
        file.create_group("central").expect("a group");
        write(&file, "central/depth_m", &shape[..2], &mut bytes);
    }
    if bytes.next() > 200 {
        write(&file, "disparity_px", &shape[..3], &mut bytes);
    }
    let mut used = [false; NAMES.len()];
    for _ in 0..bytes.below(NAMES.len() + 1) {
        let name = bytes.below(NAMES.len());
        if !std::mem::replace(&mut used[name], true) {
            attribute(&file, NAMES[name], &mut bytes);
        }
    }
    file.close().expect("it was written");

    let limits = Limits { max_bytes: 1 << 16 };
    let _ = holo_io::detect_format(&path);
    let _ = holo_io::is_light_field_hdf5(&path);
    let Ok(field) = Hdf5LightField::open(&path, &limits) else { return };
    let _ = field.rig().copied();
    let (all, central) = field.maps();
    all.into_iter().for_each(|map| drop(field.read_map(map)));
    central.into_iter().for_each(|map| drop(field.read_central_map(map)));
    if let Ok(read) = field.read() {
        assert_eq!((read.shape(), read.channels()), (field.shape(), field.channels()));
    }
}

fn write(file: &File, name: &str, shape: &[usize], bytes: &mut Bytes<'_>) {
    fn dataset<T: H5Type + Clone>(file: &File, name: &str, shape: &[usize], value: T, is_chunked: bool) {
        let array = ArrayD::from_elem(IxDyn(shape), value);
        let builder = file.new_dataset_builder();
        // Axes of length 0 have no chunks.
        let is_chunked = is_chunked && !shape.is_empty() && !shape.contains(&0);
        let builder = if is_chunked { builder.chunk(vec![1; shape.len()]).deflate(1) } else { builder };
        builder.with_data(array.view()).create(name).expect("it is sound");
    }
    let is_chunked = bytes.next() > 127;
    match bytes.below(7) {
        0 | 1 => dataset(file, name, shape, bytes.next(), is_chunked),
        2 => dataset(file, name, shape, u16::from(bytes.next()), is_chunked),
        3 => dataset(file, name, shape, f32::from(bytes.next()), is_chunked),
        4 => dataset(file, name, shape, bytes.number(), is_chunked),
        5 => dataset(file, name, shape, i64::from(bytes.next()), is_chunked),
        _ => dataset(file, name, shape, bytes.next() > 9, is_chunked),
    }
}

fn attribute(file: &File, name: &str, bytes: &mut Bytes<'_>) {
    let at: &Container = &file.dataset("H").expect("it was written");
    let count = bytes.below(4);
    let numbers: Array1<f64> = (0..count).map(|_| bytes.number()).collect();
    let word = WORDS[bytes.below(WORDS.len())];
    // Of the file, or of the samples.
    macro_rules! create {
        ($data:expr) => {
            if bytes.next() > 60 {
                file.new_attr_builder().with_data($data).create(name).map(drop)
            } else {
                at.new_attr_builder().with_data($data).create(name).map(drop)
            }
        };
    }
    let written = match bytes.below(7) {
        0 => create!(numbers.view()),
        1 => create!(ndarray::aview0(&numbers.first().copied().unwrap_or(1.0))),
        2 => create!(numbers.mapv(|x| x as u64).view()),
        3 => create!(numbers.mapv(|x| x as i8).view()),
        4 => create!(ndarray::arr0(word.parse::<VarLenUnicode>().expect("no NUL in it")).view()),
        5 => create!(ndarray::arr1(&vec![VarLenAscii::from_ascii(word).expect("it is ASCII"); count]).view()),
        _ => create!(numbers.mapv(|x| x as f32).view()),
    };
    // Arrays without elements cannot be attributes.
    assert!(written.is_ok() || count == 0, "{name}");
}

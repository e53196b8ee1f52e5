//! MAT files of version 7.3: the same variables as in version 5, and the structure that MATLAB and h5py read.
#![cfg(feature = "hdf5")]

use crate::python;
use holo_core::{DynLightField, GridSize, LightField, LightFieldShape, Projection, Rig};
use holo_io::{
    FileFormat, Limits, MatArray, MatOptions, MatOrder, MatValue, MatVariable, MatVersion, MatWriter, detect_format,
    read_mat, read_mat_info, read_mat_light_field, write_mat, write_mat_light_field,
};
use ndarray::{Array5, ArrayD, Axis, Slice};
use proptest::prelude::*;

const OPTIONS: [MatOptions; 2] =
    [MatOptions::new().version(MatVersion::V73), MatOptions::new().version(MatVersion::V73).compressed(true)];

fn rig(shape: LightFieldShape) -> Rig {
    Rig::builder(shape)
        .focal_length_m(0.05)
        .sensor_size_m(0.036)
        .baseline_m(1e-3)
        .focus_distance_m(2.0)
        .build()
        .unwrap()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]

    #[test]
    fn light_fields_keep_five_axes(
        shape in prop::array::uniform5(1_usize..5),
        views_first in any::<bool>(),
        compressed in 0..2_usize,
    ) {
        let value = |(v, u, t, s, c)| (v * 97 + u * 31 + t * 11 + s * 5 + c * 3) as u16;
        let mut samples = Array5::from_shape_fn(shape, value);
        samples.invert_axis(Axis(2));
        let field = LightField::new(samples).unwrap();
        let order = if views_first { MatOrder::LightFieldToolbox } else { MatOrder::Lenses };
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("scene_5d.mat");
        write_mat_light_field(&path, &field, None, order, &OPTIONS[compressed]).unwrap();
        let read = read_mat_light_field(&path, &Limits::default()).unwrap();
        prop_assert_eq!(read.light_field, DynLightField::U16(field));
    }

    #[test]
    fn rows_in_groups_of_any_size_make_the_light_field(
        shape in (1_usize..11, 1_usize..22, 1_usize..4, 1_usize..13, 1_usize..4),
        steps in prop::collection::vec(1_usize..7, 11),
        is_compressed in any::<bool>(),
    ) {
        let samples = Array5::from_shape_fn(shape, |(v, u, t, s, c)| (v * 97 + u * 31 + t * 11 + s * 5 + c * 3) as u16);
        let split = LightFieldShape::new(GridSize::new(shape.2, shape.3), GridSize::new(shape.0, shape.1)).unwrap();
        let rig = rig(split).to_builder().projection(Projection::Orthographic).build().unwrap();
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("scene_5d.mat");
        let mut writer = MatWriter::create(&path, &rig, shape.4, is_compressed).unwrap();
        let mut first = 0;
        for step in steps {
            let end = shape.0.min(first + step);
            writer.write_lens_rows(samples.slice_axis(Axis(0), Slice::from(first..end))).unwrap();
            first = end;
        }
        prop_assert!(writer.write_lens_rows(samples.slice_axis(Axis(0), Slice::from(..1))).is_err());
        writer.finish().unwrap();
        let read = read_mat_light_field(&path, &Limits::default()).unwrap();
        prop_assert_eq!(read.light_field, DynLightField::U16(LightField::new(samples).unwrap()));
        prop_assert_eq!(read.rig, Some(rig));
    }
}

#[test]
fn missing_or_wrong_rows_leave_no_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene_5d.mat");
    let rig = rig(LightFieldShape::new(GridSize::new(2, 2), GridSize::new(3, 3)).unwrap());
    let mut writer = MatWriter::<u8>::create(&path, &rig, 3, true).unwrap();
    let error = writer.write_lens_rows(Array5::zeros((1, 4, 2, 2, 3)).view()).unwrap_err();
    assert!(error.to_string().contains("do not fit"), "{error}");
    writer.write_lens_rows(Array5::zeros((2, 3, 2, 2, 3)).view()).unwrap();
    let error = writer.finish().unwrap_err();
    assert!(error.to_string().contains("only 2 of 3 lens rows"), "{error}");
    assert!(MatWriter::<u8>::create(&path, &rig, 0, true).is_err());
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
}

#[test]
fn both_versions_have_the_same_variables() {
    let folder = tempfile::tempdir().unwrap();
    let cube = ArrayD::from_shape_fn(vec![70, 200, 90], |at| (at[0] as f32).sin() + at[1] as f32 - at[2] as f32);
    let signed = ArrayD::from_shape_fn(vec![3, 1, 4], |at| at[0] as i32 - 70_000 * at[2] as i32);
    let empty = ArrayD::<f64>::zeros(vec![0, 3]);
    let one = ndarray::aview0(&0.1_f64).into_dyn();
    let variables = [
        MatVariable { name: "cube", value: MatValue::F32(cube.view()) },
        MatVariable { name: "empty", value: MatValue::F64(empty.view()) },
        MatVariable { name: "nothing", value: MatValue::Text("") },
        MatVariable { name: "one", value: MatValue::F64(one) },
        MatVariable { name: "signed", value: MatValue::I32(signed.view()) },
        MatVariable { name: "word", value: MatValue::Text("Größe µm 光") },
    ];
    let five = folder.path().join("five.mat");
    write_mat(&five, &variables, &MatOptions::default()).unwrap();
    for options in OPTIONS {
        let path = folder.path().join("seven.mat");
        let written = write_mat(&path, &variables, &options).unwrap();
        assert_eq!(written, holo_io::hash_file(&path).unwrap());
        assert_eq!(detect_format(&path).unwrap(), FileFormat::Mat73);
        assert_eq!(read_mat(&path, &Limits::default()).unwrap(), read_mat(&five, &Limits::default()).unwrap());
        assert_eq!(read_mat_info(&path).unwrap(), read_mat_info(&five).unwrap());
        let bytes = std::fs::read(&path).unwrap();
        assert!(bytes.starts_with(b"MATLAB 7.3 MAT-file") && &bytes[124..128] == b"\x00\x02IM");
        assert!(bytes[512..].starts_with(b"\x89HDF\r\n\x1a\n\x00"));
        std::thread::sleep(std::time::Duration::from_millis(1100));
        assert_eq!(write_mat(&path, &variables, &options).unwrap(), written);
        assert!(read_mat(&path, &Limits { max_bytes: 100 }).is_err());
    }
    assert_eq!(read_mat(&five, &Limits::default()).unwrap()[2].1, MatArray::Text(String::new()));
}

#[test]
fn h5py_finds_the_structure_of_matlab() {
    const SCRIPT: &str = r#"
import numpy as np
file = h5py.File(sys.argv[1])
assert file.userblock_size == 512
x = file["x"]
assert x.shape == (4, 3, 2) and (x[...].T == np.arange(24).reshape(2, 3, 4)).all(), x[...]
assert x.attrs["MATLAB_class"] == b"uint16"
kind = x.attrs.get_id("MATLAB_class").get_type()
assert not kind.is_variable_str() and kind.get_size() == 6
assert file["word"].attrs["MATLAB_class"] == b"char" and file["word"].attrs["MATLAB_int_decode"] == 2
assert "".join(map(chr, file["word"][:, 0])) == "px"
assert file["none"].attrs["MATLAB_empty"] == 1 and file["none"][...].tolist() == [0, 3]
print("fine")
"#;
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("x.mat");
    let x = ArrayD::from_shape_vec(vec![2, 3, 4], (0..24_u16).collect()).unwrap();
    let none = ArrayD::<f64>::zeros(vec![0, 3]);
    let variables = [
        MatVariable { name: "x", value: MatValue::U16(x.view()) },
        MatVariable { name: "word", value: MatValue::Text("px") },
        MatVariable { name: "none", value: MatValue::F64(none.view()) },
    ];
    for options in OPTIONS {
        write_mat(&path, &variables, &options).unwrap();
        let Some(text) = python::run(&["h5py"], SCRIPT, &[path.to_str().unwrap()]) else { return };
        assert_eq!(text.trim(), "fine");
    }
}

/// Two other readers of version 7.3: one for every class, one for numbers.
#[test]
fn hdf5storage_and_mat73_read_files_of_this_crate() {
    const SCRIPT: &str = r#"
import numpy as np
v, u, t, s, c = np.ogrid[:4, :3, :2, :5, :3]
for path, kind in zip(sys.argv[1::2], sys.argv[2::2]):
    for file in (hdf5storage.loadmat(path), mat73.loadmat(path)):
        H = file["H"]
        assert H.shape == (4, 3, 2, 5, 3) and H.dtype == np.dtype(kind), (H.shape, H.dtype)
        assert (H == (v * 97 + u * 31 + t * 11 + s * 5 + c * 3).astype(kind)).all()
print("fine")
"#;
    let folder = tempfile::tempdir().unwrap();
    let samples =
        Array5::from_shape_fn((4, 3, 2, 5, 3), |(v, u, t, s, c)| (v * 97 + u * 31 + t * 11 + s * 5 + c * 3) as u16);
    let field = LightField::new(samples).unwrap();
    let mut arguments = Vec::new();
    for (number, options) in OPTIONS.iter().enumerate() {
        for kind in ["uint8", "uint16", "float32", "float64"] {
            let path = folder.path().join(format!("{kind}{number}.mat"));
            match kind {
                "uint8" => {
                    write_mat_light_field(&path, &field.map(|&x| x as u8).unwrap(), None, MatOrder::Lenses, options)
                }
                "uint16" => write_mat_light_field(&path, &field, None, MatOrder::Lenses, options),
                "float32" => write_mat_light_field(
                    &path,
                    &field.map(|&x| f32::from(x)).unwrap(),
                    None,
                    MatOrder::Lenses,
                    options,
                ),
                _ => write_mat_light_field(
                    &path,
                    &field.map(|&x| f64::from(x)).unwrap(),
                    None,
                    MatOrder::Lenses,
                    options,
                ),
            }
            .unwrap();
            arguments.extend([path.to_str().unwrap().to_owned(), kind.to_owned()]);
        }
    }
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    if let Some(text) = python::run(&["hdf5storage", "mat73"], SCRIPT, &arguments) {
        assert_eq!(text.trim(), "fine");
    }
}

//! MAT files of version 5, exchanged with SciPy in both directions.

use crate::common::data;
use crate::python;
use crate::rigs;
use holo_core::{DynLightField, GridSize, LightField, LightFieldShape};
use holo_io::{
    Error, Limits, MatArray, MatClass, MatOptions, MatOrder, MatValue, MatVariable, MatVersion, read_mat,
    read_mat_info, read_mat_light_field, read_mat_variable, write_mat, write_mat_light_field,
};
use ndarray::{Array5, ArrayD};

/// The light field of `data/make_mat.py`.
fn value((v, u, t, s, c): (usize, usize, usize, usize, usize)) -> usize {
    v * 97 + u * 31 + t * 11 + s * 5 + c * 3
}

const SHAPE: [usize; 5] = [4, 3, 2, 5, 3];

fn row<T>(values: Vec<T>) -> ArrayD<T> {
    ArrayD::from_shape_vec(vec![1, values.len()], values).unwrap()
}

#[test]
fn files_of_scipy_read_bit_for_bit() {
    for name in ["scipy_plain.mat", "scipy_compressed.mat"] {
        let path = data(name);
        let read = read_mat_light_field(&path, &Limits::default()).unwrap();
        let expected = Array5::from_shape_fn(SHAPE, |at| (value(at) % 251) as u8);
        assert_eq!(read.light_field, DynLightField::U8(LightField::new(expected).unwrap()), "{name}");
        let rig = read.rig.unwrap();
        assert_eq!((rig.baseline_y_m(), rig.baseline_x_m(), rig.focus_distance_m()), (2e-4, 1e-4, f64::INFINITY));
        assert_eq!((rig.focal_length_m(), rig.sensor_size_m()), (0.0351, 0.036));
        let all = read_mat(&path, &Limits::default()).unwrap();
        let get = |name: &str| all.iter().find(|(own, _)| own == name).unwrap().1.clone();
        assert_eq!(get("int32s"), MatArray::I32(row(vec![i32::MIN, -1, 0, i32::MAX])));
        assert_eq!(get("int8s"), MatArray::I8(row(vec![-128, -1, 0, 127])));
        assert_eq!(get("int64s"), MatArray::I64(row(vec![i64::MIN, i64::MAX])));
        assert_eq!(get("uint64s"), MatArray::U64(row(vec![u64::MAX, (1 << 53) + 1])));
        assert_eq!(get("floats"), MatArray::F32(row(vec![0.1, -0.0, f32::INFINITY])));
        assert_eq!(get("flags"), MatArray::U8(row(vec![1, 0])));
        assert_eq!(get("word"), MatArray::Text("µm".into()));
        assert_eq!(get("nothing"), MatArray::F64(ArrayD::zeros(vec![0, 3])));
        assert_eq!(all.len(), 16);
    }
}

#[test]
fn classes_that_are_not_read_are_listed_and_named() {
    let path = data("scipy_classes.mat");
    let read = read_mat_light_field(&path, &Limits::default()).unwrap();
    let expected = Array5::from_shape_fn(SHAPE, |at| value(at) as u16);
    assert_eq!(read.light_field, DynLightField::U16(LightField::new(expected).unwrap()));
    assert_eq!(read.rig, None);
    let infos = read_mat_info(&path).unwrap();
    for (name, class) in [
        ("cell", MatClass::Cell),
        ("structure", MatClass::Struct),
        ("complex", MatClass::F64),
        ("sparse", MatClass::Sparse),
        ("rows", MatClass::Text),
    ] {
        let info = infos.iter().find(|info| info.name == name).unwrap();
        assert_eq!((info.class, info.is_complex), (class, name == "complex"));
        let error = read_mat_variable(&path, name, &Limits::default()).unwrap_err();
        assert!(matches!(error, Error::Unsupported { .. }) && error.to_string().contains(name), "{error}");
    }
    assert!(read_mat(&path, &Limits::default()).is_err());
}

/// A handmade file: big-endian, and doubles stored as `int8`.
#[test]
fn other_byte_order_and_other_storage() {
    let read = read_mat(data("hand_big_endian.mat"), &Limits::default()).unwrap();
    assert_eq!(read[0], ("small".to_owned(), MatArray::F64(row(vec![-1.0, 0.0, 100.0]))));
    assert_eq!(read[1], ("whole".to_owned(), MatArray::I32(row(vec![i32::MIN, 7]).reversed_axes())));
}

#[test]
fn scipy_reads_files_of_this_crate() {
    const SCRIPT: &str = r#"
import numpy as np
file = scipy.io.loadmat(sys.argv[1])
lenses_first = sys.argv[2] == "H"
H = file[sys.argv[2]]
if not lenses_first:
    H = np.moveaxis(H, (2, 3, 0, 1, 4), (0, 1, 2, 3, 4))
v, u, t, s, c = np.ogrid[:4, :3, :2, :5, :3]
assert H.dtype == np.dtype(sys.argv[3]), H.dtype
assert H.shape == (4, 3, 2, 5, 3), H.shape
assert (H == (v * 97 + u * 31 + t * 11 + s * 5 + c * 3).astype(H.dtype)).all()
assert file["views"].tolist() == [[2, 5]] and file["lenses"].tolist() == [[4, 3]]
assert file["baseline_m"].tolist() == [[2e-4, 1e-4]] and file["focal_length_mm"].tolist() == [[35.1]]
assert file["sensor_size_mm"].tolist() == [[36]] and file["focus_distance_m"].tolist() == [[np.inf]]
assert file["axis_order"].tolist() == ["vutsc" if lenses_first else "tsvuc"]
assert file["projection"].tolist() == ["perspective"]
print("fine")
"#;
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene_5d.mat");
    let rig = rigs::unequal_baselines(LightFieldShape::new(GridSize::new(2, 5), GridSize::new(4, 3)).unwrap());
    for is_compressed in [false, true] {
        let options = MatOptions::new().version(MatVersion::V5).compressed(is_compressed);
        for (order, name) in [(MatOrder::Lenses, "H"), (MatOrder::LightFieldToolbox, "LF")] {
            let field = LightField::new(Array5::from_shape_fn(SHAPE, |at| value(at) as u16)).unwrap();
            for dtype in ["uint8", "uint16", "float32", "float64"] {
                match dtype {
                    "uint8" => {
                        write_mat_light_field(&path, &field.map(|&x| x as u8).unwrap(), Some(&rig), order, &options)
                    }
                    "uint16" => write_mat_light_field(&path, &field, Some(&rig), order, &options),
                    "float32" => write_mat_light_field(
                        &path,
                        &field.map(|&x| f32::from(x)).unwrap(),
                        Some(&rig),
                        order,
                        &options,
                    ),
                    _ => write_mat_light_field(
                        &path,
                        &field.map(|&x| f64::from(x)).unwrap(),
                        Some(&rig),
                        order,
                        &options,
                    ),
                }
                .unwrap();
                let Some(text) = python::run(&["scipy.io"], SCRIPT, &[path.to_str().unwrap(), name, dtype]) else {
                    return;
                };
                assert_eq!(text.trim(), "fine");
            }
        }
    }
}

#[test]
fn scipy_reads_every_type() {
    const SCRIPT: &str = r#"
import numpy as np
file = scipy.io.loadmat(sys.argv[1])
for name in ("uint8 int8 uint16 int16 uint32 int32 uint64 int64 single double").split():
    array = file["x_" + name]
    assert array.dtype == np.dtype(name), (name, array.dtype)
    assert array.tolist() == [[0, 1, 100], [2, 3, 101]], (name, array)
assert file["word"].tolist() == ["Größe µm"]
print("fine")
"#;
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("all.mat");
    macro_rules! arrays {
        ($($type:ident)*) => { $(let $type = ndarray::arr2(&[[0 as $type, 1 as $type, 100 as $type], [2 as $type, 3 as $type, 101 as $type]]).into_dyn();)* };
    }
    arrays! { u8 i8 u16 i16 u32 i32 u64 i64 f32 f64 }
    let variable = |name, value| MatVariable { name, value };
    let variables = [
        variable("x_uint8", MatValue::U8(u8.view())),
        variable("x_int8", MatValue::I8(i8.view())),
        variable("x_uint16", MatValue::U16(u16.view())),
        variable("x_int16", MatValue::I16(i16.view())),
        variable("x_uint32", MatValue::U32(u32.view())),
        variable("x_int32", MatValue::I32(i32.view())),
        variable("x_uint64", MatValue::U64(u64.view())),
        variable("x_int64", MatValue::I64(i64.view())),
        variable("x_single", MatValue::F32(f32.view())),
        variable("x_double", MatValue::F64(f64.view())),
        variable("word", MatValue::Text("Größe µm")),
    ];
    for is_compressed in [false, true] {
        write_mat(&path, &variables, &MatOptions::new().version(MatVersion::V5).compressed(is_compressed)).unwrap();
        let Some(text) = python::run(&["scipy.io"], SCRIPT, &[path.to_str().unwrap()]) else { return };
        assert_eq!(text.trim(), "fine");
    }
}

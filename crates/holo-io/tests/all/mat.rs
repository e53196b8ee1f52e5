//! MAT files of version 5: exact round trips for any shape, strides and type.

use crate::encoded::encoded;
use crate::rigs::unequal_baselines as rig;
use holo_core::{DynLightField, GridSize, LightField, LightFieldShape, Projection};
use holo_io::{
    Error, FileFormat, Limits, MatArray, MatClass, MatOptions, MatOrder, MatValue, MatVariable, MatVersion, decode_mat,
    detect_format, encode_mat, read_mat, read_mat_info, read_mat_light_field, read_mat_variable, write_mat,
    write_mat_light_field,
};
use ndarray::{Array5, ArrayD, Axis, IxDyn, ShapeBuilder, Slice};
use proptest::prelude::*;

const PLAIN: MatOptions = MatOptions::new().version(MatVersion::V5);
const COMPRESSED: MatOptions = MatOptions::new().version(MatVersion::V5).compressed(true);

fn variable<'a>(name: &'a str, value: MatValue<'a>) -> MatVariable<'a> {
    MatVariable { name, value }
}

fn round_trip(value: MatValue<'_>, options: &MatOptions) -> MatArray {
    let bytes = encoded(|out| encode_mat(out, &[variable("x", value)], options)).unwrap();
    let mut read = decode_mat(&bytes[..], &Limits::default()).unwrap();
    assert_eq!((read.len(), read[0].0.as_str()), (1, "x"));
    read.remove(0).1
}

/// The array in the shape of MATLAB.
fn matlab<T: Clone>(array: &ArrayD<T>) -> ArrayD<T> {
    let mut array = array.clone();
    while array.ndim() < 2 {
        array = array.insert_axis(Axis(0));
    }
    while let [_, _, .., 1] = array.shape() {
        let last = Axis(array.ndim() - 1);
        array = array.remove_axis(last);
    }
    array
}

#[test]
fn every_type_keeps_every_bit() {
    macro_rules! check {
        ($($variant:ident $type:ty: $($value:expr),*;)*) => {$(
            let array = ArrayD::from_shape_vec(IxDyn(&[1, 5]), vec![$($value as $type),*]).unwrap();
            for options in [PLAIN, COMPRESSED] {
                assert_eq!(round_trip(MatValue::$variant(array.view()), &options), MatArray::$variant(array.clone()));
            }
        )*};
    }
    check! {
        U8 u8: 0, 1, 127, 128, 255;
        I8 i8: -128, -1, 0, 1, 127;
        U16 u16: 0, 1, 255, 256, 65_535;
        I16 i16: -32_768, -1, 0, 1, 32_767;
        U32 u32: 0, 1, 65_536, 0x8000_0000_u32, u32::MAX;
        I32 i32: i32::MIN, -1, 0, 65_536, i32::MAX;
        U64 u64: 0, 1, 1_u64 << 53, (1_u64 << 53) + 1, u64::MAX;
        I64 i64: i64::MIN, -1, 0, (1_i64 << 53) + 1, i64::MAX;
        F32 f32: f32::NEG_INFINITY, -0.0, f32::MIN_POSITIVE / 2.0, 1.5, f32::MAX;
        F64 f64: f64::INFINITY, -0.0, f64::MIN_POSITIVE / 2.0, 0.1, f64::MAX;
    }
    // A signaling NaN and one with a payload keep their bits.
    let nan = ArrayD::from_shape_vec(IxDyn(&[1, 2]), vec![f32::from_bits(0x7f80_0001), f32::from_bits(0xffc1_2345)]);
    let MatArray::F32(back) = round_trip(MatValue::F32(nan.unwrap().view()), &PLAIN) else { panic!("single") };
    assert!(back.iter().map(|value| value.to_bits()).eq([0x7f80_0001, 0xffc1_2345]));
}

#[test]
fn text_of_all_kinds() {
    for text in ["", "x", "meters", "Größe µm 光场", "\u{1f4f7}\n\0tab\t"] {
        for options in [PLAIN, COMPRESSED] {
            assert_eq!(round_trip(MatValue::Text(text), &options), MatArray::Text(text.to_owned()), "{text:?}");
        }
    }
}

#[test]
fn no_elements_and_no_dimensions() {
    let empty = ArrayD::<f64>::zeros(vec![3, 0, 2]);
    assert_eq!(round_trip(MatValue::F64(empty.view()), &PLAIN), MatArray::F64(empty));
    let row = ndarray::aview1(&[1_u8, 2, 3]).into_dyn();
    assert_eq!(round_trip(MatValue::U8(row.clone()), &PLAIN), MatArray::U8(row.insert_axis(Axis(0)).to_owned()));
    let one = ndarray::aview0(&7_i16).into_dyn();
    let MatArray::I16(back) = round_trip(MatValue::I16(one), &COMPRESSED) else { panic!("int16") };
    assert_eq!((back.shape(), back[[0, 0]]), (&[1, 1][..], 7));
}

proptest! {
    #[test]
    fn any_shape_and_strides(
        shape in prop::collection::vec(1_usize..7, 0..7),
        seed in any::<u64>(),
        compressed in any::<bool>(),
        column_major in any::<bool>(),
    ) {
        let axes = shape.len();
        let mut array = ArrayD::<u16>::zeros(IxDyn(&shape).set_f(column_major));
        array.iter_mut().enumerate().for_each(|(at, value)| *value = (at as u64 ^ seed) as u16);
        let mut order: Vec<usize> = (0..axes).collect();
        (1..axes).for_each(|at| order.swap(at, (seed >> (4 * at)) as usize % (at + 1)));
        let mut view = array.view().permuted_axes(order);
        for axis in 0..axes {
            match seed >> (32 + 3 * axis) & 7 {
                0 => view.invert_axis(Axis(axis)),
                1 => view.slice_axis_inplace(Axis(axis), Slice::new(0, None, 2)),
                _ => {}
            }
        }
        let options = if compressed { COMPRESSED } else { PLAIN };
        let back = round_trip(MatValue::U16(view.clone()), &options);
        prop_assert_eq!(back, MatArray::U16(matlab(&view.to_owned())));
    }

    #[test]
    fn light_fields_keep_five_axes(
        shape in prop::array::uniform5(1_usize..5),
        views_first in any::<bool>(),
        compressed in any::<bool>(),
        kind in 0..4,
    ) {
        let [v, u, t, s, c] = shape;
        let split = LightFieldShape::new(GridSize::new(t, s), GridSize::new(v, u)).unwrap();
        let raw = ndarray::Array3::from_shape_fn((v * t, u * s, c), |(y, x, k)| (y * 40 + x * 3 + k) as u8);
        let field = LightField::from_elemental_grid(raw, split).unwrap();
        let order = if views_first { MatOrder::LightFieldToolbox } else { MatOrder::Lenses };
        let options = if compressed { COMPRESSED } else { PLAIN };
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("scene_5d.mat");
        let stored = match kind {
            0 => {
                write_mat_light_field(&path, &field, None, order, &options).unwrap();
                DynLightField::U8(field)
            }
            1 => {
                let field = field.map(|&sample| u16::from(sample) * 257).unwrap();
                write_mat_light_field(&path, &field, None, order, &options).unwrap();
                DynLightField::U16(field)
            }
            2 => {
                let field = field.map(|&sample| f32::from(sample) / 7.0).unwrap();
                write_mat_light_field(&path, &field, None, order, &options).unwrap();
                DynLightField::F32(field)
            }
            _ => {
                let field = field.map(|&sample| f64::from(sample) / 7.0).unwrap();
                write_mat_light_field(&path, &field, None, order, &options).unwrap();
                DynLightField::F64(field)
            }
        };
        let read = read_mat_light_field(&path, &Limits::default()).unwrap();
        prop_assert_eq!(read.light_field.shape(), split);
        prop_assert_eq!(read.light_field.channels(), c);
        prop_assert_eq!(read.light_field, stored);
        prop_assert_eq!(read.rig, None);
    }
}

#[test]
fn the_rig_reads_back() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene_5d.mat");
    let split = LightFieldShape::new(GridSize::new(2, 3), GridSize::new(4, 5)).unwrap();
    let field = LightField::new(Array5::<u8>::zeros(split.array_shape(3))).unwrap();
    for projection in [Projection::Perspective, Projection::Orthographic] {
        let focus_distance_m = if projection == Projection::Perspective { f64::INFINITY } else { 4.25 };
        let rig = rig(split).to_builder().focus_distance_m(focus_distance_m).projection(projection).build().unwrap();
        write_mat_light_field(&path, &field, Some(&rig), MatOrder::Lenses, &PLAIN).unwrap();
        assert_eq!(read_mat_light_field(&path, &Limits::default()).unwrap().rig, Some(rig));
    }
    let other = LightFieldShape::new(GridSize::new(2, 3), GridSize::new(5, 4)).unwrap();
    let error = write_mat_light_field(&path, &field, Some(&rig(other)), MatOrder::Lenses, &PLAIN).unwrap_err();
    assert!(matches!(error, Error::BadInput { .. }), "{error}");
    let names: Vec<String> = read_mat_info(&path).unwrap().into_iter().map(|info| info.name).collect();
    let expected = [
        "H",
        "axis_order",
        "views",
        "lenses",
        "baseline_m",
        "focal_length_mm",
        "sensor_size_mm",
        "focus_distance_m",
        "projection",
    ];
    assert_eq!(names, expected);
    assert_eq!(detect_format(&path).unwrap(), FileFormat::Mat5);
}

#[test]
fn variables_that_contradict_the_samples_are_errors() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("x.mat");
    let samples = ArrayD::<u8>::zeros(vec![4, 5, 2, 3]);
    let (views, wrong) = ([2.0, 3.0], [3.0, 2.0]);
    let numbers = |numbers| MatValue::F64(ndarray::aview1(numbers).into_dyn());
    for (extra, good) in [
        (variable("views", numbers(&views)), true),
        (variable("views", numbers(&wrong)), false),
        (variable("views", MatValue::Text("2x3")), false),
        (variable("axis_order", MatValue::Text("vuts")), false),
        (variable("axis_order", MatValue::Text("vutsv")), false),
        (variable("axes", MatValue::Text("vutsv")), false),
        (variable("axis_order", MatValue::F64(ndarray::aview1(&views).into_dyn())), false),
        (variable("projection", numbers(&views)), false),
    ] {
        write_mat(&path, &[variable("H", MatValue::U8(samples.view())), extra.clone()], &PLAIN).unwrap();
        let read = read_mat_light_field(&path, &Limits::default());
        assert_eq!(read.is_ok(), good, "{extra:?}: {read:?}");
        assert!(read.err().is_none_or(|error| matches!(error, Error::Broken { .. })));
    }
    let six = ArrayD::<u8>::zeros(vec![2; 6]);
    write_mat(&path, &[variable("H", MatValue::U8(six.view()))], &PLAIN).unwrap();
    assert!(read_mat_light_field(&path, &Limits::default()).is_err());
    let signed = ArrayD::<i32>::zeros(vec![2; 5]);
    write_mat(&path, &[variable("H", MatValue::I32(signed.view()))], &PLAIN).unwrap();
    let error = read_mat_light_field(&path, &Limits::default()).unwrap_err();
    assert!(matches!(error, Error::Unsupported { .. }), "{error}");
    write_mat(&path, &[variable("G", MatValue::I32(signed.view()))], &PLAIN).unwrap();
    let error = read_mat_light_field(&path, &Limits::default()).unwrap_err();
    assert!(error.to_string().contains("there are: G"), "{error}");
}

#[test]
fn what_cannot_be_written_is_refused() {
    let value = || MatValue::Text("x");
    let long = "a".repeat(64);
    for name in ["", "1a", "_a", "a b", "ä", "a-b", &long] {
        let error = encoded(|out| encode_mat(out, &[variable(name, value())], &PLAIN)).unwrap_err();
        assert!(matches!(error, Error::BadInput { .. }), "{name}: {error}");
    }
    assert!(encoded(|out| encode_mat(out, &[variable(&long[1..], value()), variable("a", value())], &PLAIN)).is_ok());
    assert!(encoded(|out| encode_mat(out, &[variable("a", value()), variable("a", value())], &PLAIN)).is_err());
    // Too large for version 5, without memory: one number with strides of 0.
    let huge = ndarray::aview0(&1_u8);
    let huge = huge.broadcast(IxDyn(&[1 << 16, 1 << 15])).unwrap();
    let error = encoded(|out| encode_mat(out, &[variable("H", MatValue::U8(huge.view()))], &PLAIN)).unwrap_err();
    assert!(error.to_string().contains("2147483648 bytes") && error.to_string().contains("7.3"), "{error}");
    let error =
        encoded(|out| encode_mat(out, &[variable("H", MatValue::U8(huge))], &MatOptions::default())).unwrap_err();
    assert!(error.to_string().contains("7.3"), "{error}");
    if cfg!(not(feature = "hdf5")) {
        let folder = tempfile::tempdir().unwrap();
        let options = MatOptions::new().version(MatVersion::V73);
        let error = write_mat(folder.path().join("x.mat"), &[variable("a", value())], &options).unwrap_err();
        assert!(error.to_string().contains("feature `hdf5`"), "{error}");
    }
}

#[test]
fn the_budget_is_for_all_variables_together() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("x.mat");
    let array = ArrayD::<f32>::zeros(vec![10, 10]);
    for options in [PLAIN, COMPRESSED] {
        let value = || MatValue::F32(array.view());
        write_mat(&path, &[variable("a", value()), variable("b", value())], &options).unwrap();
        let read = |max_bytes| read_mat(&path, &Limits { max_bytes });
        assert_eq!(read(800).unwrap().len(), 2);
        assert!(matches!(read(799), Err(Error::TooLarge { needed: 400, .. })));
        assert!(read_mat_variable(&path, "b", &Limits { max_bytes: 400 }).is_ok());
        assert!(read_mat_variable(&path, "c", &Limits::default()).unwrap_err().to_string().contains("a, b"));
        // Listing variables needs no memory for them.
        let infos = read_mat_info(&path).unwrap();
        assert_eq!(
            (infos[1].name.as_str(), infos[1].class, infos[1].size.as_slice()),
            ("b", MatClass::F32, &[10, 10][..])
        );
    }
}

#[test]
fn equal_inputs_give_equal_bytes_and_the_digest_is_that_of_the_file() {
    let folder = tempfile::tempdir().unwrap();
    let array = ArrayD::from_shape_fn(vec![300, 200, 30], |at| (at[0] * at[1] + at[2]) as f32);
    for options in [PLAIN, COMPRESSED] {
        let written: Vec<_> = ["a.mat", "b.mat"]
            .map(|name| write_mat(folder.path().join(name), &[variable("x", MatValue::F32(array.view()))], &options))
            .into_iter()
            .map(Result::unwrap)
            .collect();
        assert_eq!(written[0], written[1]);
        assert_eq!(written[0], holo_io::hash_file(folder.path().join("a.mat")).unwrap());
        let read = read_mat(folder.path().join("b.mat"), &Limits::default()).unwrap();
        assert_eq!(read[0].1, MatArray::F32(array.clone()));
    }
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 2);
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_device_is_an_error() {
    let array = ArrayD::<f64>::zeros(vec![500, 500]);
    let error = write_mat("/dev/full", &[variable("x", MatValue::F64(array.view()))], &PLAIN).unwrap_err();
    assert!(error.to_string().contains("free some space"), "{error}");
    let error = write_mat("/dev/full", &[variable("x", MatValue::F64(array.view()))], &COMPRESSED).unwrap_err();
    assert!(matches!(error, Error::BadInput { .. }), "{error}");
}

/// Files of version 0.1 have `axes`, which hides a function of MATLAB; the new name wins where both are there.
#[test]
fn the_order_of_axes_has_an_old_name_too() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("x.mat");
    let samples = ArrayD::<u8>::zeros(vec![4, 5, 2, 3]);
    let shape = |names: &[(&str, &str)]| {
        let mut variables = vec![variable("H", MatValue::U8(samples.view()))];
        variables.extend(names.iter().map(|&(name, order)| variable(name, MatValue::Text(order))));
        write_mat(&path, &variables, &PLAIN).unwrap();
        let views = read_mat_light_field(&path, &Limits::default()).unwrap().light_field.shape().views();
        (views.rows, views.columns)
    };
    assert_eq!(shape(&[]), (2, 3));
    assert_eq!(shape(&[("axes", "tsvuc")]), (4, 5));
    assert_eq!(shape(&[("axis_order", "tsvuc")]), (4, 5));
    assert_eq!(shape(&[("axes", "vutsc"), ("axis_order", "tsvuc")]), (4, 5));
}

//! HDF5 light fields: bit for bit there and back, in parts, streamed, beside h5py, and on a full disk.
#![cfg(feature = "hdf5")]

use crate::python;
use std::process::Command;

use crate::common::{data, names};
use crate::rigs::unequal_baselines as rig;
use holo_core::{DynLightField, GridSize, LightField, LightFieldShape, SampleKind};
use holo_io::{Error, FileFormat, Hdf5LightField, Hdf5Map, Hdf5Options, Hdf5Writer, Limits, detect_format, write_hdf5};
use ndarray::{Array2, Array3, Array4, Array5, Axis, Slice};
use proptest::prelude::*;

fn value((v, u, t, s, c): (usize, usize, usize, usize, usize)) -> f32 {
    (v * 97 + u * 31 + t * 11 + s * 5 + c * 3) as f32
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn any_shape_chunk_and_strides(
        shape in prop::array::uniform5(1_usize..6),
        chunk in prop::option::of(prop::array::uniform4(1_usize..8)),
        gzip_level in 0_u8..3,
        reversed in any::<bool>(),
        step in 1_usize..5,
    ) {
        let [v, u, t, s, c] = shape;
        let shape = LightFieldShape::new(GridSize::new(t, s), GridSize::new(v, u)).unwrap();
        let mut samples = Array5::from_shape_fn((c, t, v, s, u), |(c, t, v, s, u)| value((v, u, t, s, c)) / 7.0)
            .permuted_axes([2, 4, 1, 3, 0]);
        if reversed {
            samples.invert_axis(Axis(1));
        }
        let depth = Array4::from_shape_fn((v, u, t, s), |(v, u, t, s)| value((v, u, t, s, 0)) + 0.5);
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("scene_5d.h5");
        let options = Hdf5Options::default().gzip_level(gzip_level).chunk(chunk);
        let mut writer = Hdf5Writer::<f32>::create(&path, &rig(shape), c, &[Hdf5Map::Depth], &options).unwrap();
        // Any number of rows at a time.
        for start in (0..v).step_by(step) {
            let range = Slice::from(start..v.min(start + step));
            writer.write_lens_rows(samples.slice_axis(Axis(0), range)).unwrap();
            writer.write_map_lens_rows(Hdf5Map::Depth, depth.slice_axis(Axis(0), range)).unwrap();
        }
        let written = writer.finish().unwrap();
        prop_assert_eq!(written, holo_io::hash_file(&path).unwrap());
        let file = Hdf5LightField::open(&path, &Limits::default()).unwrap();
        let field = LightField::new(samples).unwrap();
        prop_assert_eq!(file.rig(), Some(&rig(shape)));
        prop_assert_eq!(file.read_view(t - 1, s / 2).unwrap(), field.view(t - 1, s / 2).unwrap().to_owned().into());
        prop_assert_eq!(file.read_lens(v / 2, u - 1).unwrap(), field.elemental_image(v / 2, u - 1).unwrap().to_owned().into());
        prop_assert_eq!(file.read_map(Hdf5Map::Depth).unwrap(), depth.view());
        let central = depth.index_axis(Axis(2), t / 2).index_axis_move(Axis(2), s / 2).to_owned();
        prop_assert_eq!(file.read_central_map(Hdf5Map::Depth).unwrap(), central);
        prop_assert_eq!(file.read().unwrap(), DynLightField::F32(field));
    }
}

#[test]
fn integers_and_the_central_view() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene_5d.h5");
    let shape = LightFieldShape::new(GridSize::new(2, 3), GridSize::new(4, 5)).unwrap();
    let raw = Array3::from_shape_fn((8, 15, 3), |(y, x, c)| (y * 45 + x * 3 + c) as u16 * 180);
    let field = LightField::from_elemental_grid(raw, shape).unwrap();
    let depth = Array2::from_shape_fn((4, 5), |(v, u)| if v == 0 { f32::INFINITY } else { u as f32 });
    let central = [(Hdf5Map::Depth, depth.view()), (Hdf5Map::Disparity, depth.view())];
    let options = Hdf5Options::default();
    write_hdf5(&path, &field, &rig(shape), &[], &central, &options).unwrap();
    let file = Hdf5LightField::open(&path, &Limits::default()).unwrap();
    assert_eq!((file.sample_kind(), file.channels(), file.shape()), (SampleKind::U16, 3, shape));
    assert_eq!(file.maps(), (vec![], vec![Hdf5Map::Depth, Hdf5Map::Disparity]));
    assert_eq!(file.read_central_map(Hdf5Map::Disparity).unwrap(), depth);
    assert_eq!(file.read().unwrap(), DynLightField::U16(field.clone()));
    assert!(file.read_view(0, 0).is_ok() && file.read_map(Hdf5Map::Depth).is_err());
    let [view, lens] = [file.read_view(2, 0), file.read_lens(0, 5)].map(|part| part.unwrap_err().to_string());
    assert!(view.contains("there is no view at row 2, column 0; 2 x 3 are there"), "{view}");
    assert!(lens.contains("at row 0, column 5; 4 x 5 are there"), "{lens}");
    assert_eq!(detect_format(&path).unwrap(), FileFormat::Hdf5);
    // The same again, and at another time: the same bytes.
    let first = std::fs::read(&path).unwrap();
    std::thread::sleep(std::time::Duration::from_millis(1100));
    write_hdf5(&path, &field, &rig(shape), &[], &central, &options).unwrap();
    assert!(std::fs::read(&path).unwrap() == first);
    assert_eq!(names(folder.path()), ["scene_5d.h5"]);
    write_hdf5(&path, &field.map(|&x| (x / 256) as u8).unwrap(), &rig(shape), &[], &[], &options).unwrap();
    let DynLightField::U8(read) = Hdf5LightField::open(&path, &Limits::default()).unwrap().read().unwrap() else {
        panic!("uint8")
    };
    assert_eq!(read, field.map(|&x| (x / 256) as u8).unwrap());
}

#[test]
fn what_does_not_fit_is_refused_and_leaves_the_old_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene_5d.h5");
    std::fs::write(&path, b"old").unwrap();
    let shape = LightFieldShape::new(GridSize::new(2, 3), GridSize::new(4, 5)).unwrap();
    let create =
        || Hdf5Writer::<u8>::create(&path, &rig(shape), 3, &[Hdf5Map::Depth], &Hdf5Options::default()).unwrap();
    let rows = Array5::<u8>::zeros((4, 5, 2, 3, 3));
    let bad = |error: Error| assert!(matches!(error, Error::BadInput { .. }), "{error}");
    let mut writer = create();
    bad(writer.write_lens_rows(rows.slice_axis(Axis(1), Slice::from(..4))).unwrap_err());
    bad(writer.write_map_lens_rows(Hdf5Map::RayLength, Array4::zeros((4, 5, 2, 3)).view()).unwrap_err());
    bad(writer.write_central_map(Hdf5Map::Depth, Array2::zeros((5, 4)).view()).unwrap_err());
    writer.write_lens_rows(rows.view()).unwrap();
    bad(writer.write_lens_rows(rows.view()).unwrap_err());
    // The depth is missing.
    bad(writer.finish().unwrap_err());
    drop(create());
    assert_eq!((names(folder.path()), std::fs::read(&path).unwrap()), (vec!["scene_5d.h5".into()], b"old".to_vec()));
    let error = Hdf5LightField::open(&path, &Limits::default()).unwrap_err();
    assert!(matches!(error, Error::Broken { .. }), "{error}");
    assert!(matches!(Hdf5LightField::open("/missing", &Limits::default()), Err(Error::Io { .. })));
    let bad_options = Hdf5Options::default().gzip_level(10);
    assert!(Hdf5Writer::<u8>::create(&path, &rig(shape), 3, &[], &bad_options).is_err());
    assert!(Hdf5Writer::<u8>::create("/dev/null", &rig(shape), 3, &[], &Hdf5Options::default()).is_err());
}

#[test]
fn limits_are_for_the_part_and_its_chunks() {
    let path = data("h5py_lf.h5");
    let file = Hdf5LightField::open(&path, &Limits { max_bytes: 480 }).unwrap();
    // A chunk is 2 x 2 x 2 x 5 x 3 floats, a view 4 x 3 x 3, the whole 1440 bytes.
    assert!(file.read_view(0, 0).is_ok());
    assert!(matches!(file.read(), Err(Error::TooLarge { needed: 1440, .. })));
    let file = Hdf5LightField::open(&path, &Limits { max_bytes: 479 }).unwrap();
    assert!(matches!(file.read_view(0, 0), Err(Error::TooLarge { needed: 480, .. })));
}

#[test]
fn files_of_h5py_read_bit_for_bit() {
    let file = Hdf5LightField::open(data("h5py_lf.h5"), &Limits::default()).unwrap();
    let expected = Array5::from_shape_fn((4, 3, 2, 5, 3), |at| value(at) / 7.0);
    assert_eq!(file.read().unwrap(), DynLightField::F32(LightField::new(expected).unwrap()));
    // Parallel projection with a focus at infinity: its pixels are read all the same.
    assert_eq!(file.rig(), None);
    assert!(matches!(file.rig_error(), Some(holo_core::Error::OrthographicFocus { .. })));
    let depth = file.read_map(Hdf5Map::Depth).unwrap();
    assert_eq!(depth, Array4::from_shape_fn((4, 3, 2, 5), |(v, u, t, s)| value((v, u, t, s, 0)) / 3.0));
    let file = Hdf5LightField::open(data("h5py_u16.h5"), &Limits::default()).unwrap();
    assert_eq!((file.sample_kind(), file.rig()), (SampleKind::U16, None));
    let expected = Array5::from_shape_fn((4, 3, 2, 5, 3), |at| value(at) as u16);
    assert_eq!(file.read().unwrap(), DynLightField::U16(LightField::new(expected).unwrap()));
}

#[test]
fn h5py_reads_ours() {
    const SCRIPT: &str = r#"
import numpy as np
file = h5py.File(sys.argv[1])
v, u, t, s, c = np.ogrid[:4, :3, :2, :5, :3]
value = v * 97 + u * 31 + t * 11 + s * 5 + c * 3
H = file["H"]
assert H.dtype == np.float32 and (H[...] == value.astype(np.float32) / np.float32(7)).all()
assert [H.dims[i].label for i in range(5)] == list("vutsc"), [H.dims[i].label for i in range(5)]
assert [file["depth_m"].dims[i].label for i in range(4)] == list("vuts")
# Few views are not compressed, so that training reads them at random; pixels of one view are.
assert H.compression is None and not H.shuffle and H.chunks == (4, 3, 1, 1, 3)
assert file["central/disparity_px"].compression == "gzip" and file["central/disparity_px"].shuffle
central = file["central/disparity_px"]
for dataset, axes in [(H, "vutsc"), (file["depth_m"], "vuts"), (central, "vu")]:
    for i, axis in enumerate(axes):
        assert len(dataset.dims[i]) == 1 and dataset.dims[i][0] == file[axis], (dataset, axis)
        assert (dataset.dims[i][0][...] == np.arange(dataset.shape[i])).all()
for axis, uses in zip("vutsc", [3, 3, 2, 2, 1]):
    assert file[axis].is_scale and h5py.h5ds.get_scale_name(file[axis].id) == axis.encode()
    assert len(file[axis].attrs["REFERENCE_LIST"]) == uses, axis
assert (file["depth_m"][...] == value[..., 0] + 0.5).all() and file["depth_m"].attrs["units"] == "m"
assert (file["central/disparity_px"][...] == 2).all()
assert file.attrs["axes"] == "vutsc" and file.attrs["projection"] == "perspective"
assert file.attrs["views"].tolist() == [2, 5] and file.attrs["lenses"].tolist() == [4, 3]
assert file.attrs["baseline_m"].tolist() == [2e-4, 1e-4] and file.attrs["focal_length_mm"] == 35.1
assert file.attrs["sensor_size_mm"] == 36 and file.attrs["focus_distance_m"] == np.inf
print("fine")
"#;
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene_5d.h5");
    let shape = LightFieldShape::new(GridSize::new(2, 5), GridSize::new(4, 3)).unwrap();
    let field = LightField::new(Array5::from_shape_fn((4, 3, 2, 5, 3), |at| value(at) / 7.0)).unwrap();
    let depth = Array4::from_shape_fn((4, 3, 2, 5), |(v, u, t, s)| value((v, u, t, s, 0)) + 0.5);
    let disparity = Array2::from_elem((4, 3), 2.0);
    let maps = [(Hdf5Map::Depth, depth.view())];
    let central = [(Hdf5Map::Disparity, disparity.view())];
    write_hdf5(&path, &field, &rig(shape), &maps, &central, &Hdf5Options::default()).unwrap();
    if let Some(text) = python::run(&["h5py"], SCRIPT, &[path.to_str().unwrap()]) {
        assert_eq!(text.trim(), "fine");
    }
}

#[test]
fn damaged_attributes_are_errors() {
    // Only what this crate makes of them: the C library's own parsing is not put to the test.
    let whole = std::fs::read(data("h5py_lf.h5")).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("x.h5");
    let at = |needle: &[u8]| whole.windows(needle.len()).position(|window| window == needle).unwrap();
    for (needle, replacement) in [
        (&b"orthographic"[..], &b"isometric###"[..]),
        (&[2, 0, 0, 0, 0, 0, 0, 0, 5, 0, 0, 0, 0, 0, 0, 0], &[3, 0, 0, 0, 0, 0, 0, 0, 5, 0, 0, 0, 0, 0, 0, 0]),
    ] {
        let mut bytes = whole.clone();
        let start = at(needle);
        bytes[start..start + replacement.len()].copy_from_slice(replacement);
        std::fs::write(&path, &bytes).unwrap();
        let opened = Hdf5LightField::open(&path, &Limits::default());
        assert!(matches!(opened, Err(Error::Broken { .. })), "{opened:?}");
    }
    for end in [0, 7, 8, 500, 2000, whole.len() - 1] {
        std::fs::write(&path, &whole[..end]).unwrap();
        assert!(matches!(Hdf5LightField::open(&path, &Limits::default()), Err(Error::Broken { .. })), "{end}");
    }
}

/// What the test below does in a process of its own, so that its standard error can be looked at.
#[test]
#[ignore = "run by another test in a process of its own"]
fn fill_the_disk() {
    let folder = std::path::PathBuf::from(std::env::var_os("HOLO_IO_TEST_FOLDER").unwrap());
    let shape = LightFieldShape::new(GridSize::new(20, 20), GridSize::new(16, 16)).unwrap();
    let noise = |at: (usize, usize, usize, usize, usize)| (value(at) * 0.618).sin();
    let field = LightField::new(Array5::from_shape_fn((16, 16, 20, 20, 3), noise)).unwrap();
    for gzip_level in [0, 1] {
        let path = folder.join("big.h5");
        let options = Hdf5Options::default().gzip_level(gzip_level);
        let error = write_hdf5(&path, &field, &rig(shape), &[], &[], &options).unwrap_err();
        let Error::Io { error: source, .. } = &error else { panic!("{error}") };
        assert_eq!(source.kind(), std::io::ErrorKind::StorageFull, "{error}");
        assert_eq!(names(&folder), [""; 0]);
    }
    // There is room again, and the library still works.
    let small = LightFieldShape::new(GridSize::new(1, 1), GridSize::new(2, 2)).unwrap();
    let field = LightField::new(Array5::<u8>::zeros(small.array_shape(1))).unwrap();
    write_hdf5(folder.join("small.h5"), &field, &rig(small), &[], &[], &Hdf5Options::default()).unwrap();
    assert_eq!(names(&folder), ["small.h5"]);
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_an_error_and_nothing_is_left_of_it() {
    let folder = tempfile::tempdir().unwrap();
    let mounted = Command::new("mount").args(["-t", "tmpfs", "-o", "size=64k", "tmpfs"]).arg(folder.path()).output();
    if !mounted.is_ok_and(|output| output.status.success()) {
        eprintln!("not run: needs the right to mount a small file system (root)");
        return;
    }
    let output = Command::new(std::env::current_exe().unwrap())
        .args(["hdf5::fill_the_disk", "--exact", "--ignored", "--nocapture"])
        .env("HOLO_IO_TEST_FOLDER", folder.path())
        .output()
        .unwrap();
    let unmounted = Command::new("umount").arg(folder.path()).status().unwrap();
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{stderr}");
    assert!(unmounted.success());
    // The library prints its stack of errors unless it is told not to.
    assert!(!stderr.contains("HDF5"), "{stderr}");
}

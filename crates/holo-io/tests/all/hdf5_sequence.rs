//! `sequence_5d.h5`: the frames of a sequence as one array, beside h5py, moved, with a frame missing, and of
//! frames that do not belong together.
#![cfg(feature = "hdf5")]

use crate::python;
use std::path::Path;

use holo_core::{GridSize, LightField, LightFieldShape, Rig};
use holo_io::dataset::{LIGHT_FIELD_HDF5, MANIFEST_JSON, PARAMETERS_CFG, SEQUENCE_HDF5, SequenceFolder};
use holo_io::{
    CameraPose, Error, Hdf5LightField, Hdf5Map, Hdf5Options, Limits, Manifest, ManifestValue, ParametersCfg,
    write_hdf5, write_hdf5_sequence,
};
use ndarray::{Array2, Array4, Array5};

/// Writes a frame of `lenses` lenses a row, in which samples and depths tell their place and the frame.
fn write_frame(root: &Path, frame: u32, lenses: usize) {
    let folder = root.join(SequenceFolder::frame_name(frame));
    std::fs::create_dir(&folder).unwrap();
    let shape = LightFieldShape::new(GridSize::new(2, 5), GridSize::new(4, lenses)).unwrap();
    let rig = Rig::builder(shape)
        .focal_length_m(0.05 + f64::from(frame) * 1e-3)
        .sensor_size_m(0.036)
        .baseline_m(1e-3)
        .focus_distance_m(2.0)
        .build()
        .unwrap();
    let value = |(v, u, t, s, c)| (v * 97 + u * 31 + t * 11 + s * 5 + c * 3) as f32 + frame as f32 * 1000.0;
    let samples = LightField::new(Array5::from_shape_fn(shape.array_shape(3), value)).unwrap();
    let depth = Array4::from_shape_fn((4, lenses, 2, 5), |(v, u, t, s)| value((v, u, t, s, 0)) + 0.5);
    let disparity = Array2::from_elem((4, lenses), frame as f32);
    let maps = [(Hdf5Map::Depth, depth.view())];
    let central = [(Hdf5Map::Disparity, disparity.view())];
    let options = Hdf5Options::default();
    write_hdf5(folder.join(LIGHT_FIELD_HDF5), &samples, &rig, &maps, &central, &options).unwrap();
    let mut parameters = ParametersCfg::from_rig(&rig);
    let position_m = [f64::from(frame), 2.0, 3.0];
    parameters.center_cam = Some(CameraPose { position_m, rotation_rad: [0.25, 0.5, 0.75] });
    let mut manifest = Manifest { rig: Some(rig), ..Manifest::default() };
    manifest.settings.insert("time_s".into(), ManifestValue::Float(f64::from(frame) / 8.0));
    manifest.files.insert(PARAMETERS_CFG.into(), parameters.write(folder.join(PARAMETERS_CFG)).unwrap());
    manifest.write(folder.join(MANIFEST_JSON)).unwrap();
}

#[test]
fn h5py_reads_all_frames_as_one_array() {
    const SCRIPT: &str = r#"
import os
import numpy as np
path = sys.argv[1]
f, v, u, t, s, c = np.ogrid[:3, :4, :3, :2, :5, :3]
value = (v * 97 + u * 31 + t * 11 + s * 5 + c * 3 + (f + 7) * 1000).astype(np.float32)
with h5py.File(path) as file:
    assert file.attrs["format"] == "holo light field sequence 1" and file.attrs["axes"] == "fvutsc"
    assert file["H"].is_virtual and file["H"].dtype == np.float32
    assert (file["H"][...] == value).all() and (file["H"][1, :, :, 0, 3] == value[1, :, :, 0, 3]).all()
    assert (file["depth_m"][...] == value[..., 0] + 0.5).all()
    assert (file["central/disparity_px"][...] == np.arange(7, 10)[:, None, None]).all()
    # xarray and netCDF take the names and coordinates of dimensions from their scales.
    for name, axes in [("H", "fvutsc"), ("depth_m", "fvuts"), ("central/disparity_px", "fvu"), ("time_s", "f"),
                       ("focal_length_mm", "f"), ("baseline_m", "fj"), ("camera_position_m", "fi"), ("camera_rotation_rad", "fi")]:
        dataset = file[name]
        assert dataset.ndim == len(axes) and dataset.attrs["axes"] == axes
        for i, axis in enumerate(axes):
            assert list(dataset.dims[i].values()) == [file[axis]] and dataset.dims[i].label == axis, (name, axis)
    assert file["f"][...].tolist() == [7, 8, 9] and file["i"].shape == (3,)
    assert file["time_s"][...].tolist() == [0.875, 1, 1.125]
    assert np.allclose(file["focal_length_mm"], [57, 58, 59], rtol=1e-15)
    assert file["camera_position_m"][...].tolist() == [[7, 2, 3], [8, 2, 3], [9, 2, 3]]
    assert file["camera_rotation_rad"][...].tolist() == [[0.25, 0.5, 0.75]] * 3
    assert file.attrs["views"].tolist() == [2, 5]
os.remove(os.path.join(os.path.dirname(path), "frame_0008", "scene_5d.h5"))
with h5py.File(path) as file:
    assert np.isnan(file["H"][1]).all() and (file["H"][2] == value[2]).all()
print("fine")
"#;
    let folder = tempfile::tempdir().unwrap();
    let [here, there] = ["here", "there"].map(|name| folder.path().join(name));
    std::fs::create_dir(&here).unwrap();
    (7..10).for_each(|frame| write_frame(&here, frame, 3));
    let sequence = SequenceFolder::open(&here).unwrap();
    write_hdf5_sequence(&sequence, sequence.frames()).unwrap();
    let first = std::fs::read(here.join(SEQUENCE_HDF5)).unwrap();
    assert!(first.len() < 100_000, "{} bytes", first.len());
    // The same bytes again, whatever was there.
    std::thread::sleep(std::time::Duration::from_millis(1100));
    write_hdf5_sequence(&sequence, sequence.frames()).unwrap();
    assert!(first == std::fs::read(here.join(SEQUENCE_HDF5)).unwrap());
    let error = Hdf5LightField::open(here.join(SEQUENCE_HDF5), &Limits::default()).unwrap_err();
    assert!(error.to_string().contains("a sequence of 3 frames"), "{error}");
    // Moved as a whole.
    std::fs::rename(&here, &there).unwrap();
    let path = there.join(SEQUENCE_HDF5);
    if let Some(text) = python::run(&["h5py"], SCRIPT, &[path.to_str().unwrap()]) {
        assert_eq!(text.trim(), "fine");
    }
}

#[test]
fn frames_that_do_not_belong_together_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    write_frame(folder.path(), 0, 3);
    write_frame(folder.path(), 1, 4);
    let sequence = SequenceFolder::open(folder.path()).unwrap();
    let error = |frames: &[u32]| write_hdf5_sequence(&sequence, frames).unwrap_err();
    let other = error(&[0, 1]);
    assert!(matches!(other, Error::BadInput { .. }) && other.to_string().contains("frame 1"), "{other}");
    assert!(matches!(error(&[]), Error::BadInput { .. }));
    assert!(matches!(error(&[0, 2]), Error::Io { .. }));
    let file = folder.path().join("frame_0000").join(LIGHT_FIELD_HDF5);
    std::fs::write(&file, b"no HDF5").unwrap();
    assert!(matches!(error(&[0]), Error::Broken { .. }));
    assert!(!folder.path().join(SEQUENCE_HDF5).exists());
}

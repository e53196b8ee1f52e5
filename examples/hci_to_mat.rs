//! Converts a folder of the HCI 4D light field benchmark to one MAT file, with its rig.
//!
//! `cargo run --example hci_to_mat -- FOLDER light_field.mat`, or without arguments on a synthetic folder. In MATLAB:
//! `load('light_field.mat'); imshow(squeeze(LF(5, 5, :, :, :)))`.

use holo_core::{DynLightField, GridSize, Layout, LightField, LightFieldShape, Rig, for_each_sample};
use holo_io::{
    Compression, HciImage, HciTruth, MatOptions, MatOrder, ParametersCfg, ReadOptions, read_light_field,
    write_mat_light_field,
};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let scratch = tempfile::tempdir()?;
    let (folder, out) = match arguments.as_slice() {
        [folder, out] => (folder.into(), out.into()),
        _ => {
            write_hci_folder(scratch.path())?;
            (scratch.path().to_owned(), std::env::temp_dir().join("holo_example_light_field.mat"))
        }
    };

    let file = read_light_field(&folder, &ReadOptions::default())?;
    // LF(t, s, v, u, c), the order of the Light Field Toolbox.
    let (order, options) = (MatOrder::LightFieldToolbox, MatOptions::default());
    let digest = for_each_sample!(DynLightField, &file.light_field, field => {
        write_mat_light_field(&out, field, file.rig.as_ref(), order, &options)
    })?;
    println!("{:?}: {} bytes in {}", file.format, digest.bytes, out.display());
    Ok(())
}

/// Nine views of one gray each, with the parameters of their rig.
fn write_hci_folder(folder: &std::path::Path) -> Result<(), Box<dyn std::error::Error>> {
    let shape = LightFieldShape::new(GridSize::new(3, 3), GridSize::new(32, 48))?;
    let mut light_field = LightField::filled(shape, 3, Layout::ViewpointGrid, 0_u8)?;
    light_field.views_mut().for_each(|((t, s), mut view)| view.fill((25 * (t * 3 + s)) as u8));
    let rig = Rig::builder(shape)
        .focal_length_m(0.1)
        .sensor_size_m(0.035)
        .baseline_m(0.025)
        .focus_distance_m(4.25)
        .build()?;
    HciImage {
        views: Some((&DynLightField::from(light_field)).into()),
        parameters: &ParametersCfg::from_rig(&rig),
        disparity_px: HciTruth::None,
        depth_m: HciTruth::None,
        high_resolution: None,
    }
    .write(folder, Compression::Fast)?;
    Ok(())
}

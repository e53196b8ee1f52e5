//! What shows the picture of a render: raw PNGs and 5D arrays.
//!
//! Linear radiance goes into HDF5 and EXR as it is; exposure and the sRGB curve come between it and all integers.

use holo_core::{LightFieldOwned, Rig};
use holo_io::{Compression, MatOptions, MatOrder, Meaning, StoredSample, Written, dataset};
use holo_render::{Rendered, exposure};
use ndarray::ArrayView3;

use super::layers::{self, Wanted};
use super::output::OutputFolder;
use crate::arguments::{GroundTruthArgument, MatOrderArgument, Output, RenderOptions};
use crate::failure::Failure;

/// Outputs that need a picture, with what they are called.
pub const NEED_COLOR: [(Output, &str); 4] =
    [(Output::Vpi, "vpi"), (Output::El, "el"), (Output::Mat, "mat"), (Output::H5, "h5")];

/// What is written when nothing is named.
pub const USUAL: [Output; 3] = [Output::Vpi, Output::El, Output::Mat];

/// The names of those outputs among `write` that need a picture, as in "vpi and el".
pub fn needing_color(write: &[Output]) -> Option<String> {
    let names: Vec<&str> =
        NEED_COLOR.iter().filter(|(output, _)| write.contains(output)).map(|(_, name)| *name).collect();
    let (last, others) = names.split_last()?;
    Some(if others.is_empty() { (*last).to_owned() } else { format!("{} and {last}", others.join(", ")) })
}

/// Writes all that shows the picture.
pub fn write(
    folder: &mut OutputFolder,
    options: &RenderOptions,
    wanted: &Wanted,
    rendered: &mut Rendered,
    rig: &Rig,
    outputs: &[Output],
    exposure_ev: Option<f64>,
) -> Result<(), Failure> {
    if outputs.contains(&Output::Exr) {
        layers::write_exr(folder, rendered)?;
    }
    if let Some(color) = rendered.color.as_ref().filter(|_| wanted.color) {
        layers::write_color(folder, color, options.ground_truth == GroundTruthArgument::All)?;
    }
    if outputs.contains(&Output::H5) {
        write_hdf5(folder, rendered, rig)?;
    }
    // The radiance is four times the size of what is written: it goes as soon as it is encoded.
    if let (Some(color), Some(ev)) = (rendered.color.take(), exposure_ev) {
        if options.bit_depth == 16 {
            let coded = exposure::encode_16bit(&color, ev)?;
            drop(color);
            write_coded(folder, options, outputs, &coded, rig, holo_io::write_png_u16)?;
        } else {
            let coded = exposure::encode_8bit(&color, ev)?;
            drop(color);
            write_coded(folder, options, outputs, &coded, rig, holo_io::write_png_u8)?;
        }
    }
    Ok(())
}

type WritePng<T> = fn(std::path::PathBuf, ArrayView3<T>, Meaning, Compression) -> Result<Written, holo_io::Error>;

/// The files of integers, side by side on the threads.
fn write_coded<T: StoredSample>(
    folder: &mut OutputFolder,
    options: &RenderOptions,
    outputs: &[Output],
    coded: &LightFieldOwned<T>,
    rig: &Rig,
    png: WritePng<T>,
) -> Result<(), Failure> {
    let write = |name: &str, image: ArrayView3<T>| png(folder.file(name), image, Meaning::Srgb, Compression::Published);
    let elemental = || {
        outputs.contains(&Output::El).then(|| {
            let name = dataset::ELEMENTAL_PNG;
            match coded.as_elemental_grid() {
                Some(image) => write(name, image),
                None => write(name, coded.to_elemental_grid().view()),
            }
        })
    };
    let viewpoint = || {
        let wanted = outputs.contains(&Output::Vpi);
        wanted.then(|| write(dataset::VIEWPOINT_PNG, coded.to_viewpoint_grid().view()))
    };
    let mat = || {
        outputs.contains(&Output::Mat).then(|| {
            let order = match options.mat_order {
                MatOrderArgument::Lenses => MatOrder::Lenses,
                MatOrderArgument::Lftoolbox => MatOrder::LightFieldToolbox,
            };
            let path = folder.file(dataset::LIGHT_FIELD_MAT);
            holo_io::write_mat_light_field(path, coded, Some(rig.parameters()), order, &MatOptions::default())
        })
    };
    let ((elemental, viewpoint), mat) = rayon::join(|| rayon::join(elemental, viewpoint), mat);
    let written =
        [(dataset::ELEMENTAL_PNG, elemental), (dataset::VIEWPOINT_PNG, viewpoint), (dataset::LIGHT_FIELD_MAT, mat)];
    for (name, written) in written {
        if let Some(written) = written {
            folder.add(name, written?);
        }
    }
    Ok(())
}

/// Linear radiance and the maps that were rendered: of all views if there are any, else of the central one.
#[cfg(feature = "hdf5")]
fn write_hdf5(folder: &mut OutputFolder, rendered: &Rendered, rig: &Rig) -> Result<(), Failure> {
    use holo_io::{Hdf5Map, Hdf5Options};
    use holo_render::Layer;
    use ndarray::Axis;

    let Some(color) = &rendered.color else { return Ok(()) };
    let kind = |layer: Layer| match layer {
        Layer::Depth => Some(Hdf5Map::Depth),
        Layer::RayLength => Some(Hdf5Map::RayLength),
        Layer::Disparity => Some(Hdf5Map::Disparity),
        _ => None,
    };
    let all = rendered.all.iter().flat_map(holo_render::Layers::iter);
    let maps: Vec<_> =
        all.filter_map(|(layer, field)| Some((kind(layer)?, field.samples().index_axis_move(Axis(4), 0)))).collect();
    let central = rendered.central.iter().filter(|_| maps.is_empty());
    let central: Vec<_> =
        central.filter_map(|(layer, image)| Some((kind(layer)?, image.index_axis(Axis(2), 0)))).collect();
    let name = dataset::LIGHT_FIELD_HDF5;
    let written =
        holo_io::write_hdf5(folder.file(name), color, rig.parameters(), &maps, &central, &Hdf5Options::default())?;
    folder.add(name, written);
    Ok(())
}

#[cfg(not(feature = "hdf5"))]
fn write_hdf5(_: &mut OutputFolder, _: &Rendered, _: &Rig) -> Result<(), Failure> {
    Err(without_hdf5())
}

/// Why a build without HDF5 cannot.
#[cfg(not(feature = "hdf5"))]
pub fn without_hdf5() -> Failure {
    Failure::Usage(
        "this build of holo has no HDF5; `cargo xtask build` makes one that has, or cargo build --features hdf5".into(),
    )
}

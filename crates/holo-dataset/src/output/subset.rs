//! Some of the views of a rig. They are written with the numbers that they have in the whole grid, `hci/input_Cam040.png`, and without the others; the
//! rig in `parameters.cfg` is that of the whole grid. With the same exposure they are those of a render of all views without
//! path reuse: byte for byte, unless a rounding of the ray tracing backend, which depends on the rays that are traced together, decides a code.

use holo_core::{GridSize, LightFieldOwned, Sample, ViewIndex};
use holo_io::{ColorEncoding, Compression, FolderFile, ParametersCfg, dataset, hci};
use holo_render::{Denoise, GroundTruth};
use rayon::prelude::*;

use super::folder::OutputFolder;
use crate::Error;
use crate::settings::{LayerChoice, Output, RenderSettings, RigSettings, ViewSubset};

/// Checks what else a render of some views may have.
pub(crate) fn check(settings: &RenderSettings, rig: &RigSettings) -> Result<(), Error> {
    let Some(subset) = &rig.subset else { return Ok(()) };
    let output = &settings.output;
    let bad = |what: String| Err(Error::BadRequest(what));
    if let Some(file) = output.write.iter().find(|output| **output != Output::Hci) {
        let name = file.name();
        return bad(format!("`write {name}` is of all views; `subset` writes hci, the files of single views"));
    }
    let of_all = [LayerChoice::Color, LayerChoice::Error, LayerChoice::All];
    if let Some(layer) = of_all.into_iter().find(|layer| output.layers.contains(layer)) {
        let name = layer.name();
        return bad(format!("`layers {name}` needs all views; remove it, or `subset`"));
    }
    if settings.light.denoise != Denoise::Off {
        return bad("`denoise views` needs all views; remove it, or `subset`".into());
    }
    if output.ground_truth == GroundTruth::All {
        return bad("`ground-truth all` is of all views; remove it, or `subset`".into());
    }
    if output.sensor_model.is_some() {
        return bad("`sensor-model` exposes the raw image of all views; remove it, or `subset`".into());
    }
    let GridSize { rows, columns } = rig.views;
    match subset {
        ViewSubset::List(list) => match list.iter().find(|view| view.row >= rows || view.column >= columns) {
            Some(ViewIndex { row, column }) => {
                bad(format!("`subset` has the view {column},{row}; there are {columns} x {rows}, counted from 0"))
            }
            None => Ok(()),
        },
        ViewSubset::Cross | ViewSubset::Star => Ok(()),
    }
}

/// Writes the views, which are side by side in `coded`, by their numbers in the whole grid.
pub(crate) fn write<T: Sample>(
    folder: &mut OutputFolder,
    coded: &LightFieldOwned<T>,
    views: &[ViewIndex],
    parameters: &ParametersCfg,
) -> Result<(), Error> {
    folder.subfolder(dataset::HCI_FOLDER)?;
    let columns = parameters.num_cams.columns;
    let name =
        |view: &ViewIndex| format!("{}/{}", dataset::HCI_FOLDER, hci::view_file_name(view.row * columns + view.column));
    let files: Vec<_> = views.iter().map(|view| (name(view), folder.file(&name(view)))).collect();
    let write_one = |(k, (_, path)): (usize, &(String, FolderFile))| {
        Ok(holo_io::write_png(path, coded.view(0, k)?, ColorEncoding::Srgb, Compression::Best)?)
    };
    let written = files.par_iter().enumerate().map(write_one).collect::<Result<Vec<_>, Error>>()?;
    for ((name, _), written) in files.iter().zip(written) {
        folder.add(name.clone(), written);
    }
    let name = format!("{}/{}", dataset::HCI_FOLDER, dataset::PARAMETERS_CFG);
    let written = parameters.write(folder.file(&name))?;
    folder.add(name, written);
    Ok(())
}

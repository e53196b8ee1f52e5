//! Raw PNGs as light fields: what `remap` and `extract` have in common.

use std::path::Path;

use holo_core::{GridSize, Layout, LightField, LightFieldOwned, Split};
use holo_io::{Limits, ParametersCfg, PngSamples, dataset};

use crate::arguments::LayoutArgument;
use crate::failure::Failure;

/// A raw image of either depth.
pub enum Raw {
    U8(LightFieldOwned<u8>),
    U16(LightFieldOwned<u16>),
}

/// Reads a raw PNG. Its layout comes from `from` or the file's name, its views from `views` or the `parameters.cfg`
/// beside it.
pub fn read(path: &Path, from: Option<LayoutArgument>, views: Option<GridSize>) -> Result<(Raw, Layout), Failure> {
    let layout = from.map(layout).or_else(|| holo_io::layout_of_file_name(path)).ok_or_else(|| {
        Failure::Usage(format!("{}: neither --from nor the name (_el, _vpi) says which grid this is", path.display()))
    })?;
    // Given views are believed; parameters must fit the image, or they are those of another one.
    let (views, lenses) = match views {
        Some(views) => (views, None),
        None => {
            let beside = path.with_file_name(dataset::PARAMETERS_CFG);
            let missing = |why: &dyn std::fmt::Display| {
                Failure::Usage(format!("how many views? give --views; {} does not tell: {why}", beside.display()))
            };
            let parameters = ParametersCfg::read(&beside).map_err(|e| missing(&e))?;
            (parameters.num_cams, Some(parameters.image_resolution_px))
        }
    };
    let samples = holo_io::read_png(path, &Limits::default())?;
    let (rows, columns, _) = samples.dim();
    if views.rows == 0 || views.columns == 0 || rows % views.rows != 0 || columns % views.columns != 0 {
        return Err(Failure::Usage(format!(
            "{}: {columns} x {rows} pixels do not divide into {} x {} views",
            path.display(),
            views.columns,
            views.rows
        )));
    }
    let split = Split::new(views, GridSize::new(rows / views.rows, columns / views.columns))?;
    if let Some(lenses) = lenses.filter(|lenses| *lenses != split.lenses()) {
        return Err(Failure::Usage(format!(
            "{}: {columns} x {rows} pixels are not the {} x {} views of {} x {} px that the {} beside it speaks of; if it \
             belongs to another image, give --views",
            path.display(),
            views.columns,
            views.rows,
            lenses.columns,
            lenses.rows,
            dataset::PARAMETERS_CFG
        )));
    }
    let raw = match samples {
        PngSamples::U8(image) => Raw::U8(wrap(image, split, layout)?),
        PngSamples::U16(image) => Raw::U16(wrap(image, split, layout)?),
    };
    Ok((raw, layout))
}

fn wrap<T: Copy>(image: ndarray::Array3<T>, split: Split, layout: Layout) -> Result<LightFieldOwned<T>, Failure> {
    Ok(match layout {
        Layout::ElementalGrid => LightField::from_elemental_grid(image, split)?,
        Layout::ViewpointGrid => LightField::from_viewpoint_grid(image, split)?,
    })
}

/// The layout that a word of the command line means.
pub fn layout(argument: LayoutArgument) -> Layout {
    match argument {
        LayoutArgument::El => Layout::ElementalGrid,
        LayoutArgument::Vpi => Layout::ViewpointGrid,
    }
}

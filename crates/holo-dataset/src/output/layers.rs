//! Layers of a render as float maps, and the names of their files.
//!
//! Every layer is written as a float map: `scene_<layer>.pfm` for the central view, and for all views a folder
//! `<layer>` with one map a view (`-` in the name of a layer is `_` in a file name). `scene_central.exr` contains all
//! layers of the central view.

use holo_core::LightFieldOwned;
use holo_io::dataset::{self, layer_of_view};
use holo_io::{ColorEncoding, Compression, Destination, FileDigest};
use holo_render::{Layer, Layers, Rendered};
use ndarray::{ArrayView3, Axis};
use rayon::prelude::*;

use super::folder::OutputFolder;
pub(crate) use super::names::{COLOR, ERROR, FLOWS, VISIBILITY, file_part};
use super::wanted::Wanted;
use crate::Error;

/// Writes the layers of `wanted`, and disparity also as PNG over the range `disparity_px`.
pub(crate) fn write(
    folder: &mut OutputFolder,
    wanted: &Wanted,
    rendered: &Rendered,
    disparity_px: Option<(f64, f64)>,
) -> Result<(), Error> {
    for (layer, image) in rendered.central.iter().filter(|(layer, _)| wanted.written.contains(*layer)) {
        write_central(folder, layer.name(), image.view())?;
    }
    if let Some(disparity) = rendered.central.disparity_px().filter(|_| wanted.written.contains(Layer::Disparity)) {
        let (low, high) = disparity_px.unwrap_or((0.0, 0.0));
        let path = folder.file(dataset::DISPARITY_PNG);
        let plane = disparity.index_axis(Axis(2), 0);
        let written = holo_io::write_disparity_png(path, plane, low, high, Compression::Best)?;
        folder.add(dataset::DISPARITY_PNG, written);
    }
    write_hit_mask(folder, dataset::HIT_MASK_PNG, wanted, rendered)?;
    let all = rendered.all.iter().flat_map(Layers::iter);
    for (layer, field) in all.filter(|(layer, _)| wanted.written.contains(*layer)) {
        write_all_views(folder, layer.name(), field)?;
    }
    Ok(())
}

/// Writes the mask of what is hit, if it is wanted: 255, and 0 where depth is infinite.
pub(crate) fn write_hit_mask(
    folder: &mut OutputFolder,
    name: &str,
    wanted: &Wanted,
    rendered: &Rendered,
) -> Result<(), Error> {
    let mask = rendered.central.iter().find(|(layer, _)| *layer == Layer::HitMask);
    let Some((_, mask)) = mask.filter(|_| wanted.hit_mask) else { return Ok(()) };
    let codes = mask.mapv(|hit| if hit > 0.0 { 255_u8 } else { 0 });
    let written = holo_io::write_png(folder.file(name), codes.view(), ColorEncoding::Linear, Compression::Best)?;
    folder.add(name, written);
    Ok(())
}

/// Writes a layer as float maps: of the central view, and with `all` of all views.
pub(super) fn write_views(
    folder: &mut OutputFolder,
    name: &str,
    field: &LightFieldOwned<f32>,
    all: bool,
) -> Result<(), Error> {
    write_central(folder, name, central_view(field)?)?;
    if all { write_all_views(folder, name, field) } else { Ok(()) }
}

pub(crate) fn central_view(field: &LightFieldOwned<f32>) -> Result<ArrayView3<'_, f32>, Error> {
    let (t, s) = field.shape().central_view();
    Ok(field.view(t, s)?)
}

/// Writes a layer of the central view.
pub(super) fn write_central(folder: &mut OutputFolder, name: &str, image: ArrayView3<f32>) -> Result<(), Error> {
    let file = format!("scene_{}.pfm", file_part(name));
    let written = write_pfm(folder.file(&file), image)?;
    folder.add(file, written);
    Ok(())
}

/// Writes one PFM a view into a folder.
fn write_all_views(folder: &mut OutputFolder, name: &str, field: &LightFieldOwned<f32>) -> Result<(), Error> {
    let name = file_part(name);
    folder.subfolder(&name)?;
    let views = field.shape().views();
    let written: Vec<(String, FileDigest)> = (0..views.count())
        .into_par_iter()
        .map(|k| {
            let file = layer_of_view(&name, k, views.count(), "pfm");
            let view = field.view(k / views.columns, k % views.columns)?;
            let written = write_pfm(folder.file(&file), view)?;
            Ok((file, written))
        })
        .collect::<Result<_, Error>>()?;
    written.into_iter().for_each(|(file, written)| folder.add(file, written));
    Ok(())
}

/// Writes a PFM, gray or RGB by the number of channels.
pub(crate) fn write_pfm(path: impl Destination, image: ArrayView3<f32>) -> Result<FileDigest, holo_io::Error> {
    match image.dim().2 {
        1 => holo_io::write_pfm(path, image.index_axis_move(Axis(2), 0)),
        _ => holo_io::write_pfm_rgb(path, image),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Depth and disparity have the file names of [`dataset`].
    #[test]
    fn files_are_named_by_their_layer() {
        let file = |layer: Layer| format!("scene_{}.pfm", file_part(layer.name()));
        assert_eq!(file(Layer::Depth), dataset::DEPTH_PFM);
        assert_eq!(file(Layer::Disparity), dataset::DISPARITY_PFM);
        assert_eq!(file(Layer::GeometricNormal), "scene_geometric_normal.pfm");
    }
}

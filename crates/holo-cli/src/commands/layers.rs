//! Layers of a render: which are wanted, under which names they are written.
//!
//! Every layer is a float map: `scene_<layer>.pfm` for the central view, a folder `<layer>` with one map a view for all
//! views (`-` in a layer's name is `_` in a file's). `scene_central.exr` holds all of the central view at once.

use std::path::PathBuf;

use holo_core::LightFieldOwned;
use holo_io::{Compression, Written, dataset};
use holo_render::{Layer, LayerSet, Layers, Rendered};
use ndarray::{ArrayView3, Axis};
use rayon::prelude::*;

use super::output::OutputFolder;
use crate::arguments::{GroundTruthArgument, JobOptions, LayerArgument, Output};
use crate::failure::Failure;

/// The name of the picture among the layers, in linear light.
const COLOR: &str = "color";

/// Which layers are wanted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Wanted {
    /// To be written as float maps.
    pub written: LayerSet,
    /// To be known of the central view, whether they are written or not.
    pub central: LayerSet,
    /// To be known of all views.
    pub all: LayerSet,
    /// Whether the picture is written as a float map too, where there is one.
    pub color: bool,
}

impl Wanted {
    pub fn new(options: &JobOptions) -> Self {
        let named = &options.layers;
        let mut written: LayerSet = named.iter().fold(LayerSet::EMPTY, |set, name| set.union(layers(*name)));
        if named.is_empty() && options.write.is_empty() {
            written = [Layer::Depth, Layer::Disparity].into();
        }
        for (output, layer) in [(Output::Depth, Layer::Depth), (Output::Disparity, Layer::Disparity)] {
            if options.write.contains(&output) {
                written = written.union([layer].into());
            }
        }
        // What the files of several layers hold.
        let mut held = written;
        if options.write.contains(&Output::H5) {
            held = held.union([Layer::Depth, Layer::RayLength, Layer::Disparity].into());
        }
        if options.write.contains(&Output::Hci) {
            held = held.union([Layer::Depth, Layer::Disparity].into());
        }
        let exr = options.write.contains(&Output::Exr);
        Self {
            written,
            // The range of disparities belongs to every dataset.
            central: if exr { LayerSet::ALL } else { held.union([Layer::Disparity].into()) },
            all: if options.ground_truth == GroundTruthArgument::All { held } else { LayerSet::EMPTY },
            color: names_color(options) || named.contains(&LayerArgument::All),
        }
    }

    /// Their names, for the manifest.
    pub fn names(&self, rendered: &Rendered) -> Vec<&'static str> {
        let color = (self.color && rendered.color.is_some()).then_some(COLOR);
        color.into_iter().chain(self.written.iter().map(Layer::name)).collect()
    }
}

/// Whether the picture is asked for by name, so that it cannot be left out.
pub fn names_color(options: &JobOptions) -> bool {
    options.layers.contains(&LayerArgument::Color)
}

/// The layers that a word of the command line means.
fn layers(argument: LayerArgument) -> LayerSet {
    let one = match argument {
        LayerArgument::Color => return LayerSet::EMPTY,
        LayerArgument::All => return LayerSet::ALL,
        LayerArgument::Depth => Layer::Depth,
        LayerArgument::RayLength => Layer::RayLength,
        LayerArgument::Disparity => Layer::Disparity,
        LayerArgument::GeometricNormal => Layer::GeometricNormal,
        LayerArgument::ShadingNormal => Layer::ShadingNormal,
        LayerArgument::Albedo => Layer::Albedo,
        LayerArgument::ObjectId => Layer::ObjectId,
        LayerArgument::MaterialId => Layer::MaterialId,
        LayerArgument::HitMask => Layer::HitMask,
    };
    LayerSet::of(&[one])
}

/// Writes all that `wanted` names, and the disparity's picture over the range `disparity_px`.
pub fn write(
    folder: &mut OutputFolder,
    wanted: &Wanted,
    rendered: &Rendered,
    disparity_px: Option<(f64, f64)>,
) -> Result<(), Failure> {
    for (layer, image) in rendered.central.iter().filter(|(layer, _)| wanted.written.contains(*layer)) {
        write_central(folder, layer.name(), image.view())?;
    }
    if let Some(disparity) = rendered.central.disparity_px().filter(|_| wanted.written.contains(Layer::Disparity)) {
        let (low, high) = disparity_px.unwrap_or((0.0, 0.0));
        let path = folder.file(dataset::DISPARITY_PNG);
        let plane = disparity.index_axis(Axis(2), 0);
        let written = holo_io::write_disparity_png(path, plane, low, high, Compression::Published)?;
        folder.add(dataset::DISPARITY_PNG, written);
    }
    let all = rendered.all.iter().flat_map(Layers::iter);
    for (layer, field) in all.filter(|(layer, _)| wanted.written.contains(*layer)) {
        write_all_views(folder, layer.name(), field)?;
    }
    Ok(())
}

/// Writes the picture as float maps, of the central view and, if they are wanted, of all views.
pub fn write_color(folder: &mut OutputFolder, color: &LightFieldOwned<f32>, all: bool) -> Result<(), Failure> {
    write_central(folder, COLOR, central_view(color)?)?;
    if all { write_all_views(folder, COLOR, color) } else { Ok(()) }
}

pub fn central_view(field: &LightFieldOwned<f32>) -> Result<ArrayView3<'_, f32>, Failure> {
    let (t, s) = field.split().central_view();
    Ok(field.view(t, s)?)
}

/// What the files of a layer have in their names.
fn file_part(name: &str) -> String {
    name.replace('-', "_")
}

fn write_central(folder: &mut OutputFolder, name: &str, image: ArrayView3<f32>) -> Result<(), Failure> {
    let file = format!("scene_{}.pfm", file_part(name));
    let written = write_pfm(folder.file(&file), image)?;
    folder.add(file, written);
    Ok(())
}

/// One PFM a view in a folder of its own, numbered as in the HCI layout: view row * columns + view column.
fn write_all_views(folder: &mut OutputFolder, name: &str, field: &LightFieldOwned<f32>) -> Result<(), Failure> {
    let name = file_part(name);
    folder.subfolder(&name)?;
    let views = field.split().views();
    let digits = 3.max((views.count() - 1).to_string().len());
    let written: Vec<(String, Written)> = (0..views.count())
        .into_par_iter()
        .map(|k| {
            let file = format!("{name}/scene_{name}_Cam{k:0digits$}.pfm");
            let view = field.view(k / views.columns, k % views.columns)?;
            let written = write_pfm(folder.file(&file), view)?;
            Ok((file, written))
        })
        .collect::<Result<_, Failure>>()?;
    written.into_iter().for_each(|(file, written)| folder.add(file, written));
    Ok(())
}

/// Grey or colour by the number of channels.
fn write_pfm(path: PathBuf, image: ArrayView3<f32>) -> Result<Written, holo_io::Error> {
    match image.dim().2 {
        1 => holo_io::write_pfm(path, image.index_axis_move(Axis(2), 0)),
        _ => holo_io::write_pfm_colour(path, image),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::ValueEnum;

    /// Every layer can be named, by its own name, and `all` means each of them.
    #[test]
    fn words_are_the_names_of_layers() {
        for argument in LayerArgument::value_variants() {
            let value = argument.to_possible_value().expect("none is skipped");
            let found: Vec<Layer> = layers(*argument).iter().collect();
            match value.get_name() {
                "all" => assert_eq!(found, Layer::ALL),
                COLOR => assert_eq!(found, []),
                name => assert_eq!(found, [Layer::from_name(name).expect("a layer")]),
            }
        }
        assert_eq!(LayerArgument::value_variants().len(), Layer::COUNT + 2);
    }

    /// The two oldest files are called what everybody calls them.
    #[test]
    fn files_are_named_by_their_layer() {
        let file = |layer: Layer| format!("scene_{}.pfm", file_part(layer.name()));
        assert_eq!(file(Layer::Depth), dataset::DEPTH_PFM);
        assert_eq!(file(Layer::Disparity), dataset::DISPARITY_PFM);
        assert_eq!(file(Layer::GeometricNormal), "scene_geometric_normal.pfm");
    }
}

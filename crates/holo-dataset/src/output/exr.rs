//! OpenEXR: linear radiance without exposure, for programs that work in linear light.

use holo_core::{GridSize, Layout, LightFieldOwned};
use holo_io::{ExrChannel, ExrCompression, ExrSamples, ExrWriter, dataset};
use holo_render::{Layer, Layers, Rendered};
use ndarray::{Array3, ArrayView2, ArrayView3, Axis};

use super::folder::OutputFolder;
use super::layers::central_view;
use crate::Error;

/// The largest finite 16-bit float.
const MAX_HALF: f32 = 65_504.0;

/// The channel names of an image without layers: what programs read that know no layers.
const PLAIN: [&str; 3] = ["R", "G", "B"];

/// Writes all layers and the color of the central view into one file of 32-bit floats. The color is there twice: as
/// Blender's layer, and with plain names.
pub(crate) fn write_central(folder: &mut OutputFolder, rendered: &Rendered) -> Result<(), Error> {
    let color = rendered.color.as_ref().map(central_view).transpose()?;
    let channels = channels(&rendered.central, color);
    let channels: Vec<_> = channels.iter().map(|(name, plane)| ExrChannel::float(name, plane.view())).collect();
    let path = folder.file(dataset::CENTRAL_EXR);
    folder.add(dataset::CENTRAL_EXR, holo_io::write_exr(path, &channels)?);
    Ok(())
}

/// Writes the color of the light field as elemental image array or sub-aperture image array, as 16-bit floats if all
/// values are in their range, else as 32-bit floats.
///
/// It is written lens row by lens row, or view row by view row, without a second copy in memory.
pub(crate) fn write_grid(folder: &mut OutputFolder, color: &LightFieldOwned<f32>, layout: Layout) -> Result<(), Error> {
    let shape = color.shape();
    let (views, lenses, size) = (shape.views(), shape.lenses(), shape.raw_size());
    let (name, bands) = match layout {
        Layout::ElementalGrid => (dataset::ELEMENTAL_EXR, lenses.rows),
        Layout::ViewpointGrid => (dataset::VIEWPOINT_EXR, views.rows),
    };
    let fits = color.samples().iter().all(|value| !value.is_finite() || value.abs() <= MAX_HALF);
    let samples = if fits { ExrSamples::Half } else { ExrSamples::Float };
    let size = GridSize::new(size.rows, size.columns);
    let path = folder.file(name);
    let mut exr = ExrWriter::create(path, size, &PLAIN.map(|name| (name, samples)), ExrCompression::Zip)?;
    for band in 0..bands {
        let rows: Array3<f32> = match layout {
            Layout::ElementalGrid => color.clip_lenses(band..band + 1, 0..lenses.columns)?.to_elemental_grid()?,
            Layout::ViewpointGrid => color.clip_views(band..band + 1, 0..views.columns)?.to_viewpoint_grid()?,
        };
        exr.write_rows(&[0, 1, 2].map(|channel| rows.index_axis(Axis(2), channel)))?;
    }
    folder.add(name, exr.finish()?);
    Ok(())
}

/// The name of a layer in an EXR and its components: those of Blender where it has the layer.
fn exr_name(layer: Layer) -> (String, &'static [&'static str]) {
    let (name, components): (_, &[_]) = match layer {
        Layer::Depth => ("Depth", &["Z"]),
        Layer::RayLength => ("RayLength", &["Z"]),
        Layer::ShadingNormal => ("Normal", &["X", "Y", "Z"]),
        Layer::Albedo => ("DiffCol", &["R", "G", "B"]),
        Layer::ObjectId => ("IndexOB", &["X"]),
        Layer::MaterialId => ("IndexMA", &["X"]),
        _ => return (camel_case(layer.name()), if layer.channels() == 3 { &["X", "Y", "Z"] } else { &["X"] }),
    };
    (name.to_owned(), components)
}

/// `HitMask` of `hit-mask`. The words of a layer are ASCII and not empty.
fn camel_case(name: &str) -> String {
    let word = |word: &str| word[..1].to_ascii_uppercase() + &word[1..];
    name.split('-').map(word).collect()
}

/// The planes of `scene_central.exr` with their names.
fn channels<'a>(
    central: &'a Layers<Array3<f32>>,
    color: Option<ArrayView3<'a, f32>>,
) -> Vec<(String, ArrayView2<'a, f32>)> {
    let layers = central.iter().map(|(layer, image)| (exr_name(layer), image.view()));
    let plain = color.into_iter().flat_map(|image| {
        PLAIN.iter().enumerate().map(move |(c, name)| ((*name).to_owned(), image.index_axis_move(Axis(2), c)))
    });
    let color = color.map(|image| (("Combined".to_owned(), &PLAIN[..]), image));
    let planes = color.into_iter().chain(layers).flat_map(|((pass, components), image)| {
        let plane = move |(c, component): (usize, &&str)| {
            (format!("ViewLayer.{pass}.{component}"), image.index_axis_move(Axis(2), c))
        };
        components.iter().enumerate().map(plane)
    });
    plain.chain(planes).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_channel_of_an_exr_has_a_unique_name() {
        let central: Layers<Array3<f32>> =
            Layer::ALL.into_iter().map(|layer| (layer, Array3::zeros((2, 3, layer.channels())))).collect();
        let color = Array3::zeros((2, 3, 3));
        let channels = channels(&central, Some(color.view()));
        let names: std::collections::BTreeSet<&str> = channels.iter().map(|(name, _)| name.as_str()).collect();
        let count = 2 * 3 + Layer::ALL.iter().map(|layer| layer.channels()).sum::<usize>();
        assert_eq!((names.len(), channels.len()), (count, count), "{names:?}");
        for name in ["Combined.R", "Depth.Z", "Normal.Y", "DiffCol.B", "IndexOB.X", "IndexMA.X", "Disparity.X"] {
            assert!(names.contains(format!("ViewLayer.{name}").as_str()), "{name}");
        }
        assert!(["R", "G", "B"].iter().all(|name| names.contains(name)), "{names:?}");
    }
}

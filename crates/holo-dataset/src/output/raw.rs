//! The files of the raw image of a plenoptic camera.

use holo_core::plenoptic::{MicrolensIndex, PlenopticCamera};
use holo_core::{GridSize, LightField, LightFieldOwned, LightFieldShape};
use holo_io::interop::micro_images;
use holo_io::{CameraFile, ColorEncoding, Compression, ExrChannel, Manifest};
use holo_render::{Rendered, exposure};
use ndarray::{Array2, Array3, Axis, Zip};

use super::codes;
use super::codes::Exposed;
use super::folder::OutputFolder;
use super::layers::{COLOR, ERROR, write_hit_mask, write_pfm};
use super::memory::is_room;
use super::statistics::Finished;
use super::statistics::Statistics;
use super::wanted::Wanted;
use crate::Error;
use crate::settings::{Exposure, Output, RawLayer, RenderSettings};

/// The files of a raw image.
pub(crate) const CAMERA_TOML: &str = "camera.toml";
pub(crate) const RAW_EXR: &str = "raw.exr";
const RAW_PNG: &str = "raw_linear.png";
const RAW_HIT_MASK: &str = "raw_hit_mask.png";
pub(crate) const CENTERS_CSV: &str = "centers.csv";

/// Writes all files of the raw image of a plenoptic camera, and last the manifest.
pub(crate) fn write_all(
    settings: &RenderSettings,
    (mut rendered, wanted, mut manifest): (Rendered, Wanted, Manifest),
    (file, white): (&CameraFile, Array2<f32>),
    exposed: Exposed,
    mut folder: OutputFolder,
) -> Result<Finished, Error> {
    let camera = &file.camera;
    let outputs = wanted.outputs(rendered.color.is_some())?;
    folder.unseal()?;
    folder.add(CAMERA_TOML, holo_io::write_file(folder.file(CAMERA_TOML), file.to_toml().as_bytes())?);
    if outputs.contains(&Output::Centers) {
        folder.add(CENTERS_CSV, holo_io::write_file(folder.file(CENTERS_CSV), centers(camera).as_bytes())?);
    }
    if outputs.contains(&Output::White) {
        write_white(&mut folder, "white", &white)?;
    }
    let statistics = Statistics::new(&rendered, None);
    write_layers(&mut folder, camera, &wanted, &rendered, &white)?;
    if let (Some(color), Some(ev)) = (rendered.color.take(), exposed.ev) {
        if let Some(exposing) = exposed.sensor(settings) {
            codes::write(&mut folder, &color, exposing)?;
        }
        let color = image(color)?;
        for tool in &settings.output.tools {
            tool.write((&mut folder, ""), camera, color.view(), &white, ev)?;
        }
        drop(white);
        if outputs.contains(&Output::Raw) {
            write_raw_exr(&mut folder, RAW_EXR, &color)?;
        }
        if outputs.contains(&Output::RawPng) {
            let image = encoded(color, ev);
            let path = folder.file(RAW_PNG);
            folder.add(RAW_PNG, holo_io::write_png(path, image.view(), ColorEncoding::Linear, Compression::Best)?);
            manifest.exposure_ev = Some(ev);
        }
    }
    statistics.write_to(&mut manifest);
    Ok(Finished { disparity_px: None, statistics, files: folder.seal(manifest)? })
}

/// The raw image of a light field of one view.
pub(crate) fn image(field: LightFieldOwned<f32>) -> Result<Array3<f32>, Error> {
    Ok(field.into_elemental_grid().or_else(|field| field.to_elemental_grid())?)
}

/// Writes `raw_LAYER.pfm` of every layer that is wanted.
fn write_layers(
    folder: &mut OutputFolder,
    camera: &PlenopticCamera,
    wanted: &Wanted,
    rendered: &Rendered,
    white: &Array2<f32>,
) -> Result<(), Error> {
    let name = |layer: &str| format!("raw_{layer}.pfm");
    for (layer, image) in rendered.central.iter().filter(|(layer, _)| wanted.written.contains(*layer)) {
        let name = name(layer.name());
        folder.add(name.clone(), write_pfm(folder.file(&name), image.view())?);
    }
    write_hit_mask(folder, RAW_HIT_MASK, wanted, rendered)?;
    for &layer in &wanted.raw {
        let name = name(layer.name());
        // Ground truth alone has no statistics.
        let Some(image) = raw_layer(camera, layer, rendered, white) else { continue };
        folder.add(name.clone(), holo_io::write_pfm(folder.file(&name), image.view())?);
    }
    if let Some(color) = rendered.color.as_ref().filter(|_| wanted.color) {
        let name = name(COLOR);
        folder.add(name.clone(), holo_io::write_pfm_rgb(folder.file(&name), color.to_elemental_grid()?.view())?);
    }
    if let Some(error) = &rendered.error {
        let name = name(ERROR);
        folder.add(name.clone(), write_pfm(folder.file(&name), error.to_elemental_grid()?.view())?);
    }
    Ok(())
}

/// The white image of a camera, of which a pixel is lit at least.
pub(crate) fn lit_white_image(file: &CameraFile) -> Result<Array2<f32>, Error> {
    /// The image, its codes and what is lost in blocks.
    const BYTES: usize = size_of::<f32>() + size_of::<u16>() + 1;
    // A file of a few lines announces any size.
    let size = file.camera.sensor().size;
    let bytes = size.count().saturating_mul(BYTES);
    if !is_room(bytes) {
        return Err(Error::OutOfMemory(format!(
            "a white image of {} x {} px needs {:.0} GB of memory, more than there is; use a smaller sensor",
            size.columns,
            size.rows,
            bytes as f64 / 1e9
        )));
    }
    let white = file.camera.white_image()?;
    match white.iter().any(|&light| light > 0.0) {
        true => Ok(white),
        false => Err(Error::BadRequest(format!(
            "no light reaches the sensor of the camera '{}': its micro-images lie beside the sensor or between the \
             light-sensitive parts of its pixels; check mla.offset_um, main_lens.f_number and sensor.fill",
            holo_io::shown(&file.name)
        ))),
    }
}

/// Writes a white image as EXR, and as a PNG of 16 bits in linear light, 1 being the brightest pixel.
pub(crate) fn write_white(folder: &mut OutputFolder, stem: &str, white: &Array2<f32>) -> Result<(), Error> {
    let (exr, png) = (format!("{stem}.exr"), format!("{stem}.png"));
    let digest = holo_io::write_exr(folder.file(&exr), &[ExrChannel::float("Y", white.view())])?;
    folder.add(exr, digest);
    let brightest = white.iter().fold(0.0f32, |most, &light| most.max(light)).max(f32::MIN_POSITIVE);
    let codes = white.mapv(|light| (light / brightest * 65_535.0).round() as u16).insert_axis(Axis(2));
    let digest = holo_io::write_png(folder.file(&png), codes.view(), ColorEncoding::Linear, Compression::Best)?;
    folder.add(png, digest);
    Ok(())
}

/// Writes linear color as EXR.
fn write_raw_exr(folder: &mut OutputFolder, name: &str, color: &Array3<f32>) -> Result<(), Error> {
    let planes = ["R", "G", "B"].iter().zip(color.axis_iter(Axis(2)));
    let channels: Vec<_> = planes.map(|(name, plane)| ExrChannel::float(name, plane)).collect();
    folder.add(name, holo_io::write_exr(folder.file(name), &channels)?);
    Ok(())
}

/// Writes a raw image as EXR and as a linear PNG of 16 bits.
pub(crate) fn write_raw(
    folder: &mut OutputFolder,
    stem: &str,
    color: Array3<f32>,
    wanted: Exposure,
) -> Result<(), Error> {
    write_raw_exr(folder, &format!("{stem}.exr"), &color)?;
    let ev = exposure_ev(&color, wanted)?;
    let image = encoded(color, ev);
    let name = format!("{stem}.png");
    let path = folder.file(&name);
    folder.add(name, holo_io::write_png(path, image.view(), ColorEncoding::Linear, Compression::Best)?);
    Ok(())
}

/// The exposure of raw color.
pub(crate) fn exposure_ev(color: &Array3<f32>, wanted: Exposure) -> Result<f64, Error> {
    if let Exposure::Ev(ev) = wanted {
        return Ok(ev);
    }
    let (rows, columns, _) = color.dim();
    let shape = LightFieldShape::new(GridSize::new(1, 1), GridSize::new(rows, columns))?;
    Ok(exposure::automatic_exposure(&LightField::from_elemental_grid(color.view(), shape)?))
}

/// Raw color as codes of 16 bits in linear light: 65,535 is the radiance 2^-EV.
fn encoded(color: Array3<f32>, ev: f64) -> Array3<u16> {
    let scale = (65_535.0 * ev.exp2()) as f32;
    color.mapv(|value| (value * scale).round().clamp(0.0, 65_535.0) as u16)
}

/// The lowest row and column of the micro-images on the sensor, from which files count.
pub(crate) fn first_indices(camera: &PlenopticCamera) -> (i32, i32) {
    let all = micro_images(camera);
    let first = |of: fn(&MicrolensIndex) -> i32| all.iter().map(|(lens, _)| of(lens)).min().unwrap_or(0);
    (first(|lens| lens.row), first(|lens| lens.column))
}

/// The centers of all micro-images on the sensor: column and row of the micro-image from the upper left, and the position
/// in pixels, whose centers are whole numbers.
pub(crate) fn centers(camera: &PlenopticCamera) -> String {
    use std::fmt::Write as _;
    let (first_row, first_column) = first_indices(camera);
    let mut text = String::from("k,l,u,v\n");
    for (lens, [x, y]) in micro_images(camera) {
        let (k, l) = (lens.column - first_column, lens.row - first_row);
        // Writing to a string does not fail.
        let _ = writeln!(text, "{k},{l},{},{}", x - 0.5, y - 0.5);
    }
    text
}

/// A layer that follows from the camera, the depth of the chief rays, or the statistics of the samples, if there are any.
pub(crate) fn raw_layer(
    camera: &PlenopticCamera,
    layer: RawLayer,
    rendered: &Rendered,
    white: &Array2<f32>,
) -> Option<Array2<f32>> {
    let owner = |row: usize, column: usize| camera.owner(camera.place_m([column as f64 + 0.5, row as f64 + 0.5]));
    let lens_type = |row: usize, column: usize| camera.array().type_of(owner(row, column));
    let image = |value: &(dyn Fn(usize, usize) -> f32 + Sync)| {
        let mut image = Array2::zeros(white.dim());
        Zip::indexed(&mut image).par_for_each(|(row, column), pixel| *pixel = value(row, column));
        Some(image)
    };
    let of_depth = |value: &(dyn Fn(f64, usize) -> f64 + Sync)| {
        let depth_m = rendered.central.depth_m()?;
        image(&|row, column| value(f64::from(depth_m[[row, column, 0]]), lens_type(row, column)) as f32)
    };
    let statistics = rendered.statistics.as_ref();
    match layer {
        RawLayer::LensRow => image(&|row, column| owner(row, column).row as f32),
        RawLayer::LensColumn => image(&|row, column| owner(row, column).column as f32),
        RawLayer::LensType => image(&|row, column| lens_type(row, column) as f32),
        RawLayer::White => Some(white.clone()),
        RawLayer::VirtualDepth => of_depth(&|depth_m, _| camera.virtual_depth(depth_m)),
        RawLayer::Blur => of_depth(&|depth_m, lens_type| 2.0 * camera.blur_radius_px(depth_m, lens_type).abs()),
        RawLayer::InverseDepthMean => statistics.map(|all| all.inverse_depth_mean.clone()),
        RawLayer::InverseDepthDeviation => statistics.map(|all| all.inverse_depth_deviation.clone()),
        RawLayer::Coverage => statistics.map(|all| all.coverage.clone()),
    }
}

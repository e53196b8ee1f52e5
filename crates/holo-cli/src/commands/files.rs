//! What most commands share: a light field from the command line, an image into a file.

use std::path::{Path, PathBuf};

use holo_core::{DynImageRef, SampleKind};
use holo_io::dataset::Representation;
use holo_io::{ArrayFolder, LightFieldFile, LightFieldReader, ReadOptions};
use ndarray::{Array2, Axis};

use crate::arguments::InputOptions;
use crate::console::say;
use crate::failure::Failure;

/// Reads the light field that the command line names, and says what is wrong beside its samples, and which of the files of
/// a folder is read.
pub fn read(input: &InputOptions) -> Result<LightFieldFile, Failure> {
    let reader = open(&input.input, input)?;
    say_source(&reader);
    read_samples(reader)
}

/// Reads the samples of an open light field, and says what they show to be wrong.
pub fn read_samples(reader: LightFieldReader) -> Result<LightFieldFile, Failure> {
    let said = reader.warnings().len();
    let file = reader.read()?;
    file.warnings.iter().skip(said).for_each(|warning| say!("warning: {warning}"));
    Ok(file)
}

/// Says what of a folder is read, where that is a choice or not what a folder usually has.
pub fn say_source(reader: &LightFieldReader) {
    let Some(read) = reader.representation() else { return };
    let is_usual = matches!(read, Representation::ElementalPng | Representation::ViewpointPng | Representation::Views);
    if !is_usual || reader.representations().len() > 1 {
        say!("note: reads {read}");
    }
}

/// Opens the light field without its samples; `path` instead of the input's own.
pub fn open(path: &Path, input: &InputOptions) -> Result<LightFieldReader, Failure> {
    let options = ReadOptions::default().views(input.views).layout(input.from).order(input.order);
    let reader = LightFieldReader::open(path, &options)?;
    for warning in reader.warnings() {
        say!("warning: {warning}");
    }
    Ok(reader)
}

/// Creates the folder of a file that is about to be written, as `holo render` creates its own.
pub fn create_folder_of(out: &Path) -> Result<(), Failure> {
    let Some(folder) = out.parent().filter(|folder| !folder.as_os_str().is_empty()) else { return Ok(()) };
    std::fs::create_dir_all(folder)
        .map_err(|error| Failure::Failed(format!("cannot create the folder {}: {error}", folder.display())))
}

/// Writes an image in the type of its samples: integers into a PNG, floats into a PFM.
pub fn write<'a>(out: &Path, image: impl Into<DynImageRef<'a>>) -> Result<(), Failure> {
    match holo_io::write_image(out, image) {
        Err(error @ holo_io::Error::BadInput { .. }) => Err(Failure::Usage(error.to_string())),
        other => Ok(other.map(drop)?),
    }
}

/// `stack.png` becomes `stack_007.png`.
pub fn numbered(out: &Path, number: usize, count: usize) -> PathBuf {
    let digits = count.saturating_sub(1).to_string().len().max(3);
    with_suffix(out, &format!("_{number:0digits$}"))
}

/// `view.png` becomes `view_r004_c012.png`: row first, so that names in order are images in reading order.
pub fn at_position(out: &Path, [column, row]: [usize; 2], largest: usize) -> PathBuf {
    let digits = largest.saturating_sub(1).to_string().len().max(2);
    with_suffix(out, &format!("_r{row:0digits$}_c{column:0digits$}"))
}

/// Writes the mask of the pixels that no view shows next to the image: `view_holes.png` for `view.pfm`.
pub fn write_holes(out: &Path, holes: &Array2<bool>) -> Result<(), Failure> {
    let count = holes.iter().filter(|&&is_hole| is_hole).count();
    let mask = holes.mapv(|is_hole| if is_hole { 255u8 } else { 0 });
    write(&with_suffix(out, "_holes").with_extension("png"), mask.view().insert_axis(Axis(2)))?;
    say!("{count} of {} pixels are in no view, and filled from farther surfaces", holes.len());
    Ok(())
}

/// The type of the samples of a file of linear light: floats in a PFM; a PNG has as many bits as its source, and floats get the most.
pub fn kind_of(out: &Path, source: SampleKind) -> SampleKind {
    let is_pfm = out.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("pfm"));
    match source {
        _ if is_pfm => SampleKind::F32,
        SampleKind::U8 => SampleKind::U8,
        _ => SampleKind::U16,
    }
}

pub fn with_suffix(out: &Path, suffix: &str) -> PathBuf {
    let mut name = out.file_stem().unwrap_or_default().to_os_string();
    name.push(suffix);
    if let Some(ending) = out.extension() {
        name.push(".");
        name.push(ending);
    }
    out.with_file_name(name)
}

/// The camera that an option names.
pub fn camera_named(array: &ArrayFolder, option: &str, name: &str) -> Result<usize, Failure> {
    array.position(name).ok_or_else(|| {
        let names = array.central_cameras().into_iter().map(|k| array.cameras()[k].name.as_str());
        let some = names.take(4).collect::<Vec<_>>().join(", ");
        let folder = array.folder().path().display();
        Failure::Usage(format!(
            "{option} {}: {folder} has no such camera; it has {}",
            holo_core::visible(name),
            holo_core::visible(&some)
        ))
    })
}

//! `holo view`: a light field as one HTML page.

use std::path::Path;

use holo_io::dataset::{ELEMENTAL_PNG, MANIFEST_JSON, VIEWPOINT_PNG};
use holo_io::{AtomicFile, Limits};
use holo_viewer::Page;

use super::files;
use crate::arguments::ViewOptions;
use crate::console::say;
use crate::failure::Failure;

pub fn run(options: &ViewOptions) -> Result<(), Failure> {
    let input = &options.input.input;
    let reader = files::open(dataset_of(options).unwrap_or(input), &options.input)?;
    if input.is_dir() {
        files::say_source(&reader);
    }
    let path = std::path::absolute(input).unwrap_or_else(|_| input.clone());
    let title = path.file_name().map_or_else(|| "light field".into(), |name| name.to_string_lossy());
    let mut page = Page::new(title, reader).map_err(|error| about(input, error))?;
    if let Some(path) = &options.estimate {
        let map = holo_io::read_pfm_gray(path, &Limits::default())?;
        page = page.estimate_px(map).map_err(|error| about(path, error))?;
    }
    let mut file = AtomicFile::create(&options.out)?;
    let failed = |why: std::io::Error| Failure::Failed(format!("cannot write {}: {why}", options.out.display()));
    page.write(&mut file).map_err(failed)?;
    let written = file.commit()?;
    say!(
        "wrote {} ({:.1} MB): open it in a browser; ? shows the keys",
        options.out.display(),
        written.bytes as f64 / 1e6
    );
    Ok(())
}

/// The folder of a raw image that is named itself: what its manifest contains belongs to the image.
fn dataset_of(options: &ViewOptions) -> Option<&Path> {
    let named = options.input.input.file_name().is_some_and(|name| name == ELEMENTAL_PNG || name == VIEWPOINT_PNG);
    let folder = options.input.input.parent()?;
    let plain = named && options.input.from.is_none() && options.input.views.is_none();
    (plain && folder.join(MANIFEST_JSON).is_file()).then_some(folder)
}

fn about(path: &Path, error: holo_viewer::Error) -> Failure {
    match error {
        holo_viewer::Error::Io(error) => error.into(),
        other => Failure::Failed(format!("{}: {other}", path.display())),
    }
}

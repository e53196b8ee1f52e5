//! `holo correspond`: where other cameras see the points of a camera's pixels.

use std::path::Path;

use holo_core::Correspondence;
use holo_dataset::correspondences;
use holo_io::{ArrayFolder, WorldUp, encode_npy};
use ndarray::Array2;

use super::files;
use crate::arguments::CorrespondOptions;
use crate::console::say;
use crate::failure::Failure;

pub fn run(options: &CorrespondOptions) -> Result<(), Failure> {
    // Which axis points up does not matter to pixels.
    let array = ArrayFolder::open(&options.input, WorldUp::Y)?;
    let from = files::camera_named(&array, "--from", &options.from)?;
    if let Some(to) = &options.to {
        let to = files::camera_named(&array, "--to", to)?;
        let (found, name) = (correspondences(&array, from, to)?, &array.cameras()[to].name);
        if !found.iter().any(|one| one.is_visible) {
            let (to, count) = (holo_core::visible(name), found.len());
            return Err(Failure::Usage(format!(
                "camera {to} sees none of the {count} pixels of {}; choose cameras that see the same points",
                options.from
            )));
        }
        return write(&options.out, &found, name);
    }
    for to in array.central_cameras().into_iter().filter(|&to| to != from) {
        let found = correspondences(&array, from, to)?;
        let name = &array.cameras()[to].name;
        // A light field has one central view.
        let field = name.split(':').next().unwrap_or(name);
        write(&files::with_suffix(&options.out, &format!("_{field}")), &found, name)?;
    }
    Ok(())
}

fn write(out: &Path, found: &Array2<Correspondence>, name: &str) -> Result<(), Failure> {
    let (rows, columns) = found.dim();
    let values = found.iter().flat_map(|one| {
        let [row, column] = one.place;
        [row, column, one.depth_m, f64::from(u8::from(one.is_visible))]
    });
    holo_io::write_file(out, &encode_npy("<f8", &[rows, columns, 4], values.flat_map(f64::to_le_bytes)))?;
    let seen = found.iter().filter(|one| one.is_visible).count();
    say!(
        "note: camera {} sees {:.1} % of the pixels",
        holo_core::visible(name),
        100.0 * seen as f64 / found.len() as f64
    );
    Ok(())
}

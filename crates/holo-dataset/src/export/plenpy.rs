//! Light fields for plenpy: `OUT/<scene>.mat` with `LF` of size `[T S V U 3]`, the integers of the images.

use holo_io::{MatOptions, MatOrder};

use super::source::LoadedField;
use super::{ExportJob, ExportTarget, Writer, unchecked};
use crate::Error;
use crate::output::OutputFolder;

pub(super) const TARGET: ExportTarget = ExportTarget {
    name: "plenpy-lf",
    help: "plenpy and the Light Field Toolbox: .mat files with LF, 0 to 255",
    usage: "LightField.from_mat_file(\"SCENE.mat\", key=\"LF\") of plenpy, or load SCENE.mat in MATLAB.",
    has_groups: false,
    has_objects: false,
    writer: Writer::Fields { write, check: unchecked },
};

fn write(folder: &mut OutputFolder, loaded: &LoadedField, _: &ExportJob) -> Result<(), Error> {
    let name = format!("{}.mat", loaded.name);
    let (path, rig) = (folder.file(&name), loaded.rig.as_ref());
    let (order, options) = (MatOrder::LightFieldToolbox, MatOptions::default());
    let written = holo_io::write_mat_light_field(path, &loaded.field, rig, order, &options)?;
    folder.add(name, written);
    Ok(())
}

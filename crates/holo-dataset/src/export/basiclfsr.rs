//! The source data of BasicLFSR, which the NTIRE challenge on light-field super-resolution uses.
//!
//! `OUT/datasets/<group>/training/<scene>.mat` has `LF` of size `[T S V U 3]`, sRGB from 0 to 1. Nothing else lies in the
//! folders that it walks.

use holo_io::{MatOptions, MatOrder};

use super::source::LoadedField;
use super::{ExportJob, ExportTarget, Writer, unchecked};
use crate::Error;
use crate::output::OutputFolder;

pub(super) const TARGET: ExportTarget = ExportTarget {
    name: "basiclfsr",
    help: "BasicLFSR: .mat files for super-resolution",
    usage: "Generate_Data_for_Training.py takes the folder `datasets` as --src_data_path.",
    has_groups: true,
    has_objects: false,
    writer: Writer::Fields { write, check: unchecked },
};

fn write(folder: &mut OutputFolder, loaded: &LoadedField, job: &ExportJob) -> Result<(), Error> {
    let group = job.group.as_deref().unwrap_or("HCI_new");
    let inner = format!("datasets/{group}/training");
    folder.subfolder(&inner)?;
    let field = loaded.field.map(|&code| f32::from(code) / 255.0)?;
    let name = format!("{inner}/{}.mat", loaded.name);
    let (order, options) = (MatOrder::LightFieldToolbox, MatOptions::default());
    let written = holo_io::write_mat_light_field(folder.file(&name), &field, loaded.rig.as_ref(), order, &options)?;
    folder.add(name, written);
    Ok(())
}

//! The views of a light field under the names of the Lego gantry of the Stanford archive: `OUT/<scene>/out_RR_CC_Y_X_.png`.
//!
//! Rows are counted from below, and Y grows upwards, as in the archive's rectified sets. The archive does not tell the unit
//! of its positions; here they are millimeters.

use holo_io::{ColorEncoding, Compression};

use super::source::LoadedField;
use super::{ExportJob, ExportTarget, Writer, unchecked};
use crate::Error;
use crate::output::OutputFolder;

pub(super) const TARGET: ExportTarget = ExportTarget {
    name: "stanford",
    help: "readers of the Stanford gantry: one PNG a view, with its position in its name",
    usage: "Readers take the folder of a scene; LFReadGantryArray of the Light Field Toolbox is one of them.",
    has_groups: false,
    has_objects: false,
    writer: Writer::Fields { write, check: unchecked },
};

fn write(folder: &mut OutputFolder, loaded: &LoadedField, _: &ExportJob) -> Result<(), Error> {
    let Some(rig) = &loaded.rig else {
        return Err(loaded.lacks("the names contain positions of cameras, which it does not have", "render it"));
    };
    let rows = loaded.field.shape().views().rows;
    folder.subfolder(&loaded.name)?;
    for ((t, s), view) in loaded.field.views() {
        let [y, x] = [rig.view_y_m(t), rig.view_x_m(s)].map(|m| 1e3 * m + 0.0);
        let name = format!("{}/out_{:02}_{s:02}_{y:.6}_{x:.6}_.png", loaded.name, rows - 1 - t);
        let written = holo_io::write_png(folder.file(&name), view, ColorEncoding::Srgb, Compression::Fast)?;
        folder.add(name, written);
    }
    Ok(())
}

//! The views of a light field as single images: `OUT/<scene>/view_TTT_SSS.ppm`, row and column of the view from
//! 000, binary PPM (P6) of 8 bits.

use super::source::LoadedField;
use super::{ExportJob, ExportTarget, Writer, unchecked};
use crate::Error;
use crate::output::OutputFolder;

/// Names have three digits.
const MOST: usize = 1000;

pub(super) const TARGET: ExportTarget = ExportTarget {
    name: "ppm",
    help: "any viewer of PPM: one image a view",
    usage: "Coders take the folder of a scene; the first number is the row of the view, the second its column.",
    has_groups: false,
    writer: Writer::Fields { write, check: unchecked },
};

fn write(folder: &mut OutputFolder, loaded: &LoadedField, _: &ExportJob) -> Result<(), Error> {
    let views = loaded.field.shape().views();
    if views.larger() > MOST || loaded.field.channels() != 3 {
        return Err(
            loaded.lacks("the names of views have three digits, and colors three channels", "render such views")
        );
    }
    folder.subfolder(&loaded.name)?;
    for ((t, s), view) in loaded.field.views() {
        let (rows, columns, _) = view.dim();
        let mut bytes = format!("P6\n{columns} {rows}\n255\n").into_bytes();
        bytes.extend(view.iter());
        let name = format!("{}/view_{t:03}_{s:03}.ppm", loaded.name);
        let written = holo_io::write_file(folder.file(&name), &bytes)?;
        folder.add(name, written);
    }
    Ok(())
}

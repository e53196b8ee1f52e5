//! The views of a light field as coders of JPEG Pleno read them: `OUT/<scene>/TTT_SSS.ppm`, row and column of the view from
//! 000, binary PPM (P6) of 8 bits.

use super::source::LoadedField;
use super::{ExportJob, ExportTarget, Writer, unchecked};
use crate::Error;
use crate::output::OutputFolder;

/// Names have three digits.
const MOST: usize = 1000;

pub(super) const TARGET: ExportTarget = ExportTarget {
    name: "jpeg-pleno",
    help: "JPEG Pleno: coders that read TTT_SSS.ppm",
    usage: "Coders take the folder of a scene; the first number is the row of the view, the second its column.",
    has_groups: false,
    has_objects: false,
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
        let name = format!("{}/{t:03}_{s:03}.ppm", loaded.name);
        let written = holo_io::write_file(folder.file(&name), &bytes)?;
        folder.add(name, written);
    }
    Ok(())
}

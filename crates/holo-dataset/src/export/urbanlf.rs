//! The folders of UrbanLF-Syn: `OUT/UrbanLF_Syn/Image<k>/<row>_<column>.png`, all three counted from 1, and the disparity of
//! the central view, `5_5_disparity.npy`.

use holo_core::GridSize;
use holo_io::{ColorEncoding, Compression};

use super::npy::FLOAT;
use super::source::LoadedField;
use super::{ExportJob, ExportTarget, LoadedNote, Writer};
use crate::Error;
use crate::output::OutputFolder;

const SIDE: usize = 9;

const PIXELS: GridSize = GridSize::new(480, 640);

pub(super) const TARGET: ExportTarget = ExportTarget {
    name: "urbanlf",
    help: "readers of UrbanLF-Syn: folders Image1 on, without labels of classes",
    usage: "Readers take the folder `UrbanLF_Syn`; Image1 is the first scene.",
    has_groups: false,
    has_objects: false,
    writer: Writer::Fields { write, check },
};

fn write(folder: &mut OutputFolder, loaded: &LoadedField, _: &ExportJob) -> Result<(), Error> {
    let views = loaded.field.shape().views();
    if views != GridSize::new(SIDE, SIDE) {
        let what = format!("the readers take {SIDE} x {SIDE} views, and it has {} x {}", views.columns, views.rows);
        return Err(loaded.lacks(&what, "render it with `preset urbanlf`"));
    }
    let inner = format!("UrbanLF_Syn/Image{}", loaded.number + 1);
    folder.subfolder(&inner)?;
    for ((t, s), view) in loaded.field.views() {
        let name = format!("{inner}/{}_{}.png", t + 1, s + 1);
        let written = holo_io::write_png(folder.file(&name), view, ColorEncoding::Srgb, Compression::Fast)?;
        folder.add(name, written);
    }
    if let Some(disparity) = &loaded.disparity_px {
        let name = format!("{inner}/{0}_{0}_disparity.npy", SIDE / 2 + 1);
        let values = disparity.iter().flat_map(|value| value.to_le_bytes());
        let written = holo_io::write_file(folder.file(&name), &holo_io::encode_npy(FLOAT, disparity.shape(), values))?;
        folder.add(name, written);
    }
    Ok(())
}

fn check(sizes: &[LoadedNote]) -> Option<String> {
    let is_other = sizes.iter().any(|size| *size != PIXELS);
    is_other.then(|| "readers of UrbanLF-Syn take views of 640 x 480 px alone; render with `preset urbanlf`".into())
}

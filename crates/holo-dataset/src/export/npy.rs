//! Arrays of numpy: `OUT/<scene>.npy`, uint8 of shape (T, S, V, U, 3), and `OUT/<scene>_disparity.npy`, float32 (V, U).

use holo_io::encode_npy;

use super::source::LoadedField;
use super::{ExportJob, ExportTarget, Writer, unchecked};
use crate::Error;
use crate::output::OutputFolder;

pub(super) const TARGET: ExportTarget = ExportTarget {
    name: "npy",
    help: "numpy: one array a scene, views first",
    usage: "numpy.load(\"SCENE.npy\") has the axes (view row, view column, row, column, channel).",
    has_groups: false,
    has_objects: false,
    writer: Writer::Fields { write, check: unchecked },
};

/// Little-endian samples of 32 bits.
pub(super) const FLOAT: &str = "<f4";

fn write(folder: &mut OutputFolder, loaded: &LoadedField, _: &ExportJob) -> Result<(), Error> {
    let samples = loaded.field.samples();
    // From (v, u, t, s, c) to (t, s, v, u, c).
    let views_first = samples.permuted_axes([2, 3, 0, 1, 4]);
    let bytes = encode_npy("|u1", views_first.shape(), views_first.iter().copied());
    let mut files = vec![(format!("{}.npy", loaded.name), bytes)];
    if let Some(disparity) = &loaded.disparity_px {
        let values = disparity.iter().flat_map(|value| value.to_le_bytes());
        files.push((format!("{}_disparity.npy", loaded.name), encode_npy(FLOAT, disparity.shape(), values)));
    }
    for (name, bytes) in files {
        let written = holo_io::write_file(folder.file(&name), &bytes)?;
        folder.add(name, written);
    }
    Ok(())
}

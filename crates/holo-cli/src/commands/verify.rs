//! `holo verify`: a dataset, a sequence, or one folder of it, against what its files say of one another.

use holo_dataset::{is_dataset, text, verify};

use crate::arguments::VerifyOptions;
use crate::console::out;
use crate::failure::Failure;

pub fn run(options: &VerifyOptions) -> Result<(), Failure> {
    let found = verify(&options.folder)?;
    for line in found.mismatches.iter().chain(&found.notes) {
        out!("{}", Failure::spelled(line))?;
    }
    let maker = if is_dataset(&options.folder) { "dataset" } else { "render" };
    // A sequence has folders as a dataset has.
    if maker == "render" && found.folders == 1 && found.files > 0 {
        return match found.mismatches.len() {
            0 => out!("{} files are as their manifest says", found.files),
            wrong => Err(Failure::Failed(format!(
                "{wrong} of {} files differ from their manifest; render them again",
                found.files
            ))),
        };
    }
    if found.bad_folders > 0 {
        return Err(Failure::Failed(format!(
            "{} of {} folders are missing or not as they should be; `holo {maker}` with the same options makes them",
            found.bad_folders, found.folders
        )));
    }
    let (folders, files, bytes) = (found.folders, found.files, text::bytes(found.bytes));
    out!("{folders} folders with {files} files, {bytes}, are as they should be")
}

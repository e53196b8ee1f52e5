//! `holo verify`: a dataset folder against its manifest.

use holo_io::{Manifest, dataset};

use crate::arguments::VerifyOptions;
use crate::console::out;
use crate::failure::Failure;

pub fn run(options: &VerifyOptions) -> Result<(), Failure> {
    let manifest = Manifest::read(options.folder.join(dataset::MANIFEST_JSON))?;
    let problems = manifest.verify(&options.folder);
    if problems.is_empty() {
        out!("{} files are as their manifest says", manifest.files.len())?;
        return Ok(());
    }
    for problem in &problems {
        out!("{problem}")?;
    }
    let (wrong, all) = (problems.len(), manifest.files.len());
    Err(Failure::Failed(format!("{wrong} of {all} files are not as their manifest says; render them again")))
}

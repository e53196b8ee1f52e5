//! `holo merge`: the parts of a picture become the picture.

use holo_io::Manifest;

use super::asked::Wish;
use super::output::OutputFolder;
use super::{job, part};
use crate::arguments::{JobOptions, MergeOptions};
use crate::console::say;
use crate::failure::Failure;

pub fn run(options: &MergeOptions) -> Result<(), Failure> {
    let folder = OutputFolder::create(&options.out)?;
    let (traced, job_options) = part::read(&options.parts, job_options)?;
    let exposure_ev = job::exposure_ev(&job_options, &traced.rendered);
    let finished = job::write(&job_options, traced, exposure_ev, folder)?;
    if !options.quiet {
        say!("put {} parts together: {} files in {}", options.parts.len(), finished.files.len(), options.out.display());
    }
    Ok(())
}

/// What the render was asked to write.
fn job_options(manifest: &Manifest) -> Result<JobOptions, Failure> {
    let wish = manifest.settings.get("options").and_then(Wish::of_manifest);
    let wish = wish.ok_or_else(|| Failure::Failed("the parts do not say what they were rendered with".into()))?;
    Ok(wish?.options.job)
}

//! `holo merge`: the parts of an image become the image.

use crate::arguments::MergeOptions;
use crate::console::{say, say_unless};
use crate::failure::Failure;
use crate::interrupt;

pub fn run(options: &MergeOptions) -> Result<(), Failure> {
    let files = holo_dataset::merge(&options.out, &options.parts, &say_unless(options.quiet), interrupt::rollback())?;
    if !options.quiet {
        say!("put {} parts together: {} files in {}", options.parts.len(), files.len(), options.out.display());
    }
    Ok(())
}

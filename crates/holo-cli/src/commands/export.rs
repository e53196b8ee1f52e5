//! `holo export`: light fields as the files that programs of others read.

use holo_dataset::ExportJob;

use crate::arguments::ExportOptions;
use crate::console::{say, say_unless};
use crate::failure::Failure;
use crate::interrupt;

pub fn run(options: &ExportOptions) -> Result<(), Failure> {
    let job = ExportJob::new(&options.input, options.target).views(options.views).group(options.group.clone());
    let job = job.names(options.names.clone()).objects(options.objects.clone()).overwrite(options.overwrite);
    let exported = job.run(&options.out, interrupt::rollback(), &say_unless(false))?;
    let (contents, files) = (exported.contents, exported.files.len());
    say!("wrote {files} files of {contents} for {} to {}", options.target.name, options.out.display());
    Ok(())
}

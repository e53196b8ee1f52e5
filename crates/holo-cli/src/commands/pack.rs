//! `holo pack`: a dataset as WebDataset archives.

use holo_dataset::{Described, WebDataset, finished};

use crate::arguments::PackOptions;
use crate::console::say;
use crate::failure::Failure;
use crate::interrupt;

pub fn run(options: &PackOptions) -> Result<(), Failure> {
    let max_bytes = options.max_mb.saturating_mul(1_000_000);
    let web = WebDataset { fields: options.fields.clone(), max_bytes };
    let archives = web.write(&options.dataset, &options.out, interrupt::rollback())?;
    if !options.quiet {
        archives.iter().for_each(|archive| say!("{archive}"));
        let Described { finished, of } = finished(&options.dataset)?;
        if finished < of {
            say!("note: {finished} of {of} light fields are finished; `holo verify` says what is missing");
        }
    }
    Ok(())
}

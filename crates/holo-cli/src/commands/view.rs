//! `holo view`: a light field as one HTML page.
//!
//! Nothing is computed from the picture here: the page holds the raw image as a PNG and the maps as floats, and its own
//! scripts (`view/page/`) make views, refocused pictures and errors of them.

mod base64;
mod contents;
mod page;

use holo_io::AtomicFile;

use crate::arguments::ViewOptions;
use crate::console::say;
use crate::failure::Failure;
use contents::Contents;

/// How many pixels a page may hold: 16K television fits. A browser keeps four bytes of each in graphics memory, and for a
/// moment once more in its own.
const MAX_PIXELS: usize = 1 << 27;

pub fn run(options: &ViewOptions) -> Result<(), Failure> {
    let contents = Contents::gather(options)?;
    let raw = contents.split.raw_size();
    if raw.rows.saturating_mul(raw.columns) > MAX_PIXELS {
        return Err(Failure::Failed(format!(
            "{}: {} x {} pixels are more than a browser holds ({} million); render fewer views or lenses for a page",
            options.input.input.display(),
            raw.columns,
            raw.rows,
            MAX_PIXELS / 1_000_000
        )));
    }
    let mut file = AtomicFile::create(&options.out)?;
    let failed = |why: std::io::Error| Failure::Failed(format!("cannot write {}: {why}", options.out.display()));
    page::write(&mut file, &contents).map_err(failed)?;
    let written = file.commit()?;
    say!(
        "wrote {} ({:.1} MB): open it in a browser; ? shows the keys",
        options.out.display(),
        written.bytes as f64 / 1e6
    );
    Ok(())
}

//! `holo compose`: one image per view becomes a raw image.

use std::path::PathBuf;

use holo_io::Limits;

use super::remap;
use crate::arguments::ComposeOptions;
use crate::failure::Failure;

pub fn run(options: &ComposeOptions) -> Result<(), Failure> {
    let to = remap::output_layout(options.to, &options.out, None)?;
    let (images, from) = match &options.images[..] {
        [folder] if folder.is_dir() => (holo_io::list_images(folder)?, folder.clone()),
        images => (images.to_vec(), PathBuf::from("the list of images")),
    };
    if images.len() != options.views.count() {
        return Err(Failure::Usage(format!(
            "{} has {} images, but {} x {} views need {}",
            from.display(),
            images.len(),
            options.views.columns,
            options.views.rows,
            options.views.count()
        )));
    }
    let field = holo_io::read_views(&images, options.views, options.order, &Limits::default())?;
    remap::write_grid(field, to, &options.out)
}

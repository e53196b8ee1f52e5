//! A raw PNG with the `parameters.cfg` beside it.

use std::path::Path;

use holo_core::{DynImage, GridSize, Layout};

use super::layout_of_file_name;
use crate::names::PARAMETERS_CFG;
use crate::{Error, Limits, ParametersCfg, read_png};

/// A raw image and the rig that it was made with.
#[derive(Debug, Clone, PartialEq)]
pub struct RawImage {
    /// The image. Its size is that of the rig's split.
    pub samples: DynImage,
    /// Which grid it is.
    pub layout: Layout,
    /// The camera parameters.
    pub parameters: ParametersCfg,
}

impl RawImage {
    /// Reads a raw PNG and the `parameters.cfg` in its folder.
    ///
    /// `layout` is what the caller knows; without it the file name must tell (`_el` or `_vpi`).
    ///
    /// # Errors
    ///
    /// [`Error::BadInput`] if nothing tells the layout; those of [`read_png`] and [`ParametersCfg::read`];
    /// [`Error::Broken`] if the image has not the size that the parameters say.
    pub fn read(path: impl AsRef<Path>, layout: Option<Layout>, limits: &Limits) -> Result<Self, Error> {
        let path = path.as_ref();
        let layout = layout.or_else(|| layout_of_file_name(path)).ok_or_else(|| {
            Error::bad_input(path, "the name does not tell the layout (`_el` or `_vpi`); say which it is")
        })?;
        let parameters_path = path.with_file_name(PARAMETERS_CFG);
        let parameters = ParametersCfg::read(&parameters_path)?;
        let split = holo_core::LightFieldShape::new(parameters.num_cams, parameters.image_resolution_px)
            .map_err(|error| Error::core(&parameters_path, error))?;
        let samples = read_png(path, limits)?;
        let (rows, columns, _) = samples.dim();
        if GridSize::new(rows, columns) != split.raw_size() {
            let (views, lenses, raw) = (split.views(), split.lenses(), split.raw_size());
            return Err(Error::broken(
                path,
                "raw image",
                format!(
                    "it has {columns} x {rows} pixels, but {} says {} x {} views of {} x {} pixels, which make {} x {}",
                    PARAMETERS_CFG, views.columns, views.rows, lenses.columns, lenses.rows, raw.columns, raw.rows
                ),
            ));
        }
        Ok(Self { samples, layout, parameters })
    }
}

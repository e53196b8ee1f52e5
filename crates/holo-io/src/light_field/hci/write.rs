//! The writer of HCI folders.

use std::path::Path;

use holo_core::{DynImageRef, DynLightFieldRef, GridSize, LightFieldRef, LightFieldShape, for_each_sample};
use ndarray::{ArrayView2, Axis};
use rayon::prelude::*;

use super::folder::files;
use super::names::Name;
use super::{HciQuantity, HciResolution};
use crate::error::in_words;
use crate::files::folder::{Destination, Folder, FolderFile};
use crate::files::names::PARAMETERS_CFG;
use crate::{ColorEncoding, Compression, Error, FileDigest, ParametersCfg, write_pfm, write_png};

/// A ground truth map of low resolution, or none.
#[derive(Debug, Clone, Copy)]
pub enum HciTruth<'a> {
    /// No ground truth.
    None,
    /// Of the central view, `(v, u)`.
    Central(ArrayView2<'a, f32>),
    /// Of all views, `(v, u, t, s, 1)`. The central view gets an additional file without a number.
    All(LightFieldRef<'a, f32>),
}

/// Ground truth of the central view with more values than a view has pixels, for the high-resolution scores of the
/// evaluation toolkit.
#[derive(Debug, Clone, Copy)]
pub struct HciHighResolution<'a> {
    /// Disparity in pixels *of the views* between horizontally adjacent views, `(v, u)`: `depth_map_scale` of the
    /// parameters times the rows and columns of a view.
    pub disparity_px: ArrayView2<'a, f32>,
    /// Planar depth in meters, likewise.
    pub depth_m: ArrayView2<'a, f32>,
}

/// The contents of an [HCI folder](super) that is to be written.
#[derive(Debug, Clone, Copy)]
pub struct HciImage<'a> {
    /// The images of all views, `(v, u, t, s, c)` with 1 to 4 channels of 8 or 16 bits; any strides. The HCI tools
    /// expect 3 channels of 8 bits. `None`: ground truth alone, which [`HciFolder`](super::HciFolder) does not open.
    pub views: Option<DynLightFieldRef<'a>>,
    /// The contents of `parameters.cfg`.
    pub parameters: &'a ParametersCfg,
    /// Disparity in pixels between horizontally adjacent views.
    pub disparity_px: HciTruth<'a>,
    /// Planar depth in meters.
    pub depth_m: HciTruth<'a>,
    /// Ground truth of high resolution, or none.
    pub high_resolution: Option<HciHighResolution<'a>>,
}

impl<'a> HciImage<'a> {
    /// Returns the names of all files: views, ground truth, and last `parameters.cfg`.
    #[must_use]
    pub fn file_names(&self) -> Vec<String> {
        let names = self.names().into_iter().map(|name| name.to_string());
        names.chain([PARAMETERS_CFG.to_owned()]).collect()
    }

    /// Writes the files into an existing folder, in parallel, and returns their names with size and digest, in the
    /// order of [`HciImage::file_names`].
    ///
    /// An older `parameters.cfg` is removed first and the new one is written last, so that the folder is not read
    /// before it is complete. Files of the same names are replaced; all others stay.
    ///
    /// # Errors
    ///
    /// [`Error::BadInput`] if the numbers of views or pixels of the parameters or the ground truth are not those of the
    /// views, or if the folder contains views or ground truth of another image that would stay; then nothing is
    /// written. Those of [`write_png`], [`write_pfm`] and [`ParametersCfg::write`]; then there is no `parameters.cfg`,
    /// and files that were finished before stay.
    pub fn write(
        &self,
        folder: impl AsRef<Path>,
        compression: Compression,
    ) -> Result<Vec<(String, FileDigest)>, Error> {
        // Before the folder is opened: what is wrong with the image does not depend on it.
        self.check(folder.as_ref())?;
        self.write_in(&Folder::open(folder)?, compression)
    }

    /// Writes the files into an open folder, like [`HciImage::write`].
    ///
    /// # Errors
    ///
    /// Those of [`HciImage::write`].
    pub fn write_in(&self, folder: &Folder, compression: Compression) -> Result<Vec<(String, FileDigest)>, Error> {
        self.check(folder.path())?;
        self.check_leftovers(folder.path())?;
        let parameters = folder.file(PARAMETERS_CFG);
        // Before any view is written.
        self.parameters.to_text().map_err(|error| at(parameters.path(), error))?;
        if folder.kind(PARAMETERS_CFG)?.is_some() {
            folder.remove_file(PARAMETERS_CFG)?;
        }
        let mut written: Vec<(String, FileDigest)> = self
            .names()
            .into_par_iter()
            .map(|name| {
                let text = name.to_string();
                self.write_one(name, &folder.file(text.as_str()), compression).map(|written| (text, written))
            })
            .collect::<Result<_, Error>>()?;
        written.push((PARAMETERS_CFG.to_owned(), self.parameters.write(&parameters)?));
        Ok(written)
    }

    /// The shape that the parameters specify; `check` compares it with the images.
    fn shape(&self, folder: &Path) -> Result<LightFieldShape, Error> {
        LightFieldShape::new(self.parameters.num_cams, self.parameters.image_resolution_px)
            .map_err(|error| Error::core(folder, error))
    }

    fn maps(&self) -> [(HciQuantity, HciTruth<'a>); 2] {
        [(HciQuantity::Disparity, self.disparity_px), (HciQuantity::Depth, self.depth_m)]
    }

    /// All names except that of the parameters.
    fn names(&self) -> Vec<Name> {
        let ParametersCfg { num_cams, .. } = *self.parameters;
        let count = num_cams.rows.saturating_mul(num_cams.columns);
        let mut names: Vec<Name> = self.views.iter().flat_map(|_| (0..count).map(Name::View)).collect();
        for (quantity, truth) in self.maps() {
            let name = |view| Name::truth(quantity, HciResolution::Low, view);
            match truth {
                HciTruth::None => {}
                HciTruth::Central(_) => names.push(name(None)),
                HciTruth::All(_) => names.extend([None].into_iter().chain((0..count).map(Some)).map(name)),
            }
            if self.high_resolution.is_some() {
                names.push(Name::truth(quantity, HciResolution::High, None));
            }
        }
        names
    }

    fn check(&self, folder: &Path) -> Result<(), Error> {
        let shape = self.shape(folder)?;
        let (views, lenses) = (shape.views(), shape.lenses());
        let bad = |what: String| Err(Error::bad_input(folder, what));
        if let Some(images) = self.views.map(|images| images.shape()).filter(|images| *images != shape) {
            return bad(format!(
                "the parameters specify {}, the images are {}",
                in_words((views, lenses)),
                in_words((images.views(), images.lenses()))
            ));
        }
        if let Some(HciHighResolution { disparity_px, depth_m }) = self.high_resolution {
            let scale = self.parameters.depth_map_scale.unwrap_or(1.0);
            let size = ((lenses.rows as f64 * scale) as usize, (lenses.columns as f64 * scale) as usize);
            if disparity_px.dim() != size || depth_m.dim() != size {
                return bad(format!(
                    "ground truth of high resolution has {:?} and {:?} rows and columns; `depth_map_scale` {scale} makes \
                     {size:?} of them",
                    disparity_px.dim(),
                    depth_m.dim()
                ));
            }
        }
        for (quantity, truth) in self.maps() {
            let quantity = if quantity == HciQuantity::Depth { "depth" } else { "disparity" };
            match truth {
                HciTruth::Central(map) if map.dim() != (lenses.rows, lenses.columns) => {
                    let (rows, columns) = map.dim();
                    return bad(format!(
                        "the {quantity} has {columns} x {rows} pixels, a view has {} x {}",
                        lenses.columns, lenses.rows
                    ));
                }
                HciTruth::All(maps) if maps.shape() != shape || maps.channels() != 1 => {
                    return bad(format!(
                        "the {quantity} is {} with {} channels, the images are {}; a map has 1 channel",
                        in_words((maps.shape().views(), maps.shape().lenses())),
                        maps.channels(),
                        in_words((views, lenses))
                    ));
                }
                _ => {}
            }
        }
        Ok(())
    }

    /// Refuses a folder with files of another image that a reader would read as part of this one.
    fn check_leftovers(&self, folder: &Path) -> Result<(), Error> {
        let ours: std::collections::BTreeSet<String> = self.file_names().into_iter().collect();
        for path in files(folder)?.into_values() {
            if path.file_name().and_then(|name| name.to_str()).is_some_and(|name| !ours.contains(name)) {
                return Err(Error::bad_input(
                    &path,
                    "this file of another image would stay among the new ones; remove it or choose another folder",
                ));
            }
        }
        Ok(())
    }

    fn write_one(&self, name: Name, file: &FolderFile, compression: Compression) -> Result<FileDigest, Error> {
        let path = file.path();
        let shape = self.shape(path)?;
        let GridSize { columns, .. } = shape.views();
        let failed = |error| Error::core(path, error);
        match name {
            Name::View(index) => {
                let (t, s) = (index / columns, index % columns);
                let Some(images) = &self.views else { return Err(Error::bad_input(path, "there is no view to write")) };
                let view: DynImageRef<'_> =
                    for_each_sample!(DynLightFieldRef, images, views => views.view(t, s).map_err(failed)?.into());
                write_png(file, view, ColorEncoding::Srgb, compression)
            }
            Name::Truth { depth, high: true, .. } => match self.high_resolution {
                Some(truth) => write_pfm(file, if depth { truth.depth_m } else { truth.disparity_px }),
                None => Err(Error::bad_input(path, "there is no ground truth to write")),
            },
            Name::Truth { depth, view, .. } => {
                let (t, s) = view.map_or(shape.central_view(), |index| (index / columns, index % columns));
                match if depth { self.depth_m } else { self.disparity_px } {
                    HciTruth::Central(map) => write_pfm(file, map),
                    HciTruth::All(maps) => {
                        write_pfm(file, maps.view(t, s).map_err(failed)?.index_axis_move(Axis(2), 0))
                    }
                    HciTruth::None => Err(Error::bad_input(path, "there is no ground truth to write")),
                }
            }
        }
    }
}

/// The same error with the path of a file.
fn at(path: &Path, error: Error) -> Error {
    match error {
        Error::BadInput { what, .. } => Error::bad_input(path, what),
        other => other,
    }
}

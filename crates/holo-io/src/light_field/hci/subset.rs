//! HCI folders with some of the views: a cross, a star, any others.

use std::path::{Path, PathBuf};

use holo_core::{DynLightField, GridSize, LightFieldShape, Rig, ViewIndex};

use super::FORMAT;
use super::folder::contents;
use super::names::Name;
use crate::files::names::PARAMETERS_CFG;
use crate::light_field::views::{Views, check_regular};
use crate::{Error, Limits, ParametersCfg};

/// An HCI folder of which some views are missing, opened for reading the others.
#[derive(Debug, Clone, PartialEq)]
pub struct HciSubset {
    path: PathBuf,
    parameters: ParametersCfg,
    shape: LightFieldShape,
    views: Vec<ViewIndex>,
    files: Vec<PathBuf>,
}

impl HciSubset {
    /// Opens a folder, and lists the views that it has, row by row.
    ///
    /// # Errors
    ///
    /// Those of [`HciFolder::open`](crate::HciFolder::open), but for missing views; [`Error::Broken`] if there is none.
    pub fn open(path: impl AsRef<Path>) -> Result<Self, Error> {
        let path = path.as_ref();
        let (parameters, shape, mut all) = contents(path)?;
        let columns = shape.views().columns;
        let (mut views, mut files) = (Vec::new(), Vec::new());
        for k in 0..shape.views().count() {
            if let Some(file) = all.remove(&Name::View(k)) {
                check_regular(&file)?;
                views.push(ViewIndex::new(k / columns, k % columns));
                files.push(file);
            }
        }
        if views.is_empty() {
            return Err(Error::broken(path, FORMAT, "it has no view"));
        }
        Ok(Self { path: path.to_owned(), parameters, shape, views, files })
    }

    /// Returns the path of the folder.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Returns the numbers of views and microlenses of the whole grid.
    #[must_use]
    pub const fn shape(&self) -> LightFieldShape {
        self.shape
    }

    /// Returns the contents of `parameters.cfg`.
    #[must_use]
    pub const fn parameters(&self) -> &ParametersCfg {
        &self.parameters
    }

    /// Returns the rig of the whole grid.
    ///
    /// # Errors
    ///
    /// As [`HciFolder::rig`](crate::HciFolder::rig).
    pub fn rig(&self) -> Result<Rig, Error> {
        self.parameters.rig().map_err(|error| error.about(&self.path.join(PARAMETERS_CFG)))
    }

    /// Returns the views that are there, row by row.
    #[must_use]
    pub fn views(&self) -> &[ViewIndex] {
        &self.views
    }

    /// Reads the views that are there.
    ///
    /// # Shape
    ///
    /// `(v, u, 0, k, c)`: one row of views, `k` as in [`views`](Self::views).
    ///
    /// # Errors
    ///
    /// As [`HciFolder::read`](crate::HciFolder::read).
    pub fn read(&self, limits: &Limits) -> Result<DynLightField, Error> {
        let row = GridSize::new(1, self.files.len());
        let expected = Some((self.shape.lenses(), PARAMETERS_CFG));
        Views { format: FORMAT, views: row, files: &self.files, expected }.read(limits)
    }
}

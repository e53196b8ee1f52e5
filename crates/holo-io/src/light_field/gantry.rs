//! Folders of the Lego gantry of the Stanford Light Field Archive: one PNG a view, with its position in its name.
//!
//! The rectified sets (chess, Lego knights, amethyst, ...) hold 17 x 17 files named
//!
//! ```text
//! out_00_00_-381.909271_1103.376221.png     out_ROW_COLUMN_Y_X.png
//! out_00_00_-399.772888_671.237122_.png     the same with an underscore at the end
//! ```
//!
//! # Meaning of the numbers, and its evidence
//!
//! - *Y comes before X*: the archive states it (see the source below), and the names agree: from `out_00_00` to
//!   `out_00_10` of the knights the third number changes by 1.3 and the fourth by 86.
//! - *ROW comes before COLUMN*: by the same names, the second index runs along X.
//! - *The unit is unknown*: the archive calls the positions "computed parallax", which is the position of the camera up
//!   to an unknown scale and an unknown origin. They are not millimeters; only the archive's older gantry gives those.
//! - *The direction differs between sets*: X decreases by 8.6 a column in the knights and increases by 10 in the
//!   amethyst, and some readers of these sets count rows from below. [`GantryFolder`] flips nothing: rows and columns are in
//!   the order of their indices, and the positions are returned as they are written. All of `holo-core` expects view
//!   columns to run right and view rows to run down, and [`read_light_field`](crate::read_light_field) turns them: rows,
//!   and columns where X decreases. No set was available for a test of that: check a pair of views before you use it.
//!
//! # Source
//!
//! "Geometric Calibration" of the archive (`lightfield.stanford.edu`, `calib.html`): the parallax "is included as part
//! of the file name of each rectified image, in the order (Y, X)". The order of the indices and the directions are
//! derived from published file names; no set was available for a test.

mod name;

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use holo_core::{DynImage, DynLightField, GridSize};

use crate::light_field::views::{Views, check_regular, files_by_key, has_file};
use crate::{Error, Limits};
use name::Name;

/// The name of the format in messages.
const FORMAT: &str = "gantry folder";

/// Position of a camera from a file name, in an unknown unit and from an unknown origin.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GantryPosition {
    /// The third number of the name.
    pub y: f64,
    /// The fourth number of the name.
    pub x: f64,
}

/// A folder of the Lego gantry, opened for reading; see [the module](self) for the convention.
///
/// [`open`](Self::open) reads the names of the files; the other methods read pixels.
#[derive(Debug, Clone, PartialEq)]
pub struct GantryFolder {
    path: PathBuf,
    views: GridSize,
    /// One file a view, view row by view row, in the order of their indices.
    files: Vec<PathBuf>,
    positions: Vec<GantryPosition>,
}

impl GantryFolder {
    /// Opens a folder: parses the names of its files and checks that they form a grid.
    ///
    /// Rows and columns are sorted by their indices. These need not begin at 0 and may have an equal step above 1, so
    /// that a subset, such as every second row, is a grid too. Files of other names are ignored.
    ///
    /// # Errors
    ///
    /// [`Error::Io`] if the folder cannot be listed, or a view is a link or no file; [`Error::Broken`] if it has no such file, if two files have the
    /// same indices, if a view of the grid is missing, or if rows or columns are not evenly spaced.
    pub fn open(path: impl AsRef<Path>) -> Result<Self, Error> {
        let path = path.as_ref();
        let found = files(path)?;
        if found.is_empty() {
            return Err(Error::broken(
                path,
                FORMAT,
                "there is no file named like out_00_00_-381.909271_1103.376221.png",
            ));
        }
        found.values().try_for_each(|(file, _)| check_regular(file))?;
        let rows = evenly_spaced(path, "row", found.keys().map(|&(row, _)| row).collect())?;
        let columns = evenly_spaced(path, "column", found.keys().map(|&(_, column)| column).collect())?;
        let views = GridSize::new(rows.len(), columns.len());
        let (mut files, mut positions) = (Vec::with_capacity(found.len()), Vec::with_capacity(found.len()));
        for (row, column) in rows.iter().flat_map(|&row| columns.iter().map(move |&column| (row, column))) {
            let Some((file, position)) = found.get(&(row, column)) else {
                return Err(Error::broken(
                    path,
                    FORMAT,
                    format!(
                        "there is no out_{row:02}_{column:02}_*.png, but other files make a grid of {} x {} views",
                        views.columns, views.rows
                    ),
                ));
            };
            files.push(file.clone());
            positions.push(*position);
        }
        Ok(Self { path: path.to_owned(), views, files, positions })
    }

    /// Whether the folder has at least one file with a name of this form.
    pub(crate) fn has_views(path: &Path) -> Result<bool, Error> {
        has_file(path, |name| Name::parse(name).is_some())
    }

    /// Returns the path of the folder.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Returns the number of views, T rows and S columns.
    #[must_use]
    pub const fn views(&self) -> GridSize {
        self.views
    }

    /// Returns the position of the view `(t, s)` as it is written, or `None` if there is no such view.
    #[must_use]
    pub fn position(&self, t: usize, s: usize) -> Option<GantryPosition> {
        self.index(t, s).ok().map(|index| self.positions[index])
    }

    /// Returns the file of view `(t, s)`, which must exist.
    pub(crate) fn file(&self, t: usize, s: usize) -> &Path {
        &self.files[t * self.views.columns + s]
    }

    /// Reads all views.
    ///
    /// # Shape
    ///
    /// `(v, u, t, s, c)` with 1 or 3 channels; `t` and `s` count the sorted rows and columns. An alpha channel is
    /// dropped; the color values stay as they are stored, also where alpha is 0.
    ///
    /// # Errors
    ///
    /// Those of [`read_png`](crate::read_png); [`Error::Broken`] if size, channels or bits of a view differ from the
    /// first one; [`Error::TooLarge`] if the samples of all views exceed the limits, before memory is allocated for
    /// them.
    pub fn read(&self, limits: &Limits) -> Result<DynLightField, Error> {
        self.files().read(limits)
    }

    /// Reads the view `(t, s)`.
    ///
    /// # Shape
    ///
    /// `(v, u, c)` with 1 or 3 channels; alpha is dropped as in [`GantryFolder::read`].
    ///
    /// # Errors
    ///
    /// [`Error::Core`] if there is no such view; those of [`read_png`](crate::read_png).
    pub fn read_view(&self, t: usize, s: usize, limits: &Limits) -> Result<DynImage, Error> {
        self.files().read_one(self.index(t, s)?, limits)
    }

    fn index(&self, t: usize, s: usize) -> Result<usize, Error> {
        self.files().index(&self.path, t, s)
    }

    fn files(&self) -> Views<'_> {
        Views { format: FORMAT, views: self.views, files: &self.files, expected: None }
    }
}

/// Files and positions by row and column.
type Files = BTreeMap<(usize, usize), (PathBuf, GantryPosition)>;

/// The files of a folder with names of this form.
fn files(folder: &Path) -> Result<Files, Error> {
    let parse = |name: &str| Name::parse(name).map(|name| ((name.row, name.column), name.position));
    files_by_key(folder, FORMAT, "is the same view", parse)
}

/// Returns the indices in order, if the steps between them are equal.
fn evenly_spaced(folder: &Path, what: &str, indices: BTreeSet<usize>) -> Result<Vec<usize>, Error> {
    let indices: Vec<usize> = indices.into_iter().collect();
    let steps = || indices.windows(2).map(|pair| pair[1] - pair[0]);
    let step = steps().min().unwrap_or(1);
    match steps().position(|found| found != step) {
        None => Ok(indices),
        Some(at) => Err(Error::broken(
            folder,
            FORMAT,
            format!("there is no {what} between {} and {}, but others are {step} apart", indices[at], indices[at + 1]),
        )),
    }
}

//! Folders of the Stanford Light Field Archive's Lego gantry: one PNG a view, its place in its name.
//!
//! The rectified sets (chess, Lego knights, amethyst, ...) hold 17 x 17 files named
//!
//! ```text
//! out_00_00_-381.909271_1103.376221.png     out_ROW_COLUMN_Y_X.png
//! out_00_00_-399.772888_671.237122_.png     the same with an underscore behind it
//! ```
//!
//! # What the numbers mean, and how sure that is
//!
//! - *Y comes before X*: the archive says so (see the source below), and so do the names. From `out_00_00` to `out_00_10`
//!   of the knights the third number changes by 1.3 and the fourth by 86.
//! - *ROW comes before COLUMN*: by the same names. The second index runs along X.
//! - *The unit is unknown*: the archive calls the positions "computed parallax", which is the camera's place up to an
//!   unknown scale and an unknown origin. They are not millimetres; only the archive's older gantry gives those.
//! - *The direction is not the same for all sets*: X falls by 8.6 a column in the knights and rises by 10 in the amethyst,
//!   and some readers of these sets count rows from below. So nothing is turned round here: rows and columns are in the
//!   order of their indices, and the positions, which are returned as they are written, tell which way a set runs.
//!   Before methods that expect view columns to run right and rows down (all of `holo-core`), look at a pair of views.
//!
//! # Source
//!
//! "Geometric Calibration" of the archive (`lightfield.stanford.edu`, `calib.html`): the parallax "is included as part of
//! the file name of each rectified image, in the order (Y, X)". No set was at hand when this was written: the order of the
//! indices and the directions are from names that others published.

mod name;

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

use holo_core::{DynImage, DynLightField, GridSize};

use crate::views::Views;
use crate::{Error, Limits};
use name::Name;

/// What errors call the folder.
const FORMAT: &str = "gantry folder";

/// Where a camera was, as the file's name says: in an unknown unit, from an unknown origin.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GantryPosition {
    /// The third number of the name.
    pub y: f64,
    /// The fourth number of the name.
    pub x: f64,
}

/// A folder of the Lego gantry; see [the module](self) for the convention.
///
/// Opening reads the names of the files; pixels are read when they are asked for.
#[derive(Debug, Clone, PartialEq)]
pub struct GantryFolder {
    path: PathBuf,
    views: GridSize,
    /// One file a view, in the order of their indices.
    files: Vec<PathBuf>,
    positions: Vec<GantryPosition>,
}

impl GantryFolder {
    /// Opens a folder.
    ///
    /// Rows and columns are sorted by their indices. These need not begin at 0 and may skip evenly, so a part of a set,
    /// such as every second row, is a grid too. Files of other names do not matter.
    ///
    /// # Errors
    ///
    /// [`Error::Io`] if the folder cannot be listed; [`Error::Broken`] if it has no such file, if two files have the same
    /// indices, if a view of the grid is missing, or if rows or columns are not evenly spaced.
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
        let rows = evenly_spaced(path, "row", found.keys().map(|&(row, _)| row).collect())?;
        let columns = evenly_spaced(path, "column", found.keys().map(|&(_, column)| column).collect())?;
        let views = GridSize::new(rows.len(), columns.len());
        let (mut files, mut positions) = (Vec::with_capacity(found.len()), Vec::with_capacity(found.len()));
        // At most one more look-up than there are files.
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

    /// Whether there is at least one file whose name is of this kind.
    pub(crate) fn has_views(path: &Path) -> Result<bool, Error> {
        let failed = |source| Error::io("list", path, source);
        for entry in fs::read_dir(path).map_err(failed)? {
            if entry.map_err(failed)?.file_name().to_str().and_then(Name::parse).is_some() {
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// Returns the folder's own path.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Returns the number of views, rows and columns.
    #[must_use]
    pub const fn views(&self) -> GridSize {
        self.views
    }

    /// Returns the position of view `(t, s)` as it is written, or `None` if there is no such view.
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
    /// `(v, u, t, s, c)` with 1 or 3 channels; `t` and `s` count the sorted rows and columns. An alpha channel is dropped:
    /// colours stay as they are stored, also where they are transparent.
    ///
    /// # Errors
    ///
    /// Those of [`read_png`](crate::read_png); [`Error::Broken`] if a view has another size than the first one or is of
    /// another kind; [`Error::TooLarge`] if the samples of all views exceed the limits, before memory is taken for them.
    pub fn read(&self, limits: &Limits) -> Result<DynLightField, Error> {
        self.files().read(limits)
    }

    /// Reads view `(t, s)` alone.
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

fn files(folder: &Path) -> Result<Files, Error> {
    let failed = |source| Error::io("list", folder, source);
    let mut files = Files::new();
    for entry in fs::read_dir(folder).map_err(failed)? {
        let path = entry.map_err(failed)?.path();
        let Some(name) = path.file_name().and_then(|name| name.to_str()).and_then(Name::parse) else { continue };
        if let Some((other, _)) = files.insert((name.row, name.column), (path.clone(), name.position)) {
            // Which comes first is up to the file system; the message is not.
            let (first, second) = if other < path { (other, path) } else { (path, other) };
            return Err(Error::broken(
                &second,
                FORMAT,
                format!("{} is the same view; remove the one that does not belong here", first.display()),
            ));
        }
    }
    Ok(files)
}

/// Passes indices with the same step between all neighbours.
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

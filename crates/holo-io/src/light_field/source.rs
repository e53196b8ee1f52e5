//! The sources of samples, by format.

use std::path::{Path, PathBuf};

use holo_core::{DynImage, DynLightField, LightFieldShape, ViewOrder};
use ndarray::Axis;
use ndarray::{Array2, Array4};

use crate::{Error, Limits};

use super::decode::decode;
use crate::CameraFile;
#[cfg(feature = "hdf5")]
use crate::{Hdf5LightField, Hdf5Map, arrays::hdf5::OldHciFile};
use {
    super::archives,
    crate::light_field::views::read_views,
    crate::{GantryFolder, HciFolder, HciQuantity, HciResolution, images::image_file::read_image},
    holo_core::Layout,
};

/// A ground truth map of the central view.
#[derive(Debug, Clone, Copy)]
pub(super) enum Map {
    Depth,
    Disparity,
}

/// The open folder or file that samples are read from.
#[derive(Debug)]
pub(super) enum Source {
    /// No samples: the error of reading them. There may be maps beside them.
    Nothing(Box<Error>),
    Hci(Box<HciFolder>),
    Gantry(Box<GantryFolder>),
    /// One file a view, in natural order.
    Images {
        files: Vec<PathBuf>,
        order: ViewOrder,
    },
    /// The same, of which the rows are counted from below.
    Mit(Vec<PathBuf>),
    RawImage {
        file: PathBuf,
        layout: Layout,
    },
    Eslf(PathBuf),
    /// The raw image of a plenoptic camera.
    Plenoptic {
        file: PathBuf,
        camera: Box<CameraFile>,
    },
    Mat,
    #[cfg(feature = "hdf5")]
    Hdf5(Box<Hdf5LightField>),
    #[cfg(feature = "hdf5")]
    OldHci(Box<OldHciFile>),
}

impl Source {
    pub(super) fn raw_image(&self) -> Option<PathBuf> {
        match self {
            Self::RawImage { file, .. } => Some(file.clone()),
            #[allow(unreachable_patterns, reason = "with one feature alone there is no other variant")]
            _ => None,
        }
    }

    #[allow(unused_variables, reason = "with one feature alone some are unused")]
    pub(super) fn central_map(&self, map: Map, limits: &Limits) -> Result<Option<Array2<f32>>, Error> {
        match (self, map) {
            (Self::Hci(folder), Map::Depth) => folder.central_truth(HciQuantity::Depth, HciResolution::Low, limits),
            (Self::Hci(folder), Map::Disparity) => {
                folder.central_truth(HciQuantity::Disparity, HciResolution::Low, limits)
            }
            #[cfg(feature = "hdf5")]
            (Self::Hdf5(file), map) => {
                let map = hdf5_map(map);
                let (all, central) = file.maps();
                let exists = all.contains(&map) || central.contains(&map);
                exists.then(|| file.read_central_map(map)).transpose()
            }
            #[cfg(feature = "hdf5")]
            (Self::OldHci(file), map) => file.central_map(hdf5_map(map)),
            #[allow(unreachable_patterns, reason = "with one feature alone there is no other variant")]
            _ => Ok(None),
        }
    }

    /// The disparities of all views, if the file has those of every view.
    #[allow(unused_variables, reason = "with one feature alone some are unused")]
    pub(super) fn disparity_px_of_views(&self, limits: &Limits) -> Result<Option<Array4<f32>>, Error> {
        match self {
            Self::Hci(folder) => {
                let maps = folder.truth_of_all_views(HciQuantity::Disparity, limits)?;
                Ok(maps.map(|maps| maps.into_samples().index_axis_move(Axis(4), 0)))
            }
            #[cfg(feature = "hdf5")]
            Self::Hdf5(file) => {
                let map = hdf5_map(Map::Disparity);
                file.maps().0.contains(&map).then(|| file.read_map(map)).transpose()
            }
            #[allow(unreachable_patterns, reason = "with one feature alone there is no other variant")]
            _ => Ok(None),
        }
    }

    /// The order of a list of images, which the images may contradict.
    pub(super) fn order(&self) -> Option<ViewOrder> {
        match self {
            Self::Images { order, .. } => Some(*order),
            #[allow(unreachable_patterns, reason = "with one feature alone there is no other variant")]
            _ => None,
        }
    }

    /// The view (row, column), if it can be read without the others.
    #[allow(unused_variables, reason = "with one feature alone some are unused")]
    pub(super) fn read_view(&self, (row, column): (usize, usize)) -> Result<Option<DynImage>, Error> {
        match self {
            #[cfg(feature = "hdf5")]
            Self::Hdf5(file) => file.read_view(row, column).map(Some),
            #[allow(unreachable_patterns, reason = "with one feature alone there is no other variant")]
            _ => Ok(None),
        }
    }

    #[allow(unused_variables, reason = "with one feature alone some are unused")]
    pub(super) fn read(self, path: &Path, shape: LightFieldShape, limits: &Limits) -> Result<DynLightField, Error> {
        match self {
            Self::Nothing(error) => Err(*error),
            Self::Hci(folder) => folder.read(limits),
            Self::Gantry(folder) => {
                let (first, last) = (folder.position(0, 0), folder.position(0, folder.views().columns - 1));
                let falls = first.zip(last).is_some_and(|(first, last)| first.x > last.x);
                archives::reversed(folder.read(limits)?, true, falls).map_err(|error| Error::core(path, error))
            }
            Self::Mit(files) => {
                let field = read_views(&files, shape.views(), ViewOrder::RowMajor, limits)?;
                archives::reversed(field, true, false).map_err(|error| Error::core(path, error))
            }
            Self::Eslf(file) => {
                archives::eslf(read_image(&file, limits)?, shape).map_err(|error| Error::core(path, error))
            }
            Self::Plenoptic { file, camera } => decode(&file, &camera, shape, limits),
            Self::Images { files, order } => read_views(&files, shape.views(), order, limits),
            Self::RawImage { file, layout } => DynLightField::from_grid(read_image(&file, limits)?, layout, shape)
                .map_err(|error| Error::core(path, error)),
            Self::Mat => Ok(crate::read_mat_light_field(path, limits)?.light_field),
            #[cfg(feature = "hdf5")]
            Self::Hdf5(file) => file.read(),
            #[cfg(feature = "hdf5")]
            Self::OldHci(file) => file.read(),
        }
    }
}

#[cfg(feature = "hdf5")]
fn hdf5_map(map: Map) -> Hdf5Map {
    match map {
        Map::Depth => Hdf5Map::Depth,
        Map::Disparity => Hdf5Map::Disparity,
    }
}

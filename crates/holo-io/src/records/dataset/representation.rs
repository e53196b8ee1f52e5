//! The files in which a folder holds a light field.

use std::fmt;

use holo_core::Layout;

use crate::files::names::{
    ELEMENTAL_EXR, ELEMENTAL_PNG, HCI_FOLDER, LIGHT_FIELD_HDF5, LIGHT_FIELD_MAT, RAW_EXR, RAW_PNG, VIEWPOINT_EXR,
    VIEWPOINT_PNG,
};

/// A file, or a set of files, that holds all samples of a light field in a folder.
///
/// A folder may have several. The order is that of preference: first what is read, if the folder has it.
///
/// # Examples
///
/// ```
/// use holo_io::dataset::Representation;
///
/// assert!(Representation::ElementalPng < Representation::Hdf5);
/// assert_eq!(Representation::Hdf5.to_string(), "scene_5d.h5");
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[non_exhaustive]
pub enum Representation {
    /// `scene_el.png`: the elemental image array in integers on the sRGB curve.
    ElementalPng,
    /// `scene_vpi.png`: the sub-aperture image array in the same integers.
    ViewpointPng,
    /// `scene_5d.h5`: linear floats of 32 bits.
    Hdf5,
    /// `scene_5d.mat`: the integers of the raw image.
    Mat,
    /// `scene_el.exr`: the elemental image array in linear floats.
    ElementalExr,
    /// `scene_vpi.exr`: the sub-aperture image array in linear floats.
    ViewpointExr,
    /// `hci/`: one PNG a view in the layout of the HCI benchmark.
    Hci,
    /// `raw.exr`: the raw image of a plenoptic camera, of which views are decoded.
    PlenopticExr,
    /// `raw_linear.png`: the same raw image in integers.
    PlenopticPng,
    /// One image a view in the folder itself, under names that are not this project's.
    Views,
}

impl Representation {
    /// Those of a dataset folder, in the order of preference.
    pub const OF_DATASET: [Self; 7] = [
        Self::ElementalPng,
        Self::ViewpointPng,
        Self::Hdf5,
        Self::Mat,
        Self::ElementalExr,
        Self::ViewpointExr,
        Self::Hci,
    ];

    /// Those of a folder of a plenoptic camera, in the order of preference.
    pub const OF_PLENOPTIC: [Self; 2] = [Self::PlenopticExr, Self::PlenopticPng];

    /// Returns the name of the file or of the subfolder; `None` for images of views in the folder itself.
    #[must_use]
    pub const fn file_name(self) -> Option<&'static str> {
        match self {
            Self::ElementalPng => Some(ELEMENTAL_PNG),
            Self::ViewpointPng => Some(VIEWPOINT_PNG),
            Self::Hdf5 => Some(LIGHT_FIELD_HDF5),
            Self::Mat => Some(LIGHT_FIELD_MAT),
            Self::ElementalExr => Some(ELEMENTAL_EXR),
            Self::ViewpointExr => Some(VIEWPOINT_EXR),
            Self::Hci => Some(HCI_FOLDER),
            Self::PlenopticExr => Some(RAW_EXR),
            Self::PlenopticPng => Some(RAW_PNG),
            Self::Views => None,
        }
    }

    /// Returns the layout of the raw image, if it is an array of elemental images or of views.
    #[must_use]
    pub const fn layout(self) -> Option<Layout> {
        match self {
            Self::ElementalPng | Self::ElementalExr => Some(Layout::ElementalGrid),
            Self::ViewpointPng | Self::ViewpointExr => Some(Layout::ViewpointGrid),
            _ => None,
        }
    }
}

/// The name of the file or subfolder, or words for images of views.
impl fmt::Display for Representation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.file_name().unwrap_or("the images of single views"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::layout_of_file_name;

    #[test]
    fn the_order_is_that_of_preference_and_names_say_the_layout() {
        assert!(Representation::OF_DATASET.is_sorted() && Representation::OF_PLENOPTIC.is_sorted());
        for representation in Representation::OF_DATASET.into_iter().chain(Representation::OF_PLENOPTIC) {
            let name = representation.file_name().unwrap();
            assert_eq!(layout_of_file_name(name), representation.layout(), "{name}");
        }
    }
}

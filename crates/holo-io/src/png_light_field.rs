//! Light fields with the samples of PNG files, from one raw image or from a file a view.

mod views;

use holo_core::{Layout, LightField, LightFieldOwned, Split};

use crate::{Error, PngSamples};

pub(crate) use views::Views;

/// A light field in the depth that its PNG files have.
///
/// # Shape
///
/// `(v, u, t, s, c)`, as every [`LightField`]; the order in memory is that of the file or files.
#[derive(Debug, Clone, PartialEq)]
pub enum PngLightField {
    /// 8 bits a channel.
    U8(LightFieldOwned<u8>),
    /// 16 bits a channel.
    U16(LightFieldOwned<u16>),
}

impl PngLightField {
    /// Takes a raw image for a light field; nothing is copied.
    ///
    /// # Errors
    ///
    /// [`Error::Core`] if the image has not the size that the split calls for.
    ///
    /// # Examples
    ///
    /// ```
    /// use holo_core::{GridSize, Layout, Split};
    /// use holo_io::{PngLightField, PngSamples};
    ///
    /// let split = Split::new(GridSize::new(2, 3), GridSize::new(4, 5))?;
    /// let raw = PngSamples::U8(ndarray::Array3::zeros((8, 15, 3)));
    /// let light_field = PngLightField::from_raw(raw, Layout::ElementalGrid, split)?;
    /// assert_eq!((light_field.split(), light_field.channels(), light_field.bits()), (split, 3, 8));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn from_raw(raw: PngSamples, layout: Layout, split: Split) -> Result<Self, Error> {
        let light_field = match (raw, layout) {
            (PngSamples::U8(raw), Layout::ElementalGrid) => LightField::from_elemental_grid(raw, split).map(Self::U8),
            (PngSamples::U8(raw), Layout::ViewpointGrid) => LightField::from_viewpoint_grid(raw, split).map(Self::U8),
            (PngSamples::U16(raw), Layout::ElementalGrid) => LightField::from_elemental_grid(raw, split).map(Self::U16),
            (PngSamples::U16(raw), Layout::ViewpointGrid) => LightField::from_viewpoint_grid(raw, split).map(Self::U16),
        };
        light_field.map_err(|error| Error::core(std::path::Path::new(crate::error::MEMORY), error))
    }

    /// Returns the number of views and lenses.
    #[must_use]
    pub fn split(&self) -> Split {
        match self {
            Self::U8(light_field) => light_field.split(),
            Self::U16(light_field) => light_field.split(),
        }
    }

    /// Returns the number of channels: 1 grey, 2 grey and alpha, 3 RGB, 4 RGB and alpha.
    #[must_use]
    pub fn channels(&self) -> usize {
        match self {
            Self::U8(light_field) => light_field.channels(),
            Self::U16(light_field) => light_field.channels(),
        }
    }

    /// Returns the bits per channel, 8 or 16.
    #[must_use]
    pub fn bits(&self) -> u8 {
        match self {
            Self::U8(_) => 8,
            Self::U16(_) => 16,
        }
    }
}

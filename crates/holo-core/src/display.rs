//! Displays that show a light field: a panel of pixels behind a sheet of lenses, also *integral display*, *light-field
//! display*, *lenticular display*.
//!
//! Every lens sends the light of each pixel behind it in a direction of its own, so an eye sees another pixel from every
//! place. [`Display::panel_image`] finds the ray of each pixel, or of each of its color stripes, and takes it from a light
//! field. [`Display::seen_from`] goes the other way on another path: it traces the rays of an eye through the lenses to
//! the panel, so a mapping can be checked without the device.
//!
//! # Geometry
//!
//! All lengths are meters. The middle of the display is the origin of x (to the right) and y (up), the sheet of lenses is
//! at z = 0, the panel is behind it at z = -gap, and viewers have z above 0. The gap is that in air: the thickness of the
//! material divided by its refractive index.
//!
//! A pixel right of the middle of its lens sends its light to the left. The pixels behind one lens therefore show an
//! elemental image rotated by 180 degrees. The *zone* of a lens is what all its own pixels reach: the pitch times
//! distance over gap. Beyond it an eye sees the pixels of the next lens, and the image repeats.
//!
//! # Source
//!
//! Lippmann, "Épreuves réversibles", 1908; slanted lenticular sheets: van Berkel, "Image preparation for 3D-LCD", 1999.

mod eye;
mod mapping;
#[cfg(test)]
mod tests;

pub use mapping::{PanelMapping, ViewSpread};

use crate::base::error::{positive, positive_or_infinite};
use crate::{Error, GridSize};

/// The parts of a pixel that emit light.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum PixelStripes {
    /// One area that emits all channels.
    #[default]
    None,
    /// Three vertical stripes: red, green, blue from left to right.
    Rgb,
    /// Three vertical stripes: blue, green, red from left to right.
    Bgr,
}

impl PixelStripes {
    /// Returns the channel of a stripe that counts from the left.
    fn channel(self, stripe: usize) -> usize {
        if self == Self::Bgr { 2 - stripe } else { stripe }
    }
}

/// A panel of square pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Panel {
    /// Rows and columns.
    pub size: GridSize,
    /// The distance between adjacent pixels, m.
    pub pitch_m: f64,
    /// The stripes of a pixel.
    pub stripes: PixelStripes,
}

/// How the lenses of a sheet are arranged.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum SheetGrid {
    /// Spherical lenses in rows and columns.
    Square,
    /// Spherical lenses in rows; every second row is shifted by half a lens.
    HexRows,
    /// Cylindrical lenses. The upper end of their axes is turned to the left by the slant, in radians.
    Lenticular {
        /// The angle between the axes and the vertical.
        slant_rad: f64,
    },
}

/// A sheet of lenses before a panel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LensSheet {
    /// The arrangement.
    pub grid: SheetGrid,
    /// The distance between adjacent lenses, m: perpendicular to the axes of cylindrical ones.
    pub pitch_m: f64,
    /// The distance from the panel, m, in air.
    pub gap_m: f64,
    /// The focal length, m; that of sharp pixels far away is the gap.
    pub focal_length_m: f64,
    /// The place of one lens, m, right of and above the middle of the display.
    pub offset_m: [f64; 2],
}

/// A display with the distance that its elemental images are made for.
///
/// # Examples
///
/// A raw image of 2 x 2 views is shown by lenses of 2 x 2 pixels for viewers far away: its elemental images turn around.
///
/// ```
/// use holo_core::display::{Display, LensSheet, Panel, PanelMapping, PixelStripes, SheetGrid};
/// use holo_core::{GridSize, LightField, LightFieldShape};
/// use ndarray::array;
///
/// let panel = Panel { size: GridSize::new(2, 4), pitch_m: 1e-4, stripes: PixelStripes::None };
/// let lenses = LensSheet {
///     grid: SheetGrid::Square,
///     pitch_m: 2e-4,
///     gap_m: 1e-3,
///     focal_length_m: 1e-3,
///     offset_m: [1e-4, 0.0],
/// };
/// let display = Display::new(panel, lenses, f64::INFINITY)?;
/// let shape = LightFieldShape::new(GridSize::new(2, 2), GridSize::new(1, 2))?;
/// let raw = array![[[1.0_f32], [2.0], [5.0], [6.0]], [[3.0], [4.0], [7.0], [8.0]]];
/// let image = display.panel_image(&LightField::from_elemental_grid(raw, shape)?, &PanelMapping::default())?;
/// let turned = array![[[4.0_f32], [3.0], [8.0], [7.0]], [[2.0], [1.0], [6.0], [5.0]]];
/// assert!(image.iter().zip(&turned).all(|(found, expected)| (found - expected).abs() < 1e-5));
/// # Ok::<(), holo_core::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Display {
    panel: Panel,
    lenses: LensSheet,
    distance_m: f64,
}

impl Display {
    /// Returns a display whose elemental images are made for viewers at a distance, in meters; infinity is allowed.
    ///
    /// From there all lenses show the same view. At infinity the elemental images are as far apart as the lenses, nearer
    /// viewers need them farther apart.
    ///
    /// # Errors
    ///
    /// [`Error::ZeroCount`] without pixels; [`Error::BadNumber`] if a length is not above 0, a place not finite, a slant
    /// not between -60 and 60 degrees, or a lens narrower than a pixel.
    pub fn new(panel: Panel, lenses: LensSheet, distance_m: f64) -> Result<Self, Error> {
        for (what, count) in [("pixel rows", panel.size.rows), ("pixel columns", panel.size.columns)] {
            if count == 0 {
                return Err(Error::ZeroCount { what });
            }
        }
        positive("pixel pitch of the panel in meters", panel.pitch_m)?;
        positive("gap between panel and lenses in meters", lenses.gap_m)?;
        positive("focal length of the lenses in meters", lenses.focal_length_m)?;
        positive_or_infinite("viewing distance in meters", distance_m)?;
        let value = positive("lens pitch in meters", lenses.pitch_m)?;
        if value < panel.pitch_m {
            return Err(Error::BadNumber { what: "lens pitch in meters", value, need: "at least the pixel pitch" });
        }
        if let Some(&value) = lenses.offset_m.iter().find(|offset| !offset.is_finite()) {
            return Err(Error::BadNumber { what: "offset of the lenses in meters", value, need: "finite" });
        }
        if let SheetGrid::Lenticular { slant_rad: value } = lenses.grid
            && !(-60_f64.to_radians()..=60_f64.to_radians()).contains(&value)
        {
            return Err(Error::BadNumber { what: "slant of the lenses in radians", value, need: "at most 60 degrees" });
        }
        Ok(Self { panel, lenses, distance_m })
    }

    /// Returns the panel.
    #[must_use]
    pub const fn panel(&self) -> &Panel {
        &self.panel
    }

    /// Returns the sheet of lenses.
    #[must_use]
    pub const fn lenses(&self) -> &LensSheet {
        &self.lenses
    }

    /// Returns the distance that the elemental images are made for, in meters; may be infinite.
    #[must_use]
    pub const fn distance_m(&self) -> f64 {
        self.distance_m
    }

    /// Returns the width and height of the panel, in meters.
    #[must_use]
    pub fn size_m(&self) -> [f64; 2] {
        [self.panel.size.columns, self.panel.size.rows].map(|count| count as f64 * self.panel.pitch_m)
    }

    /// Returns the rows and columns of an image of the display with about one pixel a lens; at least one.
    ///
    /// Cylindrical lenses are counted from left to right, and the pixels of the image are square.
    #[must_use]
    pub fn resolution(&self) -> GridSize {
        let [width, height] =
            self.size_m().map(|size| (size / self.lenses.horizontal_pitch_m()).round().max(1.0) as usize);
        GridSize::new(height, width)
    }

    /// Returns how much farther apart elemental images are than lenses.
    fn stretch(&self) -> f64 {
        1.0 + self.lenses.gap_m / self.distance_m
    }
}

impl LensSheet {
    /// Returns the distance of adjacent lenses of one row, in meters.
    #[must_use]
    pub fn horizontal_pitch_m(&self) -> f64 {
        match self.grid {
            SheetGrid::Lenticular { slant_rad } => self.pitch_m / slant_rad.cos(),
            SheetGrid::Square | SheetGrid::HexRows => self.pitch_m,
        }
    }

    /// Returns whether the lenses deflect light to all sides.
    fn is_spherical(&self) -> bool {
        !matches!(self.grid, SheetGrid::Lenticular { .. })
    }

    /// Returns the middle of the lens that is nearest to a place of the sheet; of a cylindrical one the place of its axis at
    /// the same height.
    fn middle_near(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let ([x0, y0], pitch_m) = (self.offset_m, self.pitch_m);
        let nearest = |at: f64, first: f64, step: f64| first + ((at - first) / step).round() * step;
        match self.grid {
            SheetGrid::Square => [nearest(x, x0, pitch_m), nearest(y, y0, pitch_m)],
            SheetGrid::HexRows => {
                // Two grids of rectangles, shifted by half a lens and a row.
                let row_m = pitch_m * 0.75_f64.sqrt();
                let [even, odd] = [(x0, y0), (x0 + pitch_m / 2.0, y0 + row_m)]
                    .map(|(x0, y0)| [nearest(x, x0, pitch_m), nearest(y, y0, 2.0 * row_m)]);
                let distance = |middle: [f64; 2]| (x - middle[0]).hypot(y - middle[1]);
                if distance(even) <= distance(odd) { even } else { odd }
            }
            SheetGrid::Lenticular { slant_rad } => {
                let axis_at_height = x0 - (y - y0) * slant_rad.tan();
                [nearest(x, axis_at_height, self.horizontal_pitch_m()), y]
            }
        }
    }
}

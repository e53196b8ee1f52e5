//! The image of a panel: the sample of a light field for every pixel or stripe.

use ndarray::{Array3, Data};

use super::{Display, PixelStripes};
use crate::base::memory::filled;
use crate::base::parallel::*;
use crate::{BaselineRatio, Error, LightField, Projection, Rig, Sample};

/// How the views of a light field spread over the directions of a display.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum ViewSpread {
    /// The views fill the zone of the lenses: every view is seen, and depths are as deep as that makes them.
    #[default]
    WholeZone,
    /// The scene of this rig as a model of it, enlarged or reduced in all three directions alike. Directions between which
    /// the rig has no views stay dark.
    ToScale(Rig),
}

/// How a light field is shown.
///
/// # Examples
///
/// ```
/// use holo_core::display::{PanelMapping, ViewSpread};
///
/// let mapping = PanelMapping { screen_disparity_px: 0.5, ..PanelMapping::default() };
/// assert_eq!(mapping.spread, ViewSpread::WholeZone);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PanelMapping {
    /// The spread of the views.
    pub spread: ViewSpread,
    /// The disparity between adjacent views of what appears in the plane of the lenses, in pixels. Larger disparities appear
    /// before the display, smaller ones behind it.
    pub screen_disparity_px: f64,
    /// The ratio of the baselines, [`Rig::baseline_ratio`].
    pub baseline_ratio: BaselineRatio,
    /// The row of views that cylindrical lenses show; the middle of all rows without one.
    pub view_row: Option<usize>,
}

impl Default for PanelMapping {
    fn default() -> Self {
        let (spread, view_row) = (ViewSpread::default(), None);
        Self { spread, screen_disparity_px: 0.0, baseline_ratio: BaselineRatio::EQUAL, view_row }
    }
}

impl Display {
    /// Returns the image for the panel.
    ///
    /// A view covers the panel as far as its aspect ratio allows, and what it leaves is dark, 0. A stripe gets the ray of
    /// its own place and only its channel. Between the samples of the light field, [`LightField::sample`] interpolates; light
    /// is averaged, so samples should be linear.
    ///
    /// # Shape
    ///
    /// `(row, column, c)` with the pixels of the panel; three channels if its pixels have stripes.
    ///
    /// # Errors
    ///
    /// [`Error::FinerThanLightField`] if there are more lenses than pixels in a view, or more pixels behind a lens than
    /// views: the display could show more than the light field knows. A single row of views is allowed; it has no vertical
    /// parallax. [`Error::Shape`] if stripes meet other than one or three channels, or the rig another light field;
    /// [`Error::BadNumber`] if the disparity is not finite, or a scene to scale has its screen infinitely far away;
    /// [`Error::OutOfRange`] if there is no such row of views; [`Error::OutOfMemory`] if the allocation fails.
    pub fn panel_image<S>(&self, light_field: &LightField<S>, mapping: &PanelMapping) -> Result<Array3<f32>, Error>
    where
        S: Data + Sync,
        S::Elem: Sample,
    {
        let rays = PanelRays::new(self, light_field, mapping)?;
        let (size, stripes) = (self.panel.size, self.panel.stripes);
        let channels = light_field.channels();
        let shown = match stripes {
            PixelStripes::None => channels,
            _ if channels == 1 || channels == 3 => 3,
            _ => {
                let found = vec![channels];
                return Err(Error::Shape { what: "channels of the light field", expected: vec![3], found });
            }
        };
        let too_large = Error::TooLarge { what: "image of a panel" };
        let length = crate::light_field::layout::checked_product(&[size.rows, size.columns, shown]).ok_or(too_large)?;
        let mut image = filled("the image of a panel", length, 0.0_f32)?;
        image.par_chunks_mut(size.columns * shown).enumerate().for_each(|(row, line)| {
            for (column, pixel) in line.chunks_exact_mut(shown).enumerate() {
                if stripes == PixelStripes::None {
                    if let Some([v, u, t, s]) = rays.indices(row as f64 + 0.5, column as f64 + 0.5) {
                        for (channel, value) in pixel.iter_mut().enumerate() {
                            *value = light_field.sample(v, u, t, s, channel) as f32;
                        }
                    }
                    continue;
                }
                for stripe in 0..3 {
                    let channel = stripes.channel(stripe);
                    let place = column as f64 + (stripe as f64 + 0.5) / 3.0;
                    if let Some([v, u, t, s]) = rays.indices(row as f64 + 0.5, place) {
                        pixel[channel] = light_field.sample(v, u, t, s, channel.min(channels - 1)) as f32;
                    }
                }
            }
        });
        Ok(Array3::from_shape_vec((size.rows, size.columns, shown), image).expect("the length is the product"))
    }
}

/// The rays of a panel as indices of a light field.
struct PanelRays<'a> {
    display: &'a Display,
    /// Columns and rows of a view and of the grid of views.
    pixels: [f64; 2],
    views: [f64; 2],
    /// The side of a pixel of a view on the display, m.
    pixel_m: f64,
    /// The row of views of cylindrical lenses.
    view_row: f64,
    /// Pixels to the right and down for every view to the right and down.
    disparity_px: [f64; 2],
    scale: Option<Scale>,
}

/// A scene to scale: where its rays meet the cameras.
struct Scale {
    /// From the display to the cameras, in meters of the display.
    cameras_m: f64,
    /// Between adjacent cameras, in meters of the display.
    baseline_m: [f64; 2],
    /// Whether a view is a direction instead of a place.
    is_orthographic: bool,
}

impl<'a> PanelRays<'a> {
    fn new<S: Data>(display: &'a Display, field: &LightField<S>, mapping: &PanelMapping) -> Result<Self, Error> {
        let (lenses, views) = (field.shape().lenses(), field.shape().views());
        let value = mapping.screen_disparity_px;
        if !value.is_finite() {
            return Err(Error::BadNumber { what: "disparity of the screen in pixels", value, need: "finite" });
        }
        if let Some(row) = mapping.view_row {
            crate::base::error::index_below("view row", row, views.rows)?;
        }
        let pixels = [lenses.columns as f64, lenses.rows as f64];
        let [width, height] = display.size_m();
        let pixel_m = (width / pixels[0]).min(height / pixels[1]);
        let ratio = mapping.baseline_ratio;
        let rays = Self {
            display,
            pixels,
            views: [views.columns as f64, views.rows as f64],
            pixel_m,
            view_row: mapping.view_row.map_or((views.rows - 1) as f64 / 2.0, |row| row as f64),
            disparity_px: [value * ratio.horizontal(), value * ratio.vertical()],
            scale: match &mapping.spread {
                ViewSpread::WholeZone => None,
                ViewSpread::ToScale(rig) => {
                    crate::refocus::check_rig(field, rig)?;
                    Some(Scale::new(rig, value, pixel_m)?)
                }
            },
        };
        rays.check_detail()?;
        Ok(rays)
    }

    /// Refuses a display that is finer than the light field.
    fn check_detail(&self) -> Result<(), Error> {
        let (sheet, panel) = (&self.display.lenses, &self.display.panel);
        let pitches_m = match sheet.grid {
            super::SheetGrid::HexRows => [sheet.pitch_m, sheet.pitch_m * 0.75_f64.sqrt()],
            _ => [sheet.horizontal_pitch_m(); 2],
        };
        let names = [
            ["lenses from left to right", "pixels behind a lens from left to right"],
            ["lenses from top to bottom", "pixels behind a lens from top to bottom"],
        ];
        let axes = if sheet.is_spherical() { 0..2 } else { 0..1 };
        for axis in axes {
            let lenses = self.pixels[axis] * self.pixel_m / pitches_m[axis];
            // A lens that the edge cuts, a part of a pixel and rounding do not count.
            if (lenses + 1e-9).floor() > self.pixels[axis] {
                let (what, has) = (names[axis][0], "pixels of a view");
                return Err(Error::FinerThanLightField { what, needed: lenses, has, found: self.pixels[axis] });
            }
            let views = match &self.scale {
                None => self.views[axis],
                // The views whose cameras lie in the zone, would the rig go on.
                Some(scale) => pitches_m[axis] * scale.cameras_m / sheet.gap_m / scale.baseline_m[axis],
            };
            let across = pitches_m[axis] * self.display.stretch() / panel.pitch_m;
            if (axis == 0 || self.views[1] > 1.0) && (across + 1e-9).floor() > views + 1e-9 {
                let (what, has) = (names[axis][1], "views");
                return Err(Error::FinerThanLightField { what, needed: across, has, found: views });
            }
        }
        Ok(())
    }

    /// Returns the indices `[v, u, t, s]` of the ray of a place of the panel, in pixels from its upper left corner; `None`
    /// beside the views.
    fn indices(&self, row: f64, column: f64) -> Option<[f64; 4]> {
        let (panel, sheet) = (&self.display.panel, &self.display.lenses);
        let place = [
            (column - panel.size.columns as f64 / 2.0) * panel.pitch_m,
            (panel.size.rows as f64 / 2.0 - row) * panel.pitch_m,
        ];
        let stretch = self.display.stretch();
        let middle = sheet.middle_near(place.map(|at| at / stretch));
        // Columns count to the right, rows down.
        let down = [1.0, -1.0];
        let mut view = [0.0; 2];
        for axis in 0..2 {
            let camera = match &self.scale {
                None => {
                    let zone_m = stretch * sheet.horizontal_pitch_m();
                    (stretch * middle[axis] - place[axis]) / zone_m * self.views[axis]
                }
                Some(scale) => {
                    let sideways_m = (middle[axis] - place[axis]) / sheet.gap_m * scale.cameras_m;
                    let start_m = if scale.is_orthographic { 0.0 } else { middle[axis] };
                    (start_m + sideways_m) / scale.baseline_m[axis]
                }
            };
            view[axis] = if axis == 1 && !sheet.is_spherical() {
                self.view_row
            } else if self.views[axis] == 1.0 {
                0.0
            } else {
                down[axis] * camera + (self.views[axis] - 1.0) / 2.0
            };
            if self.scale.is_some() && !(-0.5..=self.views[axis] - 0.5).contains(&view[axis]) {
                return None;
            }
        }
        let mut pixel = [0.0; 2];
        for axis in 0..2 {
            let at = down[axis] * middle[axis] / self.pixel_m + self.pixels[axis] / 2.0;
            // Lenses at the edge may have their middle outside.
            let margin = sheet.pitch_m / self.pixel_m / 2.0 + 1e-9;
            if !(-margin..=self.pixels[axis] + margin).contains(&at) {
                return None;
            }
            pixel[axis] = at - 0.5 - self.disparity_px[axis] * (view[axis] - (self.views[axis] - 1.0) / 2.0);
        }
        Some([pixel[1], pixel[0], view[1], view[0]])
    }
}

impl Scale {
    fn new(rig: &Rig, screen_disparity_px: f64, pixel_m: f64) -> Result<Self, Error> {
        for (views, baseline_m) in
            [(rig.shape().views().columns, rig.baseline_x_m()), (rig.shape().views().rows, rig.baseline_y_m())]
        {
            if views > 1 && baseline_m == 0.0 {
                return Err(Error::NoBaseline);
            }
        }
        let value = rig.disparity_x().to_depth_m(screen_disparity_px);
        if !(value.is_finite() && value > 0.0) {
            let what = "distance in meters of what appears in the plane of the lenses";
            let need = "finite and above 0; choose the disparity of another distance";
            return Err(Error::BadNumber { what, value, need });
        }
        let at = |column: usize| rig.ray(0, column, 0, 0, 0.5, 0.5).at_depth_m(value)[0];
        let meters_per_meter = pixel_m / (at(1) - at(0));
        let is_orthographic = rig.projection() == Projection::Orthographic;
        let reach = if is_orthographic { rig.focus_distance_m() } else { value };
        let baseline_m = [rig.baseline_x_m(), rig.baseline_y_m()].map(|baseline| {
            // The views of an orthographic rig are directions, which are farther apart on a screen farther away.
            baseline * meters_per_meter * value / reach
        });
        Ok(Self { cameras_m: value * meters_per_meter, baseline_m, is_orthographic })
    }
}

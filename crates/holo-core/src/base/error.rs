//! The error type of this crate.

use std::fmt;

use crate::GridSize;

/// An error of `holo-core`: an impossible shape, an index out of range, an invalid number or a failed allocation.
///
/// No function panics on data, unless its documentation says so. Sizes are checked before memory is allocated.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Error {
    /// A count that must be at least one is zero.
    ZeroCount {
        /// The counted objects, such as `"view rows"`.
        what: &'static str,
    },
    /// A size does not fit the address space.
    TooLarge {
        /// The object of that size, such as `"light field"`.
        what: &'static str,
    },
    /// An allocation failed.
    OutOfMemory {
        /// What the memory was for, with its article, such as `"a light field"`.
        what: &'static str,
        /// The requested size in bytes.
        bytes: usize,
    },
    /// The crate was built without a feature.
    MissingFeature {
        /// What needs it, as the subject of a sentence.
        what: &'static str,
        /// The feature.
        feature: &'static str,
    },
    /// The shape of an array does not agree with the other arguments.
    Shape {
        /// The array.
        what: &'static str,
        /// The required shape.
        expected: Vec<usize>,
        /// The shape of the array.
        found: Vec<usize>,
    },
    /// An index is not below its count.
    OutOfRange {
        /// The kind of index, such as `"view row"`.
        what: &'static str,
        /// The index.
        index: usize,
        /// The number of valid indices.
        count: usize,
        /// The lowest valid index: 0, or 1 for ranges as in the paper.
        first: usize,
    },
    /// A range is empty, reversed or ends beyond its axis.
    BadRange {
        /// The kind of range, such as `"view rows"`.
        what: &'static str,
        /// Its start.
        start: usize,
        /// Its end (exclusive).
        end: usize,
        /// The length of the axis.
        count: usize,
    },
    /// An image has gaps in memory, so its axes cannot be split in place.
    NotDense {
        /// The image's shape.
        shape: Vec<usize>,
        /// The image's strides, in elements.
        strides: Vec<isize>,
    },
    /// A sensor is not a whole multiple of the views and the policy was `Remainder::Exact`.
    NotDivisible {
        /// The sensor.
        sensor: GridSize,
        /// The views per axis.
        views: GridSize,
        /// The rows and columns that remain.
        border: GridSize,
    },
    /// A sensor has fewer pixels than views along an axis.
    SensorTooSmall {
        /// The sensor.
        sensor: GridSize,
        /// The views per axis.
        views: GridSize,
    },
    /// A number is NaN, infinite, of the wrong sign or outside its range.
    BadNumber {
        /// The name of the number, such as `"focal length in meters"`.
        what: &'static str,
        /// Its value.
        value: f64,
        /// The requirement, such as `"finite and above 0"`.
        need: &'static str,
    },
    /// An orthographic rig was given no finite focus distance.
    OrthographicFocus {
        /// The focus distance in meters.
        focus_distance_m: f64,
    },
    /// Depth was requested for a rig with baseline 0, which has no parallax.
    NoBaseline,
    /// A range of disparities needs more planes than a sweep has.
    TooManyPlanes {
        /// The smallest disparity, in pixels.
        low_px: f32,
        /// The largest disparity, in pixels.
        high_px: f32,
        /// The planes that the range needs.
        planes: usize,
        /// The largest number of planes.
        most: usize,
    },
    /// A display could show more than a light field knows.
    FinerThanLightField {
        /// What the display has more of, such as `"lenses from left to right"`.
        what: &'static str,
        /// How many it has.
        needed: f64,
        /// What the light field has for them, such as `"views"`.
        has: &'static str,
        /// How many it has.
        found: f64,
    },
    /// No pixel remains after border, mask and missing values are excluded.
    NothingToMeasure {
        /// The measure, such as `"disparity error"`.
        what: &'static str,
        /// Rows and columns of the map.
        shape: [usize; 2],
        /// The excluded border in pixels.
        border_px: usize,
    },
    /// No rig has the disparity range, the depth range or the combination of both.
    ImpossibleRange {
        /// The reason, such as `"the nearest depth must have the largest disparity"`.
        why: &'static str,
    },
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::ZeroCount { what } => write!(f, "the number of {what} is 0; it must be at least 1"),
            Self::TooLarge { what } => write!(f, "the {what} does not fit the address space"),
            Self::OutOfMemory { what, bytes } => write!(f, "out of memory: allocating {bytes} bytes for {what} failed"),
            Self::MissingFeature { what, feature } => {
                write!(f, "{what} needs the feature `{feature}` of holo-core; build with it")
            }
            Self::Shape { what, expected, found } => {
                write!(f, "the {what} has the shape {found:?}; it must be {expected:?}")
            }
            Self::OutOfRange { what, index, count, first } => {
                // `first + count - 1` could overflow.
                write!(f, "{what} {index} does not exist: there are {count}, counted from {first}")
            }
            Self::BadRange { what, start, end, count } => {
                write!(f, "the {what} {start}..{end} must be a range of at least one within 0..{count}")
            }
            Self::NotDense { shape, strides } => write!(
                f,
                "an image of shape {shape:?} and strides {strides:?} has gaps in memory, so its axes cannot be split \
                 in place; borrow it with from_elemental_grid_view or from_viewpoint_grid_view, or copy it first"
            ),
            Self::NotDivisible { sensor, views, border } => write!(
                f,
                "a sensor of {} rows x {} columns does not split exactly into {} x {} views: {} rows and {} columns \
                 are left over; crop it or choose other counts",
                sensor.rows, sensor.columns, views.rows, views.columns, border.rows, border.columns
            ),
            Self::SensorTooSmall { sensor, views } => write!(
                f,
                "a sensor of {} rows x {} columns is too small for {} x {} views: every view needs at least one pixel",
                sensor.rows, sensor.columns, views.rows, views.columns
            ),
            Self::BadNumber { what, value, need } => write!(f, "the {what} is {value}; it must be {need}"),
            Self::OrthographicFocus { focus_distance_m } => write!(
                f,
                "an orthographic rig needs a finite focus distance, not {focus_distance_m} m: its rays aim at points \
                 of the focus plane"
            ),
            Self::NoBaseline => {
                write!(f, "the baseline is 0: all views coincide, so disparity does not determine depth")
            }
            Self::TooManyPlanes { low_px, high_px, planes, most } => write!(
                f,
                "disparities from {low_px} to {high_px} px take {planes} planes at this effort, and at most {most} are \
                 possible; narrow the range or lower the effort"
            ),
            Self::FinerThanLightField { what, needed, has, found } => write!(
                f,
                "the display is finer than the light field: it has {needed:.1} {what}, and the light field {found:.1} \
                 {has} for them; use a light field with more {has}, or a coarser display"
            ),
            Self::NothingToMeasure { what, shape: [rows, columns], border_px } => write!(
                f,
                "no pixel is left to measure the {what}: the map has {rows} rows x {columns} columns, {border_px} px \
                 of border are excluded on every side, and the mask and missing values may exclude the rest; choose a \
                 narrower border or another mask"
            ),
            Self::ImpossibleRange { why } => write!(f, "no rig has these ranges: {why}"),
        }
    }
}

impl std::error::Error for Error {}

/// Returns the number if it is finite and above zero.
pub(crate) fn positive(what: &'static str, value: f64) -> Result<f64, Error> {
    if value.is_finite() && value > 0.0 {
        Ok(value)
    } else {
        Err(Error::BadNumber { what, value, need: "finite and above 0" })
    }
}

/// Returns the number if it is above zero; it may be infinite.
pub(crate) fn positive_or_infinite(what: &'static str, value: f64) -> Result<f64, Error> {
    if value > 0.0 { Ok(value) } else { Err(Error::BadNumber { what, value, need: "above 0 (infinity is allowed)" }) }
}

/// Returns the number if it is finite and not negative; -0 becomes 0.
pub(crate) fn not_negative(what: &'static str, value: f64) -> Result<f64, Error> {
    if value.is_finite() && value >= 0.0 {
        Ok(value + 0.0)
    } else {
        Err(Error::BadNumber { what, value, need: "finite and not negative" })
    }
}

/// Accepts an index below its count.
pub(crate) fn index_below(what: &'static str, index: usize, count: usize) -> Result<(), Error> {
    if index < count { Ok(()) } else { Err(Error::OutOfRange { what, index, count, first: 0 }) }
}

/// Accepts a range that is not empty and ends within the axis.
pub(crate) fn range_within(what: &'static str, range: &std::ops::Range<usize>, count: usize) -> Result<(), Error> {
    if range.start < range.end && range.end <= count {
        Ok(())
    } else {
        Err(Error::BadRange { what, start: range.start, end: range.end, count })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_name_the_argument_and_its_value() {
        let message = positive("focal length in meters", f64::NAN).unwrap_err().to_string();
        assert_eq!(message, "the focal length in meters is NaN; it must be finite and above 0");
        let message = index_below("view row", 7, 5).unwrap_err().to_string();
        assert_eq!(message, "view row 7 does not exist: there are 5, counted from 0");
        let message = range_within("view rows", &(3..9), 5).unwrap_err().to_string();
        assert_eq!(message, "the view rows 3..9 must be a range of at least one within 0..5");
    }

    #[test]
    #[allow(clippy::reversed_empty_ranges, reason = "reversed ranges are under test")]
    fn invalid_numbers_and_ranges_are_rejected() {
        for value in [f64::NAN, 0.0, -0.0, -1.0, f64::INFINITY, f64::NEG_INFINITY] {
            assert!(positive("x", value).is_err(), "{value}");
        }
        for value in [f64::NAN, -1.0, f64::INFINITY] {
            assert!(not_negative("x", value).is_err(), "{value}");
        }
        assert!(not_negative("x", -0.0).unwrap().is_sign_positive());
        assert!(positive_or_infinite("x", f64::INFINITY).is_ok());
        assert!(positive_or_infinite("x", f64::NAN).is_err());
        for range in [2..2, 3..2, 4..6, usize::MAX..usize::MAX] {
            assert!(range_within("x", &range, 5).is_err(), "{range:?}");
        }
        assert!(range_within("x", &(4..5), 5).is_ok());
    }
}

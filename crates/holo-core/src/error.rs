//! Everything that can go wrong in this crate.

use std::fmt;

use crate::GridSize;

/// An error of `holo-core`: an impossible shape, an index out of range, or a number that no rig can have.
///
/// Nothing in this crate panics on data; a function that cannot give a right answer returns one of these. No function
/// allocates before the size of what it is about to make has been checked.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Error {
    /// A count that must be at least one is zero.
    ZeroCount {
        /// What was counted, such as `"view rows"`.
        what: &'static str,
    },
    /// A size does not fit the address space.
    TooLarge {
        /// What was to be made, such as `"light field"`.
        what: &'static str,
    },
    /// An allocation failed.
    OutOfMemory {
        /// What the memory was for, with its article, such as `"a light field"`.
        what: &'static str,
        /// The requested size in bytes.
        bytes: usize,
    },
    /// An array does not have the shape that the other arguments call for.
    Shape {
        /// Which array.
        what: &'static str,
        /// The shape it must have.
        expected: Vec<usize>,
        /// The shape it has.
        found: Vec<usize>,
    },
    /// An index is not below its count.
    OutOfRange {
        /// Which index, such as `"view row"`.
        what: &'static str,
        /// The index.
        index: usize,
        /// How many there are.
        count: usize,
        /// The lowest legal index: 0, or 1 for the paper's own ranges.
        first: usize,
    },
    /// A range is empty, runs backwards or ends behind its axis.
    BadRange {
        /// Which range, such as `"view rows"`.
        what: &'static str,
        /// Its start.
        start: usize,
        /// Its end (exclusive).
        end: usize,
        /// The length of the axis.
        count: usize,
    },
    /// An image has gaps in memory, so that its axes cannot be split without copying or borrowing.
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
        /// The rows and columns left over.
        border: GridSize,
    },
    /// A sensor has fewer pixels than views along an axis.
    SensorTooSmall {
        /// The sensor.
        sensor: GridSize,
        /// The views per axis.
        views: GridSize,
    },
    /// A number is NaN, infinite, of the wrong sign or otherwise outside what it may be.
    BadNumber {
        /// Which number, such as `"focal length in meters"`.
        what: &'static str,
        /// Its value.
        value: f64,
        /// What it must be, such as `"finite and above 0"`.
        need: &'static str,
    },
    /// An orthographic rig was given no finite focus distance.
    OrthographicFocus {
        /// The focus distance.
        focus_distance_m: f64,
    },
    /// Depth was asked of a rig whose views coincide, which has no parallax.
    NoBaseline,
    /// Border, mask and missing values leave no pixel to measure.
    NothingToMeasure {
        /// What was to be measured, such as `"disparity error"`.
        what: &'static str,
        /// Rows and columns of the map.
        shape: [usize; 2],
        /// The ignored border in pixels.
        border_px: usize,
    },
    /// A disparity range, a depth range or both together that no rig in front of its scene can have.
    ImpossibleRange {
        /// Why, such as `"the nearest depth must have the largest disparity"`.
        why: &'static str,
    },
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::ZeroCount { what } => write!(f, "the number of {what} is 0; it must be at least 1"),
            Self::TooLarge { what } => write!(f, "the {what} does not fit the address space"),
            Self::OutOfMemory { what, bytes } => write!(f, "out of memory: allocating {bytes} bytes for {what} failed"),
            Self::Shape { what, expected, found } => {
                write!(f, "the {what} has the shape {found:?}; it must be {expected:?}")
            }
            Self::OutOfRange { what, index, count, first } => {
                // Written without `first + count - 1`, which could overflow on a hostile index.
                write!(f, "{what} {index} does not exist: there are {count}, counted from {first}")
            }
            Self::BadRange { what, start, end, count } => {
                write!(f, "the {what} {start}..{end} must be a range of at least one within 0..{count}")
            }
            Self::NotDense { shape, strides } => write!(
                f,
                "an image of shape {shape:?} and strides {strides:?} has gaps in memory, so its axes cannot be split in place; \
                 borrow it with from_elemental_grid_view or from_viewpoint_grid_view, or copy it first"
            ),
            Self::NotDivisible { sensor, views, border } => write!(
                f,
                "a sensor of {} rows x {} columns does not split exactly into {} x {} views: {} rows and {} columns are left \
                 over; crop it or choose other counts",
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
                "an orthographic rig needs a finite focus distance, not {focus_distance_m} m: its rays aim at points of the \
                 focus plane"
            ),
            Self::NoBaseline => {
                write!(f, "the baseline is 0: all views coincide, so disparity says nothing about depth")
            }
            Self::NothingToMeasure { what, shape: [rows, columns], border_px } => write!(
                f,
                "no pixel is left to measure the {what}: the map has {rows} rows x {columns} columns, {border_px} px of border \
                 are ignored on every side, and the mask and missing values may take the rest; ask for a narrower border or \
                 another mask"
            ),
            Self::ImpossibleRange { why } => write!(f, "no rig has these ranges: {why}"),
        }
    }
}

impl std::error::Error for Error {}

/// Passes a finite number above zero.
pub(crate) fn positive(what: &'static str, value: f64) -> Result<f64, Error> {
    if value.is_finite() && value > 0.0 {
        Ok(value)
    } else {
        Err(Error::BadNumber { what, value, need: "finite and above 0" })
    }
}

/// Passes a number above zero that may be infinite.
pub(crate) fn positive_or_infinite(what: &'static str, value: f64) -> Result<f64, Error> {
    if value > 0.0 { Ok(value) } else { Err(Error::BadNumber { what, value, need: "above 0 (infinity is allowed)" }) }
}

/// Passes a finite number that is not negative, with -0 made 0.
pub(crate) fn not_negative(what: &'static str, value: f64) -> Result<f64, Error> {
    if value.is_finite() && value >= 0.0 {
        Ok(value + 0.0)
    } else {
        Err(Error::BadNumber { what, value, need: "finite and not negative" })
    }
}

/// Passes an index below its count.
pub(crate) fn index_below(what: &'static str, index: usize, count: usize) -> Result<(), Error> {
    if index < count { Ok(()) } else { Err(Error::OutOfRange { what, index, count, first: 0 }) }
}

/// Passes a range that is not empty and ends within the axis.
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
    fn messages_name_the_culprit_and_its_value() {
        let message = positive("focal length in meters", f64::NAN).unwrap_err().to_string();
        assert_eq!(message, "the focal length in meters is NaN; it must be finite and above 0");
        let message = index_below("view row", 7, 5).unwrap_err().to_string();
        assert_eq!(message, "view row 7 does not exist: there are 5, counted from 0");
        let message = range_within("view rows", &(3..9), 5).unwrap_err().to_string();
        assert_eq!(message, "the view rows 3..9 must be a range of at least one within 0..5");
    }

    #[test]
    #[allow(clippy::reversed_empty_ranges)] // a backwards range is what is being refused
    fn guards_refuse_what_they_must() {
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

//! Meters to the millimeters of files and back, by moving the decimal point.
//!
//! A multiplication by 1000 rounds in binary: 0.0351 m would be written as 35.099999999999994 mm. Moving the point of
//! the shortest decimal text gives the number that a person would write, and moving it back gives the meters again.

/// Converts a length from meters to millimeters.
///
/// # Accuracy
///
/// The decimal point of the shortest text of the number is moved: 0.0351 m is 35.1 mm, where a multiplication would
/// give 35.099999999999994. [`millimeters_to_meters`] gives the number of meters again.
#[must_use]
pub fn meters_to_millimeters(length_m: f64) -> f64 {
    move_point(length_m, 3).unwrap_or(length_m * 1e3)
}

/// Converts a length from millimeters to meters: the inverse of [`meters_to_millimeters`].
///
/// # Accuracy
///
/// The decimal point of the shortest text of the number is moved. Where one of the nearest three numbers gives
/// `length_mm` again under [`meters_to_millimeters`], it is that number.
#[must_use]
pub fn millimeters_to_meters(length_mm: f64) -> f64 {
    let length_m = move_point(length_mm, -3).unwrap_or(length_mm / 1e3);
    // Moving the point rounds once, so the inverse may be an adjacent number.
    let nearby = [length_m, length_m.next_up(), length_m.next_down()];
    nearby.into_iter().find(|&length_m| meters_to_millimeters(length_m) == length_mm).unwrap_or(length_m)
}

fn move_point(value: f64, places: i32) -> Option<f64> {
    let text = format!("{value:e}");
    let (digits, exponent) = text.split_once('e')?;
    let exponent = exponent.parse::<i32>().ok()? + places;
    format!("{digits}e{exponent}").parse().ok()
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn numbers_are_those_that_a_person_would_write() {
        for (meters, millimeters) in
            [(0.035, 35.0), (0.0351, 35.1), (0.1, 100.0), (0.025, 25.0), (1e-5, 0.01), (0.0, 0.0), (1.0, 1000.0)]
        {
            assert_eq!(meters_to_millimeters(meters), millimeters);
            assert_eq!(millimeters_to_meters(millimeters), meters);
        }
        assert_eq!(meters_to_millimeters(f64::INFINITY), f64::INFINITY);
        assert!(millimeters_to_meters(f64::NAN).is_nan());
        assert_eq!(meters_to_millimeters(f64::MAX), f64::INFINITY);
    }

    proptest! {
        #[test]
        fn there_and_back_is_the_same_number(micrometers in 0_i64..10_000_000_000) {
            let meters: f64 = format!("{micrometers}e-6").parse().unwrap();
            prop_assert_eq!(millimeters_to_meters(meters_to_millimeters(meters)), meters);
        }

        #[test]
        fn what_was_written_is_written_again(meters in prop::num::f64::POSITIVE | prop::num::f64::NORMAL) {
            let millimeters = meters_to_millimeters(meters);
            prop_assume!(millimeters.is_finite() && meters.abs() > 1e-300);
            prop_assert_eq!(meters_to_millimeters(millimeters_to_meters(millimeters)), millimeters);
        }

        #[test]
        fn every_number_stays_within_one_rounding(meters in prop::num::f64::NORMAL) {
            let millimeters = meters_to_millimeters(meters);
            prop_assume!(millimeters.is_finite() && meters.abs() > 1e-300);
            prop_assert!((millimeters / 1e3 - meters).abs() <= meters.abs() * 4.0 * f64::EPSILON);
        }
    }
}

//! Metres to the millimetres of files and back, by moving the decimal point.
//!
//! A multiplication by 1000 rounds in binary: 0.0351 m would be written as 35.099999999999994 mm. Moving the point of
//! the shortest decimal text gives the number that a person would write, and moving it back gives the metres again.

/// Returns a length in millimetres.
pub(crate) fn from_metres(length_m: f64) -> f64 {
    move_point(length_m, 3).unwrap_or(length_m * 1e3)
}

/// Returns a length in metres.
pub(crate) fn to_metres(length_mm: f64) -> f64 {
    move_point(length_mm, -3).unwrap_or(length_mm / 1e3)
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
        for (metres, millimetres) in
            [(0.035, 35.0), (0.0351, 35.1), (0.1, 100.0), (0.025, 25.0), (1e-5, 0.01), (0.0, 0.0), (1.0, 1000.0)]
        {
            assert_eq!(from_metres(metres), millimetres);
            assert_eq!(to_metres(millimetres), metres);
        }
        assert_eq!(from_metres(f64::INFINITY), f64::INFINITY);
        assert!(to_metres(f64::NAN).is_nan());
        assert_eq!(from_metres(f64::MAX), f64::INFINITY);
    }

    proptest! {
        #[test]
        fn there_and_back_is_the_same_number(micrometres in 0_i64..10_000_000_000) {
            let metres: f64 = format!("{micrometres}e-6").parse().unwrap();
            prop_assert_eq!(to_metres(from_metres(metres)), metres);
        }

        #[test]
        fn every_number_stays_within_one_rounding(metres in prop::num::f64::NORMAL) {
            let millimetres = from_metres(metres);
            prop_assume!(millimetres.is_finite() && metres.abs() > 1e-300);
            prop_assert!((millimetres / 1e3 - metres).abs() <= metres.abs() * 4.0 * f64::EPSILON);
        }
    }
}

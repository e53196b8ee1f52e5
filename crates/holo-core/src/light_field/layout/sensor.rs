//! Sensors, and their division into views and microlenses (Table I).

use crate::{Error, GridSize, LightFieldShape};

/// A sensor size in pixels.
///
/// # Source
///
/// Table I of the paper divides "8K" by 20, 40, 60, 80 and 100 views per axis and finds 397x265, 198x132, 132x88, 99x66
/// and 79x53 microlenses (columns x rows), rounded down. Two errata of the paper follow from it:
///
/// - No UHD format gives this table, only sensors of 7940..7959 x 5300..5319 pixels. [`Sensor::Paper8k`] is therefore
///   7952 x 5304 pixels, a 42-megapixel full-frame sensor. [`Sensor::Uhd8k`] is the television format.
/// - "74x53" in Fig. 8 is a misprint of 79x53.
///
/// # Examples
///
/// ```
/// use holo_core::{GridSize, Remainder, Sensor};
///
/// let table_row = Sensor::Paper8k.divide(GridSize::new(100, 100), Remainder::Crop)?;
/// assert_eq!(table_row.shape.lenses(), GridSize::new(53, 79));
/// assert_eq!(table_row.border, GridSize::new(4, 52));
/// # Ok::<(), holo_core::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Sensor {
    /// 1920 x 1080.
    Hd,
    /// 3840 x 2160.
    Uhd4k,
    /// The paper's "8K": 7952 x 5304.
    Paper8k,
    /// 7680 x 4320.
    Uhd8k,
    /// Any other size, rows first.
    Other(GridSize),
}

/// The treatment of sensor rows and columns that do not fill a block of views.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Remainder {
    /// They are cropped at the bottom and at the right, and their number is returned.
    Crop,
    /// They are an error.
    Exact,
}

/// The division of a sensor: the shape of its light field and the cropped border.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct SensorDivision {
    /// The numbers of views and of microlenses.
    pub shape: LightFieldShape,
    /// Rows cropped at the bottom and columns cropped at the right; zero when the sensor divides exactly.
    pub border: GridSize,
}

impl Sensor {
    /// Returns the size in pixels, rows first.
    #[must_use]
    pub const fn size(self) -> GridSize {
        match self {
            Self::Hd => GridSize::new(1080, 1920),
            Self::Uhd4k => GridSize::new(2160, 3840),
            Self::Paper8k => GridSize::new(5304, 7952),
            Self::Uhd8k => GridSize::new(4320, 7680),
            Self::Other(size) => size,
        }
    }

    /// Divides the sensor into `views` (T rows x S columns): every microlens covers T x S pixels.
    ///
    /// # Errors
    ///
    /// [`Error::ZeroCount`] if there are no views or no pixels; [`Error::SensorTooSmall`] if there are more views than
    /// pixels along an axis; [`Error::NotDivisible`] if pixels are left over and `remainder` is [`Remainder::Exact`];
    /// [`Error::TooLarge`] for a sensor that does not fit the address space.
    ///
    /// # Source
    ///
    /// Eq. 1 and Table I.
    pub fn divide(self, views: GridSize, remainder: Remainder) -> Result<SensorDivision, Error> {
        let sensor = self.size();
        for (what, count) in [
            ("view rows", views.rows),
            ("view columns", views.columns),
            ("sensor rows", sensor.rows),
            ("sensor columns", sensor.columns),
        ] {
            if count == 0 {
                return Err(Error::ZeroCount { what });
            }
        }
        if sensor.rows < views.rows || sensor.columns < views.columns {
            return Err(Error::SensorTooSmall { sensor, views });
        }
        let lenses = GridSize::new(sensor.rows / views.rows, sensor.columns / views.columns);
        let border = GridSize::new(sensor.rows % views.rows, sensor.columns % views.columns);
        if remainder == Remainder::Exact && border != GridSize::new(0, 0) {
            return Err(Error::NotDivisible { sensor, views, border });
        }
        Ok(SensorDivision { shape: LightFieldShape::new(views, lenses)?, border })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Table I: views per axis, then lenses as the paper prints them, columns x rows.
    const TABLE_I: [(usize, usize, usize); 5] =
        [(20, 397, 265), (40, 198, 132), (60, 132, 88), (80, 99, 66), (100, 79, 53)];

    #[test]
    fn table_one_holds_for_the_8k_sensor() {
        for (views, columns, rows) in TABLE_I {
            let divided = Sensor::Paper8k.divide(GridSize::new(views, views), Remainder::Crop).unwrap();
            assert_eq!(divided.shape.lenses(), GridSize::new(rows, columns), "{views} views per axis");
            // Raw image and border add up to the sensor, and the border is narrower than a block.
            let raw = divided.shape.raw_size();
            assert_eq!((raw.rows + divided.border.rows, raw.columns + divided.border.columns), (5304, 7952));
            assert!(divided.border.rows < views && divided.border.columns < views);
        }
    }

    #[test]
    fn table_one_holds_for_no_other_named_sensor() {
        let gives_table = |sensor: Sensor| {
            TABLE_I.iter().all(|&(views, columns, rows)| {
                sensor.divide(GridSize::new(views, views), Remainder::Crop).unwrap().shape.lenses()
                    == GridSize::new(rows, columns)
            })
        };
        for sensor in [Sensor::Hd, Sensor::Uhd4k, Sensor::Uhd8k] {
            assert!(!gives_table(sensor), "{sensor:?}");
        }
        // Erratum: exactly the sensors of 5300..5319 rows and 7940..7959 columns give the table.
        for rows in 5280..5340 {
            assert_eq!(
                gives_table(Sensor::Other(GridSize::new(rows, 7952))),
                (5300..5320).contains(&rows),
                "{rows} rows"
            );
        }
        for columns in 7920..7980 {
            assert_eq!(
                gives_table(Sensor::Other(GridSize::new(5304, columns))),
                (7940..7960).contains(&columns),
                "{columns} columns"
            );
        }
    }

    #[test]
    fn remainder_is_an_error_if_the_division_must_be_exact() {
        let views = GridSize::new(100, 100);
        assert_eq!(
            Sensor::Paper8k.divide(views, Remainder::Exact),
            Err(Error::NotDivisible { sensor: GridSize::new(5304, 7952), views, border: GridSize::new(4, 52) })
        );
        let exact = Sensor::Uhd4k.divide(GridSize::new(9, 16), Remainder::Exact).unwrap();
        assert_eq!(exact.border, GridSize::new(0, 0));
        assert_eq!(exact.shape.raw_size(), Sensor::Uhd4k.size());
    }

    #[test]
    fn impossible_sensors_are_errors() {
        let one = GridSize::new(1, 1);
        assert_eq!(
            Sensor::Hd.divide(GridSize::new(0, 1), Remainder::Crop),
            Err(Error::ZeroCount { what: "view rows" })
        );
        assert_eq!(
            Sensor::Other(GridSize::new(1, 0)).divide(one, Remainder::Crop),
            Err(Error::ZeroCount { what: "sensor columns" })
        );
        let views = GridSize::new(1, 1921);
        assert_eq!(
            Sensor::Hd.divide(views, Remainder::Crop),
            Err(Error::SensorTooSmall { sensor: Sensor::Hd.size(), views })
        );
        assert!(matches!(
            Sensor::Other(GridSize::new(usize::MAX, usize::MAX)).divide(one, Remainder::Crop),
            Err(Error::TooLarge { .. })
        ));
    }
}

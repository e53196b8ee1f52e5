//! The division of a raw image into views and microlenses: Eq. 1, Table I. **May import:** sizes and errors.

mod sensor;
mod shape;

pub use sensor::{Remainder, Sensor, SensorDivision};
pub use shape::LightFieldShape;
pub(crate) use shape::checked_product;

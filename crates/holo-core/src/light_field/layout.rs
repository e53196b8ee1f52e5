//! The division of a raw image into views and microlenses: Eq. 1, Table I, Eq. 5. **May import:** sizes and errors.

mod block;
mod sensor;
mod shape;

pub use block::{Block, OneBasedBlock};
pub use sensor::{Remainder, Sensor, SensorDivision};
pub use shape::LightFieldShape;
pub(crate) use shape::checked_product;

//! How a raw image divides into views and lenses: Eq. 1, Table I, Eq. 5. **May enter:** sizes and errors.

mod block;
mod sensor;
mod split;

pub use block::{Block, OneBasedBlock};
pub use sensor::{Remainder, Sensor, SensorSplit};
pub use split::Split;
pub(crate) use split::checked_product;

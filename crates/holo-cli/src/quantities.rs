//! Named numbers: a table for people, one JSON object for programs.

use holo_dataset::{NamedQuantity, QuantityValue, text};
use serde_json::{Map, Value};

use crate::console::out;
use crate::failure::Failure;

/// A value in the table.
fn cell(value: &QuantityValue) -> String {
    let number = |number: f64| if number.is_finite() { text::number(number) } else { number.to_string() };
    match value {
        QuantityValue::Number(value) => number(*value),
        QuantityValue::Count(count) => number(*count as f64),
        QuantityValue::Text(text) => text.clone(),
        QuantityValue::Size(size) => format!("{} x {}", size.columns, size.rows),
        QuantityValue::Range([low, high]) => format!("{} to {}", number(*low), number(*high)),
        QuantityValue::List(numbers) => numbers.iter().map(|value| number(*value)).collect::<Vec<_>>().join(", "),
        QuantityValue::Matrix(_) => "with --json".into(),
    }
}

/// Prints all of them on standard output.
pub fn print(quantities: &[NamedQuantity], as_json: bool) -> Result<(), Failure> {
    if as_json {
        let pair = |row: &NamedQuantity| -> (String, Value) {
            (row.key.clone(), serde_json::from_str(&row.value.to_json()).unwrap_or_default())
        };
        let object: Map<String, Value> = quantities.iter().map(pair).collect();
        return out!("{}", Value::Object(object));
    }
    let line = |row: &NamedQuantity| format!("{:<44} {} {}", row.name, cell(&row.value), row.unit);
    quantities.iter().try_for_each(|row| out!("{}", line(row).trim_end()))
}

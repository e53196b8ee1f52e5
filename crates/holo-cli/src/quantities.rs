//! Named numbers: a table for people, one JSON object for programs.

use holo_dataset::text;
use serde_json::{Map, Value};

use crate::console::out;
use crate::failure::Failure;

/// One number, a range of two, a size, or a matrix.
pub struct Quantity {
    pub key: String,
    pub name: String,
    pub value: Value,
    pub unit: &'static str,
}

impl Quantity {
    pub fn new(key: impl Into<String>, name: impl Into<String>, value: Value, unit: &'static str) -> Self {
        Self { key: key.into(), name: name.into(), value, unit }
    }

    fn text(&self) -> String {
        let number = |value: &Value| match value.as_f64() {
            Some(number) => text::number(number),
            None => value.as_str().unwrap_or_default().to_owned(),
        };
        match &self.value {
            Value::Array(rows) if rows.iter().any(Value::is_array) => "with --json".into(),
            Value::Array(ends) => ends.iter().map(number).collect::<Vec<_>>().join(" to "),
            Value::Object(size) => format!("{} x {}", size["columns"], size["rows"]),
            other => number(other),
        }
    }
}

/// Prints all of them on standard output.
pub fn print(quantities: Vec<Quantity>, as_json: bool) -> Result<(), Failure> {
    if as_json {
        let object: Map<String, Value> = quantities.into_iter().map(|row| (row.key, row.value)).collect();
        return out!("{}", Value::Object(object));
    }
    quantities.iter().try_for_each(|row| out!("{}", format!("{:<44} {} {}", row.name, row.text(), row.unit).trim_end()))
}

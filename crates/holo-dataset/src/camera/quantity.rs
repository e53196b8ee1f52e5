//! Named numbers: what programs compute of cameras and images, for tables and JSON.

use holo_core::GridSize;
use serde_json::{Value, json};

use crate::settings::text::json_number;

/// A quantity with its name.
#[derive(Clone, Debug, PartialEq)]
pub struct NamedQuantity {
    /// Its key in JSON.
    pub key: String,
    /// Its name for people.
    pub name: String,
    /// Its value.
    pub value: QuantityValue,
    /// Its unit; empty without one.
    pub unit: &'static str,
}

/// The value of a quantity.
#[derive(Clone, Debug, PartialEq)]
pub enum QuantityValue {
    /// A number, which may be infinite.
    Number(f64),
    /// A number of things.
    Count(usize),
    /// A text.
    Text(String),
    /// Rows and columns.
    Size(GridSize),
    /// Both ends of a range.
    Range([f64; 2]),
    /// Several numbers.
    List(Vec<f64>),
    /// The rows of a matrix.
    Matrix(Vec<Vec<f64>>),
}

impl NamedQuantity {
    /// A quantity of this key, name and unit.
    #[must_use]
    pub fn new(key: impl Into<String>, name: impl Into<String>, value: QuantityValue, unit: &'static str) -> Self {
        Self { key: key.into(), name: name.into(), value, unit }
    }
}

impl QuantityValue {
    /// The value as JSON. Numbers that JSON does not have are the texts `"inf"`, `"-inf"` and `"NaN"`.
    #[must_use]
    pub fn to_json(&self) -> String {
        self.json().to_string()
    }

    fn json(&self) -> Value {
        let list = |numbers: &[f64]| numbers.iter().copied().map(json_number).collect::<Value>();
        match self {
            Self::Number(number) => json_number(*number),
            Self::Count(count) => Value::from(*count),
            Self::Text(text) => Value::from(text.as_str()),
            Self::Size(size) => json!({ "columns": size.columns, "rows": size.rows }),
            Self::Range(ends) => list(ends),
            Self::List(numbers) => list(numbers),
            Self::Matrix(rows) => rows.iter().map(|row| list(row)).collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_json() {
        for (value, json) in [
            (QuantityValue::Number(0.1), "0.1"),
            (QuantityValue::Number(f64::INFINITY), "\"inf\""),
            (QuantityValue::Count(3), "3"),
            (QuantityValue::Text("a \"b\"".into()), r#""a \"b\"""#),
            (QuantityValue::Size(GridSize::new(2, 3)), r#"{"columns":3,"rows":2}"#),
            (QuantityValue::List(vec![1.0, f64::NEG_INFINITY]), r#"[1.0,"-inf"]"#),
            (QuantityValue::Matrix(vec![vec![1.0, 0.5], vec![0.0, 2.0]]), "[[1.0,0.5],[0.0,2.0]]"),
        ] {
            assert_eq!(value.to_json(), json);
        }
    }
}

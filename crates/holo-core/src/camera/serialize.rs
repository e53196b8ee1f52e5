//! Sizes, shapes and rigs as serde data. A rig has the form of `manifest.json`: sizes as columns and rows, lengths of the camera in millimeters.
//!
//! ```json
//! {
//!   "views": {"columns": 9, "rows": 9},
//!   "lenses": {"columns": 512, "rows": 512},
//!   "baseline_m": {"x": 0.025, "y": 0.025},
//!   "focal_length_mm": 100.0,
//!   "sensor_size_mm": 35.0,
//!   "focus_distance_m": 4.25,
//!   "projection": "perspective"
//! }
//! ```
//!
//! Formats such as JSON have no infinity: a focus at infinity is the text `"inf"`.

use serde::{Deserialize, Deserializer, Serialize, Serializer, de};

use crate::{GridSize, LightFieldShape, Projection, Rig, meters_to_millimeters, millimeters_to_meters};

/// Columns first, as everywhere in files.
#[derive(Serialize, Deserialize)]
struct Size {
    columns: usize,
    rows: usize,
}

impl Serialize for GridSize {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        Size { columns: self.columns, rows: self.rows }.serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for GridSize {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let Size { columns, rows } = Size::deserialize(deserializer)?;
        Ok(Self { rows, columns })
    }
}

/// Views and lenses.
#[derive(Serialize, Deserialize)]
struct Shape {
    views: GridSize,
    lenses: GridSize,
}

impl Serialize for LightFieldShape {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        Shape { views: self.views(), lenses: self.lenses() }.serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for LightFieldShape {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let Shape { views, lenses } = Shape::deserialize(deserializer)?;
        Self::new(views, lenses).map_err(de::Error::custom)
    }
}

#[derive(Serialize, Deserialize)]
struct RigDocument {
    views: GridSize,
    lenses: GridSize,
    baseline_m: Baseline,
    focal_length_mm: f64,
    sensor_size_mm: f64,
    focus_distance_m: Distance,
    projection: Projection,
}

#[derive(Serialize, Deserialize)]
struct Baseline {
    x: f64,
    y: f64,
}

/// A distance that may be infinite.
#[derive(Serialize, Deserialize)]
#[serde(untagged)]
enum Distance {
    Finite(f64),
    Infinite(Infinite),
}

#[derive(Serialize, Deserialize)]
enum Infinite {
    #[serde(rename = "inf")]
    Infinity,
}

impl Serialize for Rig {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let focus_m = self.focus_distance_m();
        RigDocument {
            views: self.shape().views(),
            lenses: self.shape().lenses(),
            baseline_m: Baseline { x: self.baseline_x_m(), y: self.baseline_y_m() },
            focal_length_mm: meters_to_millimeters(self.focal_length_m()),
            sensor_size_mm: meters_to_millimeters(self.sensor_size_m()),
            focus_distance_m: match focus_m.is_finite() {
                true => Distance::Finite(focus_m),
                false => Distance::Infinite(Infinite::Infinity),
            },
            projection: self.projection(),
        }
        .serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for Rig {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let rig = RigDocument::deserialize(deserializer)?;
        let shape = LightFieldShape::new(rig.views, rig.lenses).map_err(de::Error::custom)?;
        Self::builder(shape)
            .focal_length_m(millimeters_to_meters(rig.focal_length_mm))
            .sensor_size_m(millimeters_to_meters(rig.sensor_size_mm))
            .baseline_x_m(rig.baseline_m.x)
            .baseline_y_m(rig.baseline_m.y)
            .focus_distance_m(match rig.focus_distance_m {
                Distance::Finite(focus_m) => focus_m,
                Distance::Infinite(Infinite::Infinity) => f64::INFINITY,
            })
            .projection(rig.projection)
            .build()
            .map_err(de::Error::custom)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rig(focus_distance_m: f64) -> Rig {
        Rig::builder(LightFieldShape::new(GridSize::new(2, 3), GridSize::new(4, 5)).unwrap())
            .focal_length_m(0.0351)
            .baseline_x_m(1e-3)
            .baseline_y_m(2e-3)
            .focus_distance_m(focus_distance_m)
            .projection(Projection::Perspective)
            .build()
            .unwrap()
    }

    #[test]
    fn a_rig_comes_back_from_json() {
        for rig in [rig(2.5), rig(f64::INFINITY)] {
            let text = serde_json::to_string(&rig).unwrap();
            assert_eq!(serde_json::from_str::<Rig>(&text).unwrap(), rig, "{text}");
        }
        let text = serde_json::to_string(&rig(f64::INFINITY)).unwrap();
        let expected = r#"{"views":{"columns":3,"rows":2},"lenses":{"columns":5,"rows":4},"baseline_m":{"x":0.001,"y":0.002},"focal_length_mm":35.1,"sensor_size_mm":36.0,"focus_distance_m":"inf","projection":"perspective"}"#;
        assert_eq!(text, expected);
    }

    #[test]
    fn sizes_and_shapes_come_back_from_json() {
        let shape = *rig(1.0).shape();
        let text = serde_json::to_string(&shape).unwrap();
        assert_eq!(text, r#"{"views":{"columns":3,"rows":2},"lenses":{"columns":5,"rows":4}}"#);
        assert_eq!(serde_json::from_str::<LightFieldShape>(&text).unwrap(), shape);
        assert!(serde_json::from_str::<LightFieldShape>(&text.replace('3', "0")).is_err());
    }

    #[test]
    fn numbers_that_make_no_rig_are_errors() {
        let text = serde_json::to_string(&rig(2.5)).unwrap();
        for (from, to) in [("35.1", "-35.1"), (r#""columns":3"#, r#""columns":0"#), ("perspective", "fisheye")] {
            assert!(text.contains(from));
            assert!(serde_json::from_str::<Rig>(&text.replace(from, to)).is_err(), "{to}");
        }
    }
}

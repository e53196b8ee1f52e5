//! The record of a light field in the lists of a dataset.

use holo_core::{GridSize, LightFieldShape, Rig, meters_to_millimeters};
use holo_io::dataset::DatasetCamera;
use holo_io::{Manifest, ManifestValue};
use serde_json::Value;

use crate::output::{ColorStatistics, EstimatedError, Statistics};
use crate::settings::text;

/// A light field or a raw image: a finished folder of a dataset.
pub(crate) struct Record {
    /// Relative to the dataset, with `/`.
    pub folder: String,
    pub scene: String,
    pub is_test: bool,
    pub camera: DatasetCamera,
    pub manifest: Manifest,
    statistics: Statistics,
}

/// What a record says of a light field.
pub(super) struct Field {
    pub name: &'static str,
    /// The type in the vocabulary of schema.org.
    pub kind: &'static str,
    pub description: &'static str,
    /// The cameras that have it.
    of: Of,
    /// `Null` where it is unknown.
    pub value: Get,
}

const TEXT: &str = "sc:Text";
const INTEGER: &str = "sc:Integer";
const FLOAT: &str = "sc:Float";
const BOOLEAN: &str = "sc:Boolean";

/// What has a field.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Of {
    /// Every folder.
    All,
    /// Folders of rigs.
    Rigs,
    /// Folders of plenoptic cameras.
    Plenoptic,
}

/// A function that returns the value of a field.
type Get = fn(&Record) -> Value;

const fn field(name: &'static str, kind: &'static str, description: &'static str, value: Get) -> Field {
    Field { name, kind, description, of: Of::All, value }
}

const fn of_rigs(name: &'static str, kind: &'static str, description: &'static str, value: Get) -> Field {
    Field { name, kind, description, of: Of::Rigs, value }
}

const fn of_plenoptic(name: &'static str, kind: &'static str, description: &'static str, value: Get) -> Field {
    Field { name, kind, description, of: Of::Plenoptic, value }
}

/// Returns the fields that records of these cameras have, in the order of the table.
pub(super) fn fields(cameras: &[DatasetCamera]) -> impl Iterator<Item = &'static Field> {
    let has_rigs = cameras.iter().any(|camera| camera.shape().is_some());
    let has_plenoptic = cameras.iter().any(|camera| camera.shape().is_none());
    FIELDS.iter().filter(move |field| match field.of {
        Of::All => true,
        Of::Rigs => has_rigs,
        Of::Plenoptic => has_plenoptic,
    })
}

/// What every table begins with.
pub(in super::super) fn first_names() -> String {
    FIELDS.iter().take(3).map(|field| format!("{},", field.name)).collect()
}

/// All fields, in the order of the table.
static FIELDS: [Field; 42] = [
    field("folder", TEXT, "Folder of the light field, relative to the dataset", |r| r.folder.as_str().into()),
    field("scene", TEXT, "Name of the scene", |r| r.scene.as_str().into()),
    field("split", TEXT, "train or test; a scene is in one of them with all its cameras, poses and frames", |r| {
        if r.is_test { "test" } else { "train" }.into()
    }),
    of_plenoptic("camera", TEXT, "Name of the plenoptic camera", |r| r.camera.name().into()),
    of_plenoptic("sensor_columns", INTEGER, "Width of the raw image, px", |r| r.size(|size| size.columns)),
    of_plenoptic("sensor_rows", INTEGER, "Height of the raw image, px", |r| r.size(|size| size.rows)),
    of_rigs("view_columns", INTEGER, "Views in a row (S)", |r| r.shape(|shape| shape.views().columns)),
    of_rigs("view_rows", INTEGER, "Views in a column (T)", |r| r.shape(|shape| shape.views().rows)),
    of_rigs("lens_columns", INTEGER, "Microlenses in a row, which are the pixels of a view (U)", |r| {
        r.shape(|shape| shape.lenses().columns)
    }),
    of_rigs("lens_rows", INTEGER, "Microlenses in a column (V)", |r| r.shape(|shape| shape.lenses().rows)),
    of_rigs("disparity_min_px", FLOAT, "Smallest disparity of the central view, pixels between adjacent views", |r| {
        number(r.manifest.disparity_px.map(|(min, _)| min))
    }),
    of_rigs("disparity_max_px", FLOAT, "Largest disparity of the central view", |r| {
        number(r.manifest.disparity_px.map(|(_, max)| max))
    }),
    field(
        "depth_min_m",
        FLOAT,
        "Smallest depth of the central view, or of a raw image of which depth was requested",
        |r| r.depth_m(0),
    ),
    field("depth_median_m", FLOAT, "Median depth of what these pixels hit", |r| r.depth_m(1)),
    field("depth_max_m", FLOAT, "Largest depth of what these pixels hit", |r| r.depth_m(2)),
    field("hit", FLOAT, "Part of these pixels that hit something", |r| number(r.statistics.hit)),
    of_rigs("seen_by_all_views", FLOAT, "Part of the pixels of the central view that every view sees", |r| {
        number(r.statistics.seen_by_all_views)
    }),
    of_rigs(
        "occluded",
        FLOAT,
        "Part of the pixels of the central view that a quarter of the views or more do not see",
        |r| r.mask("occluded"),
    ),
    of_rigs("discontinuity", FLOAT, "Part of the same that lies near a jump of the disparity", |r| {
        r.mask("discontinuity")
    }),
    of_rigs("fine", FLOAT, "Part of the same that is narrow, before something farther", |r| r.mask("fine")),
    of_rigs("slanted", FLOAT, "Part of the same on planes that are slanted", |r| r.mask("slanted")),
    of_rigs("textureless", FLOAT, "Part of the same without texture", |r| r.mask("textureless")),
    of_rigs("repetitive", FLOAT, "Part of the same whose texture is found again in its row", |r| r.mask("repetitive")),
    of_rigs("reflective", FLOAT, "Part of the same that mirrors light or lets it pass", |r| r.mask("reflective")),
    of_rigs("transparent", FLOAT, "Part of the same that lets light pass", |r| r.mask("transparent")),
    of_rigs("baseline_mm", FLOAT, "Distance between horizontally adjacent views", |r| {
        r.rig(|rig| meters_to_millimeters(rig.baseline_x_m()))
    }),
    of_rigs("focus_distance_m", FLOAT, "Distance of the plane of disparity 0; null for infinity", |r| {
        r.rig(Rig::focus_distance_m)
    }),
    of_rigs("focal_length_mm", FLOAT, "Focal length", |r| r.rig(|rig| meters_to_millimeters(rig.focal_length_m()))),
    of_rigs("sensor_size_mm", FLOAT, "Larger image side on the sensor", |r| {
        r.rig(|rig| meters_to_millimeters(rig.sensor_size_m()))
    }),
    field("exposure_ev", FLOAT, "Exposure compensation of the integers", |r| number(r.manifest.exposure_ev)),
    of_rigs("mean_red", FLOAT, "Mean of the integers over all views, as a part of the largest integer", |r| r.mean(0)),
    of_rigs("mean_green", FLOAT, "The same of green", |r| r.mean(1)),
    of_rigs("mean_blue", FLOAT, "The same of blue", |r| r.mean(2)),
    of_rigs("deviation_red", FLOAT, "Standard deviation of the same", |r| r.deviation(0)),
    of_rigs("deviation_green", FLOAT, "The same of green", |r| r.deviation(1)),
    of_rigs("deviation_blue", FLOAT, "The same of blue", |r| r.deviation(2)),
    of_rigs("clipped", FLOAT, "Part of the pixels with the largest integer in a channel", |r| {
        number(r.statistics.color.map(|color| color.clipped))
    }),
    field("samples", FLOAT, "Samples a pixel; with a target for the error the largest number", |r| {
        let samples = r.setting("spp").and_then(ManifestValue::as_f64);
        let whole = samples.filter(|samples| samples.fract() == 0.0);
        whole.map_or_else(|| number(samples), |samples| (samples as u64).into())
    }),
    field("reconstructed", BOOLEAN, "Whether noise was reduced across views: a small bias", |r| {
        r.setting("denoise").and_then(ManifestValue::as_text).is_some_and(|how| how != "off").into()
    }),
    field(
        "error_median",
        FLOAT,
        "Estimated relative standard error of radiance, bias included: median of the pixels",
        |r| r.error(|error| error.median),
    ),
    field("error_percentile_90", FLOAT, "The same: 90 % of the pixels are below", |r| {
        r.error(|error| error.percentile_90)
    }),
    field("bytes", INTEGER, "Size of all files", |r| {
        r.manifest.files.values().map(|written| written.bytes).sum::<u64>().into()
    }),
];

impl Record {
    pub fn new(folder: String, scene: String, is_test: bool, camera: DatasetCamera, manifest: Manifest) -> Self {
        let statistics = Statistics::of_manifest(&manifest);
        Self { folder, scene, is_test, camera, manifest, statistics }
    }

    /// All fields of its camera by their names.
    pub fn to_json(&self) -> Value {
        let fields = fields(std::slice::from_ref(&self.camera));
        Value::Object(fields.map(|field| (field.name.to_owned(), (field.value)(self))).collect())
    }

    /// A number of views or microlenses of a rig.
    fn shape(&self, of: impl Fn(LightFieldShape) -> usize) -> Value {
        self.camera.shape().map_or(Value::Null, |shape| of(shape).into())
    }

    /// A side of the raw image of a plenoptic camera.
    fn size(&self, of: impl Fn(GridSize) -> usize) -> Value {
        match &self.camera {
            DatasetCamera::Plenoptic { size, .. } => of(*size).into(),
            DatasetCamera::Rig(_) => Value::Null,
        }
    }

    fn setting(&self, name: &str) -> Option<&ManifestValue> {
        self.manifest.settings.get(name)
    }

    /// A finite number of the rig.
    fn rig(&self, of: impl Fn(&Rig) -> f64) -> Value {
        number(self.manifest.rig.as_ref().map(of))
    }

    /// The part of the pixels in a mask.
    fn mask(&self, name: &str) -> Value {
        number(self.statistics.masks.get(name).copied())
    }

    fn depth_m(&self, k: usize) -> Value {
        number(self.statistics.depth_m.map(|depths| depths[k]))
    }

    fn color(&self, of: impl Fn(&ColorStatistics) -> f64) -> Value {
        number(self.statistics.color.as_ref().map(of))
    }

    fn mean(&self, channel: usize) -> Value {
        self.color(|color| color.mean[channel])
    }

    fn deviation(&self, channel: usize) -> Value {
        self.color(|color| color.deviation[channel])
    }

    fn error(&self, of: impl Fn(&EstimatedError) -> f64) -> Value {
        number(self.statistics.error.as_ref().map(of))
    }
}

/// A number if there is one and it is finite: catalogs have no infinity.
fn number(value: Option<f64>) -> Value {
    value.filter(|value| value.is_finite()).map_or(Value::Null, text::json_number)
}

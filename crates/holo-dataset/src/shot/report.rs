//! What a finished shot reports: times, rays, camera, files; as text and as JSON.

use std::fmt;
use std::ops::Range;

use holo_core::{GridSize, Rig};
use holo_io::meters_to_millimeters;
use holo_render::{Integrator, RayCounts};
use serde_json::{Value, json};

use super::warning::RenderWarning;
use crate::output::Statistics;
use crate::settings::text;
use crate::settings::word;

/// Statistics of a finished shot.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct RenderReport {
    /// Wall-clock times.
    pub seconds: Seconds,
    /// Number of rays by kind.
    pub rays: RayCounts,
    /// Number of samples of the image: pixels x samples a pixel, unless there was a target error.
    pub samples: u64,
    /// The ray tracing backend and its version.
    pub backend: String,
    /// Number of threads.
    pub threads: usize,
    /// The integrator that rendered.
    pub integrator: Integrator,
    /// Why it was chosen.
    pub why: String,
    /// What only one kind of camera reports.
    pub camera: CameraReport,
    /// The name of the pose, if it is one of several.
    pub pose: Option<String>,
    /// The number of the frame, if it is one of several.
    pub frame: Option<u32>,
    /// Numbers that describe the light field; of a shard none.
    pub statistics: Statistics,
    /// Names of the files, relative to the folder of the job; of a job of a dataset to its own.
    pub files: Vec<String>,
    /// What is probably not wanted in the image; of a shard nothing. Diagnostics received the same as lines.
    pub warnings: Vec<RenderWarning>,
}

/// What only one kind of camera reports.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub enum CameraReport {
    /// Of a rig.
    Rig {
        /// The rig.
        rig: Rig,
        /// Smallest and largest finite disparity of the central view, in pixels between horizontally adjacent views.
        disparity_px: Option<(f64, f64)>,
    },
    /// Of a plenoptic camera.
    Plenoptic {
        /// Its name.
        name: String,
        /// The size of its sensor.
        size: GridSize,
        /// The number of its micro-images.
        lenses: usize,
        /// The rows of pixels that were rendered.
        rows: Range<usize>,
        /// The share of their pixels that light reaches.
        lit_share: f64,
    },
    /// Of pinhole cameras.
    Pinholes {
        /// Their number.
        count: usize,
    },
}

/// Wall-clock time by stage, s.
#[derive(Clone, Copy, Debug, Default)]
pub struct Seconds {
    /// Reading the scene.
    pub load: f64,
    /// Building the acceleration structure.
    pub build: f64,
    /// From the first ray to the finished light field in memory, exposure included.
    pub render: f64,
    /// Encoding and writing files.
    pub write: f64,
    /// All stages.
    pub total: f64,
}

impl RenderReport {
    /// Rays of all kinds a second of rendering, in millions.
    #[must_use]
    pub fn mrays_per_second(&self) -> f64 {
        self.rays.total() as f64 / self.seconds.render.max(1e-9) / 1e6
    }

    /// Returns the rig; `None` for other cameras.
    #[must_use]
    pub fn rig(&self) -> Option<&Rig> {
        match &self.camera {
            CameraReport::Rig { rig, .. } => Some(rig),
            _ => None,
        }
    }

    /// Returns the disparity range of the central view of a rig, in pixels between horizontally adjacent views.
    #[must_use]
    pub fn disparity_px(&self) -> Option<(f64, f64)> {
        match self.camera {
            CameraReport::Rig { disparity_px, .. } => disparity_px,
            _ => None,
        }
    }

    /// The report as a JSON object, the one that `holo render --json` prints without the memory of the process.
    #[must_use]
    pub fn to_json(&self) -> String {
        self.json().to_string()
    }

    pub(crate) fn json(&self) -> Value {
        let mut object = self.run_json();
        object["backend"] = self.backend.as_str().into();
        object["threads"] = self.threads.into();
        object["integrator"] = json!({"name": word(&self.integrator), "why": self.why});
        object["files"] = json!(self.files);
        object["warnings"] = self.warnings.iter().map(ToString::to_string).collect();
        if let Some(pose) = &self.pose {
            object["pose"] = pose.as_str().into();
        }
        if let Some(frame) = self.frame {
            object["frame"] = frame.into();
        }
        match &self.camera {
            CameraReport::Rig { rig, disparity_px } => {
                object["rig"] = rig_json(rig);
                object["disparity_px"] = json!(disparity_px.map(|(min, max)| json!({"min": min, "max": max})));
            }
            CameraReport::Plenoptic { name, size, lenses, lit_share, .. } => {
                object["camera"] = json!({"name": name, "size": size_json(*size), "lenses": lenses});
                object["lit_share"] = json!(lit_share);
            }
            CameraReport::Pinholes { count } => object["cameras"] = (*count).into(),
        }
        object
    }

    /// Times, rays, samples, integrator and statistics: what differs between the renders of a dataset.
    pub(crate) fn run_json(&self) -> Value {
        let (s, rays) = (&self.seconds, self.rays);
        json!({
            "seconds": {"load": s.load, "build": s.build, "render": s.render, "write": s.write, "total": s.total},
            "rays": {"primary": rays.primary, "shadow": rays.shadow, "other": rays.secondary},
            "samples": self.samples,
            "integrator": word(&self.integrator),
            "statistics": self.statistics.json(),
        })
    }
}

fn size_json(size: GridSize) -> Value {
    json!({"columns": size.columns, "rows": size.rows})
}

fn rig_json(rig: &Rig) -> Value {
    json!({
        "views": size_json(rig.shape().views()), "lenses": size_json(rig.shape().lenses()),
        "baseline_m": {"x": rig.baseline_x_m(), "y": rig.baseline_y_m()},
        "focal_length_mm": meters_to_millimeters(rig.focal_length_m()),
        "sensor_size_mm": meters_to_millimeters(rig.sensor_size_m()),
        "focus_distance_m": text::json_number(rig.focus_distance_m()),
    })
}

/// Lines of text: what was rendered how fast, the camera, and the estimated error if there is one.
impl fmt::Display for RenderReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let what = match &self.camera {
            CameraReport::Rig { rig, .. } => text::shape(rig.shape()),
            CameraReport::Plenoptic { size, rows, .. } => format!("{} x {} px", size.columns, rows.len()),
            CameraReport::Pinholes { count } => format!("{count} cameras"),
        };
        write!(
            f,
            "rendered {what} in {:.2} s ({:.1} Mrays/s, {}, {} threads, {}: {})",
            self.seconds.render,
            self.mrays_per_second(),
            self.backend,
            self.threads,
            word(&self.integrator),
            self.why
        )?;
        match &self.camera {
            CameraReport::Rig { rig, disparity_px } => write!(f, "\n{}", text::rig(rig, *disparity_px))?,
            CameraReport::Plenoptic { name, lenses, lit_share, .. } => {
                let percent = 100.0 * lit_share;
                write!(f, "\ncamera {name}: {lenses} micro-images, {percent:.0} % of the pixels lit")?;
            }
            CameraReport::Pinholes { .. } => {}
        }
        let error = self.statistics.error;
        error.map_or(Ok(()), |error| write!(f, "\nestimated error of color: {error}"))
    }
}

//! Render jobs and datasets: from a scene and settings to a folder of files, and from many of both to a dataset.
//!
//! ```text
//! SceneSource + RenderSettings -> RenderJob -> folders (images, ground truth, parameters.cfg, manifest.json)
//! scenes x cameras             -> DatasetPlan -> <scene>/<camera>/ each, dataset.json, DATASET.md, catalog
//! ```
//!
//! A job has a shot for every pose and every frame; each of these has a folder of its own. A folder is complete when it has
//! its manifest, which is written last and contains the digest of every file. Shots that are up to date are kept, so that
//! an interrupted job or dataset continues. The work for one image can be distributed ([`Shard`]) and combined by
//! [`merge`]. [`verify`] compares files with their digests.
//!
//! # Example
//! ```
//! use holo_dataset::{RenderJob, RenderSettings, RigSettings, RunOptions, SceneSource, verify};
//!
//! # let folder = tempfile::tempdir()?;
//! # let out = folder.path().join("plaster");
//! let rig = RigSettings::default().views([3, 4]).lenses([8, 12]); // rows, columns
//! let settings = RenderSettings::default().camera(rig).samples(1);
//! let outcomes = RenderJob::new(SceneSource::gallery("plaster")?, settings).run(&out, &RunOptions::new())?;
//! let report = outcomes[0].1.report().expect("it was rendered");
//! assert!(report.files.contains(&"scene_el.png".to_owned()));
//! assert_eq!(verify(&out)?.bad_folders, 0);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

#![forbid(unsafe_code)]

pub mod settings;
pub use settings::text;

mod camera;
mod collection;
mod describe;
mod error;
mod export;
mod output;
mod resume;
mod score;
mod shot;
mod watch;

pub use camera::{
    ArrayDepth, ArrayViewpoint, BenchmarkSize, BoardPose, Calibrated, CalibrationBenchmark, DecodeJob, DemosaicMethod,
    DevelopJob, DevelopOutput, Developed, KnownCamera, NamedQuantity, Placement, QuantityValue, Surface, TargetJob,
    calibration_score, camera_of_raw, camera_optics, correspondences, estimate_depth, estimate_from_views, grid_score,
    jittered, planned_rig, read_poses, read_raw, read_white, rig_optics, synthesize_from_array, synthetic_aperture,
    write_demosaiced, write_white_images,
};
pub use collection::{
    DatasetCameras, DatasetJob, DatasetPlan, DatasetRun, DatasetSummary, JobSummary, SetProperties, drawn, sources,
};
pub use describe::{Archive, Described, Verification, WebDataset, finished, is_dataset, verify, write_catalog};
pub use error::Error;
pub use export::{EXPORT_TARGETS, ExportJob, ExportTarget, Exported};
pub use output::{ColorStatistics, EstimatedError, OutputFolder, Rollback, Statistics};
pub use resume::{Checkpoints, merge};
pub use score::{MapScoring, RegionMask, read_mask, region_masks};
pub use settings::{
    Camera, Color, EngineSettings, Exposure, Focus, Frames, LayerChoice, LightSettings, Output, OutputSettings, Pixels,
    Poses, RawLayer, RenderSettings, RigSettings, SceneSettings, SensorName, Shard, Sky, Spacing, Tool, ViewSubset,
    adjusted_camera,
};
pub use shot::{
    CameraReport, Drawing, Event, Prepared, RenderJob, RenderReport, RenderWarning, Rendering, RunOptions, SceneSource,
    Seconds, Shot, ShotOutcome, Stage, camera_warnings,
};
pub use watch::{About, Deduplicated, Diagnostics};

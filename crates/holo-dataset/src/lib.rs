//! Render jobs and datasets: from a scene and a specification to a folder of files, and from many of both to a dataset.
//!
//! ```text
//! SceneSource + RenderSpec -> RenderJob -> folder (images, ground truth, parameters.cfg, manifest.json)
//! cameras anywhere          -> ArrayJob -> images/NAME.png, transforms.json
//! frames of an animation   -> SequenceJob -> frame_0000/, frame_0001/ ...
//! scenes x view counts     -> DatasetPlan -> <scene>/<S>x<T>/ each, dataset.json, DATASET.md, catalog
//! ```
//!
//! A folder is complete when it has its manifest, which is written last and contains the digest of every file. A
//! dataset job whose folder is up to date is skipped, so that an interrupted dataset can be continued. The work for one
//! image can be distributed ([`Shard`]) and combined by [`merge`]. [`verify`] compares files with their digests.
//!
//! # Example
//! ```
//! use holo_core::GridSize;
//! use holo_dataset::{RenderJob, RenderSpec, Rollback, SceneSource, verify};
//!
//! # let folder = tempfile::tempdir()?;
//! # let out = folder.path().join("garden");
//! let mut spec = RenderSpec::default();
//! (spec.rig.views, spec.rig.lenses) = (GridSize::new(3, 4), Some(GridSize::new(8, 12)));
//! spec.samples = Some(1);
//! let job = RenderJob::new(SceneSource::gallery("plaster")?, spec);
//! let report = job.run(&out, None, &(), &(), &Rollback::default())?;
//! assert!(report.files.contains(&"scene_el.png".to_owned()));
//! assert_eq!(verify(&out)?.bad_folders, 0);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

#![forbid(unsafe_code)]

pub mod options;
pub mod text;

mod array;
mod catalog;
mod checkpoint;
mod decode;
mod describe;
mod develop;
mod diagnostics;
mod error;
mod exports;
mod exr;
mod files;
mod identity;
mod image_job;
mod images;
mod job;
mod layers;
mod linear_image;
mod motion;
mod optics;
mod outcome;
mod output_folder;
mod parts;
mod placement;
mod plan;
mod prepare;
mod raw;
mod raw_files;
mod report;
mod sequence;
mod shard;
mod sky;
mod source;
mod spec;
mod statistics;
mod subset;
mod summary;
mod target;
mod verify;
mod warning;
mod webdataset;

pub use array::{ArrayJob, ArrayReport};
pub use catalog::{Described, finished, write_catalog};
pub use checkpoint::Checkpoints;
pub use decode::{DecodeJob, write_white_images};
pub use develop::{DemosaicMethod, DevelopJob, DevelopOutput, Developed, write_demosaiced};
pub use diagnostics::{About, Deduplicated, Diagnostics};
pub use error::Error;
pub use exports::Tool;
pub use files::validate;
pub use image_job::{ImageJob, ImageReport};
pub use job::{RenderJob, Rendering};
pub use optics::{NamedQuantity, camera_optics, planned_rig, rig_optics};
pub use outcome::JobOutcome;
pub use output_folder::{OutputFolder, Rollback};
pub use parts::{CancelOnly, PartProgress};
pub use placement::{Placement, Surface};
pub use plan::{DatasetJob, DatasetPlan, sources};
pub use prepare::Prepared;
pub use raw::{RawJob, RawLayers, RawReport, warnings as camera_warnings};
pub use report::{RenderReport, Seconds};
pub use sequence::SequenceJob;
pub use shard::merge;
pub use source::SceneSource;
pub use spec::{
    EngineSpec, Exposure, Focus, Frames, LayerChoice, Output, RawLayer, RenderSpec, RigSpec, SceneSpec, Shard, Sky,
    ViewSubset,
};
pub use statistics::{ColorStatistics, EstimatedError, Statistics};
pub use summary::{DatasetSummary, JobSummary};
pub use target::{BoardPose, TargetJob, read_poses};
pub use verify::{Verification, is_dataset, verify};
pub use warning::RenderWarning;
pub use webdataset::{Archive, WebDataset};

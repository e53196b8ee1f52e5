//! Boards as COMPOTE reads them.

use std::path::Path;

use holo_core::GridSize;
use holo_io::interop::{BoardCorner, Libpleno};
use holo_io::{CameraFile, Folder, Manifest, ManifestValue};

use super::score::{Corner, read_corners};
use super::target::{BoardPose, TargetJob, transform};
use crate::Error;
use crate::output::raw::CAMERA_TOML;
use crate::settings::EngineSettings;

impl TargetJob {
    /// The job that rendered a folder of boards.
    ///
    /// # Errors
    /// [`Error::BadRequest`] if the folder has none; [`Error::Io`] if its files are damaged.
    pub(crate) fn of_folder(path: &Path) -> Result<Self, Error> {
        let bad =
            |what: &str| Error::BadRequest(format!("{}: {what}; render boards with `holo target`", path.display()));
        let is_one = |folder: &Folder| folder.has_file(CAMERA_TOML) && folder.has_file("corners.csv");
        let folder = Folder::open(path).ok().filter(is_one).ok_or_else(|| bad("it has no boards"))?;
        let (camera, manifest) = (CameraFile::read_in(&folder, CAMERA_TOML)?, Manifest::read_in(&folder)?);
        let text = |key: &str| match manifest.settings.get(key) {
            Some(ManifestValue::Text(text)) => Some(text.clone()),
            _ => None,
        };
        let number = |value: &ManifestValue| match *value {
            ManifestValue::Float(number) => Some(number),
            ManifestValue::Integer(number) => Some(number as f64),
            _ => None,
        };
        let corners = text("checkerboard").and_then(|text| text.parse::<GridSize>().ok());
        let square_mm = manifest.settings.get("square-mm").and_then(number);
        let (Some(corners), Some(square_mm)) = (corners, square_mm) else {
            return Err(bad("its manifest is not that of boards"));
        };
        let numbers: Vec<f64> = match manifest.settings.get("poses") {
            Some(ManifestValue::List(list)) => list.iter().filter_map(number).collect(),
            _ => Vec::new(),
        };
        let pose = |of: &[f64]| BoardPose { position_m: [of[0], of[1], of[2]], rotation_deg: [of[3], of[4], of[5]] };
        let poses: Vec<BoardPose> = numbers.chunks_exact(6).map(pose).collect();
        Ok(Self {
            camera,
            corners,
            square_m: square_mm / 1e3,
            poses: (!poses.is_empty()).then_some(poses),
            samples: 0,
            seed: manifest.seed,
            engine: EngineSettings::default(),
        })
    }

    /// Returns `poses.js`, the true places of the camera.
    pub(crate) fn compote_poses(&self, poses: &[BoardPose]) -> String {
        let board = |pose: &BoardPose| {
            let placed = transform(pose);
            let [x, y] = self.on_board(self.corners.rows - 1, self.corners.columns - 1);
            (placed.point([x * self.square_m, y * self.square_m, 0.0]), placed.columns)
        };
        Libpleno::poses(&poses.iter().map(board).collect::<Vec<_>>())
    }

    /// Returns the true corners in the folder of the boards, as COMPOTE would detect them.
    ///
    /// # Errors
    /// [`Error::Failed`] if the folder lists no corner; [`Error::Io`] if its list cannot be read.
    pub(crate) fn compote_features(&self, folder: &Folder) -> Result<String, Error> {
        let camera = &self.camera.camera;
        let found = |corner: &Corner| {
            let [frame, cluster] = corner.cluster;
            BoardCorner {
                lens: corner.lens,
                position_px: corner.position_px.map(|x| x - 0.5),
                blur_px: corner.blur_px,
                place: [cluster / self.corners.columns, cluster % self.corners.columns],
                frame,
            }
        };
        let found: Vec<BoardCorner> = read_corners(folder, camera)?.iter().map(found).collect();
        Ok(Libpleno::features(camera, self.corners, &found)?)
    }
}

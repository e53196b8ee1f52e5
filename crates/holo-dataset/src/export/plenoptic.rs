//! Raw images of plenoptic cameras: the folder of a [`Tool`] from what was rendered without it, and boards for COMPOTE.
//!
//! | target | input | files |
//! |---|---|---|
//! | `compote` | a folder of boards, which has `corners.csv` | `images.js`, `camera.js`, `scene.js`, `frame_NN.png`, `white_f*.png`; the truth: `poses.js`, `features.js`, `intrinsics.js`, `params.js` |
//! | a tool | a folder with `raw.exr`, those of poses, frames or a dataset | its folder, the bytes that a render for it has |

use std::path::{Path, PathBuf};

use holo_core::ColorEncoding;
use holo_io::dataset::{DatasetCamera, DatasetIndex, MANIFEST_JSON};
use holo_io::interop::Libpleno;
use holo_io::{CameraFile, Compression, Folder, Manifest, read_linear, write_file, write_png};
use ndarray::{Array3, ArrayView3, Axis};

use super::{ExportTarget, Writer};
use crate::Error;
use crate::camera::TargetJob;
use crate::describe::{is_dataset, shots_of};
use crate::output::raw::{CAMERA_TOML, RAW_EXR, exposure_ev, lit_white_image};
use crate::output::{OutputFolder, stopped};
use crate::settings::{Exposure, Kind, SettingType, Tool};

pub(super) const COMPOTE: ExportTarget = ExportTarget {
    name: "compote",
    help: "COMPOTE (M. Labussiere): raw images of boards, with the camera before its calibration and the truth",
    usage: "precalibrate -i images.js -c camera.js -p found-params.js, then compote with these, scene.js, and --features \
            features.js where nobody is there to click.",
    has_groups: false,
    has_objects: false,
    writer: Writer::Boards,
};

/// The target of a tool.
pub(super) const fn raw(tool: Tool) -> ExportTarget {
    let (name, help) = match Tool::KIND {
        Kind::Word(words) => (words[tool as usize].name, words[tool as usize].help),
        _ => ("", ""),
    };
    ExportTarget {
        name,
        help,
        usage: "The folder of the program has a README.txt of its own.",
        has_groups: false,
        has_objects: false,
        writer: Writer::Raw(tool),
    }
}

/// A raw image that is not read yet.
pub(super) struct RawImage {
    /// Where it lies in the export: a folder with `/` at its end, or `""`.
    inner: String,
    path: PathBuf,
    camera: CameraFile,
}

/// The raw images of a dataset, of poses and frames, or that of a folder, if the tool can read them.
pub(super) fn raw_images(input: &Path, tool: Tool) -> Result<Vec<RawImage>, Error> {
    let mut places = Vec::new();
    if is_dataset(input) {
        let index = DatasetIndex::read(input)?;
        let cameras = index.cameras.iter().filter(|camera| matches!(camera, DatasetCamera::Plenoptic { .. }));
        for camera in cameras {
            for scene in &index.scenes {
                let place = camera.folder(&scene.name)?;
                if input.join(&place).join(MANIFEST_JSON).is_file() {
                    places.push(place);
                }
            }
        }
        if places.is_empty() {
            let what = "the dataset has no finished raw image of a plenoptic camera; see `holo verify`";
            return Err(Error::BadRequest(format!("{}: {what}", input.display())));
        }
    } else if !input.join(MANIFEST_JSON).is_file() && input.is_dir() {
        places = shots_of(input)?;
    }
    if places.is_empty() {
        places.push(PathBuf::new());
    }
    let image = |place: PathBuf| {
        let path = input.join(&place);
        let folder = Folder::open(&path).ok();
        for file in [CAMERA_TOML, RAW_EXR] {
            if !folder.as_ref().is_some_and(|folder| folder.has_file(file)) {
                let advice = "render with `camera` and `write` raw";
                return Err(Error::BadRequest(format!("{}: it has no {file}; {advice}", path.display())));
            }
        }
        let camera = CameraFile::read_in(&Folder::open(&path)?, CAMERA_TOML)?;
        tool.check(&camera.camera)?;
        let parts: String = place.iter().map(|part| format!("{}/", part.to_string_lossy())).collect();
        Ok(RawImage { inner: parts, path, camera })
    };
    places.into_iter().map(image).collect()
}

impl RawImage {
    /// Writes the folder of a tool.
    pub fn write(&self, out: &mut OutputFolder, tool: Tool) -> Result<(), Error> {
        let color = read_raw(&self.path.join(RAW_EXR), &self.camera)?;
        let white = lit_white_image(&self.camera)?;
        let ev = match Manifest::read_in(&Folder::open(&self.path)?)?.exposure_ev {
            Some(ev) => ev,
            None => exposure_ev(&color, Exposure::Automatic)?,
        };
        tool.write((out, &self.inner), &self.camera.camera, color.view(), &white, ev)
    }
}

/// Reads a raw image of a camera in linear light.
fn read_raw(path: &Path, camera: &CameraFile) -> Result<Array3<f32>, Error> {
    let color = read_linear(path, &holo_io::Limits::default())?;
    let (size, (rows, columns, _)) = (camera.camera.sensor().size, color.dim());
    match (rows, columns) == (size.rows, size.columns) {
        true => Ok(color),
        false => {
            let what = format!("{columns} x {rows} px, and the sensor of the camera has {size}");
            Err(Error::Failed(format!("{}: it has {what}", path.display())))
        }
    }
}

/// Raw images of boards.
pub(super) struct Boards {
    path: PathBuf,
    job: TargetJob,
}

impl Boards {
    /// Opens a folder of boards.
    pub fn open(path: &Path) -> Result<Self, Error> {
        Ok(Self { path: path.to_owned(), job: TargetJob::of_folder(path)? })
    }

    /// Writes images, boards and truth; returns the number of boards.
    pub fn write(&self, out: &mut OutputFolder) -> Result<usize, Error> {
        let file = &self.job.camera;
        let (camera, poses) = (&file.camera, self.job.validated_poses()?);
        let truth = Libpleno::new(camera)?;
        let mut whites = Vec::new();
        // The exposure follows the aperture.
        let brightest = brightest(lit_white_image(file)?.iter());
        for (name, stopped) in stopped(camera)? {
            let white = stopped.white_image()?.insert_axis(Axis(2));
            let scale = brightest / self::brightest(white.iter());
            let codes = colored(white.view(), scale);
            out.add(name.clone(), write_png(out.file(&name), codes.view(), ColorEncoding::Linear, Compression::Best)?);
            whites.push((name, stopped.main_lens().f_number));
        }
        let mut frames = Vec::new();
        for frame in 0..poses.len() {
            let name = format!("frame_{frame:02}.png");
            let image = read_raw(&self.path.join(format!("frame_{frame:02}.exr")), file)?;
            let codes = colored(image.view(), 1.0);
            out.add(name.clone(), write_png(out.file(&name), codes.view(), ColorEncoding::Linear, Compression::Best)?);
            frames.push(name);
        }
        for (name, text) in [
            ("images.js", Libpleno::boards(&whites, &whites[0], &frames)),
            ("camera.js", Libpleno::before_calibration(camera, camera)?),
            ("scene.js", Libpleno::scene(self.job.corners, self.job.square_m)),
            ("poses.js", self.job.compote_poses(&poses)),
            ("features.js", self.job.compote_features(&Folder::open(&self.path)?)?),
            ("intrinsics.js", truth.intrinsics),
            ("params.js", truth.parameters),
        ] {
            out.add(name, write_file(out.file(name), text.as_bytes())?);
        }
        Ok(frames.len())
    }
}

fn brightest<'a>(values: impl Iterator<Item = &'a f32>) -> f32 {
    values.fold(f32::MIN_POSITIVE, |most, &value| most.max(value))
}

/// The first channel, scaled, as 8 bits of red, green and blue.
fn colored(image: ArrayView3<f32>, scale: f32) -> Array3<u8> {
    let (rows, columns, _) = image.dim();
    let code = |(row, column, _)| (255.0 * scale * image[[row, column, 0]]).round().clamp(0.0, 255.0) as u8;
    Array3::from_shape_fn((rows, columns, 3), code)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn targets_have_the_names_of_their_tools() {
        for target in super::super::EXPORT_TARGETS {
            if let Writer::Raw(tool) = target.writer {
                assert_eq!(target.name, tool.name());
            }
        }
    }
}

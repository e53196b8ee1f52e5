//! A folder with the images of cameras anywhere, as `holo render` writes it, and as NeRF and its successors read it.
//!
//! | file | contents |
//! |---|---|
//! | `transforms.json` | the cameras ([`CameraArray`]), each with the name of its image |
//! | the images | PNG, TIFF, OpenEXR or PFM; a name without ending is that of a PNG |
//! | `depth/NAME.pfm` | planar depth in meters, where there is truth |
//!
//! A camera whose image is a folder is a light field: every view of it is a camera, `NAME:S,T` for view column S and row T.

mod posed_field;

use std::path::Path;
use std::sync::Arc;

use holo_core::{GridSize, Pinhole, SampleKind};
use ndarray::{Array2, Array3, Axis};

use posed_field::{LastRead, PosedField};

use crate::cameras::transforms::{ArrayCamera, CameraArray, WorldUp};
use crate::files::names::TRANSFORMS_JSON;
use crate::images::image_file::read_image_info;
use crate::{EntryKind, Error, Folder, Limits, read_linear, read_pfm_gray};

/// The folder of the depths.
const DEPTH: &str = "depth";

/// A folder with the images of cameras anywhere. Images are read one by one, those of a light field together.
#[derive(Debug, Clone)]
pub struct ArrayFolder {
    folder: Folder,
    cameras: Vec<ArrayCamera>,
    images: Vec<Image>,
    fields: Vec<PosedField>,
    last_read: Arc<LastRead>,
}

/// Where the image of a camera is.
#[derive(Debug, Clone)]
enum Image {
    /// A file in the folder.
    File(String),
    /// The view (t, s) of a light field.
    View { field: usize, view: (usize, usize) },
}

impl ArrayFolder {
    /// Whether a path is a folder with a `transforms.json`.
    #[must_use]
    pub fn is_one(path: impl AsRef<Path>) -> bool {
        let path = path.as_ref();
        path.is_dir() && Folder::open(path).is_ok_and(|folder| folder.has_file(TRANSFORMS_JSON))
    }

    /// Opens a folder, and reads its cameras.
    ///
    /// # Errors
    ///
    /// Those of [`CameraArray::read_in`] and, of light fields, [`LightFieldReader::open`](crate::LightFieldReader::open);
    /// [`Error::Broken`] if a camera names no image; [`Error::Io`] if an image is missing; [`Error::Unsupported`] if the camera of a
    /// light field is unknown.
    pub fn open(path: impl AsRef<Path>, up: WorldUp) -> Result<Self, Error> {
        let folder = Folder::open(path)?;
        let (array, named) = CameraArray::read_with_files(&folder, TRANSFORMS_JSON, up)?;
        let (mut cameras, mut images, mut fields) = (Vec::new(), Vec::new(), Vec::new());
        for (camera, named) in array.cameras.into_iter().zip(named) {
            let Some(name) = named else {
                let shown = crate::shown(&camera.name);
                let what = format!("camera '{shown}' has no `file_path`, which names its image");
                return Err(Error::broken(&folder.path_of(TRANSFORMS_JSON), "transforms", what));
            };
            if folder.kind(&name)? == Some(EntryKind::Folder) {
                let field = PosedField::open(folder.sub(&name)?.path().to_owned(), &camera)?;
                let views = field.rig().shape().views();
                for (t, s) in (0..views.rows).flat_map(|t| (0..views.columns).map(move |s| (t, s))) {
                    cameras.push(ArrayCamera { name: format!("{}:{s},{t}", camera.name), ..camera.clone() });
                    images.push(Image::View { field: fields.len(), view: (t, s) });
                }
                fields.push(field);
                continue;
            }
            let with_ending = format!("{name}.png");
            let is_without = !folder.has_file(&name) && folder.has_file(&with_ending);
            cameras.push(camera);
            images.push(Image::File(if is_without { with_ending } else { name }));
        }
        Ok(Self { folder, cameras, images, fields, last_read: Arc::default() })
    }

    /// The number of the camera with this name; of a light field that of its central view.
    #[must_use]
    pub fn position(&self, name: &str) -> Option<usize> {
        self.cameras.iter().position(|camera| camera.name == name).or_else(|| {
            let central = |field: &PosedField| field.rig().shape().central_view();
            self.images.iter().zip(&self.cameras).position(|(image, camera)| match image {
                Image::View { field, view } => {
                    *view == central(&self.fields[*field])
                        && camera.name.rsplit_once(':').is_some_and(|(field, _)| field == name)
                }
                Image::File(_) => false,
            })
        })
    }

    /// The numbers of the cameras in the middle: of every light field its central view, and every camera with an image of its own.
    #[must_use]
    pub fn central_cameras(&self) -> Vec<usize> {
        let is_central = |image: &Image| match image {
            Image::View { field, view } => *view == self.fields[*field].rig().shape().central_view(),
            Image::File(_) => true,
        };
        (0..self.images.len()).filter(|&k| is_central(&self.images[k])).collect()
    }

    /// The cameras.
    #[must_use]
    pub fn cameras(&self) -> &[ArrayCamera] {
        &self.cameras
    }

    /// The folder.
    #[must_use]
    pub const fn folder(&self) -> &Folder {
        &self.folder
    }

    /// Returns camera `k`, counted from 0, with the size of its image, which is read from its header where the cameras do not say.
    ///
    /// # Errors
    ///
    /// [`Error::BadInput`] if there is no such camera; [`Error::Broken`] if its matrix is no rotation and translation; those of the
    /// reader of the image.
    pub fn pinhole(&self, k: usize) -> Result<Pinhole, Error> {
        let camera = self.camera(k)?;
        let pinhole = match &self.images[k] {
            Image::View { field, view } => self.fields[*field].pinhole(*view),
            Image::File(name) => {
                let size = match camera.size {
                    Some(size) => size,
                    None => read_image_info(&self.folder.regular_path(name)?)?.size,
                };
                let [x, y, z, position_m] = camera.axes_and_position;
                Pinhole::new([x, y, z], position_m, camera.focal_px, size)
            }
        };
        pinhole.map_err(|error| {
            let what = format!("camera '{}': {error}", crate::shown(&camera.name));
            Error::broken(&self.folder.path_of(TRANSFORMS_JSON), "transforms", what)
        })
    }

    /// The type of the samples of the image of camera `k`.
    ///
    /// # Errors
    ///
    /// [`Error::BadInput`] if there is no such camera; those of the reader of the image.
    pub fn kind(&self, k: usize) -> Result<SampleKind, Error> {
        self.camera(k)?;
        match &self.images[k] {
            Image::File(name) => Ok(read_image_info(&self.folder.regular_path(name)?)?.kind),
            Image::View { field, .. } => {
                Ok(self.fields[*field].light(*field, &self.last_read, &Limits::default())?.kind)
            }
        }
    }

    /// Reads the image of camera `k` in linear light, without alpha and divided by the gain of the camera: light of the scene, equal
    /// in all cameras.
    ///
    /// # Shape
    ///
    /// `(row, column, channel)`.
    ///
    /// # Errors
    ///
    /// [`Error::BadInput`] if there is no such camera; [`Error::Broken`] if the image has another size than the cameras say; those of
    /// [`read_linear`].
    pub fn image(&self, k: usize, limits: &Limits) -> Result<Array3<f32>, Error> {
        let expected = self.pinhole(k)?.size();
        let name = match &self.images[k] {
            Image::View { field, view } => {
                return self.fields[*field].image(*field, *view, &self.last_read, limits);
            }
            Image::File(name) => name,
        };
        let path = self.folder.regular_path(name)?;
        let mut image = read_linear(&path, limits)?;
        check_size(&path, expected, (image.dim().0, image.dim().1))?;
        let gain = self.camera(k)?.gain;
        if gain != [1.0; 3] {
            let channels = image.dim().2;
            // One channel has the gain of green.
            let gain = if channels == 3 { gain } else { [gain[1]; 3] };
            for (channel, gain) in gain.into_iter().enumerate().take(channels) {
                image.index_axis_mut(Axis(2), channel).mapv_inplace(|x| (f64::from(x) / gain) as f32);
            }
        }
        Ok(image)
    }

    /// Reads the depth of the pixels of camera `k`, m, or returns `None` if the folder has none.
    ///
    /// # Shape
    ///
    /// `(row, column)`; `+infinity` where nothing is hit.
    ///
    /// # Errors
    ///
    /// [`Error::BadInput`] if there is no such camera; [`Error::Broken`] if the map has another size than the image; those of
    /// [`read_pfm_gray`].
    pub fn depth_m(&self, k: usize, limits: &Limits) -> Result<Option<Array2<f32>>, Error> {
        self.camera(k)?;
        if let Image::View { field, view } = &self.images[k] {
            return self.fields[*field].depth_m(*view);
        }
        let name = format!("{DEPTH}/{}.pfm", self.cameras[k].name);
        if !self.folder.has_file(&name) {
            return Ok(None);
        }
        let path = self.folder.regular_path(&name)?;
        let map = read_pfm_gray(&path, limits)?;
        check_size(&path, self.pinhole(k)?.size(), map.dim())?;
        Ok(Some(map))
    }

    fn camera(&self, k: usize) -> Result<&ArrayCamera, Error> {
        let count = self.cameras.len();
        let missing =
            || Error::bad_input(self.folder.path(), format!("there is no camera {k}; cameras are 0 to {}", count - 1));
        self.cameras.get(k).ok_or_else(missing)
    }
}

fn check_size(path: &Path, expected: GridSize, (rows, columns): (usize, usize)) -> Result<(), Error> {
    if (rows, columns) == (expected.rows, expected.columns) {
        return Ok(());
    }
    let what = format!("it has {columns} x {rows} pixels, and its camera {} x {}", expected.columns, expected.rows);
    Err(Error::broken(path, "image", what))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{ColorEncoding, Compression, write_pfm, write_png};
    use serde_json::{Value, json};

    const SIZE: GridSize = GridSize::new(2, 3);

    fn frame(path: &str) -> Value {
        json!({ "file_path": path, "transform_matrix": [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]] })
    }

    fn folder(file: &Value) -> tempfile::TempDir {
        let folder = tempfile::tempdir().expect("a folder");
        std::fs::create_dir_all(folder.path().join("images")).expect("a folder");
        std::fs::create_dir_all(folder.path().join("depth")).expect("a folder");
        std::fs::write(folder.path().join(TRANSFORMS_JSON), file.to_string()).expect("written");
        let image = ndarray::Array3::<u8>::from_elem((SIZE.rows, SIZE.columns, 4), 255);
        for name in ["images/a.png", "images/b.png"] {
            write_png(folder.path().join(name), image.view(), ColorEncoding::Srgb, Compression::Fast).expect("written");
        }
        let depth = Array2::<f32>::from_elem((SIZE.rows, SIZE.columns), 2.5);
        write_pfm(folder.path().join("depth/a.pfm"), depth.view()).expect("written");
        folder
    }

    #[test]
    fn images_and_depths_are_found() {
        let mut bright = frame("images/b");
        bright["gain"] = json!([2.0, 1.0, 4.0]);
        let file = json!({ "fl_x": 30, "frames": [frame("./images/a.png"), bright] });
        let folder = folder(&file);
        assert!(ArrayFolder::is_one(folder.path()) && !ArrayFolder::is_one(folder.path().join("images")));
        let array = ArrayFolder::open(folder.path(), WorldUp::Y).expect("an array");
        let limits = Limits::default();
        for k in 0..2 {
            assert_eq!(array.pinhole(k).expect("a camera").size(), SIZE);
            let light = |(_, _, channel)| [1.0, [0.5, 1.0, 0.25][channel]][k];
            assert_eq!(array.image(k, &limits).expect("an image"), Array3::<f32>::from_shape_fn((2, 3, 3), light));
        }
        assert_eq!(array.depth_m(0, &limits).expect("a map"), Some(Array2::from_elem((2, 3), 2.5)));
        assert_eq!(array.depth_m(1, &limits).expect("none"), None);
        assert!(array.image(2, &limits).is_err());
    }

    #[test]
    fn what_is_wrong_is_said() {
        let opened = |file: &Value| {
            let folder = folder(file);
            let array = ArrayFolder::open(folder.path(), WorldUp::Y);
            array.and_then(|array| array.image(0, &Limits::default())).expect_err("wrong").to_string()
        };
        let with = |frame: Value| json!({ "fl_x": 30, "w": 3, "h": 2, "frames": [frame] });
        for (file, part) in [
            (with(frame("images")), "images"),
            (with(frame("../images/a.png")), "no name of a file inside the folder"),
            (with(frame("images/c.png")), "images/c.png"),
            (
                json!({ "fl_x": 30, "w": 3, "h": 3, "frames": [frame("images/a.png")] }),
                "it has 3 x 2 pixels, and its camera 3 x 3",
            ),
            (with(json!({ "transform_matrix": frame("")["transform_matrix"] })), "has no `file_path`"),
            (
                with(json!({ "file_path": "images/a.png", "transform_matrix":
                    [[2, 0, 0, 0], [0, 2, 0, 0], [0, 0, 2, 0], [0, 0, 0, 1]] })),
                "axes of a camera",
            ),
        ] {
            let message = opened(&file);
            assert!(message.contains(part), "no '{part}' in {message}");
        }
    }
}

//! Calibration targets: raw images of checkerboards, with the exact positions of their corners.

use std::fmt::Write as _;
use std::path::Path;

use holo_core::GridSize;
use holo_io::{CameraFile, Manifest, ManifestValue, Sha256};
use holo_render::{Integrator, LayerSet, Progress, Renderer, Request};
use holo_scene::{Instance, Material, Mesh, Scene, Transform};
use ndarray::{Array3, Axis};
use serde::Deserialize;

use crate::Error;
use crate::output::raw::{
    CAMERA_TOML, CENTERS_CSV, centers, first_indices, image, lit_white_image, write_raw, write_white,
};
use crate::output::{OutputFolder, Rollback};
use crate::resume::identity::check_replaceable;
use crate::settings::{EngineSettings, Exposure};
use crate::shot::libraries;
use crate::watch::{CancelOnly, Diagnostics};

/// The samples of a pixel that find the rows of pixels with light.
const FIRST_SAMPLES: u32 = 4;

/// How far from the edge of a micro-image corners are listed, px: less than half of a detector's window is cut off.
const BORDER_PX: f64 = 1.5;

/// Albedos of the squares and of the margin.
const DARK: f32 = 0.04;
const BRIGHT: f32 = 0.8;

/// The place of a board: its center in the frame of the camera, which looks along -Z, and its rotation about x, then y,
/// then z. At rest its front faces the camera and its columns run right.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BoardPose {
    /// The center, in meters.
    pub position_m: [f64; 3],
    /// The angles, in degrees.
    #[serde(default)]
    pub rotation_deg: [f64; 3],
}

/// Raw images of a checkerboard in several poses.
#[derive(Clone, Debug)]
pub struct TargetJob {
    /// The camera.
    pub camera: CameraFile,
    /// Inner corners, rows and columns.
    pub corners: GridSize,
    /// The side of a square, in meters.
    pub square_m: f64,
    /// The poses, one image each; `None`: five around the focus.
    pub poses: Option<Vec<BoardPose>>,
    /// Samples a pixel.
    pub samples: u32,
    /// Random seed.
    pub seed: u64,
    /// The ray tracing backend and the number of threads.
    pub engine: EngineSettings,
}

/// Reads poses: TOML with a table `[[pose]]` of `position_m` and `rotation_deg` each.
///
/// # Errors
/// [`Error::Failed`] if the file cannot be read or is no such TOML.
pub fn read_poses(path: &Path) -> Result<Vec<BoardPose>, Error> {
    #[derive(Deserialize)]
    #[serde(deny_unknown_fields)]
    struct Document {
        pose: Vec<BoardPose>,
    }
    let failed = |why: String| Error::Failed(format!("{}: {why}", path.display()));
    let text = std::fs::read_to_string(path).map_err(|why| failed(why.to_string()))?;
    let document: Document = toml::from_str(&text).map_err(|why| failed(why.to_string()))?;
    let is_finite = |pose: &BoardPose| pose.position_m.iter().chain(&pose.rotation_deg).all(|x| x.is_finite());
    match document.pose.iter().position(|pose| !is_finite(pose)) {
        Some(number) => Err(failed(format!("pose {number}: its numbers must be finite"))),
        None => Ok(document.pose),
    }
}

/// Writes the image of a frame.
pub(super) type WriteFrame<'a> = dyn Fn(&mut OutputFolder, usize, Array3<f32>) -> Result<(), Error> + 'a;

impl TargetJob {
    /// Renders into the folder `out`: `frame_NN.exr` and `frame_NN.png` of every pose, the white image, `centers.csv`,
    /// `corners.csv` and `camera.toml`. Returns the names of the files, and the number of listed corners.
    ///
    /// `corners.csv` has a line for every corner and micro-image that it lies in, at least 1.5 px from the edge: column `k`
    /// and row `l` of the micro-image as in `centers.csv`, the position `u`, `v` in px with whole numbers at the centers of
    /// pixels, the signed radius `rho` of the blur in px, the number `cluster` of the corner, the number `frame` of the
    /// image, its place `x`, `y`, `z` in the frame of the camera in m, the `type` of the microlens, and whether it is
    /// `visible`, which corners on the back are not.
    ///
    /// # Errors
    /// [`Error::BadRequest`] for an impossible board or no pose; [`Error::Render`] for errors and cancellation of the
    /// renderer; [`Error::Io`] if files cannot be written.
    pub fn run(
        &self,
        out: &Path,
        progress: &dyn Progress,
        diagnostics: &dyn Diagnostics,
        rollback: &Rollback,
    ) -> Result<(Vec<String>, usize), Error> {
        let color = |folder: &mut OutputFolder, frame: usize, image: Array3<f32>| {
            // A white square has 80 % of the range.
            write_raw(folder, &format!("frame_{frame:02}"), image, Exposure::Ev(0.0))
        };
        self.run_with((out, ""), (progress, diagnostics, rollback), self.identity(), &color)
    }

    /// The same into the folder `inner` below `root`, with another identity, and `write` for the image of a frame.
    pub(super) fn run_with(
        &self,
        place: (&Path, &str),
        (progress, diagnostics, rollback): (&dyn Progress, &dyn Diagnostics, &Rollback),
        mut manifest: Manifest,
        write: &WriteFrame<'_>,
    ) -> Result<(Vec<String>, usize), Error> {
        let poses = self.validated_poses()?;
        let camera = &self.camera.camera;
        let white = lit_white_image(&self.camera)?;
        let mut folder = OutputFolder::create_in(place, false, rollback, diagnostics)?;
        folder.unseal()?;
        let text = self.camera.to_toml();
        folder.add(CAMERA_TOML, holo_io::write_file(folder.file(CAMERA_TOML), text.as_bytes())?);
        folder.add(CENTERS_CSV, holo_io::write_file(folder.file(CENTERS_CSV), centers(camera).as_bytes())?);
        write_white(&mut folder, "white", &white)?;
        let mut table = String::from("k,l,u,v,rho,cluster,frame,x,y,z,type,visible\n");
        let mut count = 0;
        for (frame, pose) in poses.iter().enumerate() {
            let placed = transform(pose);
            count += self.list_corners(frame, &placed, &mut table);
            let EngineSettings { backend, threads } = self.engine;
            let renderer = Renderer::new(&self.board(&placed), &Transform::IDENTITY, backend, threads)?;
            let request = Request::new(camera.clone()).integrator(Integrator::Direct).samples(self.samples);
            let request = request.seed(self.seed + frame as u64).layers(LayerSet::EMPTY);
            manifest.libraries = libraries(&renderer);
            let seen = self.seen(&renderer, &request, progress)?;
            write(&mut folder, frame, seen)?;
        }
        folder.add("corners.csv", holo_io::write_file(folder.file("corners.csv"), table.as_bytes())?);
        Ok((folder.seal(manifest)?, count))
    }

    /// The raw image of a board before black: with all samples in the rows of pixels that see it, 0 in the others. A row that
    /// is more than a micro-image away from any light of the first samples is 0 even if a later sample would find some.
    fn seen(&self, renderer: &Renderer, request: &Request, progress: &dyn Progress) -> Result<Array3<f32>, Error> {
        let rendered = |request: &Request, progress: &dyn Progress| -> Result<Array3<f32>, Error> {
            let color = renderer.render(request, progress)?.color;
            image(color.ok_or_else(|| Error::Failed("the renderer returned no color".into()))?)
        };
        if self.samples <= FIRST_SAMPLES {
            return rendered(request, progress);
        }
        let mut first = rendered(&request.clone().samples(FIRST_SAMPLES), &CancelOnly(progress))?;
        let lit: Vec<bool> = first.outer_iter().map(|row| row.iter().any(|&light| light > 0.0)).collect();
        let (Some(low), Some(high)) = (lit.iter().position(|lit| *lit), lit.iter().rposition(|lit| *lit)) else {
            // A board that few samples see.
            return rendered(request, progress);
        };
        let margin = self.camera.camera.micro_image_pitch_px().ceil() as usize;
        let rows = low.saturating_sub(margin)..(high + margin + 1).min(lit.len());
        let all = rendered(&request.clone().rows(Some(rows.clone())), progress)?;
        first.slice_axis_mut(Axis(0), rows.into()).assign(&all);
        Ok(first)
    }

    /// Checks that the folder `out` holds no other images: it has no manifest, or one of the same target.
    ///
    /// # Errors
    /// [`Error::BadRequest`] if there are others; [`Error::Io`] if the manifest of the folder is damaged.
    pub fn check_replaceable(&self, out: &Path) -> Result<(), Error> {
        check_replaceable((out, ""), || Ok(self.identity()), |_| None)
    }

    /// What identifies the job in a manifest.
    pub(super) fn identity(&self) -> Manifest {
        let mut manifest = Manifest { seed: self.seed, ..Manifest::default() };
        manifest.versions.insert("holo".into(), env!("CARGO_PKG_VERSION").into());
        let mut set = |key: &str, value: ManifestValue| drop(manifest.settings.insert(key.into(), value));
        set("camera-file", self.camera.name.clone().into());
        set("camera_sha256", Sha256::of(self.camera.to_toml().as_bytes()).to_string().into());
        set("checkerboard", self.corners.to_string().into());
        set("square-mm", (1e3 * self.square_m).into());
        set("spp", self.samples.into());
        let numbers = self.poses.iter().flatten().flat_map(|pose| pose.position_m.into_iter().chain(pose.rotation_deg));
        set("poses", ManifestValue::List(numbers.map(ManifestValue::Float).collect()));
        manifest
    }

    /// The poses, or five around the focus.
    pub(crate) fn validated_poses(&self) -> Result<Vec<BoardPose>, Error> {
        let bad = |what: &str| Err(Error::BadRequest(what.into()));
        if self.corners.count() == 0 || self.corners.larger() > 1000 {
            return bad("a checkerboard has 1 to 1000 inner corners along each side");
        }
        if !(self.square_m.is_finite() && self.square_m > 0.0) {
            return bad("the squares of a checkerboard must be larger than 0");
        }
        match &self.poses {
            Some(poses) if poses.is_empty() => return bad("`poses` has no pose; without it there are five"),
            Some(poses) => return Ok(poses.clone()),
            None => {}
        }
        let focus_m = 1.0 / self.camera.camera.inverse_focus_per_m();
        if !(focus_m.is_finite() && focus_m > 0.0) {
            return bad("the camera has no finite focus to place boards around; give `poses`");
        }
        let tilted = |x: f64, y: f64, depth: f64| BoardPose {
            position_m: [0.0, 0.0, -depth * focus_m],
            rotation_deg: [x, y, 0.0],
        };
        Ok(vec![
            tilted(0.0, 0.0, 0.9),
            tilted(25.0, 0.0, 0.9),
            tilted(-25.0, 0.0, 1.1),
            tilted(0.0, 25.0, 1.2),
            tilted(0.0, -25.0, 0.8),
        ])
    }

    /// The place of a corner on the board, from its center, in squares: x right, y up.
    pub(super) fn on_board(&self, row: usize, column: usize) -> [f64; 2] {
        [column as f64 - (self.corners.columns - 1) as f64 / 2.0, (self.corners.rows - 1) as f64 / 2.0 - row as f64]
    }

    /// Adds a line for every corner in every micro-image; returns their number.
    fn list_corners(&self, frame: usize, placed: &Transform, table: &mut String) -> usize {
        let camera = &self.camera.camera;
        let size = camera.sensor().size;
        let (first_row, first_column) = first_indices(camera);
        // How far from the center of a micro-image corners are listed: its radius is that of the pupil, for all types.
        let listed_px = camera.micro_image_radii_m(0)[1] / camera.sensor().pixel_m - BORDER_PX;
        let mut count = 0;
        for row in 0..self.corners.rows {
            for column in 0..self.corners.columns {
                let [x, y] = self.on_board(row, column).map(|x| x * self.square_m);
                let point = placed.point([x, y, 0.0]);
                // The front's normal points at the camera, along the ray from the point to the pupil.
                let normal = placed.columns[2];
                let is_visible = normal.iter().zip(&point).map(|(n, p)| -n * p).sum::<f64>() > 0.0;
                let cluster = row * self.corners.columns + column;
                for lens in camera.lenses_seeing(point, listed_px) {
                    let Some(found) = camera.project(point, lens) else { continue };
                    let [u, v] = found.position_px;
                    if !(0.0..=size.columns as f64).contains(&u) || !(0.0..=size.rows as f64).contains(&v) {
                        continue;
                    }
                    let lens_type = camera.array().type_of(lens);
                    let (k, l) = (lens.column - first_column, lens.row - first_row);
                    let rho = -found.blur_radius_px;
                    let [x, y, z] = point;
                    let visible = u8::from(is_visible);
                    // Writing to a string does not fail.
                    let _ = writeln!(
                        table,
                        "{k},{l},{},{},{rho},{cluster},{frame},{x},{y},{z},{lens_type},{visible}",
                        u - 0.5,
                        v - 0.5
                    );
                    count += 1;
                }
            }
        }
        count
    }

    /// The board with a margin of one square, unlit, in the frame of the camera.
    fn board(&self, placed: &Transform) -> Scene {
        let mut scene = Scene::default();
        let mut meshes = [Mesh::default(), Mesh::default()];
        let (rows, columns) = (self.corners.rows as i64, self.corners.columns as i64);
        for row in -2..=rows {
            for column in -2..=columns {
                // The outermost ring is bright.
                let is_margin = row == -2 || column == -2 || row == rows || column == columns;
                let is_dark = !is_margin && (row + column).rem_euclid(2) == 0;
                let mesh = &mut meshes[usize::from(is_dark)];
                let first = mesh.positions.len() as u32;
                let [x, y] = [
                    (column as f64 - (columns - 1) as f64 / 2.0) * self.square_m,
                    ((rows - 1) as f64 / 2.0 - row as f64) * self.square_m,
                ];
                let (right, below) = (x + self.square_m, y - self.square_m);
                for [x, y] in [[x, below], [right, below], [right, y], [x, y]] {
                    mesh.positions.push(placed.point([x, y, 0.0]).map(|x| x as f32));
                }
                mesh.triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
            }
        }
        for (mut mesh, albedo) in meshes.into_iter().zip([BRIGHT, DARK]) {
            mesh.material = scene.materials.len();
            let base_color = [albedo, albedo, albedo, 1.0];
            scene.materials.push(Material { unlit: true, base_color, ..Material::default() });
            scene.meshes.push(mesh);
            let mesh = scene.meshes.len() - 1;
            scene.instances.push(Instance { name: "checkerboard".into(), mesh, transform: Transform::IDENTITY });
        }
        scene
    }
}

/// Board to camera.
pub(super) fn transform(pose: &BoardPose) -> Transform {
    let [x, y, z] = pose.rotation_deg.map(f64::to_radians);
    let about = |axis: usize, angle: f64, p: [f64; 3]| {
        let (sin, cos) = angle.sin_cos();
        let (a, b) = ((axis + 1) % 3, (axis + 2) % 3);
        let mut out = p;
        out[a] = cos * p[a] - sin * p[b];
        out[b] = sin * p[a] + cos * p[b];
        out
    };
    let turned = |p: [f64; 3]| about(2, z, about(1, y, about(0, x, p)));
    let columns = [turned([1.0, 0.0, 0.0]), turned([0.0, 1.0, 0.0]), turned([0.0, 0.0, 1.0])];
    Transform { columns, translation: pose.position_m }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rows without light are left out; the others have the bytes of the whole image.
    #[test]
    fn boards_are_rendered_where_they_are_seen() {
        let mut job = TargetJob {
            camera: CameraFile::preset("h3dv").unwrap(),
            corners: GridSize::new(2, 3),
            square_m: 0.01,
            poses: None,
            samples: 2,
            seed: 3,
            engine: EngineSettings::default(),
        };
        let focus_m = 1.0 / job.camera.camera.inverse_focus_per_m();
        for (x, square_m) in [(0.0, 0.01), (0.0, 1e-5), (1e3, 0.01)] {
            job.square_m = square_m * focus_m;
            let pose = BoardPose { position_m: [x, 0.1 * focus_m, -focus_m], rotation_deg: [10.0, 0.0, 0.0] };
            let EngineSettings { backend, threads } = job.engine;
            let board = job.board(&transform(&pose));
            let renderer = Renderer::new(&board, &Transform::IDENTITY, backend, threads).unwrap();
            let request = Request::new(job.camera.camera.clone()).integrator(Integrator::Direct).samples(2).seed(3);
            let request = request.layers(LayerSet::EMPTY);
            let whole = image(renderer.render(&request, &()).unwrap().color.unwrap()).unwrap();
            let seen = job.seen(&renderer, &request, &()).unwrap();
            assert_eq!(seen, whole, "{x} {square_m}");
            let lit = whole.iter().filter(|light| **light > 0.0).count();
            assert!(if x > 0.0 { lit == 0 } else { square_m < 1e-3 || lit > 1000 && lit < whole.len() / 4 }, "{lit}");
        }
    }
}

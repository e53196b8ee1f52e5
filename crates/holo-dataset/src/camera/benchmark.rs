//! The benchmark of calibrations: boards and white images of several cameras, with the truth.

mod cameras;
mod cards;
mod poses;
mod recorded;

use std::path::Path;

use holo_io::interop::{LensletGridModel, Libpleno};
use holo_io::{CameraFile, Folder, Manifest, Sha256};
use holo_render::{Integrator, Layer, LayerSet, Progress, Renderer, Request};
use holo_scene::Transform;
use ndarray::{Array3, Axis};

use self::cameras::{ENTRIES, Entry, Tier};
use self::poses::Poses;
use self::recorded::Recorder;
use super::target::{BoardPose, TargetJob};
use crate::Error;
use crate::output::raw::{CAMERA_TOML, image, lit_white_image};
use crate::output::{OutputFolder, Rollback, existing};
use crate::resume::identity::{check_replaceable, difference};
use crate::settings::EngineSettings;
use crate::shot::libraries;
use crate::watch::{About, Diagnostics};

/// The version of cameras, poses and files.
const VERSION: u32 = 1;

/// The f-numbers of white images, relative to that of the camera: whole stops.
const STOPS: [f64; 5] = [1.0, std::f64::consts::SQRT_2, 2.0, 2.0 * std::f64::consts::SQRT_2, 4.0];

/// The side of a cell of the textured scene, in squares of a board.
const CELL: f64 = 0.25;

/// The depths of the textured scene.
const SCENE_DEPTH: &str = "scene_depth.pfm";

/// Bytes of the files of a board, per pixel of the sensor: as measured.
const BYTES_PER_PIXEL: f64 = 5.5;

/// Data for calibrations of plenoptic cameras, with the truth: the cameras `r12-a` to `r12-d`, `illum`, `f01` and `square`, each
/// behind a thin lens and behind glass.
///
/// A folder each, such as `r12-a-glass`, has
///
/// - `white`: white images at five f-numbers, and `data_sheet.toml`, what is known of the camera;
/// - `boards`, `held-out` and `sweep`: 16 and 15 boards in free poses and 11 that move along the axis, as [`TargetJob`] writes them
///   but for their images, with the poses in `poses.toml`;
/// - `scene`: textured cards before a wall, `scene_depth.pfm` with the depth of every pixel's chief ray in meters, and the camera;
/// - `compote` and `lftoolbox`: the same for COMPOTE and the Light Field Toolbox.
///
/// Every image is there without noise, `NAME.png`, 16 bits in linear gray, and as the codes of a sensor, `NAME_noisy.png`.
#[derive(Clone, Debug)]
pub struct CalibrationBenchmark {
    /// Whether sensors and boards have their full size; else a quarter of the pixels, and microlenses as large.
    pub is_full: bool,
    /// The cameras; none: all.
    pub cameras: Vec<String>,
    /// Samples a pixel.
    pub samples: u32,
    /// The ray tracing backend and the number of threads.
    pub engine: EngineSettings,
}

/// How much a benchmark is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BenchmarkSize {
    /// Cameras, each behind two lenses.
    pub cameras: usize,
    /// Images of boards.
    pub boards: usize,
    /// Pixels of all of them.
    pub pixels: f64,
    /// Bytes on the disk, about.
    pub bytes: f64,
}

/// The texts for a program: its folder, and the names and contents of the files.
type ProgramTexts = (&'static str, Vec<(String, String)>);

/// A camera of the benchmark behind a lens.
struct Configuration<'a> {
    entry: &'a Entry,
    tier: Tier,
    truth: CameraFile,
    data_sheet: CameraFile,
}

impl CalibrationBenchmark {
    /// Returns the names of the cameras.
    #[must_use]
    pub fn camera_names() -> Vec<&'static str> {
        ENTRIES.iter().map(|entry| entry.name).collect()
    }

    fn entries(&self) -> Result<Vec<&'static Entry>, Error> {
        if let Some(name) = self.cameras.iter().find(|name| ENTRIES.iter().all(|entry| entry.name != **name)) {
            let names = Self::camera_names().join(", ");
            return Err(Error::BadRequest(format!(
                "the benchmark has no camera '{}'; it has {names}",
                holo_io::shown(name)
            )));
        }
        let is_wanted = |entry: &&Entry| self.cameras.is_empty() || self.cameras.iter().any(|name| name == entry.name);
        Ok(ENTRIES.iter().filter(is_wanted).collect())
    }

    /// Returns how much it is.
    ///
    /// # Errors
    /// [`Error::BadRequest`] for an unknown camera.
    pub fn size(&self) -> Result<BenchmarkSize, Error> {
        let entries = self.entries()?;
        let boards = Tier::ALL.len() * Poses::ALL.iter().map(|poses| poses.count()).sum::<usize>();
        let mut pixels = 0.0;
        for entry in &entries {
            pixels += (boards * entry.camera(Tier::Thin, self.is_full)?.camera.sensor().size.count()) as f64;
        }
        let bytes = BYTES_PER_PIXEL * pixels;
        Ok(BenchmarkSize { cameras: entries.len(), boards: boards * entries.len(), pixels, bytes })
    }

    /// Renders into the folder `out`. Parts that are there already are kept, so that it continues after an interruption;
    /// `overwrite` permits to replace others.
    ///
    /// # Errors
    /// [`Error::BadRequest`] for an unknown camera, or a folder with other images; [`Error::Render`] for errors and
    /// cancellation of the renderer; [`Error::Io`] if files cannot be written.
    pub fn run(
        &self,
        out: &Path,
        overwrite: bool,
        watch: (&dyn Progress, &dyn Diagnostics, &Rollback),
    ) -> Result<(), Error> {
        OutputFolder::create_plain(out, watch.2)?.keep();
        for entry in self.entries()? {
            for tier in Tier::ALL {
                let truth = entry.camera(tier, self.is_full)?;
                let data_sheet = entry.data_sheet(self.is_full)?;
                self.write(&Configuration { entry, tier, truth, data_sheet }, (out, overwrite), watch)?;
            }
        }
        Ok(())
    }

    /// Writes a camera behind a lens.
    fn write(
        &self,
        configuration: &Configuration<'_>,
        (out, overwrite): (&Path, bool),
        watch: (&dyn Progress, &dyn Diagnostics, &Rollback),
    ) -> Result<(), Error> {
        let recorder = Recorder::new(configuration.entry.sensor()?, &lit_white_image(&configuration.truth)?);
        let name = |part: &str| format!("{}/{part}", configuration.name());
        let part = |inner: &str, identity: &Manifest, write: &dyn Fn() -> Result<(), Error>| -> Result<(), Error> {
            if is_there(out, inner, identity)? {
                return Ok(());
            }
            if !overwrite {
                check_replaceable((out, inner), || Ok(identity.clone()), |_| None)?;
            }
            watch.1.report(About::Scene, inner);
            write()
        };
        let white = name("white");
        let identity = self.identity(configuration);
        part(&white, &identity, &|| configuration.write_white(&recorder, (out, &white), watch, identity.clone()))?;
        for poses in Poses::ALL {
            let inner = name(poses.name());
            let job = self.job(configuration, poses);
            let mut identity = job.identity();
            identity.settings.insert("calibration-benchmark".into(), VERSION.into());
            part(&inner, &identity, &|| {
                let write = |folder: &mut OutputFolder, frame: usize, image: Array3<f32>| {
                    if frame == 0 {
                        let text = poses::to_toml(job.poses.as_deref().unwrap_or_default());
                        folder.add("poses.toml", holo_io::write_file(folder.file("poses.toml"), text.as_bytes())?);
                    }
                    recorder.write(folder, &format!("frame_{frame:02}"), frame as u64, &image)
                };
                job.run_with((out, &inner), watch, identity.clone(), &write).map(drop)
            })?;
        }
        let inner = name("scene");
        let mut scene = identity.clone();
        scene.settings.insert("spp".into(), self.samples.into());
        part(&inner, &scene, &|| self.write_scene(configuration, &recorder, (out, &inner), watch, scene.clone()))?;
        let texts = self.texts(configuration, out)?;
        for (program, texts) in texts {
            let inner = name(program);
            let mut identity = identity.clone();
            let sum =
                texts.iter().flat_map(|(name, text)| [name.as_bytes(), text.as_bytes()]).collect::<Vec<_>>().concat();
            identity.settings.insert("texts_sha256".into(), Sha256::of(&sum).to_string().into());
            part(&inner, &identity, &|| {
                let mut folder = OutputFolder::create_in((out, &inner), false, watch.2, watch.1)?;
                folder.unseal()?;
                for (name, text) in &texts {
                    folder.add(name.clone(), holo_io::write_file(folder.file(name), text.as_bytes())?);
                }
                folder.seal(identity.clone()).map(drop)
            })?;
        }
        Ok(())
    }

    /// Renders the textured scene.
    fn write_scene(
        &self,
        configuration: &Configuration<'_>,
        recorder: &Recorder,
        place: (&Path, &str),
        (progress, diagnostics, rollback): (&dyn Progress, &dyn Diagnostics, &Rollback),
        mut identity: Manifest,
    ) -> Result<(), Error> {
        let camera = &configuration.truth.camera;
        let cell_m = configuration.entry.board(self.is_full).1 * CELL;
        let scene = cards::scene(&configuration.data_sheet.camera, cell_m, configuration.entry.depths_m);
        let EngineSettings { backend, threads } = self.engine;
        let renderer = Renderer::new(&scene, &Transform::IDENTITY, backend, threads)?;
        let request = Request::new(camera.clone()).integrator(Integrator::Direct).samples(self.samples);
        let rendered = renderer.render(&request.layers(LayerSet::of(&[Layer::Depth])), progress)?;
        let lost = || Error::Failed("the renderer returned neither color nor depth".into());
        let depth_m = rendered.central.depth_m().ok_or_else(lost)?.index_axis(Axis(2), 0);
        let mut folder = OutputFolder::create_in(place, false, rollback, diagnostics)?;
        folder.unseal()?;
        let text = configuration.truth.to_toml();
        folder.add(CAMERA_TOML, holo_io::write_file(folder.file(CAMERA_TOML), text.as_bytes())?);
        folder.add(SCENE_DEPTH, holo_io::write_pfm(folder.file(SCENE_DEPTH), depth_m)?);
        recorder.write(&mut folder, "scene", poses::COUNT as u64, &image(rendered.color.ok_or_else(lost)?)?)?;
        identity.libraries = libraries(&renderer);
        folder.seal(identity).map(drop)
    }

    fn identity(&self, configuration: &Configuration<'_>) -> Manifest {
        let mut manifest = Manifest::default();
        manifest.versions.insert("holo".into(), env!("CARGO_PKG_VERSION").into());
        let camera = configuration.truth.to_toml();
        manifest.settings.insert("camera_sha256".into(), Sha256::of(camera.as_bytes()).to_string().into());
        manifest.settings.insert("calibration-benchmark".into(), VERSION.into());
        manifest
    }

    /// The boards in some poses.
    fn job(&self, configuration: &Configuration<'_>, poses: Poses) -> TargetJob {
        let (corners, square_m) = configuration.entry.board(self.is_full);
        TargetJob {
            camera: configuration.truth.clone(),
            corners,
            square_m,
            poses: Some(self.poses(configuration, poses)),
            samples: self.samples,
            seed: poses.first() as u64,
            engine: self.engine,
        }
    }

    /// The poses: the same before both lenses.
    fn poses(&self, configuration: &Configuration<'_>, poses: Poses) -> Vec<BoardPose> {
        let (corners, square_m) = configuration.entry.board(self.is_full);
        let half_m = [corners.columns, corners.rows].map(|count| square_m * (count + 1) as f64 / 2.0);
        poses.of(&configuration.data_sheet.camera, half_m, configuration.entry.depths_m)
    }

    /// The texts for other programs: folders, and the names and contents of their files, when the boards are in `out`.
    fn texts(&self, configuration: &Configuration<'_>, out: &Path) -> Result<Vec<ProgramTexts>, Error> {
        let truth = &configuration.truth.camera;
        let (corners, square_m) = configuration.entry.board(self.is_full);
        let (data_sheet, true_camera) = (&configuration.data_sheet.camera, Libpleno::new(truth)?);
        let mut compote = vec![
            ("camera.js".to_owned(), Libpleno::before_calibration(data_sheet, truth)?),
            ("scene.js".to_owned(), Libpleno::scene(corners, square_m)),
            ("true_intrinsics.js".to_owned(), true_camera.intrinsics),
            ("true_params.js".to_owned(), true_camera.parameters),
        ];
        let f_number = truth.main_lens().f_number;
        for poses in Poses::ALL {
            let job = self.job(configuration, poses);
            for noise in ["", "_noisy"] {
                let white = |stop: f64| {
                    (format!("../white/compote/{}{noise}.png", white_name(f_number * stop)), f_number * stop)
                };
                let frame = |frame| format!("../{}/compote/frame_{frame:02}{noise}.png", poses.name());
                let frames: Vec<String> = (0..poses.count()).map(frame).collect();
                let text = Libpleno::boards(&STOPS.map(white), &white(1.0), &frames);
                compote.push((format!("{}_images{noise}.js", poses.name()), text));
            }
            let folder = Folder::open(out)?.sub(&format!("{}/{}", configuration.name(), poses.name()))?;
            compote.push((format!("{}_true_features.js", poses.name()), job.compote_features(&folder)?));
            let poses_of_job = job.poses.as_deref().unwrap_or_default();
            compote.push((format!("{}_true_poses.js", poses.name()), job.compote_poses(poses_of_job)));
        }
        let mut texts = vec![("compote", compote)];
        if truth.array().type_count() == 1 {
            texts.push(("lftoolbox", vec![("grid.json".to_owned(), LensletGridModel::new(truth)?.to_json())]));
        }
        Ok(texts)
    }
}

impl Configuration<'_> {
    fn name(&self) -> String {
        format!("{}-{}", self.entry.name, self.tier.name())
    }

    /// Writes the white images.
    fn write_white(
        &self,
        recorder: &Recorder,
        place: (&Path, &str),
        (progress, diagnostics, rollback): (&dyn Progress, &dyn Diagnostics, &Rollback),
        identity: Manifest,
    ) -> Result<(), Error> {
        let mut folder = OutputFolder::create_in(place, false, rollback, diagnostics)?;
        folder.unseal()?;
        let text = self.data_sheet.to_toml();
        folder.add("data_sheet.toml", holo_io::write_file(folder.file("data_sheet.toml"), text.as_bytes())?);
        let f_number = self.truth.camera.main_lens().f_number;
        for (number, stop) in STOPS.into_iter().enumerate() {
            let stopped = self.truth.clone().with_f_number(f_number * stop)?;
            let white = lit_white_image(&stopped)?;
            // The exposure follows the aperture.
            let brightest = white.iter().fold(f32::MIN_POSITIVE, |most, &light| most.max(light));
            let image = white.mapv(|light| light * (recorder.brightest / brightest)).insert_axis(Axis(2));
            recorder.write(&mut folder, &white_name(f_number * stop), number as u64, &image)?;
            if progress.cancelled() {
                return Err(holo_render::Error::Cancelled.into());
            }
        }
        folder.seal(identity).map(drop)
    }
}

/// The name of a white image.
fn white_name(f_number: f64) -> String {
    format!("white_f{f_number:.2}")
}

/// Whether a part of the benchmark is there.
fn is_there(out: &Path, inner: &str, identity: &Manifest) -> Result<bool, Error> {
    let Some(folder) = existing(out, inner)? else { return Ok(false) };
    if folder.kind(holo_io::dataset::MANIFEST_JSON)?.is_none() {
        return Ok(false);
    }
    Ok(difference(&Manifest::read_in(&folder)?, identity).is_none())
}

#[cfg(test)]
mod tests {
    use std::cell::RefCell;

    use holo_core::GridSize;
    use holo_core::plenoptic::{ImageSensor, PlenopticCamera};

    use super::*;
    use crate::calibration_score;

    /// Every camera is lit, sees the middle of boards, and is a camera that COMPOTE can describe.
    #[test]
    fn every_camera_sees_its_boards() {
        let benchmark =
            CalibrationBenchmark { is_full: false, cameras: Vec::new(), samples: 1, engine: EngineSettings::default() };
        for entry in ENTRIES {
            for tier in Tier::ALL {
                let truth = entry.camera(tier, false).unwrap();
                let data_sheet = entry.data_sheet(false).unwrap();
                let configuration = Configuration { entry, tier, truth, data_sheet };
                let camera = &configuration.truth.camera;
                let all = configuration.name();
                let radius_px = camera.micro_image_radii_m(0)[1] / camera.sensor().pixel_m;
                let (corners, square_m) = entry.board(false);
                for poses in Poses::ALL {
                    let boards = benchmark.poses(&configuration, poses);
                    assert_eq!(boards.len(), poses.count());
                    // A point in focus is one on the array, which may lie between microlenses.
                    let is_seen = |board: &&BoardPose| !camera.lenses_seeing(board.position_m, radius_px).is_empty();
                    let seen = boards.iter().filter(is_seen).count();
                    assert!(3 * seen >= boards.len(), "{all}: {seen} of {}", boards.len());
                    let depths_m = entry.depths_m[0] - 1e-9..=entry.depths_m[1] + 1e-9;
                    assert!(boards.iter().all(|board| depths_m.contains(&-board.position_m[2])), "{all}");
                    // A board faces the camera within the field of view; one that is larger is in its middle.
                    let tangents =
                        configuration.data_sheet.camera.angles_of_view_rad().map(|angle| (angle / 2.0).tan());
                    let is_within = |board: &BoardPose| {
                        let [x, y, z] = board.position_m;
                        let sides = [(x, corners.columns, tangents[0]), (y, corners.rows, tangents[1])];
                        sides.into_iter().all(|(at, corners, tangent)| {
                            let half_m = (corners + 1) as f64 / 2.0 * square_m;
                            at == 0.0 || at.abs() + half_m <= -z * tangent + 1e-9
                        })
                    };
                    assert!(boards.iter().all(is_within), "{all}: {boards:?}");
                }
                // The f-number of a lens of glass is that of its stop.
                let f_number = camera.main_lens().f_number / configuration.data_sheet.camera.main_lens().f_number;
                assert!((f_number - 1.0).abs() < 1e-6, "{all} {f_number}");
                assert_eq!(camera.has_glass(), tier == Tier::Glass);
                Libpleno::before_calibration(&configuration.data_sheet.camera, camera).unwrap();
            }
        }
        // All boards of a camera are on its sensor.
        let size = benchmark.size().unwrap();
        let of = |entry: &Entry| entry.camera(Tier::Thin, false).unwrap().camera.sensor().size.count() as f64;
        let pixels = ENTRIES.iter().map(of).sum::<f64>() * (size.boards / ENTRIES.len()) as f64;
        assert_eq!((size.cameras, size.pixels, size.bytes), (ENTRIES.len(), pixels, BYTES_PER_PIXEL * pixels));
        let unknown = CalibrationBenchmark { cameras: vec!["r13".into()], ..benchmark };
        assert!(unknown.size().unwrap_err().to_string().contains("r12-d"));
    }

    /// Every pixel sees a card or the wall, up to a card that is turned towards the camera by less than its half side.
    fn check_depths(path: &Path, [near_m, far_m]: [f64; 2]) {
        let depths = holo_io::read_pfm_gray(path, &holo_io::Limits::default()).unwrap();
        let range = 0.9 * near_m as f32..=1.0001 * far_m as f32;
        assert!(depths.iter().all(|depth| range.contains(depth)), "{depths:?}");
        let nearest = depths.iter().copied().fold(f32::INFINITY, f32::min);
        assert!(nearest < 0.95 * far_m as f32, "{nearest}: no card is seen");
    }

    /// A small sensor: every part is sealed, kept by a second run and replaced by one of other samples only with permission; a camera
    /// that COMPOTE reads of the folder is the true one.
    #[test]
    fn parts_are_written_once_and_score_the_truth() {
        let entry = ENTRIES.iter().find(|entry| entry.name == "r12-a").unwrap();
        let small = |file: CameraFile| {
            let sensor = ImageSensor { size: GridSize::new(140, 190), ..*file.camera.sensor() };
            let (array, lens) = (file.camera.array().clone(), file.camera.main_lens().clone());
            CameraFile { camera: PlenopticCamera::new(sensor, array, lens).unwrap(), ..file }
        };
        let configuration = Configuration {
            entry,
            tier: Tier::Thin,
            truth: small(entry.camera(Tier::Thin, false).unwrap()),
            data_sheet: small(entry.data_sheet(false).unwrap()),
        };
        let mut benchmark =
            CalibrationBenchmark { is_full: false, cameras: Vec::new(), samples: 1, engine: EngineSettings::default() };
        let out = tempfile::tempdir().unwrap();
        let out = out.path();
        let rollback = Rollback::default();
        let run = |benchmark: &CalibrationBenchmark, overwrite: bool| {
            let lines = RefCell::new(Vec::new());
            let hear = |_: About, line: &str| lines.borrow_mut().push(line.to_owned());
            benchmark.write(&configuration, (out, overwrite), (&(), &hear, &rollback)).map(|()| lines.into_inner())
        };
        let names =
            ["white", "boards", "held-out", "sweep", "scene", "compote"].map(|part| format!("r12-a-thin/{part}"));
        assert_eq!(run(&benchmark, false).unwrap(), names);
        assert!(run(&benchmark, false).unwrap().is_empty());
        std::fs::remove_file(out.join("r12-a-thin/sweep/manifest.json")).unwrap();
        assert_eq!(run(&benchmark, false).unwrap(), names[3..4]);
        benchmark.samples = 2;
        assert!(run(&benchmark, false).unwrap_err().to_string().contains("overwrite"));
        assert_eq!(run(&benchmark, true).unwrap(), names[1..5]);

        let boards = out.join("r12-a-thin/boards");
        for name in ["frame_15.png", "frame_15_noisy.png", "compote/frame_15.png", "poses.toml", "corners.csv"] {
            assert!(boards.join(name).is_file(), "{name}");
        }
        assert_eq!(
            crate::read_poses(&boards.join("poses.toml")).unwrap(),
            benchmark.poses(&configuration, Poses::Boards)
        );
        let text = std::fs::read_to_string(out.join("r12-a-thin/compote/sweep_images_noisy.js")).unwrap();
        let paths: Vec<&str> = text.split('"').filter(|word| word.ends_with(".png")).collect();
        assert_eq!(paths.len(), STOPS.len() + 11 + 1);
        assert!(paths.iter().all(|path| out.join("r12-a-thin/compote").join(path).is_file()), "{paths:?}");
        let read = CameraFile::read(out.join("r12-a-thin/compote/true_intrinsics.js")).unwrap();
        let score = calibration_score(&read, &boards).unwrap();
        let of = |key: &str| score.iter().find(|row| row.key == key).unwrap().value.clone();
        let crate::QuantityValue::List(reprojection) = of("reprojection_px") else { panic!() };
        assert!(reprojection[1] < 1e-3, "{reprojection:?}");

        check_depths(&out.join("r12-a-thin/scene/scene_depth.pfm"), entry.depths_m);

        // Noise of electrons: the codes of a bright surface scatter as much as the root of their electrons.
        let white = out.join("r12-a-thin/white");
        let image = |name: &str| match holo_io::read_png(white.join(name), &holo_io::Limits::default()).unwrap() {
            holo_core::DynImage::U16(image) => image,
            _ => panic!("{name} has no 16 bits"),
        };
        let (clean, noisy) = (image("white_f4.00.png"), image("white_f4.00_noisy.png"));
        let sensor = entry.sensor().unwrap();
        let brightest = f64::from(*clean.iter().max().unwrap());
        let electrons = 0.9 * sensor.saturation_e(sensor.base_iso);
        let (mut count, mut squares) = (0.0, 0.0);
        for (&clean, &noisy) in clean.iter().zip(&noisy) {
            let expected_e = f64::from(clean) / brightest * electrons;
            if expected_e > 0.5 * electrons {
                let found_e = (f64::from(noisy) - sensor.black) / sensor.dn_per_e;
                let variance = expected_e + sensor.read_noise_e.powi(2) + (sensor.prnu * expected_e).powi(2);
                count += 1.0;
                squares += (found_e - expected_e).powi(2) / variance;
            }
        }
        let ratio: f64 = squares / count;
        assert!(count > 1000.0 && (0.8..1.3).contains(&ratio), "{ratio} of {count}");
    }
}

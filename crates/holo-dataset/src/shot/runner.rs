//! The runner of a job: which shots, in which folders; identity, checkpoints, exposure, files.

use std::cell::OnceCell;
use std::path::{Path, PathBuf};
use std::time::Instant;

use holo_io::dataset::MANIFEST_JSON;
use holo_io::{Folder, Manifest};
use holo_render::{Request, World};
use ndarray::Axis;

use super::choices::{self, Chosen};
use super::engine::{self, engine_name};
use super::identity::{self, at_frame};
use super::job::{Event, RenderJob, Rendering, RunOptions, Shot, ShotOutcome};
use super::prepare::{Prepared, Setup, Stage};
use super::report::{CameraReport, RenderReport, Seconds};
use super::{pinholes, trace};
use crate::Error;
use crate::output::layers::FLOWS;
use crate::output::{
    self, Exposed, Finished, OutputFolder, TRANSFORMS, Traced, TracedCamera, Wanted, existing, exposure_ev, inner_name,
};
use crate::resume::checkpoint::Keeper;
use crate::resume::identity::{check_replaceable, difference};
use crate::resume::{done, merge};
use crate::settings::{Camera, Output, Poses, RenderSettings, Shard};
use crate::watch::Diagnostics;

/// The folder of a shot.
struct Place<'a> {
    root: &'a Path,
    /// Below the root.
    inner: String,
    /// Whether another image in it is replaced.
    replaces: bool,
}

/// Runs the shots of a job.
pub(crate) struct Runner<'a> {
    pub(super) job: &'a RenderJob,
    pub(super) wanted: Wanted,
    backend: String,
    /// All shots, in order.
    shots: Vec<Shot>,
    /// What identifies all shots.
    identity: OnceCell<Manifest>,
    /// What is chosen by the first shot.
    chosen: OnceCell<Chosen>,
}

impl RenderJob {
    /// Renders into the folder `out`. If an earlier run was interrupted, this one continues from its
    /// [checkpoint](crate::Checkpoints), to the same bytes; of several shots, those that are up to date are kept.
    ///
    /// # Errors
    /// [`Error::BadRequest`] if the settings contradict each other, or a folder holds another image and is not to be
    /// overwritten; [`Error::Scene`] and [`Error::Failed`] if the scene or the environment map cannot be read;
    /// [`Error::Render`] for errors and cancellation of the renderer; [`Error::Io`] if files cannot be written. Files and
    /// folders that the shot created are removed then, except for a checkpoint.
    pub fn run(&self, out: impl AsRef<Path>, options: &RunOptions) -> Result<Vec<(Shot, ShotOutcome)>, Error> {
        Runner::new(self, options.diagnostics)?.run(out.as_ref(), options)
    }

    /// Renders the complete image of a job with one shot into memory: what [`run`](Self::run) writes, before it is encoded.
    /// Needs no folder and keeps no checkpoint.
    ///
    /// # Errors
    /// As [`run`](Self::run), without those of files that are written; [`Error::BadRequest`] for several shots.
    pub fn render(&self, options: &RunOptions) -> Result<Rendering, Error> {
        Runner::new(self, options.diagnostics)?.render(options)
    }
}

impl<'a> Runner<'a> {
    /// Checks the settings, and finds the ray tracing backend.
    pub fn new(job: &'a RenderJob, diagnostics: &dyn Diagnostics) -> Result<Self, Error> {
        let wanted = Wanted::new(&job.settings)?;
        let backend = engine_name(&job.engine, diagnostics)?;
        let (identity, chosen) = (OnceCell::new(), OnceCell::new());
        let runner = Self { job, wanted, backend, shots: job.shots(), identity, chosen };
        runner.setup(&job.settings).check()?;
        Ok(runner)
    }

    fn is_single(&self) -> bool {
        self.shots.len() == 1
    }

    /// Returns what identifies a shot in a manifest. Files are read once.
    pub fn identity(&self, shot: &Shot) -> Result<Manifest, Error> {
        let settings = &self.job.settings;
        let of_job = match self.identity.get() {
            Some(of_job) => of_job,
            None => {
                let of_job = identity::of(&self.job.source, settings, &self.backend)?;
                self.identity.get_or_init(|| of_job)
            }
        };
        let frame = shot.frame.or_else(|| settings.scene.frames.and_then(|frames| frames.single()));
        Ok(identity::of_shot(of_job.clone(), settings, (frame, shot.pose())))
    }

    /// Renders the shots of a shard into their folders below `out`.
    pub fn run(&self, out: &Path, options: &RunOptions) -> Result<Vec<(Shot, ShotOutcome)>, Error> {
        let shots = &self.shots;
        let (of_shots, of_image) = if self.is_single() { (None, options.shard) } else { (options.shard, None) };
        self.check_shard(options.shard, of_image)?;
        self.check_root(out)?;
        if self.job.settings.output.write.contains(&Output::H5) {
            for shot in shots.iter().filter(|shot| shot.frame == shots[0].frame) {
                Self::frames_of(shot, out)?.iter().try_for_each(output::sequence::check)?;
            }
        }
        if !options.overwrite {
            for shot in shots {
                self.check_replaceable(shot, out, of_image)?;
            }
        }
        let Shard { part, of } = of_shots.unwrap_or(Shard { part: 1, of: 1 });
        let mine: Vec<&Shot> = shots.iter().skip(part - 1).step_by(of).collect();
        if mine.is_empty() {
            return Ok(Vec::new());
        }
        let mut outcomes = Vec::with_capacity(mine.len());
        let mut number = 0;
        // The shots of one frame share the scene.
        for group in mine.chunk_by(|a, b| a.frame == b.frame) {
            let settings = at_frame(self.chosen(options)?, group[0].frame);
            let setup = self.setup(&settings);
            let mut stage: Option<Stage> = None;
            let stage_of = |stage: &mut Option<Stage>| -> Result<(), Error> {
                if stage.is_none() {
                    *stage = Some(setup.stage(options.diagnostics)?);
                }
                Ok(())
            };
            let mut pending = Vec::new();
            for &shot in group {
                match self.kept(shot, out)? {
                    Ok(manifest) => pending.push((shot, Some(ShotOutcome::Kept(Box::new(manifest))), None)),
                    Err(why) => pending.push((shot, None, why)),
                }
            }
            if pending.iter().any(|(_, kept, _)| kept.is_none()) {
                stage_of(&mut stage)?;
            }
            let world = match &stage {
                Some(stage) => Some(stage.world(&self.job.source, &settings.light.sky, &self.job.engine)?),
                None => None,
            };
            for (shot, kept, why) in pending {
                (options.events)(Event::Begin(number, mine.len(), shot));
                let outcome = match (kept, &stage, &world) {
                    (Some(kept), ..) => kept,
                    (None, Some(stage), Some(world)) => {
                        if let Some(folder) = Self::frames_of(shot, out)? {
                            output::sequence::forget(&folder)?;
                        }
                        let inner = inner_name(&shot.folder())?;
                        let place = Place { root: out, inner, replaces: options.overwrite };
                        let mut report = self.shot(&setup, (stage, world), shot, &place, of_image, options)?;
                        report.files.iter_mut().for_each(|name| *name = shot.file(name));
                        ShotOutcome::Made(Box::new(report), why)
                    }
                    (None, ..) => return Err(Error::Failed("the scene of a shot was not loaded".into())),
                };
                (options.events)(Event::End(number, mine.len(), shot, &outcome));
                outcomes.push((shot.clone(), outcome));
                number += 1;
            }
        }
        self.finish(out)?;
        Ok(outcomes)
    }

    /// Renders one shot into the folder `inner` below `root`, unless the folder is up to date: for jobs whose folders have
    /// other names. Another image in it is replaced.
    pub fn run_shot(&self, shot: &Shot, root: &Path, inner: &Path, options: &RunOptions) -> Result<ShotOutcome, Error> {
        let inner = inner_name(inner)?;
        let why = match done(root, &inner, &self.identity(shot)?) {
            Ok(manifest) => return Ok(ShotOutcome::Kept(Box::new(manifest))),
            Err(why) => why,
        };
        let settings = at_frame(self.chosen(options)?, shot.frame);
        let setup = self.setup(&settings);
        let stage = setup.stage(options.diagnostics)?;
        let world = stage.world(&self.job.source, &settings.light.sky, &self.job.engine)?;
        let place = Place { root, inner, replaces: true };
        let report = self.shot(&setup, (&stage, &world), shot, &place, None, options)?;
        Ok(ShotOutcome::Made(Box::new(report), why))
    }

    /// Renders the only shot of a job into memory.
    pub fn render(&self, options: &RunOptions) -> Result<Rendering, Error> {
        let shots = &self.shots;
        let ([shot], false) = (&shots[..], matches!(self.job.settings.camera, Camera::Pinhole)) else {
            let count = shots.len();
            return Err(Error::BadRequest(format!(
                "the settings are of {count} images; render one at a time into memory, or all of them into a folder"
            )));
        };
        let setup = self.setup(&self.job.settings);
        let stage = setup.stage(options.diagnostics)?;
        let world = stage.world(&self.job.source, &self.job.settings.light.sky, &self.job.engine)?;
        let prepared = setup.prepare(&stage, &world, shot.pose, options.diagnostics)?;
        let start = Instant::now();
        let request = trace::request(&setup, &prepared, None)?;
        let (traced, warnings) = trace::trace(
            &setup,
            (&stage, &prepared, shot.pose),
            (&request, self.identity(shot)?),
            None,
            options.progress,
            options.diagnostics,
        )?;
        let exposure = self.job.settings.output.exposure;
        let exposure_ev = prepared.renderer.install(|| exposure_ev(exposure, &traced.rendered));
        let seconds = Seconds {
            load: stage.load_seconds,
            build: prepared.build_seconds,
            render: start.elapsed().as_secs_f64(),
            ..Seconds::default()
        };
        let Traced { rendered, camera, wanted, .. } = traced;
        let mut rendering = Rendering {
            rendered,
            visibility: None,
            motion: Vec::new(),
            raw_layers: Vec::new(),
            rig: None,
            camera: None,
            exposure_ev,
            seconds,
            warnings,
        };
        match camera {
            TracedCamera::Rig(views) => {
                rendering.rig = Some(views.rig);
                (rendering.visibility, rendering.motion) = (views.visibility, views.motion);
            }
            TracedCamera::Plenoptic { file, white } => {
                let rendered = &rendering.rendered;
                let of_camera = |layer| Some((layer, output::raw::raw_layer(&file.camera, layer, rendered, &white)?));
                rendering.raw_layers =
                    prepared.renderer.install(|| wanted.raw.iter().copied().filter_map(of_camera).collect());
                rendering.camera = Some(file);
            }
        }
        Ok(rendering)
    }

    pub(super) fn setup<'s>(&'s self, settings: &'s RenderSettings) -> Setup<'s> {
        let electrons = self.chosen.get().and_then(|chosen| chosen.electrons);
        Setup { source: &self.job.source, settings, wanted: &self.wanted, engine: &self.job.engine, electrons }
    }

    /// The settings with what is chosen by the first shot of several.
    fn chosen(&self, options: &RunOptions) -> Result<&RenderSettings, Error> {
        let shards_images = matches!(self.job.settings.camera, Camera::Pinhole) && options.shard.is_some();
        if self.is_single() && !shards_images {
            return Ok(&self.job.settings);
        }
        if let Some(chosen) = self.chosen.get() {
            return Ok(&chosen.settings);
        }
        let chosen = choices::choose(&self.setup(&self.job.settings), options.progress, options.diagnostics)?;
        Ok(&self.chosen.get_or_init(|| chosen).settings)
    }

    /// The manifest of a shot that is up to date, of several; otherwise why it is not.
    fn kept(&self, shot: &Shot, out: &Path) -> Result<Result<Manifest, Option<String>>, Error> {
        if self.is_single() {
            return Ok(Err(None));
        }
        Ok(done(out, &inner_name(&shot.folder())?, &self.identity(shot)?))
    }

    /// Checks that the folder of a shot holds no other image.
    fn check_replaceable(&self, shot: &Shot, out: &Path, of_image: Option<Shard>) -> Result<(), Error> {
        let inner = inner_name(&shot.folder())?;
        check_replaceable((out, &inner), || self.identity(shot), |older| merge::other(older, of_image))
    }

    /// Renders a shot into its folder.
    fn shot(
        &self,
        setup: &Setup,
        (stage, world): (&Stage, &World),
        shot: &Shot,
        place: &Place,
        shard: Option<Shard>,
        options: &RunOptions,
    ) -> Result<RenderReport, Error> {
        let start = Instant::now();
        let folder = OutputFolder::create_in(
            (place.root, &place.inner),
            options.overwrite,
            &options.rollback,
            options.diagnostics,
        )?;
        if !place.replaces {
            // Again, now that nobody else writes in it.
            let inside = (place.root, place.inner.as_str());
            check_replaceable(inside, || self.identity(shot), |older| merge::other(older, shard))?;
        }
        if matches!(setup.settings.camera, Camera::Pinhole) {
            let identity = self.identity(shot)?;
            return pinholes::render(self.job, (setup, identity), (stage, world), shot, (folder, shard), options);
        }
        let prepared = setup.prepare(stage, world, shot.pose, options.diagnostics)?;
        let rendering = Instant::now();
        let identity = engine::built_with(self.identity(shot)?, &prepared.renderer, options.diagnostics);
        let request = trace::request(setup, &prepared, shard)?;
        let keeper = self.keeper(folder.folder(), (stage, &prepared, &request), &identity, options.diagnostics);
        let traced = trace::trace(
            setup,
            (stage, &prepared, shot.pose),
            (&request, identity),
            keeper.as_ref(),
            options.progress,
            options.diagnostics,
        );
        let written = traced.and_then(|(traced, warnings)| {
            let mut report = self.write(setup, traced, (&prepared, &request), shard, folder, rendering)?;
            report.warnings = warnings;
            Ok(report)
        });
        if let Some(keeper) = keeper {
            keeper.report(written.is_err(), options.diagnostics);
            if written.is_ok() {
                keeper.remove();
            }
        }
        let mut report = written?;
        (report.pose, report.frame) = (shot.pose_name.clone(), shot.frame);
        report.seconds.load = stage.load_seconds;
        report.seconds.build = prepared.build_seconds;
        report.seconds.total = stage.load_seconds + start.elapsed().as_secs_f64();
        Ok(report)
    }

    /// The checkpoint of a shot. Tiles are kept of whole grids of views.
    fn keeper<'k>(
        &self,
        out: &Folder,
        (stage, prepared, request): (&'k Stage, &'k Prepared, &'k Request),
        identity: &Manifest,
        diagnostics: &dyn Diagnostics,
    ) -> Option<Keeper<'k>> {
        let has_subset = self.job.settings.camera.rig().is_some_and(|rig| rig.subset.is_some());
        let checkpoints = self.job.checkpoints.as_ref().filter(|_| !has_subset)?;
        let of = (&stage.loaded.scene, (&prepared.pose, request));
        Some(Keeper::open(checkpoints, out, of, identity, diagnostics))
    }

    /// Checks that the folder of several poses is not that of an image, to which its `transforms.json` belongs, and that
    /// this file is no list from elsewhere.
    fn check_root(&self, out: &Path) -> Result<(), Error> {
        if self.job.settings.poses.cameras().is_none() || self.owns_transforms() {
            return Ok(());
        }
        let Some(folder) = existing(out, "")? else { return Ok(()) };
        if folder.kind(MANIFEST_JSON)?.is_some() {
            return Err(Error::BadRequest(format!("{} holds an image itself; give another `out`", out.display())));
        }
        match folder.kind(TRANSFORMS)?.is_none() || output::poses::is_own(&folder) {
            true => Ok(()),
            false => Err(Error::BadRequest(format!(
                "{}: a file of this name will be written, and this one came from elsewhere; give another `out`",
                folder.path_of(TRANSFORMS).display()
            ))),
        }
    }

    /// Checks that a shard is one, and that an image can be divided.
    fn check_shard(&self, shard: Option<Shard>, of_image: Option<Shard>) -> Result<(), Error> {
        if let Some(Shard { part, of }) = shard.filter(|shard| !(1..=shard.of).contains(&shard.part)) {
            return Err(Error::BadRequest(format!("`shard {part}/{of}`: there is no such part; count from 1")));
        }
        if of_image.is_none() {
            return Ok(());
        }
        let bad = |what: &str| {
            Err(Error::BadRequest(format!("{what} is not rendered in parts; remove it, or render without `shard`")))
        };
        let settings = &self.job.settings;
        if let Some((name, _)) = FLOWS.into_iter().zip(self.wanted.flow).find(|(_, flow)| *flow) {
            return bad(&format!("`layers {name}`"));
        }
        if settings.camera.rig().is_some_and(|rig| rig.subset.is_some()) {
            return bad("`subset`");
        }
        match settings.output.write.contains(&Output::HciHighres) {
            true => bad("`write hci-highres`"),
            false => Ok(()),
        }
    }

    /// Writes the files of what was rendered since `rendering`.
    fn write(
        &self,
        setup: &Setup,
        mut traced: Traced,
        (prepared, request): (&Prepared, &Request),
        shard: Option<Shard>,
        folder: OutputFolder,
        rendering: Instant,
    ) -> Result<RenderReport, Error> {
        let renderer = &prepared.renderer;
        let rendered = &traced.rendered;
        let (rays, samples, integrator) = (rendered.rays, rendered.samples, rendered.integrator);
        let (why, rows) = (rendered.why.clone(), trace::rows(request, rendered));
        let camera = match &traced.camera {
            TracedCamera::Rig(views) => CameraReport::Rig { rig: views.rig, disparity_px: None },
            TracedCamera::Plenoptic { file, white } => {
                let size = file.camera.sensor().size;
                let rows = if rows.is_empty() { 0..size.rows } else { rows };
                let lit = white.slice_axis(Axis(0), rows.clone().into()).iter().filter(|&&light| light > 0.0).count();
                let lit_share = lit as f64 / (rows.len() * size.columns) as f64;
                let (name, lenses) = (file.name.clone(), file.camera.lens_count());
                CameraReport::Plenoptic { name, size, lenses, rows, lit_share }
            }
        };
        let ev = match shard {
            // The exposure depends on the complete image.
            Some(_) => None,
            None => renderer.install(|| exposure_ev(setup.settings.output.exposure, rendered)),
        };
        traced.manifest.libraries = engine::libraries(renderer);
        let exposed = Exposed { ev, electrons: setup.electrons };
        let (render, writing) = (rendering.elapsed().as_secs_f64(), Instant::now());
        let Finished { disparity_px, statistics, files } = renderer.install(|| match shard {
            Some(shard) => merge::write(traced, shard, folder),
            None => output::write(setup.settings, traced, exposed, folder),
        })?;
        let (camera, pixels) = match camera {
            CameraReport::Rig { rig, .. } => {
                let shape = rig.shape();
                let pixels = shape.views().count() as u64 * shape.lenses().count() as u64;
                (CameraReport::Rig { rig, disparity_px }, pixels)
            }
            other => (other, samples),
        };
        Ok(RenderReport {
            seconds: Seconds { render, write: writing.elapsed().as_secs_f64(), ..Seconds::default() },
            rays,
            samples: if integrator == holo_render::Integrator::Depth { pixels } else { samples },
            backend: renderer.engine_name().to_owned(),
            threads: renderer.threads(),
            integrator,
            why,
            camera,
            pose: None,
            frame: None,
            statistics,
            files,
            warnings: Vec::new(),
        })
    }

    /// The folder of all frames of a pose below `out`.
    fn sequence(shot: &Shot, out: &Path) -> PathBuf {
        shot.pose().map_or_else(|| out.to_owned(), |pose| out.join(pose))
    }

    /// The same folder, if it is there and the shot is one of several frames.
    fn frames_of(shot: &Shot, out: &Path) -> Result<Option<Folder>, Error> {
        if shot.frame.is_some() { existing(out, shot.pose().unwrap_or("")) } else { Ok(None) }
    }

    /// Writes the files of all shots: the poses, and the light fields of all frames as one array, if HDF5 files are wanted
    /// and all frames are there; of several parts the one that ends last.
    fn finish(&self, out: &Path) -> Result<(), Error> {
        let shots = &self.shots;
        if let (Poses::Array { cameras, up }, false) = (&self.job.settings.poses, self.owns_transforms()) {
            output::poses::write(&Folder::open(out)?, cameras, *up, self.job.settings.camera.size())?;
        }
        if !self.job.settings.output.write.contains(&Output::H5) || shots.iter().any(|shot| shot.frame.is_none()) {
            return Ok(());
        }
        for first in shots.iter().filter(|shot| shot.frame == shots[0].frame) {
            let of_pose: Vec<&Shot> = shots.iter().filter(|shot| shot.pose == first.pose).collect();
            let is_there = |shot: &&Shot| -> Result<bool, Error> {
                let Ok(Some(folder)) = existing(out, &inner_name(&shot.folder())?) else { return Ok(false) };
                let Ok(manifest) = Manifest::read_in(&folder) else { return Ok(false) };
                Ok(difference(&manifest, &self.identity(shot)?).is_none())
            };
            let mut all = true;
            for shot in &of_pose {
                all &= is_there(shot)?;
            }
            if all {
                let frames: Vec<u32> = of_pose.iter().filter_map(|shot| shot.frame).collect();
                output::sequence::write(&Self::sequence(first, out), &frames)?;
            }
        }
        Ok(())
    }

    /// Whether `transforms.json` belongs to the folder of a shot.
    fn owns_transforms(&self) -> bool {
        matches!(self.job.settings.camera, Camera::Pinhole)
    }
}

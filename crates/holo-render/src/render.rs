//! The renderer: a scene in front of a camera, ready to be looked at through any rig.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use holo_core::{GridSize, Layout, LightField, LightFieldOwned, Rig, Split};
use ndarray::{Array2, Axis};
use rayon::prelude::*;

use crate::accel::holes::{Cover, Holes};
use crate::accel::{self, Backend, Engine};
use crate::appearance::{Appearance, Kinds};
use crate::dispatch;
use crate::emitters::Emitters;
use crate::environment::Surroundings;
use crate::error::Error;
use crate::geometry::{Geometry, LARGEST_COORDINATE};
use crate::integrator::auto::{self, Contents};
use crate::integrator::depth::{DepthTile, TruthTile};
use crate::integrator::direct;
use crate::integrator::path::PathTile;
use crate::integrator::{Context, Integrator, RayCounts};
use crate::light::{self, PreparedLight, STRONGEST};
use crate::primary::RigTables;
use crate::sampling::MOST_SAMPLES;
use crate::scene::{self, Scene, Transform};
use crate::tile::{Tile, Tiling};

/// Scattering events at most: far more than any scene needs, far less than the purposes of random numbers.
const MOST_BOUNCES: u32 = 65_536;

/// A scene with its acceleration structure, in the frame of one camera.
pub struct Renderer {
    /// What light meets.
    engine: Arc<dyn Engine>,
    /// What the ground truth meets: the same unless surfaces have holes.
    truth_engine: Arc<dyn Engine>,
    note: Option<String>,
    geometry: Arc<Geometry>,
    appearance: Arc<Appearance>,
    lights: Vec<PreparedLight>,
    emitters: Option<Emitters>,
    surroundings: Option<Surroundings>,
    pool: rayon::ThreadPool,
}

/// What to render.
#[derive(Clone, Debug)]
pub struct Request {
    /// The cameras.
    pub rig: Rig,
    /// How light is modelled.
    pub integrator: Integrator,
    /// Rays through every pixel: 1 goes through its centre, more are spread over it (a box filter).
    pub samples: u32,
    /// Chooses the random numbers.
    pub seed: u64,
    /// Radiance of the constant sky, linear RGB.
    pub sky: [f32; 3],
    /// Scattering events at most, for the integrator `Path` and for `Auto` when it chooses that.
    pub max_bounces: u32,
    /// Whether paths that carry little may end at random, those that survive counting for more (unbiased).
    pub roulette: bool,
    /// Relative standard error per pixel at which it needs no more samples; `samples` are the most it gets then.
    pub target_error: Option<f64>,
    /// Whether the views of a block of 4 x 4 draw the same random directions: faster, because their rays stay together,
    /// but their noise is alike then, which looks like a texture at the focus plane.
    pub shared_noise: bool,
    /// Whether `Auto` follows light from surface to surface; without, only to mirrors and glass.
    pub indirect: bool,
    /// For which views depth and disparity are wanted; always through the pixel's centre, whatever `samples` is.
    pub ground_truth: GroundTruth,
}

impl Request {
    /// Everything as the command line has it by default, with one sample and without a sky.
    #[must_use]
    pub fn new(rig: Rig) -> Self {
        Self {
            rig,
            integrator: Integrator::Auto,
            samples: 1,
            seed: 0,
            sky: [0.0; 3],
            max_bounces: 8,
            roulette: true,
            target_error: None,
            shared_noise: false,
            indirect: true,
            ground_truth: GroundTruth::Central,
        }
    }
}

/// For which views ground truth is made.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum GroundTruth {
    /// The central view.
    #[default]
    Central,
    /// Every view (the central one as well).
    All,
}

/// What was rendered. Light fields lie in memory as elemental grids.
#[derive(Debug)]
pub struct Rendered {
    /// Linear RGB radiance; `None` from the integrator `Depth`.
    pub color: Option<LightFieldOwned<f32>>,
    /// Depth and disparity of the central view, axes (v, u).
    pub central: Truth<Array2<f32>>,
    /// Depth and disparity of all views, one channel, if they were asked for.
    pub all: Option<Truth<LightFieldOwned<f32>>>,
    /// The integrator used.
    pub integrator: Integrator,
    /// Why it was.
    pub why: String,
    /// How many rays it took, ground truth included.
    pub rays: RayCounts,
    /// How many samples the picture took: views x lenses x samples unless there was a target error.
    pub samples: u64,
}

/// Ground truth in two units.
#[derive(Clone, Debug, PartialEq)]
pub struct Truth<T> {
    /// Planar depth along the optical axis, m; +infinity where nothing is hit.
    pub depth_m: T,
    /// Disparity between horizontally adjacent views (Eq. 3), px; nearer is larger. Where the baselines differ, the one
    /// between vertically adjacent views is [`Rig::disparity_y`] of the depth.
    pub disparity_px: T,
}

/// How a caller follows a render and stops it.
pub trait Progress: Sync {
    /// `done` of `total` units of work are finished. Called from any thread.
    fn advance(&self, done: u64, total: u64) {
        let _ = (done, total);
    }

    /// Asked often; once it says yes the render ends with [`Error::Cancelled`].
    fn cancelled(&self) -> bool {
        false
    }
}

impl Progress for () {}

impl Renderer {
    /// Checks `scene`, moves it into the frame of a camera at `pose` and builds the acceleration structure, on `threads`
    /// threads (0: as many as rayon chooses, one per core).
    ///
    /// # Errors
    /// A broken scene, an engine that cannot be had, threads that cannot be started.
    pub fn new(scene: &Scene, pose: &Transform, backend: Backend, threads: usize) -> Result<Self, Error> {
        scene.validate()?;
        if !scene::is_camera_pose(pose) {
            return Err(Error::BadSetting("the camera pose must be a rotation and a translation, both finite".into()));
        }
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .map_err(|e| Error::BadSetting(format!("{threads} threads cannot be started: {e}")))?;
        let (geometry, built) = pool.install(|| {
            let geometry = Arc::new(Geometry::build(scene, pose)?);
            let built = accel::build(backend, &geometry, pool.current_num_threads())?;
            Ok::<_, Error>((geometry, built))
        })?;
        let (engine, note) = built;
        let appearance = Arc::new(Appearance::new(&scene.materials, &scene.textures));
        let engine: Arc<dyn Engine> = Arc::from(engine);
        let [engine, truth_engine] = [Cover::Random, Cover::Half].map(|cover| {
            let inner = Arc::clone(&engine);
            if !appearance.kinds().has(Kinds::HOLES) {
                return inner;
            }
            Arc::new(Holes { inner, geometry: Arc::clone(&geometry), appearance: Arc::clone(&appearance), cover })
        });
        let lights = light::prepare(&scene.lights, pose);
        let emitters = Emitters::build(&geometry, &scene.materials, &scene.textures);
        let surroundings = scene.environment.as_ref().map(|environment| Surroundings::new(environment, pose));
        let surroundings = surroundings.filter(|surroundings| !surroundings.is_black());
        Ok(Self { engine, truth_engine, note, geometry, appearance, lights, emitters, surroundings, pool })
    }

    /// The engine and its version, such as "embree 4.4.0" or "bvh".
    #[must_use]
    pub fn engine_name(&self) -> &str {
        self.engine.name()
    }

    /// Why the engine is not the one that is usually best.
    #[must_use]
    pub fn engine_note(&self) -> Option<&str> {
        self.note.as_deref()
    }

    /// Threads that this renderer uses.
    #[must_use]
    pub fn threads(&self) -> usize {
        self.pool.current_num_threads()
    }

    #[cfg(feature = "bench")]
    pub(crate) fn engine(&self) -> &dyn Engine {
        &*self.engine
    }

    /// Runs `work` on this renderer's threads.
    pub fn install<R: Send>(&self, work: impl FnOnce() -> R + Send) -> R {
        self.pool.install(work)
    }

    /// Renders. The result depends on nothing but the scene, the pose and `request`: not on threads or their timing.
    ///
    /// # Errors
    /// Impossible settings, memory that cannot be had, [`Error::Cancelled`].
    pub fn render(&self, request: &Request, progress: &dyn Progress) -> Result<Rendered, Error> {
        self.pool.install(|| self.render_here(request, progress))
    }

    /// Depth and disparity of the central view alone.
    ///
    /// # Errors
    /// As [`Renderer::render`].
    pub fn central_truth(&self, rig: &Rig) -> Result<Truth<Array2<f32>>, Error> {
        let request = Request { integrator: Integrator::Depth, ..Request::new(*rig) };
        Ok(self.render(&request, &())?.central)
    }

    fn render_here(&self, request: &Request, progress: &dyn Progress) -> Result<Rendered, Error> {
        let (integrator, why) = self.choose(request)?;
        let split = *request.rig.split();
        let (lenses, views) = (split.lenses(), split.views());
        let all_counts = [lenses.rows, lenses.columns, views.rows, views.columns];
        let stop = Stop::new(progress);
        let with_color = integrator != Integrator::Depth;
        let with_all = request.ground_truth == GroundTruth::All;
        // One sample through the centre sees what the ground truth asks for, unless it may pass by chance.
        let has_holes = self.appearance.kinds().has(Kinds::HOLES);
        let together = with_color && with_all && request.samples == 1 && !has_holes;

        let tiling = Tiling::new(all_counts);
        // The large arrays first: a size that does not fit is refused before anything else is made for it.
        let mut color = if with_color { Some(zeros(split, 3)?) } else { None };
        let mut all = if with_all { Some(Truth::light_fields(split)?) } else { None };
        let tile_count = if with_color || with_all { tiling.tiles().len() } else { 0 };
        let passes = u64::from(with_color) + u64::from(with_all && !together);
        let context = self.context(request, integrator, &tiling, &stop);
        let truth_context = self.context(request, Integrator::Depth, &tiling, &stop);
        let with_central = u64::from(!with_all);
        let central_tiles = with_central * central_tiling(&split).tiles().len() as u64;
        let work = Work::new(progress, &stop, passes * tile_count as u64 + central_tiles);
        let mut rays = RayCounts::default();
        let mut samples = 0;

        if let Some(color) = &mut color {
            let truth = if together { all.as_mut() } else { None };
            let truth: Vec<Option<TruthTile>> = match truth {
                Some(truth) => truth.tiles(&tiling).into_iter().map(Some).collect(),
                None => std::iter::repeat_with(|| None).take(tile_count).collect(),
            };
            let parts: Vec<_> = tiling.cut(color.samples_mut()).into_iter().zip(truth).collect();
            rays = rays
                + work.run(&tiling, parts, |tile, (color, truth)| {
                    dispatch::run(PathTile { context: &context, tile, color, truth })
                })?;
            // Every sample has one ray from the camera.
            samples = rays.primary;
        }
        if let Some(all) = all.as_mut().filter(|_| !together) {
            rays = rays
                + work.run(&tiling, all.tiles(&tiling), |tile, out| {
                    dispatch::run(DepthTile { context: &truth_context, tile, out })
                })?;
        }
        let central = if let Some(all) = &all {
            let (t, s) = split.central_view();
            let plane = |field: &LightFieldOwned<f32>| field.samples().slice(ndarray::s![.., .., t, s, 0]).to_owned();
            Truth { depth_m: plane(&all.depth_m), disparity_px: plane(&all.disparity_px) }
        } else {
            let tiling = central_tiling(&split);
            let (central, count) =
                central(&self.context(request, Integrator::Depth, &tiling, &stop), &tiling, &work, split.lenses())?;
            rays = rays + count;
            central
        };
        if stop.requested() {
            return Err(Error::Cancelled);
        }
        Ok(Rendered { color, central, all, integrator, why, rays, samples })
    }

    /// What the integrators read over the packets of `tiling`.
    fn context<'a>(
        &'a self,
        request: &Request,
        integrator: Integrator,
        tiling: &Tiling,
        stop: &'a Stop<'a>,
    ) -> Context<'a> {
        let split = request.rig.split();
        Context {
            engine: if integrator == Integrator::Depth { &*self.truth_engine } else { &*self.engine },
            geometry: &self.geometry,
            appearance: &self.appearance,
            lights: &self.lights,
            sky: request.sky,
            tables: RigTables::new(&request.rig, tiling),
            disparity: request.rig.disparity(),
            seed: request.seed,
            samples: request.samples,
            max_bounces: if integrator == Integrator::Direct { direct::BOUNCES } else { request.max_bounces },
            roulette: request.roulette,
            target_error: request.target_error,
            shared_noise: request.shared_noise,
            indirect: integrator == Integrator::Direct || request.indirect,
            emitters: self.emitters.as_ref(),
            surroundings: self.surroundings.as_ref(),
            has_discs: self.lights.iter().any(PreparedLight::is_disc),
            has_holes: self.appearance.kinds().has(Kinds::HOLES),
            has_glow: self.appearance.kinds().has(Kinds::GLOWS.and(Kinds::UNLIT)),
            columns: [split.lenses().columns as u32, split.views().columns as u32],
            stop,
        }
    }

    fn choose(&self, request: &Request) -> Result<(Integrator, String), Error> {
        let split = request.rig.split();
        if !(1..=MOST_SAMPLES).contains(&request.samples) {
            return Err(Error::BadSetting(format!(
                "{} samples per pixel; 1 to {MOST_SAMPLES} can be drawn",
                request.samples
            )));
        }
        if request.target_error.is_some_and(|target| !(target > 0.0 && target.is_finite())) {
            return Err(Error::BadSetting("the target error must be finite and above 0".into()));
        }
        if !(1..=MOST_BOUNCES).contains(&request.max_bounces) {
            let asked = request.max_bounces;
            return Err(Error::BadSetting(format!("{asked} bounces; 1 to {MOST_BOUNCES} can be followed")));
        }
        if split.lenses().count() > u32::MAX as usize || split.views().count() > u32::MAX as usize {
            return Err(Error::BadSetting("2^32 or more lenses or views".into()));
        }
        if request.sky.iter().any(|c| !(0.0..=STRONGEST).contains(c)) {
            return Err(Error::BadSetting(format!("the sky {:?} must lie between 0 and {STRONGEST:e}", request.sky)));
        }
        // Rays are linear in all indices: what the corners are, no ray between them exceeds.
        let (lenses, views) = (split.lenses(), split.views());
        for (v, u) in [(0, 0), (lenses.rows - 1, lenses.columns - 1)] {
            for (t, s) in [(0, 0), (views.rows - 1, views.columns - 1)] {
                let ray = request.rig.ray(v, u, t, s, 0.5, 0.5);
                if !ray.origin_m.iter().chain(&ray.direction).all(|x| x.abs() < LARGEST_COORDINATE) {
                    return Err(Error::BadSetting(format!(
                        "the rig is too large: a ray starts at {:?} m and runs along {:?}; choose a smaller baseline or sensor",
                        ray.origin_m, ray.direction
                    )));
                }
            }
        }
        Ok(match request.integrator {
            Integrator::Auto => auto::choose(&self.contents(request), request.indirect),
            chosen => (chosen, "asked for".into()),
        })
    }

    /// What decides which integrator the scene needs.
    fn contents(&self, request: &Request) -> Contents {
        let kinds = self.appearance.kinds();
        let discs = self.lights.iter().filter(|light| light.is_disc()).count();
        Contents {
            punctual_lights: self.lights.len() - discs,
            discs,
            emitters: self.emitters.is_some(),
            sky: request.sky.iter().any(|&c| c > 0.0),
            surroundings: self.surroundings.is_some(),
            glossy: kinds.has(Kinds::GLOSSY),
            unlit: kinds.has(Kinds::UNLIT),
            all_unlit: self.appearance.is_all_unlit(),
        }
    }
}

impl Truth<LightFieldOwned<f32>> {
    fn light_fields(split: Split) -> Result<Self, Error> {
        Ok(Self { depth_m: zeros(split, 1)?, disparity_px: zeros(split, 1)? })
    }

    fn tiles(&mut self, tiling: &Tiling) -> Vec<TruthTile<'_>> {
        let depth = tiling.cut(self.depth_m.samples_mut());
        let disparity = tiling.cut(self.disparity_px.samples_mut());
        depth.into_iter().zip(disparity).map(|(depth_m, disparity_px)| TruthTile { depth_m, disparity_px }).collect()
    }
}

/// A light field of zeros whose memory is an elemental grid.
fn zeros(split: Split, channels: usize) -> Result<LightFieldOwned<f32>, Error> {
    Ok(LightField::filled(split, channels, Layout::ElementalGrid, 0.0)?)
}

/// Ground truth of the central view.
fn central(
    context: &Context,
    tiling: &Tiling,
    work: &Work,
    lenses: GridSize,
) -> Result<(Truth<Array2<f32>>, RayCounts), Error> {
    let mut truth = Truth::light_fields(Split::new(GridSize::new(1, 1), lenses)?)?;
    let trace = |tile: &Tile, out| dispatch::run(DepthTile { context, tile, out });
    let rays = work.run(tiling, truth.tiles(tiling), trace)?;
    let plane = |field: LightFieldOwned<f32>| {
        let image = field.into_elemental_grid().unwrap_or_else(|field| field.to_elemental_grid());
        image.index_axis_move(Axis(2), 0)
    };
    Ok((Truth { depth_m: plane(truth.depth_m), disparity_px: plane(truth.disparity_px) }, rays))
}

fn central_tiling(split: &Split) -> Tiling {
    let (lenses, (t, s)) = (split.lenses(), split.central_view());
    Tiling::of_view([lenses.rows, lenses.columns], [t, s])
}

/// Asks the caller whether to stop, and remembers a yes: what was skipped once is missing for good.
pub(crate) struct Stop<'a> {
    progress: &'a dyn Progress,
    seen: AtomicBool,
}

impl<'a> Stop<'a> {
    fn new(progress: &'a dyn Progress) -> Self {
        Self { progress, seen: AtomicBool::new(false) }
    }

    pub fn requested(&self) -> bool {
        if self.progress.cancelled() {
            self.seen.store(true, Ordering::Relaxed);
        }
        self.seen.load(Ordering::Relaxed)
    }
}

/// Tiles on all threads, with progress and a way to stop.
struct Work<'a> {
    progress: &'a dyn Progress,
    stop: &'a Stop<'a>,
    total: u64,
    done: AtomicU64,
}

impl<'a> Work<'a> {
    fn new(progress: &'a dyn Progress, stop: &'a Stop<'a>, total: u64) -> Self {
        Self { progress, stop, total, done: AtomicU64::new(0) }
    }

    fn run<P: Send>(
        &self,
        tiling: &Tiling,
        parts: Vec<P>,
        trace: impl Fn(&Tile, P) -> RayCounts + Sync,
    ) -> Result<RayCounts, Error> {
        let tiles = tiling.tiles();
        debug_assert_eq!(tiles.len(), parts.len());
        tiles
            .par_iter()
            .zip(parts)
            .map(|(tile, part)| {
                if self.stop.requested() {
                    return Err(Error::Cancelled);
                }
                let rays = trace(tile, part);
                let done = self.done.fetch_add(1, Ordering::Relaxed) + 1;
                self.progress.advance(done, self.total);
                Ok(rays)
            })
            .try_reduce(RayCounts::default, |a, b| Ok(a + b))
    }
}

#[cfg(test)]
mod tests;

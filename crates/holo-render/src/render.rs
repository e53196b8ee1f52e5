//! The renderer: a scene in front of a camera, ready to be looked at through any rig.

use std::ops::Range;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use holo_core::{GridSize, Layout, LightField, LightFieldOwned, Rig, Split};
use ndarray::Array3;
use rayon::prelude::*;

use crate::accel::holes::{Cover, Holes};
use crate::accel::{self, Backend, Engine};
use crate::appearance::{Appearance, Kinds};
use crate::dispatch;
use crate::emitters::Emitters;
use crate::environment::Surroundings;
use crate::error::Error;
use crate::geometry::{Geometry, Instancing, LARGEST_COORDINATE};
use crate::integrator::auto::{self, Contents};
use crate::integrator::depth::DepthTile;
use crate::integrator::direct;
use crate::integrator::path::{self, PathTile};
use crate::integrator::truth::TruthTile;
use crate::integrator::{Context, Integrator, RayCounts};
use crate::layers::{Layer, LayerSet, Layers};
use crate::light::{self, PreparedLight, STRONGEST};
use crate::primary::RigTables;
use crate::sampling::MOST_SAMPLES;
use crate::tile::{Tile, Tiling};
use holo_scene::{Scene, Transform};

/// Scattering events at most: far more than any scene needs, far less than the purposes of random numbers.
const MOST_BOUNCES: u32 = 65_536;

/// The largest number up to which f32 holds all whole ones: 2^24.
const MOST_NUMBERED: usize = 1 << 24;

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
    /// The camera's axes (right, up, back) in the world.
    to_world: [[f64; 3]; 3],
    /// Instances and materials of the scene.
    counts: [usize; 2],
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
    /// Whether `Auto` follows light from surface to surface; without, only to mirrors and glass.
    pub indirect: bool,
    /// Which layers are wanted beside colour; always of what the ray through the pixel's centre meets first, whatever
    /// `samples` is.
    pub layers: LayerSet,
    /// For which views they are wanted.
    pub ground_truth: GroundTruth,
    /// The rows of lenses that are wanted; `None`: all. They come out as they would within the whole if they are such as
    /// [`Renderer::part_of_lens_rows`] gives.
    pub lens_rows: Option<Range<usize>>,
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
            indirect: true,
            layers: DEPTH_AND_DISPARITY,
            ground_truth: GroundTruth::Central,
            lens_rows: None,
        }
    }
}

/// What nearly everybody wants.
const DEPTH_AND_DISPARITY: LayerSet = LayerSet::of(&[Layer::Depth, Layer::Disparity]);

/// For which views ground truth is made.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum GroundTruth {
    /// The central view.
    #[default]
    Central,
    /// Every view (the central one as well).
    All,
}

/// What was rendered. Light fields lie in memory as elemental grids; all arrays have the lens rows that were asked for.
#[derive(Debug)]
pub struct Rendered {
    /// Linear RGB radiance; `None` from the integrator `Depth`.
    pub color: Option<LightFieldOwned<f32>>,
    /// The layers of the central view, axes (v, u, c).
    pub central: Layers<Array3<f32>>,
    /// The layers of all views, if they were asked for.
    pub all: Option<Layers<LightFieldOwned<f32>>>,
    /// The integrator used.
    pub integrator: Integrator,
    /// Why it was.
    pub why: String,
    /// How many rays it took, ground truth included.
    pub rays: RayCounts,
    /// How many samples the picture took: views x lenses x samples unless there was a target error.
    pub samples: u64,
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
        Self::with_instancing(scene, pose, backend, threads, accel::instancing(backend))
    }

    /// As `new`; `instancing` must be something that the engine knows.
    pub(crate) fn with_instancing(
        scene: &Scene,
        pose: &Transform,
        backend: Backend,
        threads: usize,
        instancing: Instancing,
    ) -> Result<Self, Error> {
        scene.validate()?;
        if !pose.is_pose() {
            return Err(Error::BadSetting("the camera pose must be a rotation and a translation, both finite".into()));
        }
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .map_err(|e| Error::BadSetting(format!("{threads} threads cannot be started: {e}")))?;
        let (geometry, built) = pool.install(|| {
            let geometry = Arc::new(Geometry::build(scene, pose, instancing)?);
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
        let counts = [scene.instances.len(), scene.materials.len()];
        let to_world = pose.columns;
        Ok(Self {
            engine,
            truth_engine,
            note,
            geometry,
            appearance,
            lights,
            emitters,
            surroundings,
            to_world,
            counts,
            pool,
        })
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

    /// The lens rows of part `part` (from 0) of `of`, such that the parts of a request come out byte for byte as the whole.
    ///
    /// Parts are about equally high; the cuts lie between tiles. What the request says of lens rows does not matter.
    ///
    /// # Errors
    /// Impossible settings; more parts than there are rows of tiles.
    pub fn part_of_lens_rows(&self, request: &Request, part: usize, of: usize) -> Result<Range<usize>, Error> {
        let (integrator, _) = self.choose(request)?;
        let step = Tilings::new(request, integrator).row_step();
        let rows = request.rig.split().lenses().rows;
        let most = rows.div_ceil(step);
        if part >= of || of > most {
            return Err(Error::BadSetting(format!(
                "part {} of {of}: this picture of {rows} rows of lenses can be cut into 1 to {most} parts",
                part + 1
            )));
        }
        let cut = |part: usize| (most * part / of * step).min(rows);
        Ok(cut(part)..cut(part + 1))
    }

    /// Layers of the central view alone, axes (v, u, c).
    ///
    /// # Errors
    /// As [`Renderer::render`].
    pub fn central_layers(&self, rig: &Rig, layers: LayerSet) -> Result<Layers<Array3<f32>>, Error> {
        let request = Request { integrator: Integrator::Depth, layers, ..Request::new(*rig) };
        Ok(self.render(&request, &())?.central)
    }

    /// Depth and disparity of the central view alone.
    ///
    /// # Errors
    /// As [`Renderer::render`].
    pub fn central_truth(&self, rig: &Rig) -> Result<Layers<Array3<f32>>, Error> {
        self.central_layers(rig, DEPTH_AND_DISPARITY)
    }

    fn render_here(&self, request: &Request, progress: &dyn Progress) -> Result<Rendered, Error> {
        let (integrator, why) = self.choose(request)?;
        let tilings = Tilings::new(request, integrator);
        let whole = *request.rig.split();
        let rows = request.lens_rows.clone().unwrap_or(0..whole.lenses().rows);
        if rows.is_empty() || rows.end > whole.lenses().rows {
            let count = whole.lenses().rows;
            return Err(Error::BadSetting(format!("lens rows {rows:?} are not some of the {count} that there are")));
        }
        let split = Split::new(whole.views(), GridSize::new(rows.len(), whole.lenses().columns))?;
        let Tilings { color: color_tiling, all: all_tiling, central: central_tiling } = tilings.lens_rows(&rows);
        let stop = Stop::new(progress);
        let with_color = integrator != Integrator::Depth;
        let with_layers = !request.layers.is_empty();
        let with_all = request.ground_truth == GroundTruth::All && with_layers;

        // The large arrays first: a size that does not fit is refused before anything else is made for it.
        let mut color = if with_color { Some(zeros(split, 3)?) } else { None };
        let mut all = if with_all { Some(light_fields(split, request.layers)?) } else { None };
        let tile_count = |wanted: bool, tiling: &Tiling| if wanted { tiling.tiles().len() as u64 } else { 0 };
        let total = tile_count(with_color, &color_tiling)
            + tile_count(with_all, &all_tiling)
            + tile_count(with_layers && !with_all, &central_tiling);
        let work = Work::new(progress, &stop, total);
        let mut rays = RayCounts::default();
        let mut samples = 0;

        if let Some(color) = &mut color {
            let context = self.context(request, integrator, &color_tiling, &stop);
            let parts = color_tiling.cut(color.samples_mut());
            rays = work
                .run(&color_tiling, parts, |tile, color| dispatch::run(PathTile { context: &context, tile, color }))?;
            // Every sample has one ray from the camera.
            samples = rays.primary;
        }
        // The ground truth has rays of its own, through the pixels' centres, however many samples colour takes.
        if let Some(all) = &mut all {
            let context = self.context(request, Integrator::Depth, &all_tiling, &stop);
            rays = rays
                + work.run(&all_tiling, tiles(all, &all_tiling), |tile, out| {
                    dispatch::run(DepthTile { context: &context, tile, out })
                })?;
        }
        let central = if let Some(all) = &all {
            let (t, s) = whole.central_view();
            all.iter().map(|(layer, field)| Ok((layer, field.view(t, s)?.to_owned()))).collect::<Result<_, Error>>()?
        } else if with_layers {
            let context = self.context(request, Integrator::Depth, &central_tiling, &stop);
            let (central, count) = central(&context, &central_tiling, &work, split.lenses(), request.layers)?;
            rays = rays + count;
            central
        } else {
            Layers::default()
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
            to_world: self.to_world,
            seed: request.seed,
            samples: request.samples,
            max_bounces: bounces(request, integrator),
            roulette: request.roulette,
            target_error: request.target_error,
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
        for (layer, what, count) in
            [(Layer::ObjectId, "instances", self.counts[0]), (Layer::MaterialId, "materials", self.counts[1])]
        {
            if request.layers.contains(layer) && count > MOST_NUMBERED {
                return Err(Error::BadSetting(format!(
                    "the layer '{layer}' numbers at most {MOST_NUMBERED} {what}; the scene has {count}: leave it out"
                )));
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

/// Light fields for `layers`.
fn light_fields(split: Split, layers: LayerSet) -> Result<Layers<LightFieldOwned<f32>>, Error> {
    layers.iter().map(|layer| Ok((layer, zeros(split, layer.channels())?))).collect()
}

/// All layers cut into the same tiles.
fn tiles<'a>(fields: &'a mut Layers<LightFieldOwned<f32>>, tiling: &Tiling) -> Vec<TruthTile<'a>> {
    let mut tiles = Vec::new();
    for (layer, field) in fields.iter_mut() {
        let parts = tiling.cut(field.samples_mut());
        tiles.resize_with(parts.len(), TruthTile::default);
        tiles.iter_mut().zip(parts).for_each(|(tile, part)| tile.extend([(layer, part)]));
    }
    tiles
}

/// A light field of zeros whose memory is an elemental grid.
fn zeros(split: Split, channels: usize) -> Result<LightFieldOwned<f32>, Error> {
    Ok(LightField::filled(split, channels, Layout::ElementalGrid, 0.0)?)
}

/// Layers of the central view.
fn central(
    context: &Context,
    tiling: &Tiling,
    work: &Work,
    lenses: GridSize,
    layers: LayerSet,
) -> Result<(Layers<Array3<f32>>, RayCounts), Error> {
    let mut fields = light_fields(Split::new(GridSize::new(1, 1), lenses)?, layers)?;
    let trace = |tile: &Tile, out| dispatch::run(DepthTile { context, tile, out });
    let rays = work.run(tiling, tiles(&mut fields, tiling), trace)?;
    let image = |field: LightFieldOwned<f32>| field.into_elemental_grid().unwrap_or_else(|f| f.to_elemental_grid());
    Ok((fields.into_iter().map(|(layer, field)| (layer, image(field))).collect(), rays))
}

/// Scattering events that the integrator follows.
fn bounces(request: &Request, integrator: Integrator) -> u32 {
    if integrator == Integrator::Direct { direct::BOUNCES } else { request.max_bounces }
}

/// How the light field is cut for the picture, for layers of all views, and for those of the central one.
struct Tilings {
    color: Tiling,
    all: Tiling,
    central: Tiling,
}

impl Tilings {
    fn new(request: &Request, integrator: Integrator) -> Self {
        let split = request.rig.split();
        let (lenses, views) = (split.lenses(), split.views());
        let counts = [lenses.rows, lenses.columns, views.rows, views.columns];
        let (t, s) = split.central_view();
        Self {
            color: Tiling::with_tiles_of(counts, path::tile_pixels(request.samples, bounces(request, integrator))),
            all: Tiling::new(counts),
            central: Tiling::of_view([lenses.rows, lenses.columns], [t, s]),
        }
    }

    fn lens_rows(&self, rows: &Range<usize>) -> Self {
        let [color, all, central] = [self.color, self.all, self.central].map(|tiling| tiling.lens_rows(rows.clone()));
        Self { color, all, central }
    }

    /// Lens rows between which nothing changes if the rest is rendered elsewhere: scattered rays are sorted and traced tile
    /// by tile, ground truth packet by packet.
    fn row_step(&self) -> usize {
        let steps = [self.color.tile_rows(), self.all.packet_rows(), self.central.packet_rows()];
        steps.into_iter().fold(1, least_common_multiple)
    }
}

fn least_common_multiple(a: usize, b: usize) -> usize {
    let (mut x, mut y) = (a, b);
    while y != 0 {
        (x, y) = (y, x % y);
    }
    a / x * b
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
mod instancing_tests;
#[cfg(test)]
mod tests;

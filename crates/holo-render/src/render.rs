//! The renderer: a scene in front of a camera, ready to be looked at through any rig.

mod image;
mod plan;
mod request;
mod work;

use std::ops::Range;
use std::sync::Arc;

use holo_core::{Projection, Rig};
use holo_scene::{Scene, Transform};
use ndarray::Array3;

pub use self::request::{GroundTruth, Rendered, Request, Views};

use self::plan::{Plan, Region};
use self::request::DEPTH_AND_DISPARITY;
use crate::accel::{self, Backend, Engine};
use crate::camera::RaySource;
use crate::camera::framing::Framed;
use crate::camera::rig::RigRays;
use crate::error::Error;
use crate::film::layers::{LayerSet, Layers};
use crate::geometry::{Geometry, Instancing};
use crate::integrator::auto::{self, Contents};
use crate::integrator::{Context, Integrator, Policy, SceneData};
use crate::light::Emitters;
use crate::light::EnvironmentLight;
use crate::light::{self, PreparedLight};
use crate::material::{Appearance, Kinds};
use crate::material::{Cover, Holes};
use crate::progress::{Progress, Stop};
use crate::sampling::Sampler;

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
    surroundings: Option<EnvironmentLight>,
    /// The camera's axes (right, up, back) in the world.
    to_world: [[f64; 3]; 3],
    /// Instances and materials of the scene.
    counts: [usize; 2],
    pool: rayon::ThreadPool,
}

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
        let surroundings = scene.environment.as_ref().map(|environment| EnvironmentLight::new(environment, pose));
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
        let step = Plan::new(request, integrator).row_step();
        let rows = request.rig.shape().lenses().rows;
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

    /// The focus distance that halves the range of disparities: the harmonic mean of the nearest and the farthest depth
    /// in the central view (of the perspective rig focused at infinity). Infinite where that view sees nothing.
    ///
    /// # Errors
    /// As [`Renderer::render`]; an orthographic rig that sees nothing.
    pub fn automatic_focus_m(&self, framed: &Framed) -> Result<f64, Error> {
        let truth = self.central_truth(&framed.rig_with(Projection::Perspective, f64::INFINITY)?)?;
        let hits = truth.depth_m().into_iter().flatten().filter(|z| z.is_finite()).map(|&z| f64::from(z));
        let (near, far) = hits.fold((f64::INFINITY, 0.0f64), |(near, far), z| (near.min(z), far.max(z)));
        if far > 0.0 {
            return Ok(2.0 / (1.0 / near + 1.0 / far));
        }
        match framed.projection {
            Projection::Perspective => Ok(f64::INFINITY),
            Projection::Orthographic => Err(Error::BadSetting(
                "the central view sees nothing to focus on; give a focus distance (--focus-m)".into(),
            )),
        }
    }

    /// What the integrators read over the packets of `region`.
    fn context<'a>(
        &'a self,
        request: &Request,
        integrator: Integrator,
        region: &Region,
        stop: &'a Stop<'a>,
    ) -> Context<'a> {
        let (seed, samples, sampling) = (request.seed, request.samples, request.sampling);
        let rig = RigRays::new(&request.rig, &region.tiling, &region.selection, sampling.shared_views());
        let scene = SceneData {
            engine: if integrator == Integrator::Depth { &*self.truth_engine } else { &*self.engine },
            geometry: &self.geometry,
            appearance: &self.appearance,
            lights: &self.lights,
            emitters: self.emitters.as_ref(),
            surroundings: self.surroundings.as_ref(),
            sky: request.sky,
            to_world: self.to_world,
            has_discs: self.lights.iter().any(PreparedLight::is_disc),
            has_holes: self.appearance.kinds().has(Kinds::HOLES),
            has_glow: self.appearance.kinds().has(Kinds::GLOWS.and(Kinds::UNLIT)),
        };
        let policy = Policy {
            max_bounces: request.bounces(integrator),
            roulette: request.roulette,
            target_error: request.target_error,
            indirect: integrator == Integrator::Direct || request.indirect,
        };
        Context { scene, camera: RaySource::Rig(rig), sampler: Sampler { seed, samples, sampling }, policy, stop }
    }

    /// The integrator for a request that can be rendered, and why it is this one.
    fn choose(&self, request: &Request) -> Result<(Integrator, String), Error> {
        request.check(self.counts)?;
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

#[cfg(test)]
mod instancing_tests;
#[cfg(test)]
mod tests;

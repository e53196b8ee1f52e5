//! The renderer: a scene in front of a camera, which any rig at that camera pose can render.

#[cfg(feature = "bench")]
#[doc(hidden)]
pub mod bench;
mod check;
mod checkpoint;
mod color;
mod image;
mod motion;
mod plan;
mod raw;
mod request;
mod rounds;
mod spectral;
mod transport;
mod visibility;
mod work;
mod world;

use std::num::NonZeroUsize;
use std::ops::Range;
use std::path::Path;
use std::sync::Arc;

use holo_core::optics::{DepthRange, DisparityRange, rig_for_disparities};
use holo_core::{Projection, Rig};
use holo_scene::{Scene, Transform};
use ndarray::Array3;

pub use self::checkpoint::{Checkpoint, FinishedTile, TileId, TileKind};
#[cfg(feature = "bench")]
pub(crate) use self::color::samples;
pub use self::motion::{Frame, Motion};
pub use self::request::{Camera, Denoise, GroundTruth, RawStatistics, Rendered, Request, Views};
pub use self::transport::{Reuse, TextureFilter, Transport};
pub use self::world::World;

use self::plan::{Plan, Region};
use self::raw::RawRequest;
use self::request::{DEPTH_AND_DISPARITY, RigRequest};
use crate::accel::{Backend, Engine};
use crate::camera::RaySource;
use crate::camera::framing::Framed;
use crate::camera::moved::Moved;
use crate::camera::rig::RigRays;
use crate::error::Error;
use crate::film::guides::Movement;
use crate::film::layers::{LayerSet, Layers};
use crate::geometry::Geometry;
use crate::integrator::auto::{self, Contents};
use crate::integrator::progress::{Progress, Stop};
use crate::integrator::{Context, Integrator, Policy, SceneData};
use crate::light::Emitters;
use crate::light::EnvironmentLight;
use crate::light::PreparedLight;
use crate::material::{Appearance, MaterialFlags};
use crate::sampling::{self, Sampler};

/// A scene with its acceleration structure, in the frame of one camera.
///
/// One renderer renders any number of [`Request`]s: rigs with different views, resolutions and focus distances at the
/// same camera pose.
pub struct Renderer {
    /// The engines for light transport and for ground truth (AOVs), which differ if materials use alpha; without and
    /// with culling of back faces.
    engines: [[Arc<dyn Engine>; 2]; 2],
    note: Option<String>,
    geometry: Arc<Geometry>,
    appearance: Arc<Appearance>,
    lights: Vec<PreparedLight>,
    emitters: Option<Arc<Emitters>>,
    environment: Option<EnvironmentLight>,
    /// The axes of the camera (right, up, back) in world coordinates.
    to_world: [[f64; 3]; 3],
    /// The number of instances and materials of the scene.
    counts: [usize; 2],
    /// Where the camera stands, if not at the origin.
    moved: Option<Moved>,
    pool: Arc<rayon::ThreadPool>,
}

impl Renderer {
    /// Validates `scene`, transforms it to the frame of a camera at `pose` (camera to world) and builds the
    /// acceleration structure. The renderer uses `threads` threads; `None`: one per core. A [`World`] does the same for
    /// many poses.
    ///
    /// # Errors
    /// As [`World::new`] and [`World::at`].
    pub fn new(
        scene: &Scene,
        pose: &Transform,
        backend: Backend,
        threads: impl Into<Option<NonZeroUsize>>,
    ) -> Result<Self, Error> {
        World::new(scene, backend, threads)?.at(pose)
    }

    /// The name and version of the ray tracing backend, such as "embree 4.4.0" or "bvh".
    #[must_use]
    pub fn engine_name(&self) -> &str {
        self.engines[0][0].name()
    }

    /// The file of the library that was loaded for the ray tracing backend; `None` if it is built in, or the system does
    /// not tell.
    #[must_use]
    pub fn engine_library(&self) -> Option<&Path> {
        self.engines[0][0].library()
    }

    /// Why [`Backend::Auto`] did not select Embree; `None` if it did, or if the backend was requested explicitly.
    #[must_use]
    pub fn engine_note(&self) -> Option<&str> {
        self.note.as_deref()
    }

    /// The number of threads of this renderer.
    #[must_use]
    pub fn threads(&self) -> usize {
        self.pool.current_num_threads()
    }

    #[cfg(feature = "bench")]
    pub(crate) fn engine(&self) -> &dyn Engine {
        self.engines[0][0].as_ref()
    }

    /// Returns a renderer whose camera stands at `pose` in the coordinates of the camera of this one; of one that was moved
    /// itself, of that which was not. It shares everything with this one, and is there at once: for images that are looked
    /// at while a camera moves. It renders plain color alone.
    ///
    /// # Accuracy
    /// Rays are moved in single precision, so that edges may differ from those of a renderer at that pose, and fine textures
    /// are not filtered.
    ///
    /// # Errors
    /// [`Error::BadSetting`] for a pose that is not a rotation and translation.
    pub fn moved(&self, pose: &Transform) -> Result<Self, Error> {
        if !pose.is_pose() {
            return Err(Error::BadSetting("the camera pose must be a rotation and a translation, both finite".into()));
        }
        Ok(Self {
            engines: self.engines.clone(),
            note: self.note.clone(),
            geometry: Arc::clone(&self.geometry),
            appearance: Arc::clone(&self.appearance),
            lights: self.lights.clone(),
            emitters: self.emitters.clone(),
            environment: self.environment.clone(),
            to_world: self.to_world,
            counts: self.counts,
            moved: Some(Moved::new(pose)),
            pool: Arc::clone(&self.pool),
        })
    }

    /// Runs `work` in the thread pool of this renderer.
    pub fn install<R: Send>(&self, work: impl FnOnce() -> R + Send) -> R {
        self.pool.install(work)
    }

    /// Renders `request`. Of a plenoptic camera, a sample is a ray from a point of a pixel through a point of a microlens that
    /// both apertures let pass: pixels that no light reaches are black and cost nothing. The result depends only on the scene, the pose and `request`, not on the number of threads or
    /// their timing.
    ///
    /// # Errors
    /// [`Error::BadSetting`] for settings that are out of range or do not fit the scene, [`Error::Core`] if a light
    /// field does not fit into memory, [`Error::Cancelled`] if `progress` cancels.
    pub fn render(&self, request: &Request, progress: &dyn Progress) -> Result<Rendered, Error> {
        self.pool.install(|| self.render_here(request, progress, None))
    }

    /// Renders in the current thread pool.
    fn render_here(
        &self,
        request: &Request,
        progress: &dyn Progress,
        checkpoint: Option<&dyn Checkpoint>,
    ) -> Result<Rendered, Error> {
        request.check(self.counts)?;
        if self.moved.is_some() {
            request.check_moved(self.choose(request)?.0)?;
        }
        match &request.camera {
            Camera::Rig(rig) => self.render_rig(&RigRequest { rig, request }, progress, checkpoint),
            Camera::Plenoptic(camera) if request.transport.spectral && self.choose(request)?.0 != Integrator::Depth => {
                self.render_spectral(camera, request, progress, checkpoint)
            }
            Camera::Plenoptic(camera) => self.render_raw(&RawRequest { camera, request }, progress, checkpoint),
        }
    }

    /// Renders `request` as [`render`](Self::render) does, to the same values, but takes the tiles that `checkpoint`
    /// contains from it, and hands it finished tiles now and then. Progress counts the tiles that are left to render.
    ///
    /// # Errors
    /// As [`Renderer::render`].
    pub fn render_with_checkpoint(
        &self,
        request: &Request,
        progress: &dyn Progress,
        checkpoint: &dyn Checkpoint,
    ) -> Result<Rendered, Error> {
        self.pool.install(|| self.render_here(request, progress, Some(checkpoint)))
    }

    /// The rows of shard `shard` (from 0) of `count` shards: of microlenses of a rig, or of pixels of a plenoptic camera.
    /// Each shard renders exactly the bytes that these rows have in the whole image.
    ///
    /// Shards have about the same height; those of a rig begin at tiles. [`Request::rows`] is ignored.
    ///
    /// # Errors
    /// [`Error::BadSetting`] as in [`Renderer::render`], and for more shards than rows of tiles.
    pub fn shard_rows(&self, request: &Request, shard: usize, count: usize) -> Result<Range<usize>, Error> {
        let (integrator, _) = self.choose(request)?;
        let whole = request.clone().rows(None);
        let rows = whole.row_range().len();
        let step = match &whole.camera {
            Camera::Rig(_) => Plan::new(&whole.of_rig()?, integrator).row_step(),
            Camera::Plenoptic(_) => 1,
        };
        let max_count = rows.div_ceil(step);
        if shard >= count || count > max_count {
            return Err(Error::BadSetting(format!(
                "shard {} of {count}: this image of {rows} rows can be cut into 1 to {max_count} shards",
                shard + 1
            )));
        }
        let start = |shard: usize| (max_count * shard / count * step).min(rows);
        Ok(start(shard)..start(shard + 1))
    }

    /// Renders layers of the central view of `rig` only; each image has the axes (v, u, c).
    ///
    /// # Errors
    /// As [`Renderer::render`].
    pub fn central_layers(&self, rig: &Rig, layers: LayerSet) -> Result<Layers<Array3<f32>>, Error> {
        let request = Request::new(*rig).integrator(Integrator::Depth).layers(layers);
        Ok(self.render(&request, &())?.central)
    }

    /// Renders the depth (m) and disparity (px) of the central view of `rig` only; each image has the axes (v, u, c).
    ///
    /// # Errors
    /// As [`Renderer::render`].
    pub fn central_truth(&self, rig: &Rig) -> Result<Layers<Array3<f32>>, Error> {
        self.central_layers(rig, DEPTH_AND_DISPARITY)
    }

    /// The focus distance, m, at which the largest positive and the largest negative disparity are equal: the harmonic
    /// mean of the nearest and the farthest depth in the central view (of the perspective rig focused at infinity).
    /// Infinite if no ray of that view hits anything.
    ///
    /// # Errors
    /// As [`Renderer::render`]; [`Error::BadSetting`] for an orthographic rig if no ray hits anything.
    pub fn automatic_focus_m(&self, framed: &Framed) -> Result<f64, Error> {
        let depths_m = self.central_depths_m(&framed.rig_with(Projection::Perspective, f64::INFINITY)?)?;
        if let Some((near, far)) = depths_m {
            return Ok(2.0 / (1.0 / near + 1.0 / far));
        }
        match framed.projection {
            Projection::Perspective => Ok(f64::INFINITY),
            Projection::Orthographic => Err(Error::BadSetting(
                "the central view sees nothing to focus on; give a focus distance (`focus-m`)".into(),
            )),
        }
    }

    /// The nearest and the farthest depth, m, that the central view of `rig` hits; `None` if it hits nothing.
    ///
    /// # Errors
    /// As [`Renderer::render`].
    pub fn central_depths_m(&self, rig: &Rig) -> Result<Option<(f64, f64)>, Error> {
        let truth = self.central_truth(rig)?;
        let hits = truth.depth_m().into_iter().flatten().filter(|z| z.is_finite()).map(|&z| f64::from(z));
        let (near, far) = hits.fold((f64::INFINITY, 0.0f64), |(near, far), z| (near.min(z), far.max(z)));
        Ok((far > 0.0).then_some((near, far)))
    }

    /// The rig at this camera whose central view has the disparity `max_px` at the nearest depth that it hits and
    /// `min_px` at the farthest: focus distance and baseline follow, those of `framed` do not matter.
    ///
    /// # Accuracy
    /// Odd numbers of views: that of depths in f32. With even ones the central view moves with the baseline, and what it
    /// hits with it: the best of ten rounds is taken, within a few percent of the range even in foliage.
    ///
    /// # Errors
    /// [`Error::BadSetting`] for orthographic views, and if the central view hits nothing or only a single depth;
    /// [`Error::Core`] if no focus distance gives these disparities; otherwise as [`Renderer::render`].
    pub fn rig_for_disparities(&self, framed: &Framed, disparities: DisparityRange) -> Result<Rig, Error> {
        const ROUNDS: usize = 10;
        let bad = |why: &str| Error::BadSetting(format!("{why}; give `baseline-m` and `focus-m`, not `disparity`"));
        if framed.projection == Projection::Orthographic {
            return Err(bad("a range of disparities is for perspective views"));
        }
        let mut rig = framed.rig_with(Projection::Perspective, f64::INFINITY)?;
        let mut best = (f64::INFINITY, rig);
        for round in 0..=ROUNDS {
            let seen = self.central_depths_m(&rig)?;
            let (near_m, far_m) = seen.ok_or_else(|| bad("the central view sees nothing, so no disparities"))?;
            if near_m >= far_m {
                return Err(bad("all that the central view sees has the same depth, so there is no range"));
            }
            let depths = DepthRange::new(near_m, far_m)?;
            if round > 0 {
                let of_depth = |depth_m| rig.disparity().from_depth_m(depth_m);
                let error =
                    (of_depth(near_m) - disparities.max_px).abs().max((of_depth(far_m) - disparities.min_px).abs());
                if error < best.0 {
                    best = (error, rig);
                }
                // Depths are f32.
                if error < 1e-6 * (disparities.max_px - disparities.min_px) {
                    break;
                }
            }
            let found = rig_for_disparities(depths, disparities, framed.intrinsics, framed.shape.lenses())?;
            rig = rig.to_builder().baseline_m(found.baseline_m).focus_distance_m(found.focus_distance_m).build()?;
        }
        Ok(best.1)
    }

    /// The context of the integrators for the packets of `region`.
    fn context<'a>(
        &'a self,
        request: &RigRequest,
        integrator: Integrator,
        region: &Region,
        stop: &'a Stop<'a>,
    ) -> Context<'a> {
        let transport = &request.transport;
        let rig = RigRays::new(request.rig, &region.tiling, &region.selection);
        let rig = rig.with_filter_width(request.filter_width_px);
        let policy = Policy {
            target_error: transport.target_error.filter(|_| rounds::target(request).is_none()),
            reuse: self.reuses(request, integrator, region),
            ..self.policy(transport, integrator)
        };
        let guides = plan::needs_guides(request).then(|| {
            let ratio = request.rig.baseline_ratio();
            let movement = ratio.vertical().max(ratio.horizontal()) as f32;
            Movement::Disparity(color::disparity(request.rig), movement)
        });
        let is_plain = request.denoise == Denoise::Off;
        // Footprints are in the coordinates of the camera.
        let filters = self.filters_textures(transport) && is_plain && self.moved.is_none();
        let sampler = Sampler {
            seed: transport.seed,
            samples: transport.samples.of_traced(),
            sampling: transport.sampling,
            // A square of several pixels is more than what its center sees.
            centered: transport.samples == 1.into() && is_plain && request.filter_width_px == 1.0,
            cells: filters.then(|| sampling::cells(transport.samples.of_traced())),
        };
        let scene = self.scene_data(transport, integrator);
        let (camera, moved) = (RaySource::Rig(rig), self.moved.as_ref());
        Context { scene, camera, sampler, policy, guides, inverse_depths: false, moved, stop }
    }

    /// Whether textures are filtered by the footprints of camera rays: if there are any.
    fn filters_textures(&self, transport: &Transport) -> bool {
        transport.texture_filter == TextureFilter::Footprint && self.appearance.has_textures()
    }

    /// The scene as the integrators use it.
    fn scene_data(&self, transport: &Transport, integrator: Integrator) -> SceneData<'_> {
        SceneData {
            engine: self.engines[usize::from(transport.cull)][usize::from(integrator == Integrator::Depth)].as_ref(),
            geometry: &self.geometry,
            appearance: &self.appearance,
            lights: &self.lights,
            emitters: self.emitters.as_deref(),
            environment: self.environment.as_ref(),
            sky: transport.sky,
            backdrop: transport.backdrop,
            to_world: self.to_world,
            has_discs: self.lights.iter().any(PreparedLight::is_disc),
            has_alpha: self.appearance.flags().has(MaterialFlags::ALPHA),
            has_media: self.appearance.flags().has(MaterialFlags::VOLUME),
            has_emission: self.appearance.flags().has(MaterialFlags::EMISSIVE.union(MaterialFlags::UNLIT)),
        }
    }

    /// The termination of paths that share nothing.
    fn policy(&self, transport: &Transport, integrator: Integrator) -> Policy {
        Policy {
            max_bounces: transport.bounces(integrator),
            roulette: transport.roulette,
            target_error: transport.target_error,
            indirect: integrator == Integrator::Direct || transport.indirect,
            multiple_scattering: transport.multiple_scattering,
            indirect_limit: transport.indirect_limit,
            reuse: false,
            transparent_shadows: transport.transparent_shadows && self.appearance.flags().has(MaterialFlags::GLOSSY),
        }
    }

    /// Whether the views of a packet share light.
    fn reuses(&self, request: &RigRequest, integrator: Integrator, region: &Region) -> bool {
        let transport = &request.transport;
        // A single sample is for speed.
        let is_possible = transport.samples.of_traced() > 1
            && region.tiling.is_one_lens_a_packet()
            && !region.selection.is_list()
            && !transport.transparent_shadows
            && transport.indirect_limit == f32::INFINITY
            && !self.appearance.flags().has(MaterialFlags::BLEND)
            && (transport.indirect || integrator == Integrator::Direct);
        let finds_light = transport.bounces(integrator) > 1
            || transport.sky.iter().any(|&c| c > 0.0)
            || self.environment.is_some()
            || self.emitters.is_some();
        transport.reuse == Reuse::Views && is_possible && finds_light && request.denoise == Denoise::Off
    }

    /// Validates the request; returns the integrator and the reason for it.
    fn choose(&self, request: &Request) -> Result<(Integrator, String), Error> {
        request.check(self.counts)?;
        Ok(self.integrator(&request.transport))
    }

    /// The integrator and the reason for it.
    fn integrator(&self, transport: &Transport) -> (Integrator, String) {
        match transport.integrator {
            Integrator::Auto => auto::choose(&self.contents(transport), transport.indirect),
            chosen => (chosen, "requested".into()),
        }
    }

    /// The properties of the scene that determine the integrator.
    fn contents(&self, transport: &Transport) -> Contents {
        let flags = self.appearance.flags();
        let discs = self.lights.iter().filter(|light| light.is_disc()).count();
        Contents {
            punctual_lights: self.lights.len() - discs,
            discs,
            emitters: self.emitters.is_some(),
            sky: transport.sky.iter().any(|&c| c > 0.0),
            environment: self.environment.is_some(),
            glossy: flags.has(MaterialFlags::GLOSSY),
            unlit: flags.has(MaterialFlags::UNLIT),
            all_unlit: self.appearance.is_all_unlit(),
        }
    }
}

#[cfg(test)]
mod checkpoint_tests;
#[cfg(test)]
mod instancing_tests;
#[cfg(test)]
mod layer_tests;
#[cfg(test)]
mod tests;
#[cfg(test)]
mod texture_filter_tests;
#[cfg(test)]
mod visibility_tests;

//! The world: what of a scene does not depend on the camera.

use std::num::NonZeroUsize;
use std::sync::Arc;

use holo_scene::{Scene, Transform};

use super::Renderer;
use crate::accel::{self, Backend, Engine};
use crate::error::Error;
use crate::geometry::{Geometry, Instancing};
use crate::light::{self, Emitters, EnvironmentLight};
use crate::material::media::MAX_MEDIA;
use crate::material::{AlphaTest, AlphaTested, Appearance, MaterialFlags};

/// A validated scene with its materials, textures and environment, for renderers at any number of poses.
///
/// Geometry is in camera coordinates, so that depth is exact wherever a camera stands: every [`Renderer`] has an
/// acceleration structure of its own.
pub struct World<'a> {
    scene: &'a Scene,
    backend: Backend,
    instancing: Instancing,
    appearance: Arc<Appearance>,
    /// In the frame of the world.
    environment: Option<EnvironmentLight>,
    pool: Arc<rayon::ThreadPool>,
}

/// An engine, and a note about its choice.
type Built = (Box<dyn Engine>, Option<String>);

impl<'a> World<'a> {
    /// Validates `scene` and prepares what does not depend on the camera. The renderers of this world use `threads`
    /// threads; `None`: one per core.
    ///
    /// # Errors
    /// [`Error::Scene`] for an invalid scene, [`Error::BadSetting`] for too many kinds of glass, or if the threads cannot be
    /// started.
    pub fn new(scene: &'a Scene, backend: Backend, threads: impl Into<Option<NonZeroUsize>>) -> Result<Self, Error> {
        Self::with_instancing(scene, backend, threads.into(), accel::instancing(backend))
    }

    /// As `new`; the engine must support `instancing`.
    pub(crate) fn with_instancing(
        scene: &'a Scene,
        backend: Backend,
        threads: Option<NonZeroUsize>,
        instancing: Instancing,
    ) -> Result<Self, Error> {
        scene.validate()?;
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads.map_or(0, NonZeroUsize::get)) // 0: one per core.
            .build()
            .map_err(|e| match threads {
                Some(threads) => Error::BadSetting(format!("{threads} threads cannot be started: {e}")),
                None => Error::BadSetting(format!("one thread per core cannot be started: {e}")),
            })?;
        let appearance = Arc::new(Appearance::new(&scene.materials, &scene.textures));
        if appearance.media_count() > MAX_MEDIA {
            return Err(Error::BadSetting(format!(
                "the scene has {} kinds of glass with a volume; at most {MAX_MEDIA} are supported",
                appearance.media_count()
            )));
        }
        let environment = scene.environment.as_ref().map(|map| EnvironmentLight::new(map, &Transform::IDENTITY));
        let environment = environment.filter(|environment| !environment.is_black());
        Ok(Self { scene, backend, instancing, appearance, environment, pool: Arc::new(pool) })
    }

    /// Transforms the scene to the frame of a camera at `pose` (camera to world) and builds the acceleration structure.
    ///
    /// # Errors
    /// [`Error::Embree`] if the backend is not available, [`Error::OutOfMemory`] if it runs out of memory,
    /// [`Error::Scene`] for coordinates out of range, [`Error::BadSetting`] for a pose that is not a rotation and
    /// translation.
    pub fn at(&self, pose: &Transform) -> Result<Renderer, Error> {
        if !pose.is_pose() {
            return Err(Error::BadSetting("the camera pose must be a rotation and a translation, both finite".into()));
        }
        let Self { scene, appearance, pool, .. } = self;
        let (geometry, (engine, note)) = pool.install(|| self.build(pose))?;
        let engine: Arc<dyn Engine> = Arc::from(engine);
        let engines = [false, true].map(|cull| {
            [AlphaTest::Stochastic, AlphaTest::Threshold].map(|test| -> Arc<dyn Engine> {
                let inner = Arc::clone(&engine);
                if !cull && !appearance.flags().has(MaterialFlags::ALPHA) {
                    return inner;
                }
                let (geometry, appearance) = (Arc::clone(&geometry), Arc::clone(appearance));
                Arc::new(AlphaTested { inner, geometry, appearance, test, cull })
            })
        });
        Ok(Renderer {
            engines,
            note,
            lights: light::prepare(&scene.lights, pose),
            emitters: Emitters::build(&geometry, &scene.materials, &scene.textures).map(Arc::new),
            moved: None,
            environment: self.environment.clone().map(|environment| environment.at(pose)),
            to_world: pose.columns,
            counts: [scene.instances.len(), scene.materials.len()],
            geometry,
            appearance: Arc::clone(appearance),
            pool: Arc::clone(pool),
        })
    }

    /// The geometry in the frame of a camera, its engine, and a note if `Auto` fell back to the BVH.
    fn build(&self, pose: &Transform) -> Result<(Arc<Geometry>, Built), Error> {
        let threads = self.pool.current_num_threads();
        let geometry = Arc::new(Geometry::build(self.scene, pose, self.instancing)?);
        match accel::build(self.backend, &geometry, threads) {
            // The BVH needs less memory, and has no instances.
            Err(why @ Error::OutOfMemory(_)) if self.backend == Backend::Auto => {
                drop(geometry);
                let geometry = Arc::new(Geometry::build(self.scene, pose, accel::instancing(Backend::Bvh))?);
                let (engine, _) = accel::build(Backend::Bvh, &geometry, threads)?;
                Ok((geometry, (engine, Some(accel::fallback(&why)))))
            }
            built => Ok((geometry, built?)),
        }
    }
}

//! One camera after another in the same scene, for programs that show a scene while its camera is set up.

use holo_core::{GridSize, LightFieldShape, Rig};
use holo_render::{Layer, Renderer, Request, World};

use super::job::RenderJob;
use super::prepare::{Prepared, Setup, Stage};
use super::trace;
use super::warning::{self, RenderWarning};
use crate::Error;
use crate::output::Wanted;
use crate::watch::Diagnostics;

/// The longer side of an image that shows if a render needs a warning, px.
const FEW_PIXELS: usize = 128;

impl RenderJob {
    /// Loads the scene of the job at its frame, with its sky and its ground.
    ///
    /// # Errors
    /// [`Error::Failed`] if the scene or the environment map cannot be read; [`Error::BadRequest`] for several frames.
    pub fn stage(&self, diagnostics: &dyn Diagnostics) -> Result<Stage, Error> {
        let wanted = Wanted::new(&self.settings)?;
        self.setup(&wanted).stage(diagnostics)
    }

    /// Prepares the first camera of the job in a `world` of its `stage`. The acceleration structure of `earlier`, a camera
    /// in the same world, is kept if the pose is the same.
    ///
    /// # Errors
    /// [`Error::BadRequest`] and [`Error::Core`] for settings that contradict each other, [`Error::Failed`] if the scene has
    /// no suitable camera, [`Error::Render`] if the acceleration structure cannot be built.
    pub fn prepare(
        &self,
        stage: &Stage,
        world: &World,
        earlier: Option<Prepared>,
        diagnostics: &dyn Diagnostics,
    ) -> Result<Prepared, Error> {
        let wanted = Wanted::new(&self.settings)?;
        self.setup(&wanted).prepare_after(earlier, (stage, world), 0, diagnostics)
    }

    /// Prepares the first camera of the job for images that are looked at while it moves, at once: `still` is a renderer of
    /// the world at the identity. See [`Renderer::moved`] for what it renders. The focus must be a distance, and the
    /// baseline must not follow from disparities.
    ///
    /// # Errors
    /// As [`prepare`](Self::prepare); [`Error::Render`] if the focus or the baseline needs a view.
    pub fn prepare_moved(&self, stage: &Stage, still: &Renderer) -> Result<Prepared, Error> {
        let wanted = Wanted::new(&self.settings)?;
        self.setup(&wanted).prepare_moved(stage, still)
    }

    /// Returns the request that [`run`](Self::run) would render for a prepared camera.
    ///
    /// # Errors
    /// As [`check`](Self::check).
    pub fn request(&self, prepared: &Prepared) -> Result<Request, Error> {
        let wanted = Wanted::new(&self.settings)?;
        trace::request(&self.setup(&wanted), prepared, None)
    }

    fn setup<'a>(&'a self, wanted: &'a Wanted) -> Setup<'a> {
        let Self { source, settings, engine, .. } = self;
        Setup { source, settings, wanted, engine, electrons: None }
    }
}

impl Prepared {
    /// Returns the warnings that a render with this camera would give, before it begins; those of a rig.
    ///
    /// # Errors
    /// [`Error::Render`] as for any render of depth.
    pub fn warnings(&self) -> Result<Vec<RenderWarning>, Error> {
        let Some(rig) = self.rig() else { return Ok(Vec::new()) };
        let warnings = |seen: &Rig| -> Result<Vec<RenderWarning>, Error> {
            Ok(warning::of(rig, &self.renderer.central_layers(seen, [Layer::Depth].into())?))
        };
        // The same image with fewer pixels sees less: what it does not warn of is no warning.
        let (views, lenses) = (rig.shape().views(), rig.shape().lenses());
        let part = (FEW_PIXELS as f64 / lenses.larger() as f64).min(1.0);
        let few = |count: usize| ((count as f64 * part).round() as usize).max(1);
        let few = GridSize::new(few(lenses.rows), few(lenses.columns));
        if few != lenses {
            let seen = rig.to_builder().shape(LightFieldShape::new(views, few)?).build()?;
            if warnings(&seen)?.is_empty() {
                return Ok(Vec::new());
            }
        }
        warnings(rig)
    }
}

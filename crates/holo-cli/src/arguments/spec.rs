//! From the command line to what the libraries take.

use holo_dataset::{EngineSpec, Focus, RenderSpec, RigSpec, SceneSpec};
use holo_io::CameraFile;

use crate::failure::Failure;

use super::{
    DatasetOptions, EngineOptions, JobOptions, MainLensOptions, OpticsOptions, RenderOptions, RigOptions,
    SceneFileOptions,
};

impl RenderOptions {
    pub fn spec(&self) -> RenderSpec {
        let mut spec = self.job.spec();
        spec.rig = self.rig.spec();
        spec
    }
}

impl DatasetOptions {
    /// Without views, of which every job has its own.
    pub fn spec(&self) -> RenderSpec {
        let mut spec = self.job.spec();
        spec.rig = self.main_lens.spec();
        spec
    }
}

impl JobOptions {
    fn spec(&self) -> RenderSpec {
        let mut spec = RenderSpec::default();
        spec.scene = self.scene_file.spec();
        spec.integrator = self.integrator;
        spec.samples = self.spp;
        spec.target_error = self.target_error;
        spec.max_bounces = self.max_bounces;
        spec.roulette = !self.no_roulette;
        spec.indirect = !self.no_indirect;
        spec.indirect_limit = self.indirect_limit.map_or(f32::INFINITY, |limit| limit as f32);
        spec.transparent_shadows = self.transparent_shadows;
        spec.multiple_scattering = !self.no_multiple_scattering;
        spec.reuse = self.reuse;
        spec.texture_filter = self.texture_filter;
        spec.denoise = self.denoise;
        spec.cull = self.cull;
        spec.sky = self.sky.clone();
        spec.exposure = self.exposure;
        spec.ground_truth = self.ground_truth;
        spec.layers = self.layers.clone();
        spec.outputs = self.write.clone();
        spec.mat_order = self.mat_order;
        (spec.sensor_model, spec.iso) = (self.sensor_model.clone(), self.iso);
        (spec.bit_depth, spec.seed) = (self.bit_depth, self.seed);
        spec
    }
}

impl SceneFileOptions {
    pub fn spec(&self) -> SceneSpec {
        let mut spec = SceneSpec::default();
        (spec.light_units, spec.solid_glass) = (self.light_units, self.solid_glass);
        spec.material_variant.clone_from(&self.material_variant);
        (spec.frames, spec.fps) = (self.frame, self.fps);
        spec.animation.clone_from(&self.animation);
        spec
    }
}

impl MainLensOptions {
    pub fn spec(&self) -> RigSpec {
        let mut spec = RigSpec::default();
        (spec.sensor, spec.f_number, spec.focus) = (self.sensor, self.f_number, self.focus_m);
        spec.disparity_px = self.disparity;
        spec
    }
}

impl MainLensOptions {
    /// A plenoptic camera with the focus and the f-number that were given.
    pub fn adjusted(&self, mut camera: CameraFile) -> Result<CameraFile, Failure> {
        if let Focus::Meters(depth_m) = self.focus_m {
            camera = camera.with_focus_m(depth_m).map_err(Failure::Usage)?;
        }
        if let Some(f_number) = self.f_number {
            camera = camera.with_f_number(f_number).map_err(Failure::Usage)?;
        }
        Ok(camera)
    }
}

impl RigOptions {
    pub fn spec(&self) -> RigSpec {
        let mut spec = self.main_lens.spec();
        spec.views = self.views;
        spec.lenses = self.lenses;
        spec.lens_shifts = self.lens_shifts;
        spec.baseline_m = self.baseline_m;
        spec.focal_mm = self.focal_mm;
        spec.sensor_mm = self.sensor_mm;
        spec.projection = self.projection;
        spec.camera = self.camera.clone();
        spec.subset.clone_from(&self.subset);
        spec
    }
}

impl OpticsOptions {
    pub fn spec(&self) -> RigSpec {
        let mut spec = self.main_lens.spec();
        spec.views = self.views.unwrap_or(spec.views);
        spec.lenses = self.lenses;
        spec.baseline_m = self.baseline_m;
        (spec.focal_mm, spec.sensor_mm) = (Some(self.focal_mm), self.sensor_mm);
        spec
    }
}

impl EngineOptions {
    pub fn spec(&self) -> EngineSpec {
        EngineSpec { backend: self.backend, threads: usize::from(self.threads.unwrap_or(0)) }
    }
}

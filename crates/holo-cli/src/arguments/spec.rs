//! From the command line to what the libraries take.

use holo_dataset::{EngineSpec, RenderSpec, RigSpec};

use super::{DatasetOptions, EngineOptions, JobOptions, MainLensOptions, RenderOptions, RigOptions};

impl RenderOptions {
    pub fn spec(&self) -> RenderSpec {
        RenderSpec { rig: self.rig.spec(), ..self.job.spec() }
    }
}

impl DatasetOptions {
    /// Without views, of which every job has its own.
    pub fn spec(&self) -> RenderSpec {
        RenderSpec { rig: self.main_lens.spec(), ..self.job.spec() }
    }
}

impl JobOptions {
    fn spec(&self) -> RenderSpec {
        RenderSpec {
            rig: RigSpec::default(),
            integrator: self.integrator,
            samples: self.spp,
            target_error: self.target_error,
            max_bounces: self.max_bounces,
            roulette: !self.no_roulette,
            indirect: !self.no_indirect,
            sky: self.sky.clone(),
            exposure: self.exposure,
            ground_truth: self.ground_truth,
            layers: self.layers.clone(),
            outputs: self.write.clone(),
            mat_order: self.mat_order,
            bit_depth: self.bit_depth,
            seed: self.seed,
        }
    }
}

impl MainLensOptions {
    pub fn spec(&self) -> RigSpec {
        RigSpec { sensor: self.sensor, f_number: self.f_number, focus: self.focus_m, ..RigSpec::default() }
    }
}

impl RigOptions {
    pub fn spec(&self) -> RigSpec {
        RigSpec {
            views: self.views,
            lenses: self.lenses,
            baseline_m: self.baseline_m,
            focal_mm: self.focal_mm,
            sensor_mm: self.sensor_mm,
            projection: self.projection,
            camera: self.camera.clone(),
            ..self.main_lens.spec()
        }
    }
}

impl EngineOptions {
    pub fn spec(&self) -> EngineSpec {
        EngineSpec { backend: self.backend, threads: usize::from(self.threads.unwrap_or(0)) }
    }
}

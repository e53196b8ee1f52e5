//! From the command line to what the libraries take.

use clap::ValueEnum;
use holo_core::{Layout, Projection, ViewOrder};
use holo_dataset::{EngineSpec, LayerChoice, Output, RenderSpec, RigSpec};
use holo_io::MatOrder;
use holo_render::{Backend, GroundTruth, Integrator};

use super::{
    BackendArgument, DatasetOptions, EngineOptions, GroundTruthArgument, IntegratorArgument, JobOptions, LayerArgument,
    LayoutArgument, MainLensOptions, MatOrderArgument, OrderArgument, OutputArgument, ProjectionArgument,
    RenderOptions, RigOptions,
};

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
            integrator: match self.integrator {
                IntegratorArgument::Auto => Integrator::Auto,
                IntegratorArgument::Depth => Integrator::Depth,
                IntegratorArgument::Direct => Integrator::Direct,
                IntegratorArgument::Path => Integrator::Path,
            },
            samples: self.spp,
            target_error: self.target_error,
            max_bounces: self.max_bounces,
            roulette: !self.no_roulette,
            indirect: !self.no_indirect,
            sky: self.sky.clone(),
            exposure: self.exposure,
            ground_truth: match self.ground_truth {
                GroundTruthArgument::Central => GroundTruth::Central,
                GroundTruthArgument::All => GroundTruth::All,
            },
            layers: self.layers.iter().map(|layer| layer.choice()).collect(),
            outputs: self.write.iter().map(|output| output.output()).collect(),
            mat_order: match self.mat_order {
                MatOrderArgument::Lenses => MatOrder::Lenses,
                MatOrderArgument::Lftoolbox => MatOrder::LightFieldToolbox,
            },
            bit_depth: self.bit_depth,
            seed: self.seed,
        }
    }
}

impl From<LayoutArgument> for Layout {
    fn from(argument: LayoutArgument) -> Self {
        match argument {
            LayoutArgument::El => Self::ElementalGrid,
            LayoutArgument::Vpi => Self::ViewpointGrid,
        }
    }
}

impl From<OrderArgument> for ViewOrder {
    fn from(argument: OrderArgument) -> Self {
        match argument {
            OrderArgument::RowMajor => Self::RowMajor,
            OrderArgument::Serpentine => Self::Serpentine,
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
            projection: match self.projection {
                ProjectionArgument::Perspective => Projection::Perspective,
                ProjectionArgument::Orthographic => Projection::Orthographic,
            },
            camera: self.camera.clone(),
            ..self.main_lens.spec()
        }
    }
}

impl EngineOptions {
    pub fn spec(&self) -> EngineSpec {
        EngineSpec {
            backend: match self.backend {
                BackendArgument::Auto => Backend::Auto,
                BackendArgument::Embree => Backend::Embree,
                BackendArgument::Bvh => Backend::Bvh,
            },
            threads: usize::from(self.threads.unwrap_or(0)),
        }
    }
}

/// The word of a value on the command line.
fn word(argument: &impl ValueEnum) -> String {
    argument.to_possible_value().map_or_else(String::new, |value| value.get_name().to_owned())
}

impl LayerArgument {
    fn choice(&self) -> LayerChoice {
        // A test has every word of the command line looked up.
        LayerChoice::from_name(&word(self)).unwrap_or(LayerChoice::All)
    }
}

impl OutputArgument {
    fn output(&self) -> Output {
        Output::from_name(&word(self)).unwrap_or(Output::El)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use holo_render::Layer;

    /// Every layer and every output can be named, by its own name.
    #[test]
    fn words_of_the_command_line_are_names_of_the_library() {
        for argument in LayerArgument::value_variants() {
            assert_eq!(LayerChoice::from_name(&word(argument)).map(LayerChoice::name), Some(word(argument).as_str()));
        }
        assert_eq!(LayerArgument::value_variants().len(), Layer::COUNT + 2);
        for argument in OutputArgument::value_variants() {
            assert_eq!(Output::from_name(&word(argument)).map(Output::name), Some(word(argument).as_str()));
        }
    }
}

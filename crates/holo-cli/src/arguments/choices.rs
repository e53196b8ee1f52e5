//! The words that options take, with what they mean: values of the libraries.

use super::{NormalsArgument, SurfaceArgument};
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use holo_core::refocus::Kernel;
use holo_core::sensor::Demosaic;
use holo_core::{Effort, Layout, Projection, ViewOrder};
use holo_dataset::{DevelopOutput, LayerChoice, Output, RawLayer, Tool};
use holo_io::{MatOrder, WorldUp};
use holo_render::{Backend, Denoise, GroundTruth, Integrator, Layer, Reuse, TextureFilter};

/// A value, its word, and its line of `--help`; one without a line has none.
type Choices<T> = [(T, &'static str, &'static str)];

pub const INTEGRATORS: &Choices<Integrator> = &[
    (Integrator::Auto, "auto", "The cheapest that is exact for the scene"),
    (Integrator::Depth, "depth", "Ground truth alone, without color"),
    (Integrator::Direct, "direct", "Direct light"),
    (Integrator::Path, "path", "Path tracing: global illumination"),
];

pub const DENOISE: &Choices<Denoise> = &[
    (Denoise::Off, "off", "No: every pixel is the mean of its own samples"),
    (Denoise::Views, "views", "By neighboring views"),
];

pub const TOOLS: &Choices<Tool> = &[
    (Tool::LfToolbox, "lftoolbox", "Light Field Toolbox for MATLAB (D. Dansereau)"),
    (Tool::PlenoptiCam, "plenopticam", "PlenoptiCam (C. Hahne)"),
    (Tool::Libpleno, "libpleno", "libpleno, COMPOTE (M. Labussiere)"),
    (Tool::Pip, "pip", "PIP, Plenoptic Image Processing (Kiel University)"),
    (Tool::Raytrix, "raytrix", "Raytrix's calibration, for PlenopticToolbox2.0 (L. Palmieri)"),
    (Tool::Plenpy, "plenpy", "plenpy (M. Schambach)"),
    (Tool::Lytro, "lytro", "Files of Lytro's cameras, for LFToolbox"),
];

pub const DEVELOP_OUTPUTS: &Choices<DevelopOutput> = &[
    (DevelopOutput::Png, "png", "NAME.png: the codes, in 16 bits"),
    (DevelopOutput::Dng, "dng", "NAME.dng: the same for raw converters; of a mosaic only"),
    (DevelopOutput::Clean, "clean", "NAME_clean.png: the codes without noise"),
    (DevelopOutput::Rgb, "rgb", "NAME_rgb.png: 8 bits without mosaic and noise; saturation is white"),
];

/// How `holo demosaic` finds missing colors.
#[derive(Clone, Copy, Debug)]
pub enum DemosaicArgument {
    Plain(Demosaic),
    MicroImages,
}

pub const DEMOSAIC: &Choices<DemosaicArgument> = &[
    (DemosaicArgument::Plain(Demosaic::Bilinear), "bilinear", "The mean of the nearest pixels of a color"),
    (
        DemosaicArgument::Plain(Demosaic::Malvar),
        "malvar",
        "Corrected by the curvature of the pixel's color (Malvar, He, Cutler)",
    ),
    (DemosaicArgument::Plain(Demosaic::Homogeneity), "ahd", "Along edges (Hirakawa, Parks)"),
    (
        DemosaicArgument::MicroImages,
        "micro-images",
        "By pixels of the same micro-image, weighted with the white image; needs --camera-file",
    ),
];

pub const REUSE: &Choices<Reuse> = &[
    (Reuse::Off, "off", "No: the noise of every pixel is independent"),
    (Reuse::Views, "views", "Between groups of 16 neighboring views"),
];

pub const TEXTURE_FILTERS: &Choices<TextureFilter> = &[
    (TextureFilter::Off, "off", "No: the texture at the hit point"),
    (TextureFilter::Footprint, "footprint", "The mean over a cell of the pixel"),
];

pub const GROUND_TRUTHS: &Choices<GroundTruth> =
    &[(GroundTruth::Central, "central", "Of the central view"), (GroundTruth::All, "all", "Of every view")];

pub const PROJECTIONS: &Choices<Projection> = &[
    (Projection::Perspective, "perspective", "Every view is a pinhole camera"),
    (Projection::Orthographic, "orthographic", "The rays of a view are parallel"),
];

pub const BACKENDS: &Choices<Backend> = &[
    (Backend::Auto, "auto", "Embree if it is installed, else the built-in BVH"),
    (Backend::Embree, "embree", "Intel Embree 4"),
    (Backend::Bvh, "bvh", "The built-in bounding volume hierarchy"),
];

pub const LAYOUTS: &Choices<Layout> = &[
    (Layout::ViewpointGrid, "vpi", "A grid of viewpoint images (sub-aperture images)"),
    (Layout::ElementalGrid, "el", "A grid of elemental images (micro-images): the raw image of the sensor"),
];

pub const LAYERS: &Choices<LayerChoice> = &[
    (LayerChoice::Color, "color", "The image in linear light, without exposure"),
    (LayerChoice::One(Layer::Depth), "depth", "Along the optical axis, m; infinity where nothing was hit"),
    (LayerChoice::One(Layer::RayLength), "ray-length", "Along the ray, m; infinity where nothing was hit"),
    (LayerChoice::One(Layer::Disparity), "disparity", "Between adjacent views, px; also as a PNG"),
    (
        LayerChoice::One(Layer::GeometricNormal),
        "geometric-normal",
        "Of the triangle, in world space, on the visible side",
    ),
    (LayerChoice::One(Layer::ShadingNormal), "shading-normal", "Interpolated between the vertices, likewise"),
    (LayerChoice::One(Layer::Albedo), "albedo", "Base color, linear"),
    (LayerChoice::One(Layer::ObjectId), "object-id", "Number of the instance, from 1; 0 where nothing was hit"),
    (LayerChoice::One(Layer::MaterialId), "material-id", "Number of the material, from 1; 0 where nothing was hit"),
    (LayerChoice::One(Layer::HitMask), "hit-mask", "1 where something was hit, else 0"),
    (LayerChoice::All, "all", "All of the above"),
    (LayerChoice::Visibility, "visibility", "Part of all views that see the point; 1: all. Of the central view alone"),
    (
        LayerChoice::OpticalFlow,
        "optical-flow",
        "With --frame: where the image of a point moves until the next frame, px (.flo)",
    ),
    (LayerChoice::SceneFlow, "scene-flow", "With --frame: how the point moves in world space until the next frame, m"),
    (LayerChoice::Raw(RawLayer::LensRow), "lens-row", "Plenoptic camera: row of the nearest micro-image"),
    (LayerChoice::Raw(RawLayer::LensColumn), "lens-column", "Its column"),
    (LayerChoice::Raw(RawLayer::LensType), "lens-type", "Its type of microlens, from 0"),
    (LayerChoice::Raw(RawLayer::White), "white", "Light of a scene of radiance 1"),
    (
        LayerChoice::Raw(RawLayer::VirtualDepth),
        "virtual-depth",
        "Distance of the main lens's image from the array, in gaps",
    ),
    (LayerChoice::Raw(RawLayer::Blur), "blur", "Diameter of the blur, px"),
    (
        LayerChoice::Raw(RawLayer::InverseDepthMean),
        "inverse-depth-mean",
        "Mean of 1 / depth over what a pixel sees, 1/m",
    ),
    (LayerChoice::Raw(RawLayer::InverseDepthDeviation), "inverse-depth-deviation", "Its standard deviation"),
    (LayerChoice::Raw(RawLayer::Coverage), "coverage", "Share of the light that comes from surfaces"),
    (LayerChoice::Error, "error", "Estimated relative standard error of color, bias included"),
];

pub const SURFACES: &Choices<SurfaceArgument> = &[
    (SurfaceArgument::Plane, "plane", "A grid or a line in front of the target, with parallel axes"),
    (SurfaceArgument::Cylinder, "cylinder", "An arc or a circle around the target, in one row or several"),
    (SurfaceArgument::Sphere, "sphere", "Evenly on a sphere, or a part of it, around the target"),
];

pub const WORLD_UPS: &Choices<WorldUp> =
    &[(WorldUp::Z, "z", "As in Blender and nerfstudio"), (WorldUp::Y, "y", "As in glTF")];

pub const MAT_ORDERS: &Choices<MatOrder> = &[
    (MatOrder::Lenses, "lenses", "`H` of size [V U T S C]: microlenses first"),
    (MatOrder::LightFieldToolbox, "lftoolbox", "`LF` of size [T S V U C]: views first, as in the Light Field Toolbox"),
];

pub const OUTPUTS: &Choices<Output> = &[
    (Output::Vpi, "vpi", "scene_vpi.png: all views side by side"),
    (Output::El, "el", "scene_el.png: the raw image of the sensor behind the microlenses"),
    (Output::Disparity, "disparity", "scene_disparity.pfm and .png of the central view"),
    (Output::Depth, "depth", "scene_depth.pfm of the central view"),
    (
        Output::Exr,
        "exr",
        "scene_central.exr: color and all layers of the central view, linear. With el or vpi also scene_el.exr, scene_vpi.exr",
    ),
    (Output::Mat, "mat", "scene_5d.mat: the raw image's integers as a 5D array for MATLAB"),
    (Output::H5, "h5", "scene_5d.h5: linear radiance and the layers of depth and disparity as 5D arrays"),
    (Output::Hci, "hci", "hci/: a PNG a view with depth and disparity, in the layout of the HCI benchmark"),
    (Output::HciHighres, "hci-highres", "hci, with ground truth of the central view in ten times the resolution"),
    (Output::Raw, "raw", "Plenoptic camera: raw.exr, the raw image, linear"),
    (Output::RawPng, "raw-png", "Plenoptic camera: raw_linear.png, the same with 16 bits"),
    (Output::White, "white", "Plenoptic camera: white.exr and white.png"),
    (Output::Centers, "centers", "Plenoptic camera: centers.csv, the centers of the micro-images"),
];

pub const NORMALS: &Choices<NormalsArgument> = &[
    (NormalsArgument::Pinhole, "pinhole", "Angles between the surfaces that the cameras see"),
    (
        NormalsArgument::Toolkit,
        "toolkit",
        "Beside them those of the HCI benchmark's evaluation toolkit, whose point cloud is sheared: what it publishes",
    ),
];

pub const ORDERS: &Choices<ViewOrder> = &[
    (ViewOrder::RowMajor, "row-major", "Every row from left to right, as the HCI benchmark counts"),
    (ViewOrder::Serpentine, "serpentine", "Every second row from right to left, as a gantry moves"),
];

pub const KERNELS: &Choices<Kernel> = &[
    (Kernel::CatmullRom, "cubic", "Catmull-Rom cubic: sharper"),
    (Kernel::Bilinear, "bilinear", "The two or four nearest pixels"),
];

pub const EFFORTS: &Choices<Effort> = &[
    (Effort::Draft, "draft", "A handful of views"),
    (Effort::Fast, "fast", "More views, no refinement of the whole image"),
    (Effort::Balanced, "balanced", "A good map in reasonable time"),
    (Effort::Thorough, "thorough", "All views and every refinement"),
];

/// A parser of these words.
pub fn choice<T: Copy + Send + Sync + 'static>(choices: &'static Choices<T>) -> impl TypedValueParser<Value = T> {
    let values = choices.iter().map(|&(_, name, help)| {
        // The British spelling of version 0.1.0.
        let value = PossibleValue::new(name).help(help);
        if name == "color" { value.alias("colour") } else { value }
    });
    PossibleValuesParser::new(values).try_map(move |word| {
        let word = if word == "colour" { "color" } else { &word };
        choices.iter().find(|choice| choice.1 == word).map(|choice| choice.0).ok_or("not one of the words")
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_of_the_command_line_are_names_of_the_library() {
        assert!(LAYERS.iter().all(|&(layer, name, _)| layer.name() == name));
        assert_eq!(LAYERS.len(), Layer::COUNT + RawLayer::ALL.len() + 6);
        assert!(OUTPUTS.iter().all(|&(output, name, _)| output.name() == name));
        assert!(INTEGRATORS.iter().all(|&(value, name, _)| holo_dataset::options::integrator_name(value) == name));
    }
}

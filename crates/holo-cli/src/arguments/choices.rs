//! The words that options take, with what they mean: values of the libraries.

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use holo_core::refocus::Kernel;
use holo_core::sensor::Demosaic;
use holo_core::{Effort, Layout, ViewOrder};
use holo_dataset::DevelopOutput;
use holo_io::WorldUp;
use holo_render::Backend;

/// `--normals`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NormalsArgument {
    /// The true rays.
    Pinhole,
    /// The true rays, and the point cloud of the HCI benchmark's toolkit.
    Toolkit,
}

/// What cameras stand on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SurfaceArgument {
    Plane,
    Cylinder,
    Sphere,
}

/// A value, its word, and its line of `--help`; one without a line has none.
type Choices<T> = [(T, &'static str, &'static str)];

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

pub const BACKENDS: &Choices<Backend> = &[
    (Backend::Auto, "auto", "Embree if it is installed, else the built-in BVH"),
    (Backend::Embree, "embree", "Intel Embree 4"),
    (Backend::Bvh, "bvh", "The built-in bounding volume hierarchy"),
];

pub const LAYOUTS: &Choices<Layout> = &[
    (Layout::ViewpointGrid, "vpi", "A grid of viewpoint images (sub-aperture images)"),
    (Layout::ElementalGrid, "el", "A grid of elemental images (micro-images): the raw image of the sensor"),
];

pub const SURFACES: &Choices<SurfaceArgument> = &[
    (SurfaceArgument::Plane, "plane", "A grid or a line in front of the target, with parallel axes"),
    (SurfaceArgument::Cylinder, "cylinder", "An arc or a circle around the target, in one row or several"),
    (SurfaceArgument::Sphere, "sphere", "Evenly on a sphere, or a part of it, around the target"),
];

pub const WORLD_UPS: &Choices<WorldUp> =
    &[(WorldUp::Z, "z", "As in Blender and nerfstudio"), (WorldUp::Y, "y", "As in glTF")];

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
    (ViewOrder::ColumnMajor, "column-major", "Every column from above"),
    (ViewOrder::ColumnSerpentine, "column-serpentine", "Every second column from below"),
    (ViewOrder::RowMajorUp, "row-major-up", "row-major with the lowest row first"),
    (ViewOrder::SerpentineUp, "serpentine-up", "serpentine with the lowest row first"),
    (ViewOrder::ColumnMajorUp, "column-major-up", "Every column from below"),
    (ViewOrder::ColumnSerpentineUp, "column-serpentine-up", "column-serpentine with the first column from below"),
];

pub const KERNELS: &Choices<Kernel> = &[
    (Kernel::CatmullRom, "cubic", "Catmull-Rom cubic: sharper"),
    (Kernel::Bilinear, "bilinear", "The two or four nearest pixels"),
];

pub const EFFORTS: &Choices<Effort> = &[
    (Effort::Draft, "draft", "A handful of views"),
    (Effort::Fast, "fast", "More views, no refinement of the whole image"),
    (Effort::Balanced, "balanced", "A good map in reasonable time"),
    (Effort::Thorough, "thorough", "Up to 9 x 9 views, every refinement"),
];

/// A parser of these words.
pub fn choice<T: Copy + Send + Sync + 'static>(choices: &'static Choices<T>) -> impl TypedValueParser<Value = T> {
    let values = choices.iter().map(|&(_, name, help)| PossibleValue::new(name).help(help));
    PossibleValuesParser::new(values).try_map(move |word| {
        choices.iter().find(|choice| choice.1 == word).map(|choice| choice.0).ok_or("not one of the words")
    })
}

//! The words of settings, with what they mean.

use holo_core::Projection;
use holo_io::{ManifestValue, MatOrder};
use holo_render::{Backend, Denoise, GroundTruth, Integrator, Layer, Reuse, TextureFilter};
use holo_scene::gltf::LightUnits;

use super::declare::words;
use super::types::{LayerChoice, Output, RawLayer, Tool};
use super::value::{Kind, Malformed, SettingType, Word};

words!(LightUnits:
    (LightUnits::Gltf, "gltf", "Candela and lux, as glTF prescribes"),
    (LightUnits::Blender, "blender", "Those of Blender's lighting mode \"Standard\", 683 times as bright"),
    (LightUnits::Auto, "auto", "By the generator of the file and its numbers"),
);

words!(Integrator:
    (Integrator::Auto, "auto", "The cheapest that is exact for the scene"),
    (Integrator::Depth, "depth", "Ground truth alone, without color"),
    (Integrator::Direct, "direct", "Direct light"),
    (Integrator::Path, "path", "Path tracing: global illumination"),
);

words!(Denoise:
    (Denoise::Off, "off", "No: every pixel is the mean of its own samples"),
    (Denoise::Views, "views", "By neighboring views"),
);

words!(Reuse:
    (Reuse::Off, "off", "No: the noise of every pixel is independent"),
    (Reuse::Views, "views", "Between groups of 16 neighboring views, whose noise does not move with disparity"),
);

words!(TextureFilter:
    (TextureFilter::Off, "off", "No: the texture at the hit point"),
    (TextureFilter::Footprint, "footprint", "The mean over a cell of the pixel"),
);

words!(GroundTruth:
    (GroundTruth::Central, "central", "Of the central view"),
    (GroundTruth::All, "all", "Of every view"),
);

words!(Projection:
    (Projection::Perspective, "perspective", "Every view is a pinhole camera"),
    (Projection::Orthographic, "orthographic", "The rays of a view are parallel"),
);

words!(Backend:
    (Backend::Auto, "auto", "Embree if it is installed, else the built-in BVH"),
    (Backend::Embree, "embree", "Intel Embree 4"),
    (Backend::Bvh, "bvh", "The built-in bounding volume hierarchy"),
);

words!(MatOrder:
    (MatOrder::Lenses, "lenses", "`H` of size [V U T S C]: microlenses first"),
    (MatOrder::LightFieldToolbox, "lftoolbox", "`LF` of size [T S V U C]: views first, as in the Light Field Toolbox"),
);

words!(LayerChoice:
    (LayerChoice::Color, "color", "The image in linear light, without exposure"),
    (LayerChoice::One(Layer::Depth), "depth", "Along the optical axis, m; infinity where nothing was hit"),
    (LayerChoice::One(Layer::RayLength), "ray-length", "Along the ray, m; infinity where nothing was hit"),
    (LayerChoice::One(Layer::Disparity), "disparity", "Between adjacent views, px; also as a PNG"),
    (LayerChoice::One(Layer::GeometricNormal), "geometric-normal", "Of the triangle, in world space, on the visible side"),
    (LayerChoice::One(Layer::ShadingNormal), "shading-normal", "Interpolated between the vertices, likewise"),
    (LayerChoice::One(Layer::Albedo), "albedo", "Base color, linear"),
    (LayerChoice::One(Layer::ObjectId), "object-id", "Number of the instance, from 1; 0 where nothing was hit"),
    (LayerChoice::One(Layer::MaterialId), "material-id", "Number of the material, from 1; 0 where nothing was hit"),
    (LayerChoice::One(Layer::HitMask), "hit-mask", "1 where something was hit, else 0"),
    (LayerChoice::One(Layer::Reflective), "reflective", "1 where the surface mirrors light, 2 where it lets it pass, else 0"),
    (LayerChoice::All, "all", "All of the above, and all of a plenoptic camera"),
    (LayerChoice::Visibility, "visibility", "Part of all views that see the point; 1: all. Of the central view alone"),
    (LayerChoice::OpticalFlow, "optical-flow",
        "With `frame`: where the image of a point moves until the next frame, px (.flo)"),
    (LayerChoice::SceneFlow, "scene-flow", "With `frame`: how the point moves in world space until the next frame, m"),
    (LayerChoice::Raw(RawLayer::LensRow), "lens-row", "Plenoptic camera: row of the nearest micro-image"),
    (LayerChoice::Raw(RawLayer::LensColumn), "lens-column", "Its column"),
    (LayerChoice::Raw(RawLayer::LensType), "lens-type", "Its type of microlens, from 0"),
    (LayerChoice::Raw(RawLayer::White), "white", "Light of a scene of radiance 1"),
    (LayerChoice::Raw(RawLayer::VirtualDepth), "virtual-depth",
        "Distance of the main lens's image from the array, in gaps"),
    (LayerChoice::Raw(RawLayer::Blur), "blur", "Diameter of the blur, px"),
    (LayerChoice::Raw(RawLayer::InverseDepthMean), "inverse-depth-mean",
        "Mean of 1 / depth over what a pixel sees, 1/m"),
    (LayerChoice::Raw(RawLayer::InverseDepthDeviation), "inverse-depth-deviation", "Its standard deviation"),
    (LayerChoice::Raw(RawLayer::Coverage), "coverage", "Share of the light that comes from surfaces"),
    (LayerChoice::Error, "error", "Estimated relative standard error of color, bias included"),
);

words!(Output:
    (Output::Vpi, "vpi", "scene_vpi.png: all views side by side"),
    (Output::El, "el", "scene_el.png: the raw image of the sensor behind the microlenses"),
    (Output::Disparity, "disparity", "scene_disparity.pfm and .png of the central view"),
    (Output::Depth, "depth", "scene_depth.pfm of the central view"),
    (Output::Masks, "masks",
        "masks/: valid, occluded, textureless, reflective, plane, fine.. pixels of the central view, for scores"),
    (Output::Exr, "exr",
        "scene_central.exr: color and all layers of the central view, linear. With el or vpi also scene_el.exr, \
         scene_vpi.exr"),
    (Output::Mat, "mat", "scene_5d.mat: the raw image's integers as a 5D array for MATLAB"),
    (Output::H5, "h5", "scene_5d.h5: linear radiance and the layers of depth and disparity as 5D arrays"),
    (Output::Hci, "hci", "hci/: a PNG a view with depth and disparity, in the layout of the HCI benchmark"),
    (Output::HciHighres, "hci-highres", "hci, with ground truth of the central view in ten times the resolution"),
    (Output::Raw, "raw", "Plenoptic camera: raw.exr, the raw image, linear"),
    (Output::RawPng, "raw-png", "Plenoptic camera: raw_linear.png, the same with 16 bits"),
    (Output::White, "white", "Plenoptic camera: white.exr and white.png"),
    (Output::Centers, "centers", "Plenoptic camera: centers.csv, the centers of the micro-images"),
);

words!(Tool:
    (Tool::LfToolbox, "lftoolbox", "Light Field Toolbox for MATLAB (D. Dansereau)"),
    (Tool::PlenoptiCam, "plenopticam", "PlenoptiCam (C. Hahne)"),
    (Tool::Libpleno, "libpleno", "libpleno, COMPOTE (M. Labussiere)"),
    (Tool::Pip, "pip", "PIP, Plenoptic Image Processing (Kiel University)"),
    (Tool::Raytrix, "raytrix", "Raytrix's calibration, for PlenopticToolbox2.0 (L. Palmieri)"),
    (Tool::Plenpy, "plenpy", "plenpy (M. Schambach)"),
    (Tool::Lytro, "lytro", "Files of Lytro's cameras, for LFToolbox"),
);

/// The name of a value of an enum.
macro_rules! named {
    ($($type:ty),*) => {$(
        impl $type {
            /// Returns the name on the command line and in files.
            #[must_use]
            pub fn name(self) -> &'static str {
                name(&self)
            }
        }
    )*};
}

named!(LayerChoice, Output, Tool);

/// Returns the word of a value of an enum.
#[must_use]
pub fn name<T: SettingType>(value: &T) -> &'static str {
    let (ManifestValue::Text(name), Kind::Word(words)) = (value.value(), T::KIND) else { return "" };
    words.iter().find(|word| word.name == name).map_or("", |word| word.name)
}

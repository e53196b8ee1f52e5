//! Options of loading.

use super::Limits;

/// Options of [`load_with`](super::load_with). Make one with `LoadOptions::default()` and change its fields.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct LoadOptions {
    /// Limits of the size of a file.
    pub limits: Limits,
    /// The unit of the intensities of lights.
    pub light_units: LightUnits,
    /// Whether closed meshes with transmission but without a volume are bodies of glass. As glTF defines them, they are
    /// thin panes without refraction, like soap bubbles.
    pub solid_glass: bool,
    /// The name of a variant of `KHR_materials_variants`; `None`: the materials of the primitives.
    pub material_variant: Option<String>,
    /// The time of the animations of the file, s; `None`: the pose of the nodes without animation.
    pub time_s: Option<f64>,
    /// The name of the animation to play, or its index; `None`: all of them.
    pub animation: Option<String>,
}

/// The unit of the intensities of lights in a file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum LightUnits {
    /// Those of `KHR_lights_punctual`: candela and lux, used as numbers.
    #[default]
    Gltf,
    /// Those that Blender writes with its lighting mode "Standard": 683 lm/W times its own. They are divided by 683, so
    /// that lights are as bright beside emissive materials as in Blender.
    Blender,
    /// [`LightUnits::Blender`] for a file whose generator is Blender and whose lights all look like its mode "Standard",
    /// else [`LightUnits::Gltf`].
    Auto,
}

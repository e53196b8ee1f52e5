//! The gallery: scenes built in code, identical on all machines.
//!
//! A scene of the gallery is an ordinary [`Scene`]. It can be rendered, changed, or written with
//! [`crate::gltf::to_glb`] without loss: the indirect light comes from an emissive room, not from an environment map
//! (`garden` has only a sun and a lamp). All scenes have table-top scale (0.2 to 1 m, except for lamps and the room
//! around them). Every scene has one camera with an aspect ratio of 3:2 and a focal length of 50 mm (39 mm: `garden`)
//! on a 36 mm sensor, and no view sees past the scene.
//!
//! The last column is the largest disparity between adjacent views for 20 x 20 views of 397 x 265 pixels at f/5 with
//! automatic focus; the smallest is its negative.
//!
//! | name | purpose | largest disparity, px |
//! |---|---|---|
//! | `garden` | dense foliage of many instances, textured background, hard shadows | 0.16 |
//! | `mirror` | a mirror, metal and glaze before a papered wall | 0.11 |
//! | `clockwork` | rough metals in many thin layers | 0.12 |
//! | `glasses` | clear glass: refraction, total internal reflection | 0.17 |
//! | `bottles` | colored thick glass before the light | 0.18 |
//! | `birdcage` | thin structures and their shadows | 0.14 |
//! | `chess` | soft and hard shadows over a pattern | 0.20 |
//! | `mountains` | slanted and layered planes | 0.14 |
//! | `billiards` | specular highlights | 0.24 |
//! | `tiles` | repetitive texture, equal to the last texel | 0.11 |
//! | `plaster` | textureless surfaces | 0.14 |
//! | `curtains` | transparency by alpha: holes and veils | 0.12 |
//! | `lanterns` | emissive light from within the scene | 0.15 |
//! | `dominoes` | a large range of depths | 0.35 |
//! | `fruit` | a still life of all materials | 0.15 |
//! | `fence` | depth through a fence before foliage | 0.17 |
//!
//! Four more vary one difficulty of the estimation of depth each ([`STRATIFIED`]): `backgammon` (fine structures), `dots` (small
//! objects in little light), `pyramids` (planes and curves), `stripes` (contrast and texture at occlusions).
//!
//! Three more move ([`ANIMATED`], [`animation`]): `pendulum` swings before a wall, in `turning_clockwork` the wheels turn,
//! and in `garden_walk` the camera walks over the lawn.

mod billiards;
mod birdcage;
mod bottles;
mod chess;
mod clockwork;
mod curtains;
mod dominoes;
mod fence;
mod fruit;
mod garden;
mod glasses;
mod lanterns;
mod mirror;
mod mountains;
mod pendulum;
mod plaster;
mod stratified;
#[cfg(test)]
mod tests;
mod tiles;

use crate::animation::Animation;
use crate::{Error, Scene, gltf};

/// The names of the scenes that a dataset has unless others are named, in the order of the table above: first the oldest, then by difficulty (mirrors and glass,
/// shapes, light, all together), and last one that is hard for the estimation of depth.
pub const NAMES: &[&str] = &[
    "garden",
    "mirror",
    "clockwork",
    "glasses",
    "bottles",
    "birdcage",
    "chess",
    "mountains",
    "billiards",
    "tiles",
    "plaster",
    "curtains",
    "lanterns",
    "dominoes",
    "fruit",
    "fence",
];

/// The number of scenes at the beginning of [`NAMES`] that the paper's dataset has.
pub const OF_PAPER: usize = 15;

/// The names of the stratified scenes. They are no part of a dataset unless they are named.
pub const STRATIFIED: &[&str] = &["backgammon", "dots", "pyramids", "stripes"];

/// The names of the animated scenes. They are no part of a dataset unless they are named.
pub const ANIMATED: &[&str] = &["pendulum", "turning_clockwork", "garden_walk"];

/// Returns the names of all scenes: [`NAMES`], [`STRATIFIED`], [`ANIMATED`].
pub fn all_names() -> impl Iterator<Item = &'static str> + Clone {
    NAMES.iter().chain(STRATIFIED).chain(ANIMATED).copied()
}

/// Builds the scene with this name, an animated one at rest; `None` for an unknown name.
#[must_use]
pub fn scene(name: &str) -> Option<Scene> {
    let build = match name {
        "garden" => garden::scene,
        "mirror" => mirror::scene,
        "clockwork" => clockwork::scene,
        "glasses" => glasses::scene,
        "bottles" => bottles::scene,
        "birdcage" => birdcage::scene,
        "chess" => chess::scene,
        "mountains" => mountains::scene,
        "billiards" => billiards::scene,
        "tiles" => tiles::scene,
        "plaster" => plaster::scene,
        "curtains" => curtains::scene,
        "lanterns" => lanterns::scene,
        "dominoes" => dominoes::scene,
        "fruit" => fruit::scene,
        "fence" => fence::scene,
        "backgammon" => stratified::backgammon,
        "dots" => stratified::dots,
        "pyramids" => stratified::pyramids,
        "stripes" => stratified::stripes,
        "pendulum" => pendulum::scene,
        "turning_clockwork" => clockwork::scene,
        "garden_walk" => garden::scene,
        _ => return None,
    };
    Some(build())
}

/// The scene with this name as binary glTF, an animated one with its animation; `None` for an unknown name.
///
/// # Errors
/// As [`gltf::to_glb`].
pub fn to_glb(name: &str) -> Option<Result<Vec<u8>, Error>> {
    let scene = scene(name)?;
    Some(match animation(name) {
        Some(animation) => gltf::to_glb_animated(&scene, &animation),
        None => gltf::to_glb(&scene),
    })
}

/// The animation of the scene with this name; `None` if it rests.
#[must_use]
pub fn animation(name: &str) -> Option<Animation> {
    match name {
        "pendulum" => Some(pendulum::animation()),
        "turning_clockwork" => Some(clockwork::animation()),
        "garden_walk" => Some(garden::walk()),
        _ => None,
    }
}

/// The purpose of the scene with this name; `None` for an unknown name.
#[must_use]
pub fn purpose(name: &str) -> Option<&'static str> {
    Some(match name {
        "garden" => "dense foliage of many instances, textured background, hard shadows",
        "mirror" => "a mirror, metal and glaze before a papered wall",
        "clockwork" => "rough metals in many thin layers",
        "glasses" => "clear glass: refraction, total internal reflection",
        "bottles" => "colored thick glass before the light",
        "birdcage" => "thin structures and their shadows",
        "chess" => "soft and hard shadows over a pattern",
        "mountains" => "slanted and layered planes",
        "billiards" => "specular highlights",
        "tiles" => "repetitive texture, equal to the last texel",
        "plaster" => "textureless surfaces",
        "curtains" => "transparency by alpha: holes and veils",
        "lanterns" => "emissive light from within the scene",
        "dominoes" => "a large range of depths",
        "fruit" => "a still life of all materials",
        "fence" => "depth through a fence before foliage",
        "backgammon" => "stratified: fine structures, occlusions and steps of disparity",
        "dots" => "stratified: small objects in less and less light",
        "pyramids" => "stratified: planes and curves, convex and concave",
        "stripes" => "stratified: contrast and texture at occlusions",
        "pendulum" => "animated: a pendulum before resting textures",
        "turning_clockwork" => "animated: turning wheels of rough metal",
        "garden_walk" => "animated: a camera path through dense foliage",
        _ => return None,
    })
}

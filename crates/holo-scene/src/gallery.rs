//! Scenes built in code: nothing to download, the same bytes everywhere.
//!
//! A scene of the gallery is an ordinary [`Scene`]: render it, change it, or export it with [`crate::gltf::to_glb`], which
//! leaves nothing out: what fills the shadows is a room that glows, not an environment map (`garden` has a sun and a lamp
//! alone). All are at table-top scale (0.2 to 1 m but for lamps and the room they stand in) and seen through a lens of 50 mm
//! (39 mm: `garden`). The last
//! column has the largest disparity between neighbors of 20 x 20 views of 397 x 265 pixels at f/5 with automatic focus;
//! the least is its negative. No view sees past the scene. Every scene has one camera, for pictures of 3:2.
//!
//! | name | what it is there for | largest disparity, px |
//! |---|---|---|
//! | `garden` | dense foliage of many instances, textured background, hard shadows | 0.16 |
//! | `mirror` | a mirror, metal and glaze before a papered wall | 0.12 |
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

mod billiards;
mod birdcage;
mod bottles;
mod chess;
mod clockwork;
mod curtains;
mod dominoes;
mod fruit;
mod garden;
mod glasses;
mod lanterns;
mod materials;
mod mirror;
mod mountains;
mod noise;
mod patterns;
mod plaster;
mod shapes;
mod solids;
mod studio;
#[cfg(test)]
mod tests;
mod textures;
mod tiles;

use crate::Scene;

/// The names that [`scene`] knows, in the order of the table above: the oldest first, then by what is hard about them,
/// from mirrors and glass over shapes and light to all at once.
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
];

/// The scene of this name, or `None`.
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
        _ => return None,
    };
    Some(build())
}

/// What the scene of this name is there for, or `None`.
#[must_use]
pub fn purpose(name: &str) -> Option<&'static str> {
    Some(match name {
        "garden" => "dense foliage of many instances, textured background, hard shadows",
        "mirror" => "a mirror, metal and glaze before a papered wall",
        "clockwork" => "rough metals in many thin layers",
        "glasses" => "clear glass: refraction, total internal reflection",
        "bottles" => "coloured thick glass before the light",
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
        _ => return None,
    })
}

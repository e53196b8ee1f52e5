//! What the scenes of a set have, measured in its truth: properties by the masks of the central views, and near-duplicates.

use std::fmt;
use std::path::Path;

use holo_io::dataset::{DISPARITY_PFM, DatasetIndex};
use holo_io::{Limits, Manifest};
use holo_scene::recipe::Recipe;

use crate::Error;
use crate::output::Statistics;

/// The properties: a scene has one if at least this part of its central view is in a mask.
const PROPERTIES: [(&str, &str, f64); 8] = [
    ("thin", "fine", 0.05),
    ("occluding", "occluded", 0.1),
    ("slanted", "slanted", 0.1),
    ("textureless", "textureless", 0.3),
    ("repetitive", "repetitive", 0.01),
    ("reflective", "reflective", 0.1),
    ("transparent", "transparent", 0.03),
    ("foliage", "discontinuity", 0.4),
];

/// Two scenes are near-duplicates if so many of 64 differences between places of their disparity maps have another sign, or
/// fewer, and the mean colors of their views differ by less than that, as a part of white.
const HASH_BITS: u32 = 4;
const COLOR: f64 = 0.02;

/// What the scenes of a set have. Prints as a table.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct SetProperties {
    /// The number of finished scenes with masks.
    pub scenes: usize,
    /// For each property, the share of scenes that have it.
    pub shares: Vec<(&'static str, f64)>,
    /// The number of scenes that resemble an earlier one.
    pub near_duplicates: usize,
}

/// A scene, as short as it can be compared.
struct Digest {
    signs: u64,
    color: [f64; 3],
}

impl SetProperties {
    /// Reads the finished folders of a dataset, of several cameras those of the first. Folders without masks are left out.
    ///
    /// # Errors
    /// [`Error::Io`] if `dataset.json` or a manifest cannot be read.
    pub fn read(root: &Path) -> Result<Self, Error> {
        let index = DatasetIndex::read(root)?;
        let (mut scenes, mut counts, mut near_duplicates) = (0, [0; PROPERTIES.len()], 0);
        let mut known: Vec<Digest> = Vec::new();
        let Some(camera) = index.cameras.first() else {
            return Ok(Self { scenes, shares: Vec::new(), near_duplicates });
        };
        for scene in &index.scenes {
            let folder = root.join(camera.folder(&scene.name)?);
            let path = folder.join(holo_io::dataset::MANIFEST_JSON);
            if !path.is_file() {
                continue;
            }
            let statistics = Statistics::of_manifest(&Manifest::read(path)?);
            if statistics.masks.is_empty() {
                continue;
            }
            scenes += 1;
            for (count, (_, mask, least)) in counts.iter_mut().zip(PROPERTIES) {
                *count += usize::from(statistics.masks.get(mask).is_some_and(|part| *part >= least));
            }
            if let Some(digest) = digest(&folder, &statistics) {
                near_duplicates += usize::from(known.iter().any(|other| is_near(other, &digest)));
                known.push(digest);
            }
        }
        let share = |count: usize| count as f64 / scenes.max(1) as f64;
        let shares = PROPERTIES.iter().zip(counts).map(|((name, ..), count)| (*name, share(count))).collect();
        Ok(Self { scenes, shares, near_duplicates })
    }

    /// The properties whose shares are not as the recipe says: the property, its share, and the least and largest it may be. Of
    /// few scenes a share may be off by two standard deviations.
    #[must_use]
    pub fn beyond(&self, recipe: &Recipe) -> Vec<(String, f64, [f64; 2])> {
        let mut out = Vec::new();
        if self.scenes == 0 {
            return out;
        }
        for (name, [low, high]) in recipe.shares() {
            let Some((_, share)) = self.shares.iter().find(|(known, _)| *known == name) else { continue };
            let slack = |bound: f64| 2.0 * (bound * (1.0 - bound) / self.scenes as f64).sqrt();
            if *share < low - slack(low) || *share > high + slack(high) {
                out.push((name.to_owned(), *share, [low, high]));
            }
        }
        out
    }
}

/// The names of all properties.
pub(super) fn names() -> impl Iterator<Item = &'static str> {
    PROPERTIES.iter().map(|(name, ..)| *name)
}

/// What a scene is compared by, if it has a disparity map.
fn digest(folder: &Path, statistics: &Statistics) -> Option<Digest> {
    let map = holo_io::read_pfm_gray(folder.join(DISPARITY_PFM), &Limits::default()).ok()?;
    let (rows, columns) = map.dim();
    if rows < 8 || columns < 9 {
        return None;
    }
    // The mean of the map over 8 x 9 parts.
    let part = |v: usize, u: usize| {
        let (from, to) = ([v * rows / 8, u * columns / 9], [(v + 1) * rows / 8, (u + 1) * columns / 9]);
        let places = (from[0]..to[0]).flat_map(|y| (from[1]..to[1]).map(move |x| [y, x]));
        let (sum, count) = places.fold((0.0, 0.0), |(sum, count), place| (sum + f64::from(map[place]), count + 1.0));
        sum / count
    };
    let mut signs = 0;
    for (v, u) in (0..8).flat_map(|v| (0..8).map(move |u| (v, u))) {
        signs = signs << 1 | u64::from(part(v, u) > part(v, u + 1));
    }
    Some(Digest { signs, color: statistics.color.map_or([0.0; 3], |color| color.mean) })
}

fn is_near(a: &Digest, b: &Digest) -> bool {
    let is_same_color = a.color.iter().zip(b.color).all(|(a, b)| (a - b).abs() < COLOR);
    is_same_color && (a.signs ^ b.signs).count_ones() <= HASH_BITS
}

impl fmt::Display for SetProperties {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} scenes with masks; of them", self.scenes)?;
        for (k, (name, share)) in self.shares.iter().enumerate() {
            write!(f, "{} {:.0} % {name}", if k > 0 { "," } else { "" }, 100.0 * share)?;
        }
        write!(f, "; {} near-duplicates", self.near_duplicates)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_beyond_the_recipe_are_named() {
        let text = Recipe::by_name("mixed").unwrap().text().to_owned();
        let text = text.split("[shares]").next().unwrap().to_owned();
        let recipe =
            Recipe::from_toml(&format!("{text}\n[shares]\nthin = [0.2, 0.5]\nslanted = [0.5, 1.0]\n")).unwrap();
        let of = |thin, slanted, scenes| SetProperties {
            scenes,
            shares: vec![("thin", thin), ("slanted", slanted), ("foliage", 1.0)],
            near_duplicates: 0,
        };
        assert_eq!(of(0.3, 0.7, 1000).beyond(&recipe), []);
        assert_eq!(
            of(0.6, 0.4, 1000).beyond(&recipe),
            [("slanted".to_owned(), 0.4, [0.5, 1.0]), ("thin".to_owned(), 0.6, [0.2, 0.5])]
        );
        // By chance, of 20 scenes.
        assert_eq!(of(0.6, 0.4, 20).beyond(&recipe), []);
        assert_eq!(names().count(), PROPERTIES.len());
    }

    #[test]
    fn scenes_that_resemble_each_other_are_found() {
        let folder = tempfile::tempdir().unwrap();
        let of = |name: &str, disparity: fn(usize, usize) -> f32| {
            let inner = folder.path().join(name);
            std::fs::create_dir(&inner).unwrap();
            let map = ndarray::Array2::from_shape_fn((32, 45), |(v, u)| disparity(v, u));
            holo_io::write_pfm(inner.join(DISPARITY_PFM), map.view()).unwrap();
            digest(&inner, &Statistics::default()).unwrap()
        };
        let waves = of("waves", |v, u| ((v + 2 * u) as f32 * 0.2).sin());
        let same = of("same", |v, u| 0.5 * ((v + 2 * u) as f32 * 0.2).sin() + 0.01 * (u % 3) as f32);
        let other = of("other", |v, u| ((3 * v + u) as f32 * 0.1).cos());
        assert!(is_near(&waves, &same));
        assert!(!is_near(&waves, &other));
        let colored = Digest { color: [0.1; 3], ..same };
        assert!(!is_near(&waves, &colored), "of another color");
    }
}

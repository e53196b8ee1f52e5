//! The regions of the four stratified scenes ([`holo_scene::gallery::STRATIFIED`]), by the objects that pixels see.
//!
//! | scene | region | pixels | score |
//! |---|---|---|---|
//! | backgammon | `spikes` | the spikes | thinning: nearer to the background |
//! | | `between_spikes` | the background in columns with spikes | fattening: nearer to the foreground |
//! | dots | `boxes` | what is no dot | MSE x 100 |
//! | | `dots` | the eight largest dots of each box | missed dots: half of the pixels or more are off by more than 0.4 px |
//! | pyramids | `relief` | pyramids and balls | bumpiness |
//! | | `base` | what surrounds them | bumpiness |
//! | stripes | `dark_stripes`, `bright_stripes` | the stripes | BadPix(0.07) |
//!
//! # Source
//! Scores and scenes are those of the HCI benchmark (Honauer et al., ACCV 2016); the files of its evaluation toolkit have other
//! names, [`Objects::toolkit_masks`].

use std::path::Path;

use holo_core::DynImage;
use holo_io::dataset::MANIFEST_JSON;
use holo_io::{Folder, Limits, Manifest, ManifestValue};
use ndarray::{Array2, Axis};

use super::RegionMask;
use crate::Error;
use crate::output::OBJECTS_PNG;

/// The names of the objects of each scene.
const SCENES: [&[&str]; 4] = [
    &["background", "foreground", "spikes"],
    &["box", "dot"],
    &["base", "pyramids", "balls out", "balls in"],
    &["background", "dark stripes", "bright stripes"],
];

/// What lights the scenes, and is not seen.
const ROOM: &str = "room, ";

/// The dots of a box of `dots`, from the largest. The last is left out of the score.
const DOTS: usize = 9;

/// The columns that the spikes of `backgammon` are counted in, for plots of the toolkit.
const BINS: usize = 15;

/// The objects that the pixels of the central view of a stratified scene see.
pub(crate) struct Objects {
    names: Vec<String>,
    /// The number of an object, from 1; 0 where nothing is hit.
    labels: Array2<usize>,
}

impl Objects {
    /// Reads the objects of a map: `masks/objects.png` and the manifest, which lie beside it or in the folder above. `None`
    /// if they are those of another scene, or of another size.
    pub fn read(map: &Path, dim: (usize, usize)) -> Result<Option<Self>, Error> {
        let folder = Folder::around(map).into_iter().find(|folder| folder.has_file(OBJECTS_PNG));
        let Some(folder) = folder.filter(|folder| folder.has_file(MANIFEST_JSON)) else { return Ok(None) };
        let manifest = Manifest::read_in(&folder)?;
        let Some(ManifestValue::List(names)) = manifest.settings.get("objects") else { return Ok(None) };
        let text = |name: &ManifestValue| match name {
            ManifestValue::Text(name) => name.clone(),
            _ => String::new(),
        };
        let names: Vec<String> = names.iter().map(text).collect();
        let is_stratified = SCENES.iter().any(|known| {
            known.iter().all(|known| names.iter().any(|name| name == known))
                && names.iter().all(|name| known.contains(&&**name) || name.starts_with(ROOM))
        });
        if !is_stratified {
            return Ok(None);
        }
        let DynImage::U16(image) = holo_io::read_png(folder.path_of(OBJECTS_PNG), &Limits::default())? else {
            return Ok(None);
        };
        let labels = image.index_axis(Axis(2), 0).mapv(usize::from);
        Ok((labels.dim() == dim).then_some(Self { names, labels }))
    }

    /// The regions of the scene.
    pub fn regions(&self) -> Vec<RegionMask> {
        let mut out: Vec<RegionMask> = [
            ("spikes", &["spikes"][..]),
            ("boxes", &["box"]),
            ("relief", &["pyramids", "balls out", "balls in"]),
            ("base", &["base"]),
            ("dark_stripes", &["dark stripes"]),
            ("bright_stripes", &["bright stripes"]),
        ]
        .into_iter()
        .filter(|(_, names)| self.has(names[0]))
        .map(|(region, names)| (region.to_owned(), self.seen(names)))
        .collect();
        if self.has("spikes") {
            out.push(("between_spikes".into(), self.between_spikes()));
        }
        if self.has("dot") {
            out.push(("dots".into(), self.dots().mapv(|size| (1..DOTS).contains(&usize::from(size)))));
        }
        out
    }

    /// The masks of the scene under their names in the toolkit, but for what has no texture.
    pub fn toolkit_masks(&self) -> Vec<(&'static str, Array2<u8>)> {
        let binary = |mask: Array2<bool>| mask.mapv(|is_in| if is_in { 255 } else { 0 });
        let of = |names: &[&str]| binary(self.seen(names));
        if self.has("spikes") {
            return vec![
                ("mask_foreground", of(&["foreground", "spikes"])),
                ("mask_background", of(&["background"])),
                ("mask_foreground_thinning", of(&["spikes"])),
                ("mask_foreground_fattening", binary(self.between_spikes())),
                ("mask_vertical_bins", self.bins()),
            ];
        }
        if self.has("dot") {
            return vec![
                ("mask_background", of(&["box"])),
                ("mask_boxes", self.boxes()),
                ("mask_dots_by_size", self.dots()),
            ];
        }
        if self.has("base") {
            return vec![
                ("mask_plane", of(&["base"])),
                ("mask_pyramids", of(&["pyramids"])),
                ("mask_sphere_out", of(&["balls out"])),
                ("mask_sphere_in", of(&["balls in"])),
            ];
        }
        vec![("mask_high_contrast", of(&["dark stripes"])), ("mask_low_contrast", of(&["bright stripes"]))]
    }

    fn has(&self, name: &str) -> bool {
        self.names.iter().any(|own| own == name)
    }

    /// The object that a label stands for: how many of its name come before it, and its name.
    fn object(&self, label: usize) -> Option<(usize, &str)> {
        let name = self.names.get(label.checked_sub(1)?)?;
        let before = self.names[..label - 1].iter().filter(|other| *other == name).count();
        Some((before, name))
    }

    /// A value for each object, at the pixels that see it.
    fn painted(&self, value: impl Fn(usize, &str) -> u8) -> Array2<u8> {
        let object = |label| self.object(label).map_or(0, |(number, name)| value(number, name));
        let values: Vec<u8> = (0..=self.names.len()).map(object).collect();
        self.labels.mapv(|label| values.get(label).copied().unwrap_or(0))
    }

    /// The pixels that see objects of these names.
    fn seen(&self, names: &[&str]) -> Array2<bool> {
        self.painted(|_, name| names.contains(&name).into()).mapv(|is_seen| is_seen > 0)
    }

    /// For each dot its number by size, from 1.
    fn dots(&self) -> Array2<u8> {
        self.painted(|number, name| if name == "dot" { (number % DOTS) as u8 + 1 } else { 0 })
    }

    /// For each box its number, from 1: also where its dots are. The pixels at its edges have none, which the toolkit expects.
    fn boxes(&self) -> Array2<u8> {
        let own = self.painted(|number, name| match name {
            "dot" => (number / DOTS) as u8 + 1,
            "box" => number as u8 + 1,
            _ => 0,
        });
        Array2::from_shape_fn(own.dim(), |(v, u)| {
            let neighbors = [[v.wrapping_sub(1), u], [v + 1, u], [v, u.wrapping_sub(1)], [v, u + 1]];
            let is_inside = neighbors.iter().all(|&place| own.get(place) == own.get([v, u]));
            if is_inside { own[[v, u]] } else { 0 }
        })
    }

    /// The columns from the first spike to the last.
    fn columns(&self) -> std::ops::Range<usize> {
        let spikes = self.seen(&["spikes"]);
        let mut columns = (0..spikes.ncols()).filter(|&u| spikes.column(u).iter().any(|is_spike| *is_spike));
        let first = columns.next().unwrap_or(0);
        first..columns.next_back().map_or(first, |last| last + 1)
    }

    fn between_spikes(&self) -> Array2<bool> {
        let columns = self.columns();
        let mut out = self.seen(&["background"]);
        out.indexed_iter_mut().for_each(|((_, u), is_in)| *is_in &= columns.contains(&u));
        out
    }

    /// The columns of the spikes in equal parts, from 1.
    fn bins(&self) -> Array2<u8> {
        let columns = self.columns();
        Array2::from_shape_fn(self.labels.dim(), |(_, u)| match columns.contains(&u) {
            true => ((u - columns.start) * BINS / columns.len()) as u8 + 1,
            false => 0,
        })
    }
}

#[cfg(test)]
mod tests {
    use ndarray::Array2;

    use super::*;

    fn objects(names: &[&str], labels: &[&[usize]]) -> Objects {
        let labels = Array2::from_shape_fn((labels.len(), labels[0].len()), |(v, u)| labels[v][u]);
        Objects { names: names.iter().map(|name| (*name).to_owned()).collect(), labels }
    }

    fn drawn<T: Copy>(mask: &Array2<T>, sign: impl Fn(T) -> char) -> Vec<String> {
        mask.rows().into_iter().map(|row| row.iter().map(|value| sign(*value)).collect()).collect()
    }

    fn region(objects: &Objects, name: &str) -> Vec<String> {
        let regions = objects.regions();
        let (_, mask) = regions.iter().find(|(known, _)| known == name).expect(name);
        drawn(mask, |is_in| if is_in { '#' } else { '.' })
    }

    fn toolkit(objects: &Objects, name: &str) -> Vec<String> {
        let masks = objects.toolkit_masks();
        let (_, mask) = masks.iter().find(|(known, _)| *known == name).expect(name);
        drawn(mask, |code| match code {
            0 => '.',
            255 => '#',
            number => char::from(b'0' + number),
        })
    }

    /// A foreground on the left, two spikes, and the background to the right of them, a pixel of which hits nothing.
    #[test]
    fn spikes_and_what_lies_between_them() {
        let scene = objects(
            &["background", "foreground", "spikes"],
            &[&[2, 3, 1, 3, 1, 1], &[2, 3, 1, 3, 1, 1], &[2, 3, 1, 1, 1, 0]],
        );
        assert_eq!(region(&scene, "spikes"), [".#.#..", ".#.#..", ".#...."]);
        assert_eq!(region(&scene, "between_spikes"), ["..#...", "..#...", "..##.."]);
        assert_eq!(toolkit(&scene, "mask_foreground_thinning"), region(&scene, "spikes"));
        assert_eq!(toolkit(&scene, "mask_foreground_fattening"), region(&scene, "between_spikes"));
        assert_eq!(toolkit(&scene, "mask_foreground"), ["##.#..", "##.#..", "##...."]);
        assert_eq!(toolkit(&scene, "mask_background"), ["..#.##", "..#.##", "..###."]);
        // The columns of the spikes in 15 parts.
        assert_eq!(toolkit(&scene, "mask_vertical_bins")[0], ".16;..");
    }

    /// Two boxes with nine dots each; labels are those of the instances: a box, then its dots.
    #[test]
    fn dots_have_their_sizes_and_boxes() {
        let mut names = Vec::new();
        for _ in 0..2 {
            names.push("box");
            names.extend(["dot"; 9]);
        }
        let scene =
            objects(&names, &[&[1, 2, 1, 9, 10, 1], &[1; 6], &[1; 6], &[11; 6], &[11; 6], &[11, 12, 11, 19, 20, 0]]);
        assert_eq!(region(&scene, "boxes")[0], "#.#..#");
        assert_eq!(region(&scene, "boxes")[5], "#.#...");
        let at = |rows: Vec<String>| [rows[0].clone(), rows[5].clone()];
        assert_eq!(at(region(&scene, "dots")), [".#.#..", ".#.#.."], "the smallest is not counted");
        assert_eq!(at(toolkit(&scene, "mask_dots_by_size")), [".1.89.", ".1.89."]);
        let edged = ["......", ".1111.", "......", "......", ".2222.", "......"];
        assert_eq!(toolkit(&scene, "mask_boxes"), edged);
    }

    #[test]
    fn reliefs_and_stripes_are_told_apart() {
        let scene = objects(&["base", "pyramids", "balls out", "balls in"], &[&[1, 2, 3, 4, 0]]);
        assert_eq!(region(&scene, "relief"), [".###."]);
        assert_eq!(region(&scene, "base"), ["#...."]);
        let masks = ["mask_plane", "mask_pyramids", "mask_sphere_out", "mask_sphere_in"];
        assert_eq!(masks.map(|name| toolkit(&scene, name)[0].clone()), ["#....", ".#...", "..#..", "...#."]);
        let scene = objects(&["background", "dark stripes", "bright stripes"], &[&[1, 2, 3]]);
        assert_eq!(region(&scene, "dark_stripes"), [".#."]);
        assert_eq!(toolkit(&scene, "mask_high_contrast"), [".#."]);
        assert_eq!(region(&scene, "bright_stripes"), ["..#"]);
        assert_eq!(toolkit(&scene, "mask_low_contrast"), ["..#"]);
    }
}

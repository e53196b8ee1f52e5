//! Masks of the central view, for scores: which pixels are hard, and why. They follow from the scene, not from images.
//!
//! | mask | pixels |
//! |---|---|
//! | `valid` | something is hit |
//! | `occluded` | a quarter of the views or more do not see the point: it is hidden, or beyond their images |
//! | `discontinuity` | within two pixels of a jump of the disparity by more than 0.1 px between neighbors |
//! | `slanted` | planes along which the disparity changes by more than 0.01 px from pixel to pixel |
//! | `repetitive` | the albedo around, 9 x 9, is found again in its row, 6 to 48 px away, within 0.03 on the mean, and not beside itself |
//! | `textureless` | the albedo of the pixels around, 5 x 5, differs by less than 0.02 in every channel |
//! | `reflective` | the surface mirrors light or lets it pass ([`holo_scene::Material::is_reflective`]) |
//! | `transparent` | those of them that let light pass ([`holo_scene::Material::is_transparent`]) |
//! | `plane` | all pixels around, 3 x 3, have normals within 0.1 degrees, and no jump |
//! | `smooth` | the same with normals within 10 degrees, where it is no plane: a curved surface |
//! | `fine` | narrower than 8 px: between two jumps to what is farther, along a row, a column or a diagonal |
//! | `fine_surrounding` | at most 4 px from something fine, and farther by a jump |
//!
//! Beside them lies `objects.png`: the number of the object that a pixel hits, from 1, 16 bits; 0 where nothing is hit. The
//! manifest has the names in this order, `objects`, up to 4 MiB of them. Scenes of more than 65,535 objects have no such file.

use std::collections::BTreeMap;
use std::ops::Range;

use holo_io::{ColorEncoding, Compression};
use holo_render::{Layer, LayerSet, Layers, Rendered};
use ndarray::{Array2, Array3, ArrayView3, Axis};
use rayon::prelude::*;

use super::folder::OutputFolder;
use crate::Error;

/// The layers of the central view that masks follow from, beside its visibility.
pub(super) const LAYERS: LayerSet = LayerSet::of(&[
    Layer::Disparity,
    Layer::GeometricNormal,
    Layer::Albedo,
    Layer::HitMask,
    Layer::Reflective,
    Layer::ObjectId,
]);

/// The folder of the masks.
const FOLDER: &str = "masks";

/// The numbers of the objects.
pub(crate) const OBJECTS_PNG: &str = "masks/objects.png";

/// Points that a smaller part of the views sees are occluded.
const SEEN: f32 = 0.75;

/// A larger difference between the disparities of neighbors is a jump, px.
const JUMP_PX: f32 = 0.1;

/// How far pixels are from a jump that they belong to, px.
const NEAR_JUMP: usize = 2;

/// The range of albedo below which there is no texture, and how far from a pixel it counts.
const TEXTURE: f32 = 0.02;
const AROUND_TEXTURE: usize = 2;

/// 1 - the cosine of the angle between normals of one plane: 0.1 degrees.
const PLANE: f32 = 1.5e-6;

/// The same of a smooth surface: 10 degrees.
const SMOOTH: f32 = 0.0152;

/// Fine structures are narrower, px; what surrounds them is as near as half of that.
const FINE_PX: usize = 8;

/// A plane is slanted if its disparity changes by more, px from pixel to pixel.
const SLANT_PX: f32 = 0.01;

/// How far pixels belong to a pattern, how far away it is found again, and how much its albedo may differ there, on the mean.
const PATTERN: usize = 4;
const REPEATED: Range<usize> = 6..49;
const SAME: f32 = 0.03;

/// Writes all masks: 8-bit PNGs, 255 where a pixel belongs to the mask. Returns the part of the pixels in each.
pub(super) fn write(
    folder: &mut OutputFolder,
    rendered: &Rendered,
    visibility: &Array2<f32>,
) -> Result<BTreeMap<String, f64>, Error> {
    folder.subfolder(FOLDER)?;
    let mut parts = BTreeMap::new();
    for (name, mask) in masks(&rendered.central, visibility) {
        let part = mask.iter().filter(|is_in| **is_in).count() as f64 / mask.len() as f64;
        parts.insert(name.to_owned(), part);
        let codes: Array3<u8> = mask.mapv(|is_in| if is_in { 255 } else { 0 }).insert_axis(Axis(2));
        let file = format!("{FOLDER}/{name}.png");
        let written = holo_io::write_png(folder.file(&file), codes.view(), ColorEncoding::Linear, Compression::Best)?;
        folder.add(file, written);
    }
    let ids = rendered.central[Layer::ObjectId].view();
    if ids.iter().all(|&id| id <= f32::from(u16::MAX)) {
        let codes = ids.mapv(|id| id as u16);
        let path = folder.file(OBJECTS_PNG);
        let written = holo_io::write_png(path, codes.view(), ColorEncoding::Linear, Compression::Best)?;
        folder.add(OBJECTS_PNG, written);
    }
    Ok(parts)
}

fn masks(central: &Layers<Array3<f32>>, visibility: &Array2<f32>) -> [(&'static str, Array2<bool>); 12] {
    let scalar = |layer: Layer| central[layer].index_axis(Axis(2), 0).to_owned();
    let valid = scalar(Layer::HitMask).mapv(|hit| hit > 0.0);
    let disparity = scalar(Layer::Disparity);
    let near_jump = jumps(&disparity);
    let normals = central[Layer::GeometricNormal].view();
    let is_even_surface = |flatness: f32| {
        around(valid.dim(), 1, |window, [v, u]| {
            let own = normals.slice_axis(Axis(0), (v..v + 1).into());
            let cosine = |y: usize, x: usize| -> f32 { (0..3).map(|c| own[[0, u, c]] * normals[[y, x, c]]).sum() };
            let is_flat = |y: usize, x: usize| valid[[y, x]] && 1.0 - cosine(y, x) < flatness;
            valid[[v, u]] && !near_jump.0[[v, u]] && every(&window, is_flat)
        })
    };
    let (plane, smooth) = (is_even_surface(PLANE), is_even_surface(SMOOTH));
    let smooth = smooth & !&plane;
    let fine = fine(&disparity, &valid);
    let fine_surrounding = around(valid.dim(), FINE_PX / 2, |window, [v, u]| {
        let is_farther = |y: usize, x: usize| fine[[y, x]] && disparity[[y, x]] - disparity[[v, u]] > JUMP_PX;
        valid[[v, u]] && !fine[[v, u]] && !every(&window, |y, x| !is_farther(y, x))
    });
    let albedo = central[Layer::Albedo].view();
    let textureless =
        around(valid.dim(), AROUND_TEXTURE, |window, [v, u]| valid[[v, u]] && is_even(albedo, &valid, &window));
    let occluded = Array2::from_shape_fn(valid.dim(), |place| valid[place] && visibility[place] <= SEEN);
    let slope = |[rows, columns]: &Window, [v, u]: [usize; 2]| {
        let across =
            (disparity[[v, columns.end - 1]] - disparity[[v, columns.start]]) / (columns.len() - 1).max(1) as f32;
        let down = (disparity[[rows.end - 1, u]] - disparity[[rows.start, u]]) / (rows.len() - 1).max(1) as f32;
        across.hypot(down)
    };
    let slanted = around(valid.dim(), 1, |window, place| plane[place] && slope(&window, place) > SLANT_PX);
    [
        ("occluded", occluded),
        ("discontinuity", near_jump.1),
        ("reflective", scalar(Layer::Reflective).mapv(|kind| kind > 0.0)),
        ("transparent", scalar(Layer::Reflective).mapv(|kind| kind > 1.0)),
        ("slanted", slanted),
        ("repetitive", repetitive(&albedo, &valid, &textureless)),
        ("textureless", textureless),
        ("plane", plane),
        ("smooth", smooth),
        ("fine", fine),
        ("fine_surrounding", fine_surrounding),
        ("valid", valid),
    ]
}

/// Some rows and columns.
type Window = [Range<usize>; 2];

/// The value of every pixel by the pixels at most `reach` rows and columns away.
fn around(dim: (usize, usize), reach: usize, value: impl Fn(Window, [usize; 2]) -> bool) -> Array2<bool> {
    let range = |k: usize, count: usize| k.saturating_sub(reach)..(k + reach + 1).min(count);
    Array2::from_shape_fn(dim, |(v, u)| value([range(v, dim.0), range(u, dim.1)], [v, u]))
}

/// Pixels whose neighborhood is found again in their row.
fn repetitive(albedo: &ArrayView3<f32>, valid: &Array2<bool>, textureless: &Array2<bool>) -> Array2<bool> {
    let (rows, columns) = valid.dim();
    let side = 2 * PATTERN + 1;
    // Whether the neighborhood differs by less than a bound from another in the same row, on the mean.
    let is_like = |[v, u]: [usize; 2], other: usize, bound: f32| {
        let most = bound * (3 * side * side) as f32;
        let mut sum = 0.0;
        (v - PATTERN..=v + PATTERN).all(|y| {
            for k in 0..side {
                let (here, there) = (u - PATTERN + k, other - PATTERN + k);
                sum += (0..3).map(|c| (albedo[[y, here, c]] - albedo[[y, there, c]]).abs()).sum::<f32>();
            }
            sum < most
        })
    };
    let is_in = |v: usize, u: usize| {
        let fits = |x: usize| (PATTERN..columns.saturating_sub(PATTERN)).contains(&x);
        if !(PATTERN..rows.saturating_sub(PATTERN)).contains(&v) || !fits(u) || !valid[[v, u]] || textureless[[v, u]] {
            return false;
        }
        let found = |shift: isize, bound: f32| {
            let other = u.wrapping_add_signed(shift);
            fits(other) && is_like([v, u], other, bound)
        };
        // What is nearly the same beside itself, such as stripes along the row, does not repeat.
        let beside = PATTERN.div_ceil(2) as isize;
        !found(beside, 2.0 * SAME)
            && !found(-beside, 2.0 * SAME)
            && REPEATED.map(|shift| shift as isize).any(|shift| found(shift, SAME) || found(-shift, SAME))
    };
    let lines: Vec<Vec<bool>> =
        (0..rows).into_par_iter().map(|v| (0..columns).map(|u| is_in(v, u)).collect()).collect();
    Array2::from_shape_fn((rows, columns), |(v, u)| lines[v][u])
}

fn every(window: &Window, holds: impl Fn(usize, usize) -> bool) -> bool {
    window[0].clone().all(|y| window[1].clone().all(|x| holds(y, x)))
}

/// The pixels beside a jump of the disparity, and those near one.
fn jumps(disparity: &Array2<f32>) -> (Array2<bool>, Array2<bool>) {
    let beside = around(disparity.dim(), 1, |[rows, columns], [v, u]| {
        let own = disparity[[v, u]];
        let differs = |y: usize, x: usize| (disparity[[y, x]] - own).abs() > JUMP_PX;
        rows.into_iter().any(|y| differs(y, u)) || columns.into_iter().any(|x| differs(v, x))
    });
    let near = around(disparity.dim(), NEAR_JUMP, |window, _| !every(&window, |y, x| !beside[[y, x]]));
    (beside, near)
}

/// The pixels of what is narrower than [`FINE_PX`] in one of four directions: jumps to what is farther end it on both sides.
fn fine(disparity: &Array2<f32>, valid: &Array2<bool>) -> Array2<bool> {
    // How many pixels of the structure follow a pixel until what is farther begins; `None` if that is not so near.
    let beyond = |[v, u]: [usize; 2], step: [isize; 2]| {
        let mut own = disparity[[v, u]];
        for count in 0..FINE_PX {
            let place =
                [(v, step[0]), (u, step[1])].map(|(at, step)| at.checked_add_signed(step * (count as isize + 1)));
            let [Some(y), Some(x)] = place else { return None };
            let next = *disparity.get([y, x])?;
            if (next - own).abs() > JUMP_PX {
                return (next < own).then_some(count);
            }
            own = next;
        }
        None
    };
    Array2::from_shape_fn(disparity.dim(), |(v, u)| {
        let is_narrow = |step: [isize; 2]| {
            let sides = [beyond([v, u], step), beyond([v, u], step.map(|x| -x))];
            matches!(sides, [Some(one), Some(other)] if one + other + 1 < FINE_PX)
        };
        valid[[v, u]] && [[0, 1], [1, 0], [1, 1], [1, -1]].into_iter().any(is_narrow)
    })
}

/// Whether the albedo of the hits in a window hardly differs.
fn is_even(albedo: ArrayView3<f32>, valid: &Array2<bool>, [rows, columns]: &Window) -> bool {
    (0..3).all(|c| {
        let (mut low, mut high) = (f32::INFINITY, f32::NEG_INFINITY);
        for y in rows.clone() {
            for x in columns.clone().filter(|&x| valid[[y, x]]) {
                low = low.min(albedo[[y, x, c]]);
                high = high.max(albedo[[y, x, c]]);
            }
        }
        high - low < TEXTURE
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A bar of seven pixels, one of eight, a slope that falls on both sides, and a gap.
    #[test]
    fn fine_structures_are_narrow_and_in_front() {
        let mut row = vec![0.0_f32; 60];
        row[10..17].fill(1.0);
        row[25..33].fill(1.0);
        for (k, value) in row[36..45].iter_mut().enumerate() {
            *value = 0.05 * (4.0 - (k as f32 - 4.0).abs());
        }
        row[50..54].fill(-1.0);
        let disparity = Array2::from_shape_fn((30, 60), |(_, u)| row[u]);
        let found = fine(&disparity, &Array2::from_elem((30, 60), true));
        let columns: Vec<usize> = (0..60).filter(|&u| found[[15, u]]).collect();
        assert_eq!(columns, (10..17).collect::<Vec<_>>());
        assert!(
            fine(&disparity.clone().reversed_axes(), &Array2::from_elem((60, 30), true))[[12, 15]],
            "in every direction"
        );
        assert!(!fine(&disparity, &Array2::from_elem((30, 60), false))[[15, 12]], "nothing is hit");
    }

    /// A plane on the left and a nearer, textured one on the right, whose last column nothing is hit in.
    #[test]
    fn every_mask_has_its_pixels() {
        let (rows, columns, edge) = (6, 12, 6);
        let image = |channels: usize, value: fn(usize, usize) -> f32| {
            Array3::from_shape_fn(
                (rows, columns, channels),
                |(v, u, c)| if c + 1 == channels { value(v, u) } else { 0.0 },
            )
        };
        let central: Layers<Array3<f32>> = [
            (Layer::Disparity, image(1, |_, u| if u < 6 { 0.05 * u as f32 } else { 1.0 })),
            (Layer::GeometricNormal, image(3, |_, _| 1.0)),
            (Layer::Albedo, image(3, |v, u| if u < 6 { 0.5 } else { (v + u) as f32 % 2.0 })),
            (Layer::HitMask, image(1, |_, u| if u < 11 { 1.0 } else { 0.0 })),
            (Layer::Reflective, image(1, |v, _| if v < 2 { (v + 1) as f32 } else { 0.0 })),
        ]
        .into_iter()
        .collect();
        let visibility = Array2::from_shape_fn((rows, columns), |(_, u)| if u == 5 { 0.75 } else { 1.0 });
        let masks = masks(&central, &visibility);
        let row = |name: &str| -> String {
            let (_, mask) = masks.iter().find(|(known, _)| *known == name).expect(name);
            mask.row(2).iter().map(|&is_in| if is_in { '#' } else { '.' }).collect()
        };
        assert_eq!(row("valid"), "###########.");
        assert_eq!(row("occluded"), ".....#......");
        assert_eq!(row("discontinuity"), "...######...", "a slope is no jump");
        assert_eq!(row("textureless"), "####........");
        assert_eq!(row("plane"), "#####..###..", "not beside the edge at {edge}, nor beside what is not hit");
        assert_eq!(row("smooth"), "............", "both are planes");
        assert_eq!(row("fine"), "............", "nothing farther is on its right");
        assert_eq!(row("fine_surrounding"), "............");
        assert_eq!(row("reflective"), "............");
        assert_eq!(row("slanted"), "#####.......", "the disparity of the other does not change");
        assert_eq!(row("repetitive"), "............", "no pixel has 9 x 9 around it");
        let of =
            |name: &str| masks.iter().find(|(known, _)| *known == name).map(|(_, mask)| [mask[[0, 3]], mask[[1, 3]]]);
        assert_eq!([of("reflective"), of("transparent")], [Some([true, true]), Some([false, true])]);
    }

    /// Dots every 10 px, on the right side noise, and stripes along the rows below.
    #[test]
    fn patterns_are_found_again_in_their_rows() {
        let mut state = 1_u32;
        let albedo = Array3::from_shape_fn((40, 90, 3), |(v, u, _)| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            match (v, u) {
                (20.., _) => (v % 5) as f32 / 5.0,
                (_, 60..) => (state >> 16) as f32 / 65_536.0,
                _ => f32::from(u8::from(u % 10 < 3 && v % 10 < 3)),
            }
        });
        let all = Array2::from_elem((40, 90), true);
        let found = repetitive(&albedo.view(), &all, &Array2::from_elem((40, 90), false));
        assert!(found[[10, 30]] && found[[9, 12]]);
        assert!(!found[[10, 75]], "noise");
        assert!(!found[[30, 30]], "stripes");
        assert!(!repetitive(&albedo.view(), &!&all, &all)[[10, 30]]);
    }
}

//! Estimated errors beside true ones, and bias, where images are hardest.

use holo_bench::error::{luminance, sorted};
use holo_core::ViewIndex;
use holo_render::{GroundTruth, Integrator, Layer, LayerSet, Renderer, Request, Views};
use holo_scene::Scene;

/// Where errors are compared, in the order of the masks of a pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mask {
    /// All pixels.
    All,
    /// Within a pixel of a jump of the depth.
    Jumps,
    /// The brightest of a hundred.
    Brightest,
    /// The darkest of ten.
    Darkest,
    /// Materials that transmit light.
    Glass,
    /// Metal.
    Metal,
    /// The view in the corner.
    Corner,
}

/// A mask needs so many pixels to tell anything.
const FEWEST: usize = 40;

/// The second difference of the inverse depth between neighboring pixels, relative to it, that is a jump.
const JUMP: f32 = 0.02;

/// A pixel with its error: luminance in linear light.
pub struct Pixel {
    /// In the image.
    pub found: f64,
    /// In two independent references.
    pub references: [f64; 2],
    /// The estimated standard error, relative.
    pub estimated: f64,
    /// Jump of the depth, glass, metal, and the corner.
    pub marks: Marks,
}

/// What a pixel shows.
#[derive(Clone, Copy, Debug, Default)]
pub struct Marks {
    pub jump: bool,
    pub glass: bool,
    pub metal: bool,
    pub corner: bool,
}

impl Pixel {
    fn reference(&self) -> f64 {
        (self.references[0] + self.references[1]) / 2.0
    }
}

/// The marks of the pixels of some views, view by view.
pub fn marks(renderer: &Renderer, scene: &Scene, request: &Request, views: &[ViewIndex], corner: usize) -> Vec<Marks> {
    let request = request.clone().integrator(Integrator::Depth).views(Views::List(views.to_vec()));
    let request = request.layers(LayerSet::of(&[Layer::Depth, Layer::MaterialId])).ground_truth(GroundTruth::All);
    let rendered = renderer.render(&request, &()).expect("ground truth");
    let layers = rendered.all.expect("the layers of all views");
    let mut marks = Vec::new();
    for view in 0..views.len() {
        let depth = layers[Layer::Depth].view(0, view).expect("a view");
        let material = layers[Layer::MaterialId].view(0, view).expect("a view");
        let (rows, columns) = (depth.dim().0, depth.dim().1);
        let inverse = |v: usize, u: usize| 1.0 / depth[[v, u, 0]];
        let bends = |before: f32, here: f32, after: f32| {
            (before - 2.0 * here + after).abs() > JUMP * here.max(before).max(after)
        };
        let jump = |v: usize, u: usize| {
            let [up, down] = [v.saturating_sub(1), (v + 1).min(rows - 1)];
            let [left, right] = [u.saturating_sub(1), (u + 1).min(columns - 1)];
            bends(inverse(up, u), inverse(v, u), inverse(down, u))
                || bends(inverse(v, left), inverse(v, u), inverse(v, right))
        };
        for v in 0..rows {
            for u in 0..columns {
                let of = scene.materials.get((material[[v, u, 0]] as usize).wrapping_sub(1));
                marks.push(Marks {
                    jump: jump(v, u),
                    glass: of.is_some_and(|material| material.transmission > 0.5),
                    metal: of.is_some_and(|material| material.metallic > 0.5),
                    corner: view == corner,
                });
            }
        }
    }
    marks
}

/// The pixels of a mask; `None` if they are too few.
pub fn within(pixels: &[Pixel], mask: Mask) -> Option<Vec<&Pixel>> {
    let ordered = sorted(&pixels.iter().map(Pixel::reference).collect::<Vec<f64>>());
    let (dark, bright) = (ordered[ordered.len() / 10], ordered[ordered.len() * 99 / 100]);
    let holds = |pixel: &&Pixel| match mask {
        Mask::All => true,
        Mask::Jumps => pixel.marks.jump,
        Mask::Brightest => pixel.reference() > bright,
        Mask::Darkest => pixel.reference() < dark,
        Mask::Glass => pixel.marks.glass,
        Mask::Metal => pixel.marks.metal,
        Mask::Corner => pixel.marks.corner,
    };
    let found: Vec<&Pixel> = pixels.iter().filter(holds).collect();
    (found.len() >= FEWEST).then_some(found)
}

/// The root mean square of true errors divided by that of estimated ones. Errors are relative, to no less than a tenth of the
/// root mean square of `all`; the noise of the references has the expectation 0.
pub fn true_by_estimated(pixels: &[&Pixel], all: &[Pixel]) -> f64 {
    let floor = 0.01 * all.iter().map(|pixel| pixel.reference().powi(2)).sum::<f64>() / all.len() as f64;
    let (mut real, mut estimated) = (0.0, 0.0);
    for pixel in pixels {
        let ([a, b], m) = (pixel.references, pixel.reference());
        let scale = 1.0 / (m * m + floor);
        real += (pixel.found - a) * (pixel.found - b) * scale;
        estimated += (pixel.estimated * m).powi(2) * scale;
    }
    (real.max(0.0) / estimated).sqrt()
}

/// The share of pixels whose error is more than three times the estimated one.
pub fn beyond_three(pixels: &[&Pixel]) -> f64 {
    let beyond = pixels.iter().filter(|pixel| {
        let ([a, b], m) = (pixel.references, pixel.reference());
        let squared = (pixel.estimated * m).powi(2) + ((a - b) / 2.0).powi(2);
        (pixel.found - m).powi(2) > 9.0 * squared
    });
    beyond.count() as f64 / pixels.len() as f64
}

/// How far the sum of the image is from that of the references, relative.
pub fn bias(pixels: &[&Pixel]) -> f64 {
    let sum = |value: fn(&Pixel) -> f64| pixels.iter().map(|pixel| value(pixel)).sum::<f64>();
    sum(|pixel| pixel.found) / sum(Pixel::reference) - 1.0
}

/// A pixel of an image.
pub fn pixel(found: [f32; 3], references: [[f32; 3]; 2], estimated: f32, marks: Marks) -> Pixel {
    Pixel { found: luminance(found), references: references.map(luminance), estimated: estimated.into(), marks }
}

//! What the noise of reconstructed views tells of the depth: stereo on them beside stereo on a converged light field to which
//! as much independent noise was added.

use holo_core::optics::DisparityRange;
use holo_core::{GridSize, LightFieldOwned, LightFieldShape, PlaneSweepOptions, plane_sweep};
use holo_render::{Backend, Denoise, Framing, GroundTruth, Integrator, Layer, Renderer, Request, SamplesPerPixel};
use holo_scene::gallery;
use ndarray::{Array2, Axis};

use holo_bench::error::{luminance, sorted};
use holo_core::color::{linear_to_srgb8, srgb8_to_linear_table};

use crate::table::{Table, short};
use crate::{RunOptions, Section};

/// A scene of diffuse surfaces without texture, whose converged image planes describe.
const SCENE: &str = "plaster";

/// Views along an axis, and their width and height.
const VIEWS: usize = 9;
const SIDE: usize = 160;

/// The largest disparity between adjacent views, px.
const DISPARITY: f64 = 1.5;

/// The disparities that the plain sweep compares: so many steps to each side, of this size in px.
const STEPS: i32 = 40;
const STEP: f64 = 0.05;

/// The window of the plain sweep.
const WINDOW: usize = 7;

/// Pixels at every side that are not compared.
const BORDER: usize = 12;

/// Microlenses to each side over which the converged image is fitted.
const FIT: usize = 4;

/// Luminance of all views, [row][column] of views in the order (t, s).
type Field = Vec<Array2<f64>>;

pub fn section(options: &RunOptions) -> Section {
    let mut table = Table::new(&[
        "scene",
        "samples a pixel",
        "error, %",
        "plain sweep: RMSE, px",
        "converged + noise",
        "BadPix(0.07), %",
        "converged + noise",
        "plane sweep of holo: RMSE, px",
        "converged + noise",
        "BadPix(0.07), %",
        "converged + noise",
    ]);
    let mut highlights = Vec::new();
    for row in rows(options) {
        highlights.push([
            format!("stereo on reconstructed views of `{SCENE}`; flat parts; {} sample; plain sweep", row[1]),
            String::new(),
            format!(
                "RMSE {} px; {} px on a converged image with as much independent noise; BadPix(0.07) {} and {} %",
                row[3], row[4], row[5], row[6]
            ),
        ]);
        table.push(row);
    }
    Section {
        text: format!(
            "{VIEWS} x {VIEWS} views of {SIDE} x {SIDE} px, disparities within {DISPARITY} px, paths of up to 8 bounces, \
             `--denoise views`, 8 bits. Compared are the flat parts: the half of the pixels with the smallest gradient, 6 px \
             away from jumps of the depth. Converged: 64 plain samples, averaged over all views along the true disparity \
             and fitted by planes over 9 x 9 microlenses; the noise added to it is independent from pixel to pixel and \
             view to view, and has the relative RMS of the difference of the reconstructed views from it. Where stereo \
             is better on the reconstructed views, their noise carries the true depth; where it is worse, it misleads. \
             Plain sweep: the variance over the views, over {WINDOW} x {WINDOW} px."
        ),
        highlights,
        table,
        plots: Vec::new(),
    }
}

fn rows(options: &RunOptions) -> Vec<[String; 11]> {
    let scene = gallery::scene(SCENE).expect("a scene of the gallery");
    let shape = LightFieldShape::new(GridSize::new(VIEWS, VIEWS), GridSize::new(SIDE, SIDE)).expect("sizes");
    let framed = Framing::new(shape).frame(&scene).expect("a camera");
    let renderer = Renderer::new(&scene, &framed.pose, Backend::Auto, None).expect("a renderer");
    let range = DisparityRange { min_px: -DISPARITY, max_px: DISPARITY };
    let rig = renderer.rig_for_disparities(&framed, range).expect("a rig");
    let request = Request::new(rig).integrator(Integrator::Path);
    let truth = renderer
        .render(&request.clone().integrator(Integrator::Depth).ground_truth(GroundTruth::All), &())
        .expect("ground truth")
        .all
        .expect("all views");
    let disparity: Field = views(&truth[Layer::Disparity], |pixel| f64::from(pixel[0]));
    let color = |request: &Request| {
        let rendered = renderer.render(request, &()).expect("a render");
        views(&rendered.color.expect("the scene is lit"), |pixel| luminance([pixel[0], pixel[1], pixel[2]]))
    };
    let center = VIEWS * VIEWS / 2;
    let valid = away_from_jumps(&disparity[center]);
    let plain = if options.quick { 16 } else { 64 };
    let mean = gathered(&color(&request.clone().samples(plain)), &disparity);
    let converged = spread(&fitted(&mean, &valid), &disparity);
    let flat = flattest(&converged[center], &valid);
    let values: Vec<f64> = converged[center].iter().copied().filter(|x| x.is_finite()).collect();
    let gain = 0.8 / sorted(&values)[values.len() * 99 / 100];
    let quarter = SamplesPerPixel::one_in(4).expect("a power of two");
    let samples: [(&str, SamplesPerPixel); 3] = [("1/4", quarter), ("4", 4.into()), ("16", 16.into())];
    samples
        .into_iter()
        .map(|(label, count)| {
            let found = color(&request.clone().denoise(Denoise::Views).samples(count));
            let error = relative_rms(&found, &converged, &disparity, &flat);
            let noisy = with_noise(&converged, error);
            let of = |field: &Field| {
                let coded = coded(field, gain);
                let sweep = score(&plain_sweep(&coded), &disparity[center], &flat);
                let own = score(&own_sweep(&coded), &disparity[center], &flat);
                [sweep, own]
            };
            let ([a, b], [c, d]) = (of(&found), of(&noisy));
            [
                SCENE.to_owned(),
                label.to_owned(),
                short(100.0 * error),
                short(a[0]),
                short(c[0]),
                short(a[1]),
                short(c[1]),
                short(b[0]),
                short(d[0]),
                short(b[1]),
                short(d[1]),
            ]
        })
        .collect()
}

/// The views in the order (t, s), by a value of their pixels.
fn views(field: &LightFieldOwned<f32>, value: impl Fn(&[f32]) -> f64) -> Field {
    let view = |k: usize| {
        let view = field.view(k / VIEWS, k % VIEWS).expect("a view");
        let pixel = |v: usize, u: usize| (0..view.dim().2).map(|c| view[[v, u, c]]).collect::<Vec<f32>>();
        Array2::from_shape_fn((SIDE, SIDE), |(v, u)| value(&pixel(v, u)))
    };
    (0..VIEWS * VIEWS).map(view).collect()
}

/// How many views up and to the left of the center a view is.
fn offset(k: usize) -> [f64; 2] {
    [k / VIEWS, k % VIEWS].map(|k| k as f64 - (VIEWS / 2) as f64)
}

/// Interpolated between the four pixels around a place; `None` beyond the image.
fn bilinear(image: &Array2<f64>, [v, u]: [f64; 2]) -> Option<f64> {
    let (row, column) = (v.floor(), u.floor());
    let last = (SIDE - 2) as f64;
    if !(row >= 0.0 && column >= 0.0 && row <= last && column <= last) {
        return None;
    }
    let (y, x) = (v - row, u - column);
    let at = |dy: usize, dx: usize| image[[row as usize + dy, column as usize + dx]];
    Some((at(0, 0) * (1.0 - x) + at(0, 1) * x) * (1.0 - y) + (at(1, 0) * (1.0 - x) + at(1, 1) * x) * y)
}

/// The mean over all views that see what the central view sees, along the true disparity.
fn gathered(field: &Field, disparity: &Field) -> Array2<f64> {
    let center = &disparity[VIEWS * VIEWS / 2];
    Array2::from_shape_fn((SIDE, SIDE), |(v, u)| {
        let d = center[[v, u]];
        let (mut sum, mut count) = (0.0, 0.0);
        for k in 0..VIEWS * VIEWS {
            let [t, s] = offset(k);
            let place = [v as f64 - d * t, u as f64 - d * s];
            if let (Some(value), Some(there)) = (bilinear(&field[k], place), bilinear(&disparity[k], place))
                && (there - d).abs() < 0.05
            {
                sum += value;
                count += 1.0;
            }
        }
        if count > 0.0 { sum / count } else { field[VIEWS * VIEWS / 2][[v, u]] }
    })
}

/// What all views see of an image of the central one.
fn spread(image: &Array2<f64>, disparity: &Field) -> Field {
    let view = |k: usize| {
        let [t, s] = offset(k);
        Array2::from_shape_fn((SIDE, SIDE), |(v, u)| {
            let d = disparity[k][[v, u]];
            let last = (SIDE - 1) as f64 - 1e-9;
            let place = [v as f64 + d * t, u as f64 + d * s].map(|x| x.clamp(0.0, last));
            bilinear(image, place).unwrap_or(f64::NAN)
        })
    };
    (0..VIEWS * VIEWS).map(view).collect()
}

/// The pixels 6 px away from jumps, and from the border.
fn away_from_jumps(disparity: &Array2<f64>) -> Array2<bool> {
    let is_jump = |v: usize, u: usize| {
        // Beside a miss it is not a number.
        let bends = |a: f64, b: f64, c: f64| {
            let bend = (a - 2.0 * b + c).abs();
            bend > 0.05 || bend.is_nan()
        };
        bends(disparity[[v - 1, u]], disparity[[v, u]], disparity[[v + 1, u]])
            || bends(disparity[[v, u - 1]], disparity[[v, u]], disparity[[v, u + 1]])
    };
    Array2::from_shape_fn((SIDE, SIDE), |(v, u)| {
        let inside = BORDER..SIDE - BORDER;
        let near = |x: usize| x - 6..x + 7;
        inside.contains(&v) && inside.contains(&u) && !near(v).any(|row| near(u).any(|column| is_jump(row, column)))
    })
}

/// Planes fitted to the valid pixels around each.
fn fitted(image: &Array2<f64>, valid: &Array2<bool>) -> Array2<f64> {
    Array2::from_shape_fn((SIDE, SIDE), |(v, u)| {
        if !valid[[v, u]] {
            return image[[v, u]];
        }
        // Sums of 1, x, y, and of their products.
        let (mut left, mut right) = ([[0.0f64; 3]; 3], [0.0f64; 3]);
        for row in v - FIT..=v + FIT {
            for column in u - FIT..=u + FIT {
                if valid[[row, column]] {
                    let terms = [1.0, row as f64 - v as f64, column as f64 - u as f64];
                    for a in 0..3 {
                        right[a] += terms[a] * image[[row, column]];
                        (0..3).for_each(|b| left[a][b] += terms[a] * terms[b]);
                    }
                }
            }
        }
        first_of_solution(left, right).unwrap_or(image[[v, u]])
    })
}

/// The first of three unknowns, by Cramer's rule.
fn first_of_solution(left: [[f64; 3]; 3], right: [f64; 3]) -> Option<f64> {
    let determinant = |m: [[f64; 3]; 3]| {
        m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0])
            + m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0])
    };
    let with_right = std::array::from_fn(|row| [right[row], left[row][1], left[row][2]]);
    let whole = determinant(left);
    (whole.abs() > 1e-9).then(|| determinant(with_right) / whole)
}

/// The half of the valid pixels with the smallest relative gradient.
fn flattest(image: &Array2<f64>, valid: &Array2<bool>) -> Array2<bool> {
    let gradient = |v: usize, u: usize| {
        let across = image[[v, u + 2]] - image[[v, u - 2]];
        let down = image[[v + 2, u]] - image[[v - 2, u]];
        across.hypot(down) / image[[v, u]]
    };
    let all: Vec<f64> = valid.indexed_iter().filter(|(_, valid)| **valid).map(|((v, u), _)| gradient(v, u)).collect();
    let middle = sorted(&all)[all.len() / 2];
    Array2::from_shape_fn((SIDE, SIDE), |(v, u)| valid[[v, u]] && gradient(v, u) <= middle)
}

/// The relative RMS of the difference in all views, where they see flat parts of the central one.
fn relative_rms(found: &Field, reference: &Field, disparity: &Field, flat: &Array2<bool>) -> f64 {
    let (mut sum, mut count) = (0.0, 0.0);
    for k in 0..found.len() {
        let [t, s] = offset(k);
        for ((v, u), &x) in found[k].indexed_iter() {
            let d = disparity[k][[v, u]];
            let place = [v as f64 + d * t, u as f64 + d * s].map(|x| x.round().max(0.0) as usize);
            if flat.get(place).is_some_and(|flat| *flat) {
                sum += (x / reference[k][[v, u]] - 1.0).powi(2);
                count += 1.0;
            }
        }
    }
    f64::sqrt(sum / count)
}

/// Independent normal noise of this relative standard deviation.
fn with_noise(field: &Field, deviation: f64) -> Field {
    let mut state = 1_u64;
    let mut uniform = move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((state >> 33) as f64 + 0.5) / f64::from(1u32 << 31)
    };
    // Box and Muller.
    let mut normal = move || (-2.0 * uniform().ln()).sqrt() * (std::f64::consts::TAU * uniform()).cos();
    field.iter().map(|view| view.mapv(|x| x * (1.0 + deviation * normal()))).collect()
}

/// The values after 8 bits, on the curve of sRGB.
fn coded(field: &Field, gain: f64) -> Field {
    field.iter().map(|view| view.mapv(|x| f64::from(linear_to_srgb8((x * gain) as f32)) / 255.0)).collect()
}

/// The disparity at which the variance over the views, summed over a window, is least.
fn plain_sweep(field: &Field) -> Array2<f64> {
    let costs: Vec<Array2<f64>> = (-STEPS..=STEPS)
        .map(|step| {
            let d = f64::from(step) * STEP;
            let (mut sum, mut squares) = (Array2::zeros((SIDE, SIDE)), Array2::zeros((SIDE, SIDE)));
            for (k, view) in field.iter().enumerate() {
                let [t, s] = offset(k);
                let moved = shifted(&shifted(view, Axis(0), -d * t), Axis(1), -d * s);
                squares += &(&moved * &moved);
                sum += &moved;
            }
            let count = field.len() as f64;
            windowed(&(squares / count - (&sum / count).mapv(|x: f64| x * x)))
        })
        .collect();
    Array2::from_shape_fn((SIDE, SIDE), |(v, u)| {
        let at = |k: usize| costs[k][[v, u]];
        let best = (0..costs.len()).min_by(|&a, &b| at(a).total_cmp(&at(b))).unwrap_or(0);
        let k = best.clamp(1, costs.len() - 2);
        // The least of a parabola through three.
        let (before, here, after) = (at(k - 1), at(k), at(k + 1));
        let curvature = before - 2.0 * here + after;
        let part = if curvature > 0.0 { ((before - after) / 2.0 / curvature).clamp(-0.5, 0.5) } else { 0.0 };
        (k as f64 - f64::from(STEPS) + part) * STEP
    })
}

/// An image at places `by` farther along an axis, by Lanczos's filter of eight pixels, which hardly blurs.
fn shifted(image: &Array2<f64>, axis: Axis, by: f64) -> Array2<f64> {
    let whole = by.floor();
    let part = by - whole;
    let weight = |k: i32| {
        let x = std::f64::consts::PI * (f64::from(k) - part);
        if x.abs() < 1e-9 { 1.0 } else { 4.0 * x.sin() * (x / 4.0).sin() / (x * x) }
    };
    let mut weights: Vec<f64> = (-3..=4).map(weight).collect();
    let sum: f64 = weights.iter().sum();
    weights.iter_mut().for_each(|weight| *weight /= sum);
    let last = SIDE as i64 - 1;
    let mut out = Array2::zeros((SIDE, SIDE));
    for place in 0..SIDE {
        for (k, weight) in weights.iter().enumerate() {
            let from = (place as i64 + whole as i64 + k as i64 - 3).clamp(0, last) as usize;
            out.index_axis_mut(axis, place).scaled_add(*weight, &image.index_axis(axis, from));
        }
    }
    out
}

/// Means over windows.
fn windowed(image: &Array2<f64>) -> Array2<f64> {
    let reach = WINDOW / 2;
    let along = |image: &Array2<f64>, axis: Axis| {
        let mut out = Array2::zeros((SIDE, SIDE));
        for place in 0..SIDE {
            for from in place.saturating_sub(reach)..(place + reach + 1).min(SIDE) {
                out.index_axis_mut(axis, place).scaled_add(1.0 / WINDOW as f64, &image.index_axis(axis, from));
            }
        }
        out
    };
    along(&along(image, Axis(0)), Axis(1))
}

/// The estimate of `holo depth`.
fn own_sweep(field: &Field) -> Array2<f64> {
    let shape = LightFieldShape::new(GridSize::new(VIEWS, VIEWS), GridSize::new(SIDE, SIDE)).expect("sizes");
    let mut light_field =
        LightFieldOwned::filled(shape, 1, holo_core::Layout::ViewpointGrid, 0.0f32).expect("a light field");
    let table = srgb8_to_linear_table();
    for ((v, u, t, s, _), value) in light_field.samples_mut().indexed_iter_mut() {
        *value = table[(field[t * VIEWS + s][[v, u]] * 255.0).round() as usize];
    }
    let sweep = PlaneSweepOptions::default().range_px(-2.0, 2.0);
    plane_sweep(&light_field, &sweep).expect("an estimate").disparity_px.mapv(f64::from)
}

/// RMSE, and the percentage that is off by more than 0.07 px.
fn score(estimate: &Array2<f64>, truth: &Array2<f64>, flat: &Array2<bool>) -> [f64; 2] {
    let errors: Vec<f64> =
        flat.indexed_iter().filter(|(_, flat)| **flat).map(|(place, _)| estimate[place] - truth[place]).collect();
    let count = errors.len() as f64;
    let bad = errors.iter().filter(|error| error.abs() > 0.07).count() as f64;
    [(errors.iter().map(|error| error * error).sum::<f64>() / count).sqrt(), 100.0 * bad / count]
}

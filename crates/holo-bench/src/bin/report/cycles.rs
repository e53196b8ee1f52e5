//! The reconstruction across views beside Blender's Cycles with and without OpenImageDenoise, on the scenes of the gallery.

use std::path::Path;
use std::time::Instant;

use holo_bench::error::{Images, rgb, squared_error};
use holo_bench::on_the_paper_sensor;
use holo_core::{Rig, ViewIndex};
use holo_io::Limits;
use holo_render::{Denoise, Renderer, Request, TextureFilter, Views};
use holo_scene::gallery;

use crate::peers::seconds_for;
use crate::sharing::{FEW_VIEWS, geometric_mean, image};
use crate::table::{Table, short};
use crate::{RunOptions, Section, scripts};

const SAMPLES: u32 = 4;

/// The lens rows on each side that are rendered too, because the reconstruction reads them.
const HALO_ROWS: usize = 7;

/// A division of the 8K sensor, the part of its lens rows that is compared, samples, and the scenes.
struct Division {
    views: usize,
    rows: usize,
    /// Of each reference of ours, and of Cycles'.
    references: [u32; 2],
    /// Of Cycles.
    samples: &'static [u32],
    scenes: Vec<String>,
}

/// One image of Cycles.
struct Rendered {
    view: usize,
    /// `reference`, `off` or `oidn`.
    kind: String,
    seconds: f64,
    pixels: Vec<[f32; 3]>,
}

pub fn section(options: &RunOptions) -> Section {
    let all = gallery::NAMES.iter().map(|&name| name.to_owned());
    let divisions = match options.quick {
        true => {
            let scenes = vec!["plaster".into()];
            vec![Division { views: 100, rows: 4, references: [128; 2], samples: &[16, 64], scenes }]
        }
        false => vec![
            Division {
                views: 100,
                rows: 12,
                references: [4096, 1024],
                samples: &[16, 64, 256, 1024],
                scenes: all.collect(),
            },
            Division {
                views: 20,
                rows: 24,
                references: [1024, 128],
                samples: &[16, 64, 256],
                scenes: FEW_VIEWS.map(String::from).into(),
            },
        ],
    };
    let mut table = Table::new(&[
        "views",
        "scene",
        "view",
        "mean radiance, Cycles / holo",
        "holo, 4 samples, denoise views: error",
        "ms per view",
        "Cycles, most samples: error",
        "ms",
        "Cycles + OIDN, 64 samples: error",
        "ms",
        "Cycles + OIDN, most samples: error",
        "ms",
        "for the error of holo: Cycles / holo",
        "Cycles + OIDN / holo",
    ]);
    let (mut highlights, mut missing) = (Vec::new(), Vec::new());
    for division in &divisions {
        let mut ratios = Vec::new();
        for scene in &division.scenes {
            match measure(scene, division, &mut table) {
                Ok(found) => ratios.extend(found),
                Err(why) => missing.push(format!("{scene}: {why}")),
            }
        }
        highlights.extend(summary(division, &mut ratios));
    }
    let missing = if missing.is_empty() { String::new() } else { format!(" Not run: {}.", missing.join("; ")) };
    Section {
        text: format!(
            "Scenes of the gallery on the 8K sensor of the paper, paths of up to 8 bounces: 100 x 100 views of 79 x 53 \
             px, and 20 x 20 of 398 x 265; center and a corner. `holo` with {SAMPLES} samples and `--denoise views`: the \
             lens rows in the middle (12 of 53, 24 of 265) and {HALO_ROWS} on each side that the reconstruction reads; \
             its time per view is that of all lens rows at the same time per row, divided by the number of views. Cycles \
             renders a view at a time with the scene kept in memory, up to 1024 and 256 samples, without and with \
             OpenImageDenoise (albedo, normals, accurate prefilter). Errors are those of the lens rows in the middle, as \
             in the section before, each program's against two references of its own (4096 and 1024 samples here, 1024 \
             and 128 there), because they model some materials and lights differently: the ratio of their mean radiance \
             tells where. Times for the error of `holo` are interpolated between 16 and the most samples, on logarithmic \
             scales; after > where the most do not reach it. Single runs.{missing}"
        ),
        highlights,
        table,
        plots: Vec::new(),
    }
}

/// The row of the summary; `ratios` are those of time for equal error, and whether they are lower bounds.
fn summary(division: &Division, ratios: &mut [(f64, bool)]) -> Option<[String; 3]> {
    ratios.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (least, most) = (ratios.first()?, ratios.last()?);
    let more = |is_bound| if is_bound { "> " } else { "" };
    let mean = geometric_mean(&ratios.iter().map(|ratio| ratio.0).collect::<Vec<_>>());
    Some([
        format!(
            "Cycles + OIDN, {0} x {0} views, for the error of holo with {SAMPLES} samples, denoise views; {1} views of {2} scenes",
            division.views,
            ratios.len(),
            division.scenes.len()
        ),
        format!(
            "{}{} times as long (geometric mean; {}{} to {}{})",
            more(ratios.iter().any(|ratio| ratio.1)),
            short(mean),
            more(least.1),
            short(least.0),
            more(most.1),
            short(most.0)
        ),
        "against references of each program's own".into(),
    ])
}

/// Adds the rows of a scene; returns for each of its views how many times as long Cycles takes with OpenImageDenoise for
/// the same error, and whether that is a lower bound.
fn measure(name: &str, division: &Division, table: &mut Table) -> Result<Vec<(f64, bool)>, String> {
    let scene = gallery::scene(name).expect("a scene of the gallery");
    let (renderer, rig) = on_the_paper_sensor(&scene, division.views);
    let size = rig.shape().lenses();
    let first = (size.rows - division.rows) / 2;
    let rows = first..first + division.rows;
    let list = [division.views / 2, 0].map(|k| ViewIndex { row: k, column: k });
    let theirs = cycles(name, &rig, &list, division, rows.start * size.columns..rows.end * size.columns)?;
    let own = Own::render(&renderer, &Request::new(rig).lens_rows(Some(rows)), &list, division);
    let rendered_rows = (division.rows + 2 * HALO_ROWS).min(size.rows);
    let own_seconds = own.seconds * size.rows as f64 / rendered_rows as f64 / (division.views * division.views) as f64;
    let mut ratios = Vec::new();
    for view in 0..list.len() {
        let of = |kind: &str| -> Vec<&Rendered> {
            theirs.iter().filter(|image| image.view == view && image.kind == kind).collect()
        };
        let references = of("reference");
        let [a, b] = [0, 1].map(|k| references[k].pixels.as_slice());
        let error = squared_error(&own.images[view], &own.references, view);
        let limits = [vec![a.to_vec()], vec![b.to_vec()]];
        let [plain, denoised] = ["off", "oidn"].map(|kind| -> Vec<(f64, f64)> {
            of(kind).iter().map(|image| (image.seconds, squared_error(&image.pixels, &limits, 0))).collect()
        });
        let [plain_ratio, ratio] = [&plain, &denoised].map(|points| {
            let (more, needed) = seconds_for(error, points).expect("measurements");
            (needed / own_seconds, more)
        });
        let at = division.samples.iter().position(|&samples| samples == 64).expect("64 samples");
        let last = division.samples.len() - 1;
        let cells = |point: &(f64, f64)| [short(point.1), short(1e3 * point.0)];
        let [most, most_ms] = cells(&plain[last]);
        let [some_denoised, some_denoised_ms] = cells(&denoised[at]);
        let [most_denoised, most_denoised_ms] = cells(&denoised[last]);
        table.push([
            format!("{0} x {0}", division.views),
            name.to_owned(),
            ["center", "corner"][view].into(),
            short((mean(a) + mean(b)) / (mean(&own.references[0][view]) + mean(&own.references[1][view]))),
            short(error),
            short(1e3 * own_seconds),
            most,
            most_ms,
            some_denoised,
            some_denoised_ms,
            most_denoised,
            most_denoised_ms,
            format!("{}{}", plain_ratio.1, short(plain_ratio.0)),
            format!("{}{}", ratio.1, short(ratio.0)),
        ]);
        ratios.push((ratio.0, !ratio.1.is_empty()));
    }
    Ok(ratios)
}

fn mean(pixels: &[[f32; 3]]) -> f64 {
    pixels.as_flattened().iter().map(|&value| f64::from(value)).sum::<f64>() / (3 * pixels.len()) as f64
}

/// The same views of this renderer.
struct Own {
    seconds: f64,
    images: Images,
    references: [Images; 2],
}

impl Own {
    fn render(renderer: &Renderer, request: &Request, list: &[ViewIndex], division: &Division) -> Self {
        let references = [1, 2].map(|seed| {
            let request = request.clone().samples(division.references[0]).seed(seed).texture_filter(TextureFilter::Off);
            let color = renderer.render(&request.views(Views::List(list.to_vec())), &()).expect("a reference").color;
            let color = color.expect("the scene is lit");
            (0..list.len()).map(|k| image(&color, 0, k)).collect()
        });
        let start = Instant::now();
        let request = request.clone().samples(SAMPLES).denoise(Denoise::Views);
        let color = renderer.render(&request, &()).expect("a render").color.expect("the scene is lit");
        let seconds = start.elapsed().as_secs_f64();
        Self { seconds, images: list.iter().map(|view| image(&color, view.row, view.column)).collect(), references }
    }
}

/// Renders the views in Cycles; of its images `part` is kept, a range of pixels.
fn cycles(
    name: &str,
    rig: &Rig,
    list: &[ViewIndex],
    division: &Division,
    part: std::ops::Range<usize>,
) -> Result<Vec<Rendered>, String> {
    let file = std::env::temp_dir().join(format!("holo-peers-{}-{name}.glb", std::process::id()));
    let bytes = gallery::to_glb(name).expect("a scene of the gallery").map_err(|why| why.to_string())?;
    std::fs::write(&file, bytes).map_err(|why| format!("{}: {why}", file.display()))?;
    let size = rig.shape().lenses();
    let text = [
        format!("{}x{}", size.columns, size.rows),
        (rig.focal_length_m() / rig.sensor_size_m()).to_string(),
        rig.focus_distance_m().to_string(),
        division.samples.iter().map(u32::to_string).collect::<Vec<_>>().join(","),
        division.references[1].to_string(),
    ];
    let names = ["--size", "--focal", "--focus", "--samples", "--reference"];
    let mut arguments: Vec<&str> = names.into_iter().zip(&text).flat_map(|(name, text)| [name, text]).collect();
    let places: Vec<String> =
        list.iter().map(|view| format!("--view={},{}", rig.view_x_m(view.column), rig.view_y_m(view.row))).collect();
    arguments.extend(places.iter().map(String::as_str));
    let found = scripts::run("blender", "blender_views.py", "Cycles", &file, &arguments, |text| -> Vec<Rendered> {
        text.lines().filter_map(|line| parse(line, &part)).collect()
    });
    let _ = std::fs::remove_file(&file);
    let (found, expected) = (found?, list.len() * (2 * division.samples.len() + 2));
    if found.len() == expected { Ok(found) } else { Err(format!("Cycles: {} of {expected} images", found.len())) }
}

/// Parses a line of the script (see `peers/blender_views.py`); `None` for other lines.
fn parse(line: &str, part: &std::ops::Range<usize>) -> Option<Rendered> {
    let fields: Vec<&str> = line.split('\t').collect();
    let [view, kind, _, seconds, path] = fields[..] else { return None };
    let values = holo_io::read_pfm(Path::new(path), &Limits::default()).ok()?.values;
    let pixels: Vec<[f32; 3]> = values.rows().into_iter().flat_map(|row| rgb(row.iter())).collect();
    Some(Rendered {
        view: view.parse().ok()?,
        kind: kind.into(),
        seconds: seconds.parse().ok()?,
        pixels: pixels.get(part.clone())?.to_vec(),
    })
}

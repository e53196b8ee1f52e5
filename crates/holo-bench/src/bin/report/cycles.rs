//! The reconstruction across views beside Blender's Cycles with and without OpenImageDenoise, on the scenes of the gallery.

use std::ops::Range;
use std::path::Path;
use std::time::Instant;

use holo_bench::error::{Images, nine, rgb, squared_error};
use holo_bench::on_the_paper_sensor;
use holo_core::{LightFieldOwned, Rig, ViewIndex};
use holo_io::Limits;
use holo_render::{Denoise, Renderer, Request, SamplesPerPixel, TextureFilter, Views};
use holo_scene::gallery;

use crate::peers::seconds_for;
use crate::sharing::{self, Division, geometric_mean, image, mean};
use crate::table::{Table, short};
use crate::{RunOptions, Section, scripts};

/// The compared views: their numbers among nine.
const VIEWS: [(usize, &str); 2] = [(4, "center"), (0, "corner")];

/// One of so many pixels has a sample in `holo`.
const ONE_IN: u32 = 4;

/// The samples of Cycles, and those of them that have columns of their own beside the most: 64.
const SAMPLES: [u32; 3] = [16, 64, 256];
const SHOWN: usize = 1;

/// Those of each of its references: in a quick report, with 100 x 100 views, and with fewer.
fn reference_samples(options: &RunOptions, division: &Division) -> u32 {
    if options.quick || division.views < 100 { 128 } else { 1024 }
}

/// The images of `holo`.
struct Own {
    /// Of a whole render, divided by the number of views.
    seconds_per_view: f64,
    /// The error and the mean radiance of each view, in the lens rows that are compared.
    errors: [f64; VIEWS.len()],
    means: [f64; VIEWS.len()],
}

/// One image of Cycles.
struct Rendered {
    view: usize,
    /// `reference`, `off` or `oidn`.
    kind: String,
    seconds: f64,
    pixels: Vec<[f32; 3]>,
}

/// Of 100 x 100 views.
pub fn many_views(options: &RunOptions) -> Section {
    let [division, _] = sharing::divisions(options);
    section(options, &division)
}

/// Of 20 x 20 views; their references take Cycles minutes, so two scenes have to do.
pub fn few_views(options: &RunOptions) -> Section {
    let [_, mut division] = sharing::divisions(options);
    division.scenes.truncate(2);
    section(options, &division)
}

fn section(options: &RunOptions, division: &Division) -> Section {
    let mut table = Table::new(&[
        "views",
        "scene",
        "view",
        "mean radiance, Cycles / holo",
        "holo, 1/4 sample, denoise views: error",
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
    let (mut ratios, mut missing) = (Vec::new(), Vec::new());
    for scene in &division.scenes {
        match measure(options, scene, division, &mut table) {
            Ok(found) => ratios.extend(found),
            Err(why) => missing.push(format!("{scene}: {why}")),
        }
    }
    let highlights = summary(division, &mut ratios).into_iter().collect();
    let missing = if missing.is_empty() { String::new() } else { format!(" Not run: {}.", missing.join("; ")) };
    Section {
        text: format!(
            "Scenes of the gallery on the 8K sensor of the paper, paths of up to 8 bounces, {0} x {0} views; center and a \
             corner. `holo` with `--spp 1/{ONE_IN} --denoise views` renders all views together; its time is divided by \
             their number. Cycles renders a view at a time with the scene kept in memory, up to {1} samples, without and \
             with OpenImageDenoise (albedo, normals, accurate prefilter). Errors: the mean of (x - r)^2 / (r^2 + 0.01 \
             mean(r^2)) over 24 lens rows in the middle without the worst of a hundred pixels, each program's against two \
             references of its own (of `holo` {2} samples each, of Cycles {3}), because they model some materials and \
             lights differently: the ratio of their mean radiance tells where. Times for the error of `holo` are \
             interpolated between 16 and the most samples, on logarithmic scales; after > where the most do not reach it. \
             Single runs.{missing}",
            division.views,
            SAMPLES[SAMPLES.len() - 1],
            division.reference,
            reference_samples(options, division)
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
            "Cycles + OIDN, {0} x {0} views, for the error of holo with 1/{ONE_IN} sample, denoise views; {1} views of {2} \
             scenes",
            division.views,
            ratios.len(),
            division.scenes.len(),
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
fn measure(
    options: &RunOptions,
    name: &str,
    division: &Division,
    table: &mut Table,
) -> Result<Vec<(f64, bool)>, String> {
    let scene = gallery::scene(name).expect("a scene of the gallery");
    let (renderer, rig) = on_the_paper_sensor(&scene, division.views);
    let size = rig.shape().lenses();
    let rows = division.range(size);
    let list = VIEWS.map(|(number, _)| nine(division.views)[number]);
    let reference = reference_samples(options, division);
    let theirs = cycles(name, &rig, &list, reference, rows.start * size.columns..rows.end * size.columns)?;
    let own = own(&renderer, rig, division, &list);
    let mut ratios = Vec::new();
    for (view, (_, label)) in VIEWS.into_iter().enumerate() {
        let of = |kind: &str| -> Vec<&Rendered> {
            theirs.iter().filter(|image| image.view == view && image.kind == kind).collect()
        };
        let references = of("reference");
        let [a, b] = [0, 1].map(|k| references[k].pixels.as_slice());
        let error = own.errors[view];
        let limits = [vec![a.to_vec()], vec![b.to_vec()]];
        let [plain, denoised] = ["off", "oidn"].map(|kind| -> Vec<(f64, f64)> {
            of(kind).iter().map(|image| (image.seconds, squared_error(&image.pixels, &limits, 0))).collect()
        });
        let [plain_ratio, ratio] = [&plain, &denoised].map(|points| {
            let (more, needed) = seconds_for(error, points).expect("measurements");
            (needed / own.seconds_per_view, more)
        });
        let last = SAMPLES.len() - 1;
        let cells = |point: &(f64, f64)| [short(point.1), short(1e3 * point.0)];
        let [most, most_ms] = cells(&plain[last]);
        let [some_denoised, some_denoised_ms] = cells(&denoised[SHOWN]);
        let [most_denoised, most_denoised_ms] = cells(&denoised[last]);
        table.push([
            format!("{0} x {0}", division.views),
            name.to_owned(),
            label.into(),
            short((mean(a) + mean(b)) / 2.0 / own.means[view]),
            short(error),
            short(1e3 * own.seconds_per_view),
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

/// Renders all views, and references of those that are compared.
fn own(renderer: &Renderer, rig: Rig, division: &Division, list: &[ViewIndex; VIEWS.len()]) -> Own {
    let lenses = rig.shape().lenses();
    let rows = division.range(lenses);
    let pixels = rows.start * lenses.columns..rows.end * lenses.columns;
    let request = Request::new(rig).texture_filter(TextureFilter::Off).rows(Some(rows)).samples(division.reference);
    let references: [Images; 2] = [1, 2].map(|seed| {
        let request = request.clone().seed(seed).views(Views::List(list.to_vec()));
        let color = renderer.render(&request, &()).expect("a reference").color.expect("the scene is lit");
        (0..VIEWS.len()).map(|k| image(&color, 0, k)).collect()
    });
    let few = SamplesPerPixel::one_in(ONE_IN).expect("a power of two");
    let request = Request::new(rig).denoise(Denoise::Views).samples(few);
    let start = Instant::now();
    let color: LightFieldOwned<f32> =
        renderer.render(&request, &()).expect("a render").color.expect("the scene is lit");
    let seconds_per_view = start.elapsed().as_secs_f64() / (division.views * division.views) as f64;
    let error = |k: usize| {
        let found = image(&color, list[k].row, list[k].column);
        squared_error(&found[pixels.clone()], &references, k)
    };
    Own {
        seconds_per_view,
        errors: std::array::from_fn(error),
        means: std::array::from_fn(|k| (mean(&references[0][k]) + mean(&references[1][k])) / 2.0),
    }
}

/// Renders the views in Cycles; of its images `part` is kept, a range of pixels.
fn cycles(
    name: &str,
    rig: &Rig,
    list: &[ViewIndex],
    reference: u32,
    part: Range<usize>,
) -> Result<Vec<Rendered>, String> {
    let file = std::env::temp_dir().join(format!("holo-peers-{}-{name}.glb", std::process::id()));
    let bytes = gallery::to_glb(name).expect("a scene of the gallery").map_err(|why| why.to_string())?;
    std::fs::write(&file, bytes).map_err(|why| format!("{}: {why}", file.display()))?;
    let size = rig.shape().lenses();
    let text = [
        format!("{}x{}", size.columns, size.rows),
        (rig.focal_length_m() / rig.sensor_size_m()).to_string(),
        rig.focus_distance_m().to_string(),
        SAMPLES.map(|samples| samples.to_string()).join(","),
        reference.to_string(),
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
    let (found, expected) = (found?, list.len() * (2 * SAMPLES.len() + 2));
    if found.len() == expected { Ok(found) } else { Err(format!("Cycles: {} of {expected} images", found.len())) }
}

/// Parses a line of the script (see `peers/blender_views.py`); `None` for other lines.
fn parse(line: &str, part: &Range<usize>) -> Option<Rendered> {
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

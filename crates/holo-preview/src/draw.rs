//! Draws one look: the central view, what one microlens sees, a strip of the raw image, and depth.

use std::ops::Range;
use std::sync::mpsc::Sender;
use std::time::{Duration, Instant};

use holo_core::{GridSize, LightFieldOwned, Sensor};
use holo_dataset::{
    Camera, Exposure, Focus, OutputSettings, Pixels, Prepared, RenderJob, RenderSettings, RigSettings, Spacing, Stage,
    camera_warnings,
};
use holo_render::{Denoise, Layer, LayerSet, Progress, Renderer, Request, Reuse, TextureFilter, World, exposure};
use ndarray::{Array2, Axis, s};
use serde_json::{Value, json};

use crate::job::{self, Ended};
use crate::pace::Pace;
use crate::protocol::inbox::Newest;
use crate::protocol::{Event, Look, Reply};
use crate::raw_part::{RawPart, Strip};
use crate::{encode, estimate};

/// The largest image, px.
const MAX_SIZE: [usize; 2] = [1600, 1200];

/// Samples of a pixel in one pass over an image that is refined.
const PASS_SAMPLES: u32 = 4;

/// How long an image is refined, and the most passes.
const REFINE_FOR: Duration = Duration::from_secs(12);
const MAX_PASSES: u32 = 64;

/// The side of the map of depth, px.
const MAX_MAP: usize = 512;

/// What stays from look to look at one scene.
#[derive(Default)]
pub(crate) struct Kept {
    /// The camera that stood still last, with its acceleration structure.
    prepared: Option<Prepared>,
    /// The exposure of the last image that stood still.
    exposure_ev: Option<f64>,
    pace: Pace,
}

/// One look at a scene.
pub(crate) struct Drawing<'a> {
    pub stage: &'a Stage,
    pub world: &'a World<'a>,
    /// A renderer at the origin of the world.
    pub still: &'a Renderer,
    pub job: &'a RenderJob,
    pub look: &'a Look,
    /// How many frames a full render has.
    pub frames: usize,
    pub newest: Newest<'a>,
    pub events: &'a Sender<Event>,
}

impl Drawing<'_> {
    /// Draws a look: a first image at once, and if the camera stands still everything else.
    pub fn draw(&self, kept: &mut Kept) -> Result<(), Ended> {
        let start = Instant::now();
        let size = if self.look.moving { kept.pace.size(self.look.size) } else { self.look.size };
        let view = view_job(self.job, size)?;
        let prepared = view.prepare_moved(self.stage, self.still)?;
        let request = view_request(&view, &prepared, self.look.moving)?;
        // One image of a moving camera is done before the next one: newer ones would end all of them.
        let newest: &dyn Progress = if self.look.moving { &() } else { &self.newest };
        let first = color(&prepared, &request, newest)?;
        let exposure_ev = self.exposure_ev(&first, kept);
        self.send_view(&first, (exposure_ev, 1), &prepared, start)?;
        if self.look.moving {
            kept.pace.drawn(start.elapsed());
            return Ok(());
        }
        kept.exposure_ev = Some(exposure_ev);
        kept.prepared = Some(self.details(kept.prepared.take(), exposure_ev)?);
        self.refine(first, &request, &prepared, exposure_ev, start)
    }

    /// The exposure of an image: that which is set, that of the last image while the camera moves, else an automatic one.
    fn exposure_ev(&self, color: &LightFieldOwned<f32>, kept: &Kept) -> f64 {
        match (self.job.settings.output.exposure, kept.exposure_ev) {
            (Exposure::Ev(ev), _) => ev,
            (Exposure::Automatic, Some(ev)) if self.look.moving => ev,
            (Exposure::Automatic, _) => exposure::automatic_exposure(color),
        }
    }

    fn send_view(
        &self,
        color: &LightFieldOwned<f32>,
        (exposure_ev, samples): (f64, u32),
        prepared: &Prepared,
        start: Instant,
    ) -> Result<(), Ended> {
        let codes = encode::codes(color, exposure_ev)?;
        let [right, up, back] = prepared.pose.columns;
        let fov_deg = prepared.rig().map(|rig| {
            let half = rig.slope_x(rig.shape().lenses().columns as f64) - rig.slope_x(0.0);
            2.0 * (half / 2.0).atan().to_degrees()
        });
        let header = json!({
            "kind": "view",
            "number": self.look.number,
            "moving": self.look.moving,
            "samples": samples,
            "milliseconds": start.elapsed().as_secs_f64() * 1e3,
            "exposure_ev": exposure_ev,
            "width": codes.dim().1,
            "height": codes.dim().0,
            "eye": prepared.pose.translation,
            "right": right,
            "up": up,
            "back": back,
            "fov_deg": fov_deg,
        });
        self.send(header, encode::jpeg(codes.view())?);
        Ok(())
    }

    /// Adds samples to an image of one sample until it is good, or something newer arrives.
    fn refine(
        &self,
        first: LightFieldOwned<f32>,
        request: &Request,
        prepared: &Prepared,
        exposure_ev: f64,
        start: Instant,
    ) -> Result<(), Ended> {
        let seed = request.transport.seed;
        let (mut sum, mut count) = (first, 1);
        for k in 1..=MAX_PASSES {
            let samples = k * PASS_SAMPLES - count;
            let request = request.clone().samples(samples).seed(seed.wrapping_add(u64::from(k)));
            let new = color(prepared, &request, &self.newest)?;
            sum.samples_mut().zip_mut_with(&new.samples(), |sum, new| *sum += samples as f32 * new);
            count += samples;
            let is_last = start.elapsed() > REFINE_FOR || k == MAX_PASSES;
            // Each image has twice the samples of the one before.
            if k.is_power_of_two() || is_last {
                let mean = sum.map(|value| value / count as f32).map_err(|why| why.to_string())?;
                self.send_view(&mean, (exposure_ev, count), prepared, start)?;
            }
            if k == 1 {
                // Everything is shown; what follows is better.
                self.send(json!({"kind": "settled", "number": self.look.number}), Vec::new());
            }
            if is_last {
                break;
            }
        }
        Ok(())
    }

    /// Sends what the real camera sees; returns it with its acceleration structure.
    fn details(&self, earlier: Option<Prepared>, exposure_ev: f64) -> Result<Prepared, Ended> {
        let prepared = self.job.prepare(self.stage, self.world, earlier, &())?;
        let strip = self.strip(&prepared, exposure_ev)?;
        let command = estimate::commands(&self.job.source, self.look, &self.job.settings);
        let mut header = json!({
            "kind": "details",
            "number": self.look.number,
            "command": command.shell,
            "python": command.python,
            "frames": self.frames,
            "estimate": estimate::of(&self.job.settings, &prepared, &strip),
        });
        let mut payload = Vec::new();
        let more = match (&self.job.settings.camera, prepared.rig()) {
            (Camera::Plenoptic(file), _) => {
                let warnings = camera_warnings(file);
                let [width, height] = file.camera.angles_of_view_rad().map(f64::to_degrees);
                json!({"warnings": warnings, "angles_deg": [width, height], "camera": file.name})
            }
            (_, Some(rig)) => {
                let depth = prepared.renderer.central_layers(rig, [Layer::Depth].into())?;
                let depth = depth.depth_m().map(|depth| depth.index_axis(Axis(2), 0).to_owned()).unwrap_or_default();
                let warnings: Vec<String> = prepared.warnings()?.iter().map(job::told).collect();
                let shape = rig.shape();
                let map = thinned(&depth);
                let hits = depth.iter().copied().filter(|depth| depth.is_finite());
                let range = hits.clone().fold((f32::INFINITY, 0.0_f32), |(near, far), z| (near.min(z), far.max(z)));
                let hit_share = hits.count() as f64 / depth.len().max(1) as f64;
                payload = map.iter().flat_map(|value| value.to_le_bytes()).collect();
                let scale = |disparity: holo_core::Disparity| disparity.scale_m_px();
                json!({
                    "warnings": warnings,
                    "views": [shape.views().columns, shape.views().rows],
                    "lenses": [shape.lenses().columns, shape.lenses().rows],
                    "map": [map.ncols(), map.nrows()],
                    "depth_m": (hit_share > 0.0).then_some([range.0, range.1]),
                    "hit_share": hit_share,
                    "scale_m_px": [scale(rig.disparity_x()), scale(rig.disparity_y())],
                    // JSON has no infinity.
                    "inverse_focus_per_m": rig.inverse_focus_per_m(),
                    "baseline_m": rig.baseline_x_m(),
                    "focal_mm": rig.intrinsics().focal_length_m * 1e3,
                })
            }
            _ => json!({}),
        };
        merge(&mut header, more);
        self.send(header, payload);
        Ok(prepared)
    }

    /// Sends a part of the raw image at its real size, and returns what it took.
    fn strip(&self, prepared: &Prepared, exposure_ev: f64) -> Result<Strip, Ended> {
        let start = Instant::now();
        let request = self.job.request(prepared)?.layers(LayerSet::EMPTY).denoise(Denoise::Off).estimate_error(false);
        let mut request = request.statistics(false).samples(1);
        request.transport.target_error = None;
        let part = RawPart::new(self.job, prepared, self.look.lens)?;
        if let Some(rig) = part.rig {
            request = request.camera(rig);
        }
        let color = color(prepared, &request.rows(Some(part.rows.clone())), &self.newest)?;
        let seconds = start.elapsed().as_secs_f64();
        let codes = encode::codes(&color, exposure_ev)?;
        let samples = (codes.dim().0 * codes.dim().1) as f64;
        let shown = codes.slice(s![.., part.columns.clone(), ..]);
        let header = json!({
            "kind": "strip",
            "number": self.look.number,
            "first": part.first,
            "row": part.row,
            "first_row": part.first_row,
            "pitch_px": part.pitch_px,
            "is_rig": prepared.rig().is_some(),
            "views": prepared.rig().map(|rig| [rig.shape().views().columns, rig.shape().views().rows]),
            "raw": self.raw_size(prepared),
        });
        self.send(header, encode::png(shown)?);
        self.white(part.rows, part.columns)?;
        Ok(Strip { samples, seconds })
    }

    /// Sends the same part of the white image of a plenoptic camera, and the share of its pixels that get light.
    fn white(&self, rows: Range<usize>, columns: Range<usize>) -> Result<(), Ended> {
        let Some(file) = self.job.settings.camera.plenoptic() else { return Ok(()) };
        let white = file.camera.white_rows(rows).map_err(|why| why.to_string())?;
        let lit = white.iter().filter(|value| **value > 0.0).count();
        let largest = white.iter().copied().fold(0.0_f32, f32::max).max(f32::MIN_POSITIVE);
        let part = white.slice(s![.., columns]);
        let codes = part.mapv(|value| (value / largest * 255.0).round() as u8).insert_axis(Axis(2));
        let lit_share = lit as f64 / white.len() as f64;
        let header = json!({"kind": "white", "number": self.look.number, "lit_share": lit_share});
        self.send(header, encode::png(codes.view())?);
        Ok(())
    }

    fn raw_size(&self, prepared: &Prepared) -> Option<[usize; 2]> {
        let size = match (&self.job.settings.camera, prepared.rig()) {
            (Camera::Plenoptic(file), _) => file.camera.sensor().size,
            (_, rig) => rig?.shape().raw_size(),
        };
        Some([size.columns, size.rows])
    }

    fn send(&self, header: Value, payload: Vec<u8>) {
        // The page may be gone; the inbox says so next.
        let _ = self.events.send(Event::Send(Reply::with(header, payload)));
    }
}

/// The central view of a job, small, as JPEG.
pub(crate) fn thumbnail(job: &RenderJob, size: [usize; 2], newest: Newest) -> Result<Vec<u8>, Ended> {
    let stage = job.stage(&())?;
    let world = stage.world(&job.source, &job.settings.light.sky, &job.engine)?;
    let view = view_job(job, size)?;
    let prepared = view.prepare(&stage, &world, None, &())?;
    let request = view_request(&view, &prepared, false)?.samples(PASS_SAMPLES);
    let color = color(&prepared, &request, &newest)?;
    Ok(encode::jpeg(encode::codes(&color, exposure::automatic_exposure(&color))?.view())?)
}

/// Renders color.
fn color(prepared: &Prepared, request: &Request, newest: &dyn Progress) -> Result<LightFieldOwned<f32>, Ended> {
    let rendered = prepared.renderer.render(request, newest)?;
    rendered.color.ok_or_else(|| Ended::Failed("the scene has no light: choose a sky".into()))
}

/// The job of a pinhole camera in the middle of the camera of `job`, whose image fits into `size`.
fn view_job(job: &RenderJob, size: [usize; 2]) -> Result<RenderJob, Ended> {
    let settings = &job.settings;
    let (mut rig, columns, rows) = match &settings.camera {
        Camera::Rig(rig) => {
            let pixels = match rig.pixels {
                Pixels::Sensor(sensor) => Sensor::size(sensor),
                Pixels::Lenses(lenses) => lenses,
                _ => GridSize::new(2, 3),
            };
            (rig.clone(), pixels.columns as f64, pixels.rows as f64)
        }
        Camera::Plenoptic(file) => {
            let [width, height] = file.camera.angles_of_view_rad().map(|angle| (angle / 2.0).tan());
            let mut rig = RigSettings::default();
            rig.focal_mm = Some(rig.sensor_mm / (2.0 * width.max(height)));
            (rig, width, height)
        }
        Camera::Pinhole => return Err(Ended::Failed("pinhole cameras have no raw image".into())),
        _ => return Err(Ended::Failed("the camera is of no known kind".into())),
    };
    let [most_columns, most_rows] = [0, 1].map(|k| size[k].clamp(16, MAX_SIZE[k]) as f64);
    let scale = (most_columns / columns).min(most_rows / rows);
    let lenses = [rows, columns].map(|side| ((side * scale).round() as usize).max(1));
    rig.views = GridSize::new(1, 1);
    rig.pixels = Pixels::Lenses(lenses.into());
    (rig.spacing, rig.focus) = (Spacing::BaselineM(0.0), Focus::Meters(f64::INFINITY));
    (rig.lens_shifts, rig.subset) = (None, None);
    let mut own = RenderSettings::default().camera(rig).scene(settings.scene.clone());
    own.light = settings.light.clone();
    (own.light.samples, own.light.denoise, own.light.target_error) = (Some(1.into()), Denoise::Off, None);
    own.output = OutputSettings::default();
    Ok(RenderJob::new(job.source.clone(), own).engine(job.engine))
}

fn view_request(view: &RenderJob, prepared: &Prepared, moving: bool) -> Result<Request, Ended> {
    let mut request = view.request(prepared)?.layers(LayerSet::EMPTY).reuse(Reuse::Off);
    // Mirrors and glass still show what they reflect and bend.
    request.transport.indirect &= !moving;
    if moving {
        // A fifth of the time.
        request.transport.texture_filter = TextureFilter::Off;
    }
    Ok(request)
}

/// A map of at most [`MAX_MAP`] x [`MAX_MAP`] values.
fn thinned(map: &Array2<f32>) -> Array2<f32> {
    let step = map.nrows().max(map.ncols()).div_ceil(MAX_MAP).max(1) as isize;
    map.slice(s![..;step, ..;step]).to_owned()
}

/// Adds the keys of one object to another.
fn merge(into: &mut Value, more: Value) {
    if let (Value::Object(into), Value::Object(more)) = (into, more) {
        into.extend(more);
    }
}

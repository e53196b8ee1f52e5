//! Pinhole cameras anywhere, each with a pose and an image of its own, in one folder.
//!
//! | file | contents |
//! |---|---|
//! | `images/NAME.png` | 8 or 16 bits, sRGB, one exposure for all |
//! | `LAYER/NAME.pfm` | a layer, as for views |
//! | `hit_mask/NAME.png` | beside depth: 255 where something is hit |
//! | `transforms.json` | the cameras ([`CameraArray`]), with the names of the images |
//! | `manifest.json` | settings, exposure and digests |
//!
//! Every camera has an acceleration structure in its own frame, so that depth is exact wherever it stands. Cameras far
//! apart share no light. A camera may have a gain of its own, and see the scene later than the others. All of them share one
//! checkpoint, from which an interrupted job continues.

use std::collections::BTreeMap;
use std::time::Instant;

use holo_io::{ArrayCamera, CameraArray, ColorEncoding, Compression, FileDigest, Manifest};
use holo_render::{Integrator, Layer, RayCounts, Rendered, World, exposure};

use super::engine;
use super::job::{RenderJob, RunOptions, Shot};
use super::prepare::{Prepared, Setup, Stage};
use super::report::{CameraReport, RenderReport, Seconds};
use super::trace;
use crate::Error;
use crate::output::layers::{COLOR, file_part, write_hit_mask, write_pfm};
use crate::output::{OutputFolder, Statistics, TRANSFORMS, Wanted, exposure_ev};
use crate::resume::checkpoint::{ImageKeeper, Keeper};
use crate::resume::merge::{self, Label};
use crate::settings::{Exposure, Poses, Shard, word};
use crate::watch::{About, PartProgress};

/// The folder of the images.
const IMAGES: &str = "images";

/// Renders the images of all cameras, or of every N-th of a shard, into a folder.
pub(super) fn render(
    job: &RenderJob,
    (setup, identity): (&Setup, Manifest),
    (stage, world): (&Stage, &World),
    shot: &Shot,
    (mut folder, shard): (OutputFolder, Option<Shard>),
    options: &RunOptions,
) -> Result<RenderReport, Error> {
    let Some(array) = setup.settings.poses.cameras() else {
        return Err(Error::BadRequest("pinhole cameras need `transforms`, which places them".into()));
    };
    if shard.is_some_and(|shard| shard.of > array.cameras.len()) {
        let count = array.cameras.len();
        return Err(Error::BadRequest(format!(
            "{count} cameras can be cut into 1 to {count} shards; `shard` has more"
        )));
    }
    folder.unseal()?;
    let request = (array, &setup.settings.light, setup.wanted, shard);
    let keeper = job.checkpoints.as_ref().map(|checkpoints| {
        Keeper::open(checkpoints, folder.folder(), (&stage.loaded.scene, request), &identity, options.diagnostics)
    });
    let made = images(setup, (stage, world), (array, shard), (folder, identity), keeper.as_ref(), options);
    if let Some(keeper) = keeper {
        keeper.report(made.is_err(), options.diagnostics);
        if made.is_ok() {
            keeper.remove();
        }
    }
    made.map(|report| RenderReport { frame: shot.frame(), ..report })
}

/// Renders and writes the images, and last the manifest.
fn images(
    setup: &Setup,
    (stage, world): (&Stage, &World),
    (array, shard): (&CameraArray, Option<Shard>),
    (mut folder, mut identity): (OutputFolder, Manifest),
    keeper: Option<&Keeper>,
    options: &RunOptions,
) -> Result<RenderReport, Error> {
    let (start, settings) = (Instant::now(), setup.settings);
    let mut exposure = match settings.output.exposure {
        Exposure::Ev(ev) => Some(ev),
        Exposure::Automatic => None,
    };
    let Shard { part, of } = shard.unwrap_or(Shard { part: 1, of: 1 });
    let mine: Vec<usize> = (part - 1..array.cameras.len()).step_by(of).collect();
    let (mut seconds, mut rays, mut samples) = (Seconds::default(), RayCounts::default(), 0);
    let (mut threads, mut why, mut used, mut has_color) = (0, String::new(), setup.wanted.integrator, false);
    let (mut libraries, planned) = (BTreeMap::new(), identity.clone());
    for (k, &pose) in mine.iter().enumerate() {
        let camera = &array.cameras[pose];
        let prepared = prepared(setup, (stage, world), (camera, pose), options)?;
        seconds.build += prepared.build_seconds;
        identity = engine::built_with(identity, &prepared.renderer, options.diagnostics);
        let rendering = Instant::now();
        let progress = PartProgress { inner: options.progress, k, of: mine.len() };
        let request = trace::request(setup, &prepared, None)?;
        // The checkpoint is of the backend of the job.
        let mut rendered = match keeper.filter(|_| identity == planned) {
            Some(all) => {
                let keeper = ImageKeeper { all, image: (pose, array.cameras.len()), turn: (k, mine.len()) };
                prepared.renderer.render_with_checkpoint(&request, &progress, &keeper)?
            }
            None => prepared.renderer.render(&request, &progress)?,
        };
        seconds.render += rendering.elapsed().as_secs_f64();
        multiply(&mut rendered, camera.gain);
        (rays, samples, threads) = (rays + rendered.rays, samples + rendered.samples, prepared.renderer.threads());
        if k == 0 && rendered.color.is_none() && setup.wanted.integrator == Integrator::Auto {
            let note = "note: the scene has no light sources, so there is no color, only ground truth; try `sky auto`";
            options.diagnostics.report(About::Scene, note);
        }
        (has_color, used) = (has_color || rendered.color.is_some(), rendered.integrator);
        why.clone_from(&rendered.why);
        exposure = exposure.or_else(|| prepared.renderer.install(|| exposure_ev(settings.output.exposure, &rendered)));
        let (name, bits) = (&camera.name, settings.output.bit_depth);
        let writing = Instant::now();
        prepared.renderer.install(|| write(&mut folder, name, &rendered, (exposure, bits), setup.wanted))?;
        seconds.write += writing.elapsed().as_secs_f64();
        libraries.append(&mut engine::libraries(&prepared.renderer));
    }
    if let Poses::Array { cameras, up } = &settings.poses {
        folder.add(TRANSFORMS, cameras.write(folder.file(TRANSFORMS), *up)?);
    }
    let mut manifest = Manifest { exposure_ev: exposure.filter(|_| has_color), libraries, ..identity };
    manifest.settings.insert("cameras".into(), array.cameras.len().into());
    manifest.settings.insert("integrator".into(), word(&used).into());
    let backend = manifest.versions.get(engine::ENGINE).cloned().unwrap_or_default();
    if let Some(shard) = shard {
        merge::label(&mut manifest, &Label::new(shard, rays, samples, &why));
    }
    let files = folder.seal(manifest)?;
    seconds.load = stage.load_seconds;
    seconds.total = stage.load_seconds + start.elapsed().as_secs_f64();
    Ok(RenderReport {
        seconds,
        rays,
        samples,
        backend,
        threads,
        integrator: used,
        why,
        camera: CameraReport::Pinholes { count: mine.len() },
        pose: None,
        frame: None,
        statistics: Statistics::default(),
        files,
        warnings: Vec::new(),
    })
}

/// A camera in front of the scene, or, if it sees that later than the others, in front of one of its own.
fn prepared(
    setup: &Setup,
    (stage, world): (&Stage, &World),
    (camera, pose): (&ArrayCamera, usize),
    options: &RunOptions,
) -> Result<Prepared, Error> {
    if camera.time_s == 0.0 {
        return setup.prepare(stage, world, pose, options.diagnostics);
    }
    let stage = setup.stage_later(camera.time_s, options.diagnostics)?;
    let world = stage.world(setup.source, &setup.settings.light.sky, setup.engine)?;
    setup.prepare(&stage, &world, pose, options.diagnostics)
}

/// Multiplies the light of an image by the gain of its camera.
fn multiply(rendered: &mut Rendered, gain: [f64; 3]) {
    if let Some(color) = rendered.color.as_mut().filter(|_| gain != [1.0; 3]) {
        for mut pixel in color.samples_mut().rows_mut() {
            pixel.iter_mut().zip(gain).for_each(|(light, gain)| *light = (f64::from(*light) * gain) as f32);
        }
    }
}

/// Writes the files of one camera.
fn write(
    folder: &mut OutputFolder,
    name: &str,
    rendered: &Rendered,
    (exposure, bits): (Option<f64>, u8),
    wanted: &Wanted,
) -> Result<(), Error> {
    if let (Some(color), Some(ev)) = (&rendered.color, exposure) {
        folder.subfolder(IMAGES)?;
        let file = format!("{IMAGES}/{name}.png");
        let path = folder.file(&file);
        let written: FileDigest = if bits == 16 {
            let coded = exposure::encode_16bit(color, ev)?;
            holo_io::write_png(path, coded.view(0, 0)?, ColorEncoding::Srgb, Compression::Best)?
        } else {
            let coded = exposure::encode_8bit(color, ev)?;
            holo_io::write_png(path, coded.view(0, 0)?, ColorEncoding::Srgb, Compression::Best)?
        };
        folder.add(file, written);
    }
    if let Some(color) = rendered.color.as_ref().filter(|_| wanted.color) {
        let file = layer_file(folder, COLOR, name)?;
        folder.add(file.clone(), write_pfm(folder.file(&file), color.view(0, 0)?)?);
    }
    for (layer, image) in rendered.central.iter().filter(|(layer, _)| wanted.written.contains(*layer)) {
        let file = layer_file(folder, layer.name(), name)?;
        folder.add(file.clone(), write_pfm(folder.file(&file), image.view())?);
    }
    if wanted.hit_mask {
        let layer = file_part(Layer::HitMask.name());
        folder.subfolder(&layer)?;
        write_hit_mask(folder, &format!("{layer}/{name}.png"), wanted, rendered)?;
    }
    Ok(())
}

/// The file of a layer of a camera, in a folder that exists.
fn layer_file(folder: &OutputFolder, layer: &str, camera: &str) -> Result<String, Error> {
    let layer = file_part(layer);
    folder.subfolder(&layer)?;
    Ok(format!("{layer}/{camera}.pfm"))
}

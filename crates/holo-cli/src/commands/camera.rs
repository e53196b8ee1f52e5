//! `holo camera`, `holo white`, `holo calibrate`, `holo eval-calibration`, `holo target`, `holo decode`: plenoptic cameras, their white images and
//! calibration targets, and views of their raw images.

use std::path::{Path, PathBuf};

use holo_core::plenoptic::{MicrolensGrid, presets};
use holo_dataset::{
    Calibrated, DecodeJob, KnownCamera, SceneSource, TargetJob, calibration_score, camera_of_raw, grid_score,
    read_poses, text, write_white_images,
};
use holo_io::dataset::{CAMERA_TOML, RAW_EXR, RAW_PNG};
use holo_io::interop::LensletGridModel;
use holo_io::{CameraFile, ColorEncoding, Compression, Folder};

use crate::arguments::{
    CalibrateOptions, CameraOptions, DecodeOptions, EvalCalibrationOptions, TargetOptions, WhiteOptions, open_camera,
};
use crate::console::{out, say, say_unless};
use crate::failure::Failure;
use crate::interrupt;
use crate::progress::Bar;
use crate::quantities;

/// Centers of light that are farther from those of a camera, on the mean, are of another main lens, px.
const OTHER_LENS_PX: f64 = 0.2;

pub fn run(options: &CameraOptions) -> Result<(), Failure> {
    let Some(name) = &options.name else {
        return presets().iter().try_for_each(|preset| {
            let approximate = if preset.is_approximate { " (approximate)" } else { "" };
            out!("{:<14} {}{approximate}", preset.name, preset.description)
        });
    };
    let toml = CameraFile::open(name)?.to_toml();
    let Some(path) = &options.out else { return out!("{}", toml.trim_end()) };
    holo_io::write_file(path, toml.as_bytes())?;
    say!("wrote {}", path.display());
    Ok(())
}

pub fn white(options: &WhiteOptions) -> Result<(), Failure> {
    let camera = open_camera(&options.camera_file)?;
    let files = write_white_images(&camera, &options.f_numbers, &options.out, interrupt::rollback())?;
    say!("wrote {} to {}", files.join(", "), options.out.display());
    Ok(())
}

pub fn calibrate(options: &CalibrateOptions) -> Result<(), Failure> {
    let known = match (&options.camera_file, options.pixel_um) {
        (Some(camera), _) => KnownCamera::Camera(Box::new(open_camera(camera)?)),
        (None, pixel_um) => KnownCamera::Pixel(pixel_um.unwrap_or(1.0) * 1e-6),
    };
    let found = Calibrated::from_white_images(&options.white, &known)?;
    holo_io::write_file(&options.out, found.camera.to_toml().as_bytes())?;
    if let Some(path) = &options.image {
        holo_io::write_png(path, found.image().view(), ColorEncoding::Srgb, Compression::Best)?;
    }
    let (fit, camera) = (&found.fit, &found.camera.camera);
    let radii: Vec<String> = fit.radii_px.iter().map(|radius| format!("{radius:.3}")).collect();
    say!(
        "{}: {} micro-images, {:.4} px apart, turned by {:.4} degrees, of radius {} px\ncenters of light within {:.3} px \
         (RMS), {:.3} px at most\nwrote {}",
        match camera.array().grid {
            MicrolensGrid::Square => "a square grid",
            MicrolensGrid::HexRows => "a hexagonal grid of rows",
            MicrolensGrid::HexColumns => "a hexagonal grid of columns",
        },
        fit.count,
        camera.micro_image_pitch_px(),
        camera.array().rotation_rad.to_degrees(),
        radii.join(", "),
        fit.rms_px,
        fit.largest_px,
        options.out.display()
    );
    if fit.rms_px > OTHER_LENS_PX {
        say!(
            "warning: the light of the micro-images lies otherwise than that of the camera: its main lens is another, or its image is blurred"
        );
    }
    Ok(())
}

pub fn eval_calibration(options: &EvalCalibrationOptions) -> Result<(), Failure> {
    let is_grid = options.result.ends_with(".json");
    let rows = match is_grid {
        true => grid_score(&LensletGridModel::read(&options.result)?, &options.truth)?,
        false => calibration_score(&open_camera(&options.result)?, &options.truth)?,
    };
    quantities::print(&rows, options.json)
}

pub fn target(options: &TargetOptions) -> Result<(), Failure> {
    let job = TargetJob {
        camera: open_camera(&options.camera_file)?,
        corners: options.checkerboard,
        square_m: options.square_mm / 1e3,
        poses: options.poses.as_deref().map(read_poses).transpose()?,
        samples: options.spp,
        seed: 0,
        engine: options.engine.settings(),
    };
    if !options.overwrite {
        job.check_replaceable(&options.out)?;
    }
    let bar = Bar::new("rendering", false);
    let done = job.run(&options.out, &bar, &say_unless(false), interrupt::rollback());
    bar.finish();
    let (files, corners) = done?;
    say!("wrote {} files with {corners} corners to {}", files.len(), options.out.display());
    Ok(())
}

pub fn decode(options: &DecodeOptions) -> Result<(), Failure> {
    let raw = if options.raw.is_dir() { raw_image_in(&options.raw)? } else { options.raw.clone() };
    let camera = match &options.camera_file {
        Some(camera) => open_camera(camera)?,
        None => match camera_of_raw(&raw)? {
            Some(camera) => camera,
            None => camera_beside(&raw)?,
        },
    };
    let mut job = DecodeJob::new(raw, camera);
    job.white.clone_from(&options.white);
    job.depth.clone_from(&options.depth);
    job.views = options.views.map(|views| views as usize);
    job.scene = options.scene.clone().map(SceneSource::File);
    job.settings.scene.camera.clone_from(&options.camera);
    job.engine = options.engine.settings();
    if !options.overwrite {
        job.check_replaceable(&options.out)?;
    }
    let (rig, files) = job.run(&options.out, &say_unless(false), interrupt::rollback())?;
    say!("decoded {}\n{}", text::shape(rig.shape()), text::rig(&rig, None));
    say!("wrote {} files to {}", files.len(), options.out.display());
    Ok(())
}

/// The raw image in a folder of `holo render --camera-file`.
fn raw_image_in(folder: &Path) -> Result<PathBuf, Failure> {
    let opened = Folder::open(folder)?;
    let found = [RAW_EXR, RAW_PNG].into_iter().find(|name| opened.has_file(name));
    found.map(|name| folder.join(name)).ok_or_else(|| {
        Failure::Failed(format!("{}: it has neither {RAW_EXR} nor {RAW_PNG}; name the raw image", folder.display()))
    })
}

/// The camera in the folder of a raw image.
fn camera_beside(raw: &Path) -> Result<CameraFile, Failure> {
    std::fs::metadata(raw).map_err(|why| Failure::Failed(format!("cannot read {}: {why}", raw.display())))?;
    let folder = Folder::beside(raw)?;
    if folder.kind(CAMERA_TOML)?.is_some() {
        return Ok(CameraFile::read_in(&folder, CAMERA_TOML)?);
    }
    Err(Failure::Usage(format!("{}: its folder has no {CAMERA_TOML}; give --camera-file", raw.display())))
}

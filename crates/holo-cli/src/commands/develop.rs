//! `holo develop` and `holo demosaic`: from light to the codes of a sensor, and from a mosaic to color.

use holo_core::sensor::{Demosaic, ElectronsAtOne};
use holo_dataset::{DemosaicMethod, DevelopJob, text, write_demosaiced};

use crate::arguments::{DemosaicArgument, DemosaicOptions, DevelopOptions, open_camera};
use crate::console::say;
use crate::failure::Failure;

pub fn run(options: &DevelopOptions) -> Result<(), Failure> {
    let electrons = |n: f64| if n.is_finite() { ElectronsAtOne::Given(n) } else { ElectronsAtOne::Automatic };
    let mut job = DevelopJob::new(options.image.clone());
    job.camera = options.camera_file.as_deref().map(open_camera).transpose()?;
    (job.sensor, job.outputs) = (options.sensor_model.clone(), options.write.clone());
    (job.electrons_at_one, job.iso, job.time_s) = (options.electrons.map(electrons), options.iso, options.exposure_s);
    (job.camera_seed, job.seed) = (options.camera_seed, options.seed);
    (job.frame, job.frames, job.is_dark) = (options.frame, options.frames, options.dark);
    let done = job.run(&options.out)?;
    if !options.quiet {
        let (sensor, exposure) = (&done.info.sensor, &done.info.exposure);
        if !done.info.guesses.is_empty() {
            say!("note: not published of {}, and guessed: {}", done.info.name, done.info.guesses);
        }
        say!(
            "{}: {} electrons at value 1, {} codes an electron at ISO {}, black {}; {:.2} % saturated",
            done.info.name,
            text::number(exposure.electrons_at_one),
            text::number(sensor.gain(exposure.iso)),
            text::number(exposure.iso),
            text::number(sensor.black),
            100.0 * done.saturated
        );
        let files: Vec<String> = done.files.iter().map(|file| file.display().to_string()).collect();
        say!("wrote {}", files.join(", "));
    }
    Ok(())
}

pub fn demosaic(options: &DemosaicOptions) -> Result<(), Failure> {
    let method = match (options.method, options.camera_file.as_deref()) {
        (None, None) => DemosaicMethod::Plain(Demosaic::Malvar),
        (Some(DemosaicArgument::Plain(method)), None) => DemosaicMethod::Plain(method),
        (None | Some(DemosaicArgument::MicroImages), Some(camera)) => {
            DemosaicMethod::MicroImages(Box::new(open_camera(camera)?))
        }
        (Some(DemosaicArgument::MicroImages), None) => {
            return Err(Failure::Usage("--method micro-images needs --camera-file".into()));
        }
        (Some(DemosaicArgument::Plain(method)), Some(_)) => {
            let name = method.name();
            return Err(Failure::Usage(format!("--method {name} knows no microlenses; remove it or --camera-file")));
        }
    };
    let info = write_demosaiced(&options.mosaic, &method, &options.out)?;
    if !options.quiet {
        say!("demosaiced the {} of {} to {}", info.sensor.filter.name(), info.name, options.out.display());
    }
    Ok(())
}

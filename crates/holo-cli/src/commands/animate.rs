//! `holo animate`: a camera path through the views, or the frames of a sequence, as an animation or as one image per frame.

use holo_core::{DynImage, DynImageRef, GridSize, Sample, ViewPath, for_each_sample};
use holo_io::dataset::SequenceFolder;
use holo_io::{FileInfo, Manifest, dataset};
use ndarray::ArrayView3;

use super::files::{self, numbered};
use crate::arguments::{AnimateOptions, PathArgument};
use crate::failure::Failure;

/// Frames a second where neither the command line nor the input says.
const FPS: f64 = 25.0;

pub fn run(options: &AnimateOptions) -> Result<(), Failure> {
    if options.row.is_some() && !matches!(options.path, Some(PathArgument::Sweep | PathArgument::PingPong)) {
        return Err(Failure::Usage("--row is for the paths sweep and ping-pong".into()));
    }
    let input = &options.input.input;
    if input.is_dir()
        && let FileInfo::Sequence(sequence) = holo_io::probe(input)?
    {
        return through_time(&sequence, options);
    }
    let light_field = files::read(&options.input)?.light_field;
    let path = path(options, options.path.unwrap_or(PathArgument::Circle), light_field.shape().views())?;
    let shown: Vec<_> = path.iter().map(|&(t, s)| light_field.view(t, s)).collect::<Result<_, _>>()?;
    write(&shown, options.fps.unwrap_or(FPS), options)
}

/// Every frame of a sequence once: its central view, or the one that a camera has reached that needs the whole time for its
/// path.
fn through_time(sequence: &SequenceFolder, options: &AnimateOptions) -> Result<(), Failure> {
    let frames = sequence.frames();
    let mut shown: Vec<DynImage> = Vec::with_capacity(frames.len());
    for (place, &frame) in frames.iter().enumerate() {
        let light_field = files::open(&sequence.frame_path(frame), &options.input)?.read()?.light_field;
        let views = light_field.shape().views();
        let (t, s) = match options.path {
            None => light_field.shape().central_view(),
            Some(along) => {
                let path = path(options, along, views)?;
                // A closed path would show its first view twice; an open one reaches its end.
                let [steps, of] = match along {
                    PathArgument::Circle | PathArgument::PingPong => [path.len(), frames.len()],
                    PathArgument::Sweep | PathArgument::Serpentine => [path.len() - 1, (frames.len() - 1).max(1)],
                };
                path[place * steps / of]
            }
        };
        let view = light_field.view(t, s)?;
        shown.push(for_each_sample!(DynImageRef, view, view => DynImage::from(view.to_owned())));
    }
    let shown: Vec<DynImageRef<'_>> = shown.iter().map(DynImage::as_image_ref).collect();
    write(&shown, options.fps.or_else(|| frame_rate(sequence)).unwrap_or(FPS), options)
}

/// The views of a path.
fn path(options: &AnimateOptions, path: PathArgument, views: GridSize) -> Result<Vec<(usize, usize)>, Failure> {
    let row = options.row.unwrap_or(views.rows / 2);
    let path = match path {
        PathArgument::Circle => ViewPath::Circle,
        PathArgument::Sweep => ViewPath::Sweep { row },
        PathArgument::PingPong => ViewPath::PingPong { row },
        PathArgument::Serpentine => ViewPath::Serpentine,
    };
    Ok(path.views(views)?)
}

/// The frames a second with which a sequence was rendered, by the times of its first and last frame.
fn frame_rate(sequence: &SequenceFolder) -> Option<f64> {
    let (&first, &last) = (sequence.frames().first()?, sequence.frames().last()?);
    let seconds = |frame| {
        let manifest = Manifest::read(sequence.frame_path(frame).join(dataset::MANIFEST_JSON)).ok()?;
        manifest.settings.get("time_s")?.as_number()
    };
    let rate = f64::from(last - first) / (seconds(last)? - seconds(first)?);
    rate.is_finite().then_some(rate)
}

fn write(shown: &[DynImageRef<'_>], fps: f64, options: &AnimateOptions) -> Result<(), Failure> {
    if options.frames {
        for (number, &view) in shown.iter().enumerate() {
            files::write(&numbered(&options.out, number, shown.len()), view)?;
        }
        return Ok(());
    }
    let bytes = shown.iter().map(|&image| match image {
        DynImageRef::U8(image) => Some(image),
        _ => None,
    });
    let words = shown.iter().map(|&image| match image {
        DynImageRef::U16(image) => Some(image),
        _ => None,
    });
    match (bytes.collect::<Option<Vec<_>>>(), words.collect::<Option<Vec<_>>>()) {
        (Some(bytes), _) => animation(&bytes, fps, options),
        (None, Some(words)) => animation(&words, fps, options),
        (None, None) => Err(Failure::Usage(format!(
            "{} holds linear floats, which no animation can; give --frames and a name that ends in .pfm or .tif",
            options.input.input.display()
        ))),
    }
}

fn animation<T: Sample>(frames: &[ArrayView3<'_, T>], fps: f64, options: &AnimateOptions) -> Result<(), Failure> {
    match holo_io::write_animation(&options.out, frames, fps) {
        Err(error @ holo_io::Error::BadInput { .. }) => Err(Failure::Usage(format!("{error}, or give --frames"))),
        other => Ok(other?),
    }
}

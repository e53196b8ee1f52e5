//! Eq. 4 compared with memcpy: time to rearrange elemental images to views and back.
//!
//! Run with `cargo bench -p holo-bench --bench rearrange`. All times are the best of several in one run; only their
//! ratios are reliable. numpy is measured if `HOLO_PYTHON` (or `python3`) has it.

use std::hint::black_box;
use std::process::Command;
use std::time::{Duration, Instant};

use holo_core::{GridSize, LightField, LightFieldShape, Remainder, Sensor, rearrange::naive};
use ndarray::{Array3, ArrayView3, ArrayViewMut3};
use rayon::prelude::*;

/// Repetitions of the fast entries; the minimum counts.
const REPETITIONS: usize = 30;

fn main() {
    let views = GridSize::new(100, 100);
    let split = Sensor::Paper8k.divide(views, Remainder::Crop).expect("the paper's own split").shape;
    println!(
        "{} x {} views of {} x {} pixels, 3 channels, {} threads; milliseconds (times memcpy)",
        split.views().columns,
        split.views().rows,
        split.lenses().columns,
        split.lenses().rows,
        rayon::current_num_threads()
    );
    measure("RGB8", "uint8", split, |index| (index % 251) as u8);
    measure("RGB16", "uint16", split, |index| (index % 65_521) as u16);
    measure("RGB f32", "float32", split, |index| index as f32);
}

fn measure<T: Copy + Send + Sync + PartialEq>(
    name: &str,
    dtype: &str,
    split: LightFieldShape,
    sample: impl Fn(usize) -> T,
) {
    let raw = split.raw_size();
    let shape = (raw.rows, raw.columns, 3);
    let elemental =
        Array3::from_shape_vec(shape, (0..raw.count() * 3).map(sample).collect()).expect("as many as the shape has");
    let mut result = elemental.clone();

    let lenses = LightField::from_elemental_grid(elemental.view(), split).expect("dense, right size");
    let viewpoint = lenses.to_viewpoint_grid().expect("memory for a copy");
    let from_views = LightField::from_viewpoint_grid(viewpoint.view(), split).expect("dense, right size");
    // Interleaved, so that other load of the machine affects all three.
    let [mut memcpy, mut forth, mut back] = [Duration::MAX; 3];
    for _ in 0..REPETITIONS {
        memcpy = memcpy.min(time(|| copy(elemental.view(), result.view_mut())));
        forth = forth.min(time(|| lenses.to_viewpoint_grid_into(result.view_mut()).expect("right size")));
        back = back.min(time(|| from_views.to_elemental_grid_into(result.view_mut()).expect("right size")));
    }
    assert!(result == elemental, "the round trip is the identity");

    println!("{name} ({} MB)", elemental.len() * size_of::<T>() / 1_000_000);
    let report = |what: &str, time: Duration| {
        println!("  {what:<34} {:9.2} ({:6.2} x)", time.as_secs_f64() * 1e3, time.as_secs_f64() / memcpy.as_secs_f64());
    };
    report("memcpy, all threads", memcpy);
    report("elemental -> viewpoint grid", forth);
    report("viewpoint -> elemental grid", back);
    report(
        "elemental -> viewpoint, new image",
        best(3, || {
            black_box(lenses.to_viewpoint_grid().expect("memory for a copy"));
        }),
    );

    let mut reference = None;
    let naive = best(2, || reference = Some(naive::to_viewpoint_grid(elemental.view(), split).expect("right size")));
    report("the paper's loops (naive)", naive);
    assert!(reference.as_ref() == Some(&viewpoint), "fast and naive agree");

    match numpy(dtype, split) {
        Ok([forth, back]) => {
            report("numpy, elemental -> viewpoint", forth);
            report("numpy, viewpoint -> elemental", back);
        }
        Err(why) => println!("  numpy: {why}"),
    }
}

/// The baseline: copies the same bytes in one chunk per thread.
fn copy<T: Copy + Send + Sync>(source: ArrayView3<'_, T>, mut destination: ArrayViewMut3<'_, T>) {
    let source = source.as_slice().expect("standard layout");
    let destination = destination.as_slice_mut().expect("standard layout");
    let chunk = source.len().div_ceil(rayon::current_num_threads());
    destination.par_chunks_mut(chunk).zip(source.par_chunks(chunk)).for_each(|(to, from)| to.copy_from_slice(from));
}

fn time(work: impl FnOnce()) -> Duration {
    let start = Instant::now();
    work();
    start.elapsed()
}

fn best(repetitions: usize, mut work: impl FnMut()) -> Duration {
    (0..repetitions).map(|_| time(&mut work)).min().expect("at least one repetition")
}

/// The times of numpy's strided copy into an existing array, in both directions, measured in Python.
fn numpy(dtype: &str, split: LightFieldShape) -> Result<[Duration; 2], String> {
    let program = holo_bench::python();
    let [v, u, t, s, c] = split.array_shape(3);
    let script = format!(
        "import numpy as n, time; e=n.ones(({v},{t},{u},{s},{c}),n.{dtype}); \
         w=n.ones(({t},{v},{s},{u},{c}),n.{dtype}); \
         k=lambda d,a:(lambda b:(n.copyto(d,a),time.perf_counter()-b)[1])(time.perf_counter()); \
         print(min(k(w,e.transpose(1,0,3,2,4)) for _ in range(4)), \
         min(k(e,w.transpose(1,0,3,2,4)) for _ in range(4)))"
    );
    let output =
        Command::new(&program).args(["-c", &script]).output().map_err(|error| format!("{program}: {error}"))?;
    if !output.status.success() {
        let message = String::from_utf8_lossy(&output.stderr);
        return Err(format!("not measured: {}", message.lines().last().unwrap_or("no message")));
    }
    let text = String::from_utf8_lossy(&output.stdout);
    let seconds: Vec<f64> = text.split_whitespace().filter_map(|word| word.parse().ok()).collect();
    match seconds[..] {
        [forth, back] => Ok([Duration::from_secs_f64(forth), Duration::from_secs_f64(back)]),
        _ => Err(format!("unexpected answer {text:?}")),
    }
}

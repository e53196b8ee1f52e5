//! Writing an 8K light field as MAT and HDF5, compared with SciPy and h5py, and the choice of HDF5 chunk shapes.
//!
//! Run with `cargo bench -p holo-bench --bench files --features hdf5 [-- --chunks]`. The peers are measured if
//! `HOLO_PYTHON` (or `python3`) has them. Times of `holo-io` include syncing the file and its SHA-256; those of the
//! peers include neither. Every entry runs in its own process; its memory is the peak of the process, with the light
//! field.

use std::path::Path;
use std::process::Command;
use std::time::Instant;

use holo_bench::memory_bytes;
use holo_core::{GridSize, LightField, LightFieldShape};
use holo_io::{MatOptions, MatOrder, MatVersion, write_mat_light_field};
use ndarray::Array3;

/// Runs of every entry; the fastest counts.
const ROUNDS: usize = 3;

fn split() -> LightFieldShape {
    LightFieldShape::new(GridSize::new(100, 100), GridSize::new(53, 79)).expect("8K")
}

/// A sample of an elemental grid with the statistics of a render: smooth gradients, edges and noise.
fn raw(index: usize) -> f32 {
    let (x, y, c) = (index / 3 % 7900, index / 23_700, index % 3);
    let (lens, view) = ((x / 100 + y / 100) as f32, (x % 100 + y % 100) as f32);
    let edge = if (x / 100 * 7 + y / 100 * 3) % 11 < 5 { 0.3 } else { 0.0 };
    let noise = (index as u32).wrapping_mul(2_654_435_761) >> 20;
    0.3 + 0.2 * (lens * 0.3 + c as f32).sin() + edge + 0.001 * view + noise as f32 / 4096.0 * 0.03
}

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).filter(|argument| argument != "--bench").collect();
    match arguments.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        ["--one", what, folder] => one(what, Path::new(folder)),
        ["--chunks"] => chunks(),
        _ => compare(),
    }
}

/// Writes one file and prints seconds, bytes of the file and peak memory.
fn one(what: &str, folder: &Path) {
    let raw_size = split().raw_size();
    let shape = (raw_size.rows, raw_size.columns, 3);
    let count = raw_size.count() * 3;
    let (seconds, bytes) = match what {
        "mat" | "mat compressed" => {
            let image = Array3::from_shape_vec(shape, (0..count).map(|at| (raw(at) * 255.0) as u8).collect());
            let field = LightField::from_elemental_grid(image.expect("its size"), split()).expect("its size");
            let options = MatOptions::new().version(MatVersion::V5).compressed(what != "mat");
            let start = Instant::now();
            let written = write_mat_light_field(folder.join("ours"), &field, None, MatOrder::Lenses, &options);
            (start.elapsed().as_secs_f64(), written.expect("a file").bytes)
        }
        #[cfg(feature = "hdf5")]
        "hdf5" => {
            let field = floats(shape, count);
            let start = Instant::now();
            let written = write_hdf5(&folder.join("ours"), &field, None);
            (start.elapsed().as_secs_f64(), written)
        }
        other => panic!("no entry {other}"),
    };
    println!("{seconds} {bytes} {}", memory_bytes("VmHWM:").unwrap_or(0));
}

fn compare() {
    let folder = Folder::new();
    println!(
        "100 x 100 views of 79 x 53 pixels, 3 channels; best of {ROUNDS}; seconds, MB of the file, MB of peak memory"
    );
    report("MAT 5, uint8", "mat", "savemat(out, {'H': a})", "uint8", &folder.0);
    report(
        "MAT 5, uint8, compressed",
        "mat compressed",
        "savemat(out, {'H': a}, do_compression=True)",
        "uint8",
        &folder.0,
    );
    #[cfg(feature = "hdf5")]
    report("HDF5, float32, gzip 1, shuffle", "hdf5", H5PY, "float32", &folder.0);
}

#[cfg(feature = "hdf5")]
const H5PY: &str = "h5py.File(out, 'w').create_dataset('H', data=a, chunks=(4,4,10,10,3), compression=1, shuffle=True)\
                    .file.close()";

/// Runs an entry and its peer alternately and prints the fastest run of each.
fn report(name: &str, what: &str, script: &str, dtype: &str, folder: &Path) {
    // The same samples; Python reshapes them to an array with five axes.
    let samples = folder.join("samples");
    let count = split().raw_size().count() * 3;
    let bytes: Vec<u8> = match dtype {
        "uint8" => (0..count).map(|at| (raw(at) * 255.0) as u8).collect(),
        _ => (0..count).flat_map(|at| raw(at).to_le_bytes()).collect(),
    };
    std::fs::write(&samples, bytes).expect("room");
    let program = holo_bench::python();
    let script = format!(
        "import sys, os, time, resource, numpy as n\nfrom scipy.io import savemat\nimport h5py\nout=sys.argv[2]\n\
         a=n.fromfile(sys.argv[1], n.{dtype}).reshape(53,100,79,100,3).transpose(0,2,1,3,4)\nb=time.perf_counter()\n\
         {script}\nprint(time.perf_counter()-b, os.path.getsize(out), \
         resource.getrusage(resource.RUSAGE_SELF).ru_maxrss*1024)"
    );
    let mut ours = [f64::INFINITY; 3];
    let mut theirs = [f64::INFINITY; 3];
    for _ in 0..ROUNDS {
        let own = std::env::current_exe().expect("this program");
        keep(&mut ours, Command::new(own).args(["--one", what]).arg(folder));
        keep(&mut theirs, Command::new(&program).args(["-c", &script]).arg(&samples).arg(folder.join("theirs")));
    }
    let line = |who: &str, [seconds, bytes, peak]: [f64; 3]| {
        println!("  {who:<8} {seconds:7.3} s {:8.1} MB {:8.0} MB", bytes / 1e6, peak / 1e6);
    };
    println!("{name}");
    line("ours", ours);
    if theirs[0].is_finite() {
        line("theirs", theirs);
        println!("  ratio    {:7.3}", ours[0] / theirs[0]);
    } else {
        println!("  not measured: needs numpy, scipy and h5py in Python (HOLO_PYTHON)");
    }
}

/// Runs a program that prints three numbers and keeps those of its fastest run.
fn keep(best: &mut [f64; 3], command: &mut Command) {
    let Ok(output) = command.output() else { return };
    let text = String::from_utf8_lossy(&output.stdout);
    let numbers: Vec<f64> = text.split_whitespace().filter_map(|word| word.parse().ok()).collect();
    if let [seconds, bytes, peak] = numbers[..]
        && seconds < best[0]
    {
        *best = [seconds, bytes, peak];
    }
}

#[cfg(feature = "hdf5")]
fn floats(shape: (usize, usize, usize), count: usize) -> holo_core::LightFieldOwned<f32> {
    let image = Array3::from_shape_vec(shape, (0..count).map(raw).collect()).expect("its size");
    LightField::from_elemental_grid(image, split()).expect("its size")
}

#[cfg(feature = "hdf5")]
fn write_hdf5(path: &Path, field: &holo_core::LightFieldOwned<f32>, chunk: Option<[usize; 4]>) -> u64 {
    let rig = holo_core::Rig::builder(split())
        .intrinsics(holo_core::Intrinsics { focal_length_m: 0.05, sensor_size_m: 0.036 })
        .baseline_m(1e-4)
        .focus_distance_m(2.0)
        .projection(holo_core::Projection::Perspective)
        .build()
        .unwrap();
    let options = holo_io::Hdf5Options::default().chunk(chunk);
    holo_io::write_hdf5(path, field, &rig, &[], &[], &options).expect("a file").bytes
}

/// The table in the documentation of the HDF5 codec.
#[cfg(feature = "hdf5")]
fn chunks() {
    let folder = Folder::new();
    let path = folder.0.join("chunks.h5");
    let raw_size = split().raw_size();
    let field = floats((raw_size.rows, raw_size.columns, 3), raw_size.count() * 3);
    println!("| chunk (v, u, t, s) | write, s | size, MB | one lens, ms | one view, ms |");
    println!("|---|---|---|---|---|");
    for chunk in [[1, 1, 100, 100], [53, 79, 1, 1], [2, 2, 10, 10], [4, 4, 10, 10], [4, 4, 20, 20], [8, 8, 10, 10]] {
        let start = Instant::now();
        let bytes = write_hdf5(&path, &field, Some(chunk));
        let write = start.elapsed().as_secs_f64();
        let best = |read: &dyn Fn(&holo_io::Hdf5LightField)| {
            // Opened again for each run, so that the cache of the library is empty; the file is in the cache of the
            // system.
            let times = (0..3).map(|_| {
                let file = holo_io::Hdf5LightField::open(&path, &holo_io::Limits::default()).expect("ours");
                let start = Instant::now();
                read(&file);
                start.elapsed().as_secs_f64() * 1e3
            });
            times.fold(f64::INFINITY, f64::min)
        };
        let lens = best(&|file| drop(file.read_lens(26, 39).expect("a lens")));
        let view = best(&|file| drop(file.read_view(50, 50).expect("a view")));
        println!("| {chunk:?} | {write:.1} | {:.0} | {lens:.1} | {view:.1} |", bytes as f64 / 1e6);
    }
}

#[cfg(not(feature = "hdf5"))]
fn chunks() {
    println!("not measured: needs the feature `hdf5`");
}

/// A folder that is removed when dropped.
struct Folder(std::path::PathBuf);

impl Folder {
    fn new() -> Self {
        let path = std::env::temp_dir().join(format!("holo-bench-files-{}", std::process::id()));
        std::fs::create_dir_all(&path).expect("a folder");
        Self(path)
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

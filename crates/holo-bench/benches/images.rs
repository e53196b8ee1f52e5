//! An 8K raw image as PNG and EXR: time, size and memory, compared with OpenCV, Pillow and the OpenEXR library.
//!
//! Run with `cargo bench -p holo-bench --bench images -- [--folder DIR] [--rounds N]`. The other libraries are measured
//! if `HOLO_PYTHON` (or `python3`) has them (`images.py` beside this file). Every row runs in its own process, because
//! peak memory is measured per process; the memory given is that beyond the image itself.
//!
//! The image has the statistics of a render: smooth gradients, edges, and noise of about 1 %. By default files are
//! written to a file system in memory (`/dev/shm`), because `holo-io` syncs its files to the disk and the other
//! libraries do not; its times include a SHA-256 of the file, which theirs do not.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;

use holo_bench::memory_bytes;
use holo_io::{ColorEncoding, Compression, ExrChannel, ExrCompression, Limits, read_exr, write_exr_with, write_png};
use ndarray::{Array3, Axis};

const ROWS: usize = 5300;
const COLUMNS: usize = 7900;

/// Titles and rows of the tables. Times are relative to the first row.
const TABLES: [(&str, &[&str]); 4] = [
    ("PNG, RGB of 8 bits, write", &["py cv2", "py pillow", "png scratch", "png published"]),
    ("EXR, RGB of half, ZIP, write", &["py openexr-write-zip", "exr write-zip"]),
    ("EXR, RGB of half, PIZ, write", &["py openexr-write-piz", "exr write-piz"]),
    ("EXR, RGB of half, ZIP, read", &["py openexr-read", "exr read"]),
];

fn main() {
    let (mut folder, mut rounds, mut entry) = (None, 3, None);
    let mut arguments = std::env::args().skip(1).filter(|argument| argument != "--bench");
    while let Some(argument) = arguments.next() {
        let mut value = || arguments.next().expect("a value after the option");
        match argument.as_str() {
            "--folder" => folder = Some(PathBuf::from(value())),
            "--rounds" => rounds = value().parse().expect("a count"),
            "--entry" => entry = Some(value()),
            _ => panic!("{argument}: unknown"),
        }
    }
    let memory = Path::new("/dev/shm");
    let parent = folder.unwrap_or_else(|| if memory.is_dir() { memory.to_owned() } else { std::env::temp_dir() });
    if let Some(entry) = entry {
        return measure(&parent, &entry, rounds);
    }
    let folder = parent.join(format!("holo-bench-images-{}", std::process::id()));
    std::fs::create_dir(&folder).expect("a folder for the files");
    write_samples(&folder.join("image.raw"));
    println!("{COLUMNS} x {ROWS} RGB, {} threads, best of {rounds}", rayon::current_num_threads());
    for (title, entries) in TABLES {
        println!("{title:<34} {:>8} {:>8} {:>8} {:>10}", "s", "times", "MB", "extra MB");
        let mut reference = None;
        for entry in entries {
            match run(&folder, entry, rounds) {
                Ok([seconds, bytes, extra]) => {
                    let times = seconds / *reference.get_or_insert(seconds);
                    println!("  {entry:<32} {seconds:8.2} {times:8.2} {:8.1} {:10.0}", bytes / 1e6, extra / 1e6);
                }
                Err(why) => println!("  {entry:<32} not measured: {why}"),
            }
        }
    }
    std::fs::remove_dir_all(&folder).expect("the folder is removed");
}

/// Measures one row in its own process: seconds, bytes of the file, bytes of memory.
fn run(folder: &Path, entry: &str, rounds: usize) -> Result<[f64; 3], String> {
    let rounds = rounds.to_string();
    let mut command = match entry.strip_prefix("py ") {
        Some(entry) => {
            let mut python = Command::new(holo_bench::python());
            let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("benches/images.py");
            python.arg(script).arg(folder).args([entry, &rounds, &ROWS.to_string(), &COLUMNS.to_string()]);
            python
        }
        None => {
            let mut own = Command::new(std::env::current_exe().expect("the path of this program"));
            own.arg("--folder").arg(folder).args(["--rounds", &rounds, "--entry", entry]);
            own
        }
    };
    let output = command.output().map_err(|error| error.to_string())?;
    let text = String::from_utf8_lossy(&output.stdout);
    let numbers: Vec<f64> = text.split_whitespace().filter_map(|word| word.parse().ok()).collect();
    <[f64; 3]>::try_from(numbers).map_err(|_| {
        let message = String::from_utf8_lossy(&output.stderr);
        message.lines().last().unwrap_or("no message").to_owned()
    })
}

fn measure(folder: &Path, entry: &str, rounds: usize) {
    let (kind, what) = entry.split_once(' ').expect("two words");
    let bytes = std::fs::read(folder.join("image.raw")).expect("the samples");
    let samples = bytes.chunks_exact(2).map(|pair| u16::from_le_bytes([pair[0], pair[1]]));
    let file = folder.join(format!("holo.{kind}"));
    if kind == "png" {
        let image = shaped(samples.map(|sample| (sample >> 8) as u8));
        drop(bytes);
        let compression = if what == "scratch" { Compression::Fast } else { Compression::Best };
        report(rounds, &file, || {
            write_png(&file, image.view(), ColorEncoding::Srgb, compression).expect("a file");
        });
    } else if what == "read" {
        drop(bytes);
        report(rounds, &file, || drop(read_exr(&file, &Limits::default()).expect("the file of an earlier row")));
    } else {
        let image = shaped(samples.map(|sample| (f32::from(sample) / 65535.0) * (f32::from(sample) / 65535.0)));
        drop(bytes);
        let planes: Vec<_> = (0..3).map(|channel| image.index_axis(Axis(2), channel)).collect();
        let channels: Vec<_> = ["R", "G", "B"].into_iter().zip(planes).map(|(n, p)| ExrChannel::half(n, p)).collect();
        // The last table reads the ZIP file.
        let (file, compression) = match what {
            "write-zip" => (file, ExrCompression::Zip),
            _ => (folder.join("holo-piz.exr"), ExrCompression::Piz),
        };
        report(rounds, &file, || {
            write_exr_with(&file, &channels, compression).expect("a file");
        });
    }
}

fn shaped<T>(samples: impl Iterator<Item = T>) -> Array3<T> {
    Array3::from_shape_vec((ROWS, COLUMNS, 3), samples.collect()).expect("as many as the shape has")
}

/// Prints the three numbers of a row: seconds, bytes of the file, bytes of memory.
fn report(rounds: usize, file: &Path, mut work: impl FnMut()) {
    // Resets the peak memory of this process.
    let _ = std::fs::write("/proc/self/clear_refs", "5");
    let memory = |key| memory_bytes(key).unwrap_or(0);
    let before = memory("VmRSS:");
    let mut best = f64::INFINITY;
    for _ in 0..rounds {
        let start = Instant::now();
        work();
        best = best.min(start.elapsed().as_secs_f64());
    }
    let bytes = std::fs::metadata(file).expect("the file").len();
    println!("{best} {bytes} {}", memory("VmHWM:").saturating_sub(before));
}

/// Writes the image as 16-bit little-endian samples, which this file and `images.py` convert to the other formats.
fn write_samples(path: &Path) {
    let mut state = 1_u64;
    let mut noise = || {
        // The sum of four uniform numbers is approximately Gaussian.
        (0..4)
            .map(|_| {
                state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                (state >> 54) as f32 / 1024.0 - 0.5
            })
            .sum::<f32>()
    };
    let mut bytes = Vec::with_capacity(ROWS * COLUMNS * 6);
    for row in 0..ROWS {
        for column in 0..COLUMNS {
            let (y, x) = (row as f32 / ROWS as f32, column as f32 / COLUMNS as f32);
            let stripe = if ((x * 23.0).floor() + (y * 17.0).floor()) % 2.0 == 0.0 { 0.25 } else { 0.0 };
            for channel in 0..3 {
                let surface = 0.3 + 0.2 * (x * 9.0 + channel as f32).sin() * (y * 7.0).cos() + stripe;
                let sample = (surface + 0.01 * noise()).clamp(0.0, 1.0) * 65535.0;
                bytes.extend((sample as u16).to_le_bytes());
            }
        }
    }
    std::fs::write(path, bytes).expect("room for the samples");
}

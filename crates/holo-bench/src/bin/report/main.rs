//! Measures speed and error: `cargo xtask report [--quick] [--peers] [--only TEXT].. [--out DIR]`.
//!
//! Writes into `target/report` `REPORT.md`, its summary `SUMMARY.md`, one CSV file per table, and SVG plots; the
//! repository keeps the summary and some plots of a run in `report`. With `--only`, once or more, the other
//! sections of the folder stay. Every time is the median of several runs of this process with their spread (BVH builds,
//! and what takes longer than ten seconds: one run), as a ratio to a comparable time if there is one. Every error is
//! against a reference: a render with many samples, a closed form, brute-force intersection in f64, the original bits,
//! or Mitsuba's images in `tests/radiance`.
#![forbid(unsafe_code)]

mod cycles;
mod files;
mod ground_truth;
mod honesty;
mod leak;
mod light;
mod page;
mod peers;
mod plot;
mod scaling;
mod scenes;
mod scripts;
mod sensor;
mod sharing;
mod stereo;
mod table;

use std::path::PathBuf;
use std::time::Instant;

use holo_render::Backend;
use table::Table;

/// The options of a report.
pub struct RunOptions {
    /// Fewer samples and smaller images.
    pub quick: bool,
    /// Runs per measured time.
    pub rounds: usize,
    /// The available backends, the fastest one first.
    pub engines: Vec<Backend>,
}

/// The results of a section.
pub struct Section {
    /// What was measured, and how.
    pub text: String,
    /// Rows of the summary: what, speed, error.
    pub highlights: Vec<[String; 3]>,
    /// Its table.
    pub table: Table,
    /// Names and SVG of its plots.
    pub plots: Vec<(&'static str, String)>,
}

/// Measures a section.
type SectionFn = fn(&RunOptions) -> Section;

/// The sections that need other programs.
const PEERS: [&str; 3] = [
    "Beside other renderers",
    "Beside Cycles scene by scene: 100 x 100 views",
    "Beside Cycles scene by scene: 20 x 20 views",
];

/// The sections, in the order of the report.
const SECTIONS: [(&str, SectionFn); 12] = [
    (PEERS[0], peers::section),
    ("Light shared between views", sharing::section),
    (PEERS[1], cycles::many_views),
    (PEERS[2], cycles::few_views),
    ("Light", light::section),
    ("Ground truth", ground_truth::section),
    ("Scaling", scaling::section),
    ("Pixels and files", files::section),
    ("Depth from stereo", stereo::section),
    ("Depth from reconstructed views", leak::section),
    ("Photon transfer", sensor::photon_transfer),
    ("Noise of sensors", sensor::noise),
];

fn main() {
    let (mut quick, mut with_peers, mut only, mut out) = (false, false, Vec::new(), PathBuf::from("target/report"));
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        match argument.as_str() {
            "--quick" => quick = true,
            "--peers" => with_peers = true,
            "--only" => match arguments.next() {
                Some(text) => only.push(text.to_lowercase()),
                None => {
                    eprintln!("report: --only needs a part of the name of a section");
                    std::process::exit(2);
                }
            },
            "--out" => match arguments.next() {
                Some(folder) => out = folder.into(),
                None => {
                    eprintln!("report: --out needs a folder");
                    std::process::exit(2);
                }
            },
            other => {
                eprintln!(
                    "report: unknown argument '{other}'; the options are --quick, --peers, --only TEXT (once or more) and --out DIR"
                );
                std::process::exit(2);
            }
        }
    }
    let start = Instant::now();
    let options = RunOptions { quick, rounds: if quick { 3 } else { 5 }, engines: scenes::engines() };
    if let Some(unknown) =
        only.iter().find(|&text| SECTIONS.iter().all(|(title, _)| !title.to_lowercase().contains(text)))
    {
        let titles = SECTIONS.map(|(title, _)| title).join(", ");
        eprintln!("report: no section has '{unknown}' in its title; they are {titles}");
        std::process::exit(2);
    }
    // A whole title means that section alone: "light" is also a part of others.
    let is_title = |text: &str| SECTIONS.iter().any(|(title, _)| title.to_lowercase() == text);
    let names = |text: &String, title: &str| if is_title(text) { title == text } else { title.contains(text.as_str()) };
    let is_wanted = |title: &str| only.is_empty() || only.iter().any(|text| names(text, &title.to_lowercase()));
    let wanted = SECTIONS.iter().filter(|(title, _)| is_wanted(title));
    let wanted = wanted.filter(|(title, _)| with_peers || !PEERS.contains(title));
    let mut page = page::Page::open(&out, !only.is_empty());
    let mut measured = 0;
    for (title, make) in wanted {
        eprintln!("{:5.0} s  {title}", start.elapsed().as_secs_f64());
        page.put(title, &make(&options), quick);
        // After every section: an interruption keeps what is measured.
        if let Err(why) = page.write(&SECTIONS.map(|(title, _)| title)) {
            eprintln!("report: {}: {why}", out.display());
            std::process::exit(1);
        }
        measured += 1;
    }
    if measured == 0 {
        let titles = SECTIONS.map(|(title, _)| title).join(", ");
        eprintln!(
            "report: no section has '{}' in its title; they are {titles} (those beside others need --peers)",
            only.join("' or '")
        );
        std::process::exit(2);
    }
    eprintln!("{:5.0} s  wrote {}", start.elapsed().as_secs_f64(), out.join("REPORT.md").display());
}

//! Measures speed and error: `cargo xtask report [--quick] [--peers] [--only TEXT] [--out DIR]`.
//!
//! Writes `REPORT.md`, one CSV file per table, and SVG plots. Every time is the median of several runs of this process
//! with their spread (BVH builds: one run), as a ratio to a comparable time if there is one. Every error is against a
//! reference: a render with many samples, a closed form, brute-force intersection in f64, the original bits, or
//! Mitsuba's images in `tests/radiance`.
#![forbid(unsafe_code)]

mod files;
mod ground_truth;
mod light;
mod peers;
mod plot;
mod scaling;
mod scenes;
mod sharing;
mod stereo;
mod table;

use std::path::{Path, PathBuf};
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
    /// The heading.
    pub title: &'static str,
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

fn main() {
    let (mut quick, mut with_peers, mut only, mut out) = (false, false, String::new(), PathBuf::from("report"));
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        match argument.as_str() {
            "--quick" => quick = true,
            "--peers" => with_peers = true,
            "--only" => match arguments.next() {
                Some(text) => only = text,
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
                    "report: unknown argument '{other}'; the options are --quick, --peers, --only TEXT and --out DIR"
                );
                std::process::exit(2);
            }
        }
    }
    let start = Instant::now();
    let options = RunOptions { quick, rounds: if quick { 3 } else { 5 }, engines: scenes::engines() };
    let mut sections = Vec::new();
    let mut section_fns: Vec<(&str, SectionFn)> = vec![
        ("sharing between views", sharing::section),
        ("light", light::section),
        ("ground truth", ground_truth::section),
        ("scaling", scaling::section),
        ("pixels and files", files::section),
        ("disparity from stereo", stereo::section),
    ];
    if with_peers {
        section_fns.insert(0, ("other renderers", peers::section));
    }
    for (name, make) in section_fns.into_iter().filter(|(name, _)| name.contains(&only)) {
        eprintln!("{:5.0} s  {name}", start.elapsed().as_secs_f64());
        sections.push(make(&options));
    }
    if let Err(why) = write(&out, &sections, quick) {
        eprintln!("report: {}: {why}", out.display());
        std::process::exit(1);
    }
    eprintln!("{:5.0} s  wrote {}", start.elapsed().as_secs_f64(), out.join("REPORT.md").display());
}

fn write(out: &Path, sections: &[Section], quick: bool) -> std::io::Result<()> {
    std::fs::create_dir_all(out)?;
    let mut text = format!("# Speed against error\n\n{}\n", scenes::machine());
    if quick {
        text +=
            "\nA quick report: few samples, small images; its numbers have more scatter than those of a full report.\n";
    }
    let mut summary = Table::new(&["what", "speed", "error"]);
    sections.iter().flat_map(|section| &section.highlights).for_each(|row| summary.push(row.clone()));
    text += &format!("\n## Summary\n\n{}", summary.markdown());
    std::fs::write(out.join("in_short.csv"), summary.csv())?;
    for section in sections {
        text += &format!("\n## {}\n\n{}\n\n{}", section.title, section.text, section.table.markdown());
        let stem = section.title.to_lowercase().replace(' ', "_");
        std::fs::write(out.join(format!("{stem}.csv")), section.table.csv())?;
        for (name, svg) in &section.plots {
            text += &format!("\n![{name}]({name}.svg)\n");
            std::fs::write(out.join(format!("{name}.svg")), svg)?;
        }
    }
    std::fs::write(out.join("REPORT.md"), text)
}

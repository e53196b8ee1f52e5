//! Speed against error, measured anew: `cargo xtask report [--quick] [--peers] [--out DIR]`.
//!
//! Writes `REPORT.md`, a CSV file a table and SVG plots. Every time is the median of several runs of this one process, with how far the
//! runs are apart (building a tree: one run), and is told as a ratio wherever there is something to hold it against; every error is against
//! many samples, a closed form, every triangle tried in f64, the same bits, or Mitsuba's picture in `tests/radiance`.
#![forbid(unsafe_code)]

mod light;
mod moves;
mod peers;
mod plot;
mod scaling;
mod scenes;
mod sheet;
mod stereo;
mod truth;

use std::path::{Path, PathBuf};
use std::time::Instant;

use holo_render::Backend;
use sheet::Sheet;

/// What the sections are asked for.
pub struct Wish {
    /// Less of everything: a report of some two minutes.
    pub quick: bool,
    /// Runs of everything that is timed.
    pub rounds: usize,
    /// The engines of this machine.
    pub engines: Vec<Backend>,
}

/// What a section found.
pub struct Section {
    /// The heading.
    pub title: &'static str,
    /// What was measured and how, and what is to be seen.
    pub text: String,
    /// What the summary says of it: what, how fast, how wrong.
    pub highlights: Vec<[String; 3]>,
    /// Its table.
    pub sheet: Sheet,
    /// Names and contents of its plots.
    pub plots: Vec<(&'static str, String)>,
}

/// Makes a section.
type Maker = fn(&Wish) -> Section;

fn main() {
    let (mut quick, mut with_peers, mut out) = (false, false, PathBuf::from("report"));
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        match argument.as_str() {
            "--quick" => quick = true,
            "--peers" => with_peers = true,
            "--out" => match arguments.next() {
                Some(folder) => out = folder.into(),
                None => {
                    eprintln!("report: --out needs a folder behind it");
                    std::process::exit(2);
                }
            },
            other => {
                eprintln!("report: unknown argument '{other}'; there are --quick, --peers and --out DIR");
                std::process::exit(2);
            }
        }
    }
    let start = Instant::now();
    let wish = Wish { quick, rounds: if quick { 3 } else { 5 }, engines: scenes::engines() };
    let mut sections = Vec::new();
    let mut makers: Vec<(&str, Maker)> = vec![
        ("light", light::section),
        ("ground truth", truth::section),
        ("scaling", scaling::section),
        ("pixels and files", moves::section),
        ("depth from stereo", stereo::section),
    ];
    if with_peers {
        makers.insert(0, ("beside other renderers", peers::section));
    }
    for (name, make) in makers {
        eprintln!("{:5.0} s  {name}", start.elapsed().as_secs_f64());
        sections.push(make(&wish));
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
        text += "\nA quick report: few samples, small pictures; the numbers scatter more than those of a whole one.\n";
    }
    let mut summary = Sheet::new(&["what", "speed", "error"]);
    sections.iter().flat_map(|section| &section.highlights).for_each(|row| summary.push(row.clone()));
    text += &format!("\n## In short\n\n{}", summary.markdown());
    std::fs::write(out.join("in_short.csv"), summary.csv())?;
    for section in sections {
        text += &format!("\n## {}\n\n{}\n\n{}", section.title, section.text, section.sheet.markdown());
        let stem = section.title.to_lowercase().replace(' ', "_");
        std::fs::write(out.join(format!("{stem}.csv")), section.sheet.csv())?;
        for (name, svg) in &section.plots {
            text += &format!("\n![{name}]({name}.svg)\n");
            std::fs::write(out.join(format!("{name}.svg")), svg)?;
        }
    }
    std::fs::write(out.join("REPORT.md"), text)
}

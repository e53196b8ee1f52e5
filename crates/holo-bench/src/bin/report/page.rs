//! The page of a report: sections that are measured now, and those that an earlier run has measured.

use std::collections::{BTreeMap, BTreeSet};
use std::io;
use std::path::{Path, PathBuf};

use crate::table::Table;
use crate::{Section, scenes};

/// The rows of the summary, with the section that each is of.
const SUMMARY: &str = "in_short.csv";

/// Its heading.
const SUMMARY_TITLE: &str = "Summary";

/// The summary on a page of its own: the part of a report that the repository keeps.
const SUMMARY_PAGE: &str = "SUMMARY.md";

/// The sections of a report in a folder.
pub struct Page {
    folder: PathBuf,
    /// The text of every section below its heading.
    texts: BTreeMap<String, String>,
    /// Section, what, speed, error.
    highlights: Vec<[String; 4]>,
    /// Names and contents of other files.
    files: Vec<(String, String)>,
    /// The sections that this run has measured.
    measured: BTreeSet<String>,
}

impl Page {
    /// The report in `folder`, with the sections that it has if `keeps` them.
    pub fn open(folder: &Path, keeps: bool) -> Self {
        let mut page = Self {
            folder: folder.to_owned(),
            texts: BTreeMap::new(),
            highlights: Vec::new(),
            files: Vec::new(),
            measured: BTreeSet::new(),
        };
        let read = |name: &str| std::fs::read_to_string(folder.join(name)).unwrap_or_default();
        if keeps {
            let text = read("REPORT.md");
            let sections = text.split("\n## ").skip(1).filter_map(|section| section.split_once("\n\n"));
            let sections = sections.filter(|(title, _)| *title != SUMMARY_TITLE);
            page.texts.extend(sections.map(|(title, text)| (title.to_owned(), text.trim_end().to_owned())));
            let rows = read(SUMMARY);
            let cells = |row: &str| row.split(',').map(str::to_owned).collect::<Vec<_>>().try_into().ok();
            page.highlights = rows.lines().skip(1).filter_map(cells).collect();
        }
        page
    }

    /// Adds a section, or replaces it; its title is a cell of the summary and has no comma.
    pub fn put(&mut self, title: &str, section: &Section, is_quick: bool) {
        assert!(!title.contains(','), "a title with a comma: {title}");
        let quick = if is_quick { " Few samples and small images: more scatter than in a full report." } else { "" };
        let machine = scenes::machine();
        let mut text = format!("{}\n\n{machine}{quick}\n\n{}", section.text, section.table.markdown());
        for (name, svg) in &section.plots {
            text += &format!("\n![{name}]({name}.svg)\n");
            self.files.push((format!("{name}.svg"), svg.clone()));
        }
        self.texts.insert(title.to_owned(), text.trim_end().to_owned());
        self.measured.insert(title.to_owned());
        self.files
            .push((format!("{}.csv", title.to_lowercase().replace(':', "").replace(' ', "_")), section.table.csv()));
        self.highlights.retain(|row| row[0] != title);
        let rows = section.highlights.iter().map(|[what, speed, error]| [title, what, speed, error]);
        self.highlights.extend(rows.map(|row| row.map(|cell| cell.replace(',', ";"))));
    }

    /// Writes all files; the sections have the order of `titles`.
    ///
    /// # Errors
    /// Of the file system.
    pub fn write(&self, titles: &[&str]) -> io::Result<()> {
        std::fs::create_dir_all(&self.folder)?;
        let mut summary = Table::new(&["section", "what", "speed", "error"]);
        for title in titles {
            self.highlights.iter().filter(|row| row[0] == *title).for_each(|row| summary.push(row.clone()));
        }
        let times = "A time is the median of at most five runs; no run begins after ten seconds. ± is half the difference \
                     between the slowest and the fastest run; a single run has none. On shared machines only ratios are \
                     reliable.";
        let mut text = format!(
            "# Speed against error\n\nEvery section names the machine that it was measured on. {times}\n\n## {SUMMARY_TITLE}\n\n{}",
            summary.markdown()
        );
        for (title, section) in titles.iter().filter_map(|title| Some((title, self.texts.get(*title)?))) {
            text += &format!("\n## {title}\n\n{section}\n");
        }
        let write = |name: &str, text: &str| std::fs::write(self.folder.join(name), text);
        self.files.iter().try_for_each(|(name, text)| write(name, text))?;
        write(SUMMARY, &summary.csv())?;
        write(SUMMARY_PAGE, &self.summary_page(&summary, times, titles))?;
        write("REPORT.md", &text)
    }

    /// The summary, and which sections are older than this run or missing.
    fn summary_page(&self, summary: &Table, times: &str, titles: &[&str]) -> String {
        let older: Vec<&str> =
            self.texts.keys().map(String::as_str).filter(|title| !self.measured.contains(*title)).collect();
        let runs = if older.is_empty() {
            "One run measured all rows.".to_owned()
        } else {
            format!("Older than this run, maybe of another machine: {}.", older.join(", "))
        };
        let missing: Vec<&str> = titles.iter().copied().filter(|title| !self.texts.contains_key(*title)).collect();
        let missing =
            if missing.is_empty() { String::new() } else { format!(" Not measured: {}.", missing.join(", ")) };
        format!(
            "# Speed against error, in short\n\n{} {runs}{missing} {times} `cargo xtask report --peers` measures it \
             again, with all tables in `REPORT.md`.\n\n{}",
            scenes::machine(),
            summary.markdown()
        )
    }
}

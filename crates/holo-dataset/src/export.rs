//! Exports: light fields and raw images as the files that programs of others read. A target is one file, and says what it needs.
//!
//! Conventions are those of each program's own loader. What a target writes never depends on the reader knowing anything of
//! this project: sizes, ranges and orders are those that the loader expects.
//!
//! **May import:** describe, score, camera, settings, output, watch.

mod basiclfsr;
mod hci;
mod jpeg_pleno;
mod lfasr;
mod lfsd;
mod nerf;
mod npy;
mod plenoptic;
mod plenpy;
mod source;
mod stanford;
mod urbanlf;

use std::path::{Path, PathBuf};

use holo_core::GridSize;

use self::nerf::CameraLists;
use self::plenoptic::{Boards, RawImage};
use self::source::{LoadedField, SourceField, renamed, sources};
use crate::Error;
use crate::output::{OutputFolder, Rollback, TRANSFORMS};
use crate::settings::Tool;
use crate::settings::text::counted;
use crate::watch::{About, Diagnostics};

/// A program, or a family of programs, that light fields, raw images or images of pinhole cameras are written for.
#[derive(Clone, Copy, Debug)]
pub struct ExportTarget {
    /// The name.
    pub name: &'static str,
    /// What reads the files.
    pub help: &'static str,
    /// How its reader is called, for the `README.txt` of an export.
    usage: &'static str,
    /// Whether scenes lie in a group.
    has_groups: bool,
    /// Whether it has masks of chosen objects.
    has_objects: bool,
    writer: Writer,
}

/// What a target writes.
#[derive(Clone, Copy, Debug)]
enum Writer {
    /// Light fields, one after another.
    Fields { write: WriteField, check: CheckFields },
    /// All light fields as one.
    Joined(WriteJoined),
    /// Images of posed cameras: those of a folder, or the views of light fields.
    Posed(CameraLists),
    /// Raw images of plenoptic cameras.
    Raw(Tool),
    /// Raw images of boards.
    Boards,
}

/// What is exported, and how.
enum Work {
    Fields {
        sources: Vec<SourceField>,
        write: WriteField,
        check: CheckFields,
    },
    Joined(Vec<SourceField>, WriteJoined),
    /// The images of the folder.
    Pinholes(CameraLists),
    /// The views of light fields.
    Views(Vec<SourceField>, CameraLists),
    Raw(Vec<RawImage>, Tool),
    Boards(Box<Boards>),
}

type WriteField = fn(&mut OutputFolder, &LoadedField, &ExportJob) -> Result<(), Error>;

/// Returns a warning about a whole export.
type CheckFields = fn(&[LoadedNote]) -> Option<String>;

type WriteJoined = fn(&mut OutputFolder, &[SourceField]) -> Result<(), Error>;

/// What a warning about a whole export depends on: the pixels of a view.
type LoadedNote = GridSize;

/// All targets.
pub const EXPORT_TARGETS: &[ExportTarget] = &[
    hci::TARGET,
    hci::TOOLKIT,
    urbanlf::TARGET,
    basiclfsr::TARGET,
    lfasr::TARGET,
    plenpy::TARGET,
    stanford::TARGET,
    jpeg_pleno::TARGET,
    npy::TARGET,
    lfsd::TARGET,
    nerf::NERF,
    nerf::NERFSTUDIO,
    plenoptic::COMPOTE,
    plenoptic::raw(Tool::LfToolbox),
    plenoptic::raw(Tool::PlenoptiCam),
    plenoptic::raw(Tool::Libpleno),
    plenoptic::raw(Tool::Pip),
    plenoptic::raw(Tool::Raytrix),
    plenoptic::raw(Tool::Plenpy),
    plenoptic::raw(Tool::Lytro),
];

impl ExportTarget {
    /// Returns the target of a name; `None` for an unknown one.
    #[must_use]
    pub fn by_name(name: &str) -> Option<&'static Self> {
        EXPORT_TARGETS.iter().find(|target| target.name == name)
    }
}

/// An export of a light field, of those of a dataset, of images of pinhole cameras, or of raw images.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct ExportJob {
    /// A dataset, a folder or a file with a light field, a folder with those of several poses or frames, one with images of
    /// pinhole cameras, or one with raw images.
    pub input: PathBuf,
    /// The program that reads the files.
    pub target: &'static ExportTarget,
    /// The views of the light fields of a dataset that has several numbers of them.
    pub views: Option<GridSize>,
    /// The group of the scenes, a folder that some readers expect.
    pub group: Option<String>,
    /// Other names of scenes: ours, and that in the export.
    pub names: Vec<(String, String)>,
    /// The names of the objects that masks show; `*` at the end of a name stands for any ending.
    pub objects: Vec<String>,
    /// Whether `out` may have files: those of the same names are replaced, others stay.
    pub overwrite: bool,
}

/// What was written.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Exported {
    /// What was written: a number of light fields, of images, or of boards.
    pub contents: String,
    /// The names of all files, relative to the folder of the export.
    pub files: Vec<String>,
}

impl ExportJob {
    /// Creates the export of `input` for `target`.
    #[must_use]
    pub fn new(input: impl Into<PathBuf>, target: &'static ExportTarget) -> Self {
        let (names, objects) = (Vec::new(), Vec::new());
        Self { input: input.into(), target, views: None, group: None, names, objects, overwrite: false }
    }

    /// Sets the views.
    #[must_use]
    pub fn views(self, views: impl Into<Option<GridSize>>) -> Self {
        Self { views: views.into(), ..self }
    }

    /// Sets the group.
    #[must_use]
    pub fn group(self, group: impl Into<Option<String>>) -> Self {
        Self { group: group.into(), ..self }
    }

    /// Sets other names of scenes: ours, and that in the export.
    #[must_use]
    pub fn names(self, names: impl IntoIterator<Item = (String, String)>) -> Self {
        Self { names: names.into_iter().collect(), ..self }
    }

    /// Sets the names of the objects that masks show.
    #[must_use]
    pub fn objects(self, objects: impl IntoIterator<Item = String>) -> Self {
        Self { objects: objects.into_iter().collect(), ..self }
    }

    /// Sets whether files in `out` may be replaced.
    #[must_use]
    pub fn overwrite(self, overwrite: bool) -> Self {
        Self { overwrite, ..self }
    }

    /// Writes the export into the folder `out`, which must be empty or missing, unless files may be replaced.
    ///
    /// # Errors
    /// [`Error::BadRequest`] if the target needs what the light fields do not have, the dataset has several numbers of
    /// views and none is chosen, or `out` has files, with `overwrite` those of the input; [`Error::Io`] if files cannot be read or written. Nothing new stays then.
    pub fn run(
        &self,
        out: impl Into<PathBuf>,
        rollback: &Rollback,
        diagnostics: &dyn Diagnostics,
    ) -> Result<Exported, Error> {
        let out = out.into();
        // A wrong request is refused before a folder appears.
        self.check_names()?;
        let work = self.checked()?;
        if !self.overwrite && std::fs::read_dir(&out).is_ok_and(|mut entries| entries.next().is_some()) {
            return Err(Error::BadRequest(format!(
                "{} has files already; give an empty `out`, or `overwrite` to replace those of the same names",
                out.display()
            )));
        }
        self.check_apart(&out)?;
        let mut folder = OutputFolder::create_plain(&out, rollback)?;
        let contents = self.write(&mut folder, &work, diagnostics)?;
        let text = format!(
            "{contents} for {}: {}\n{}\nWritten by holo {} from {}.\n",
            self.target.name,
            self.target.help,
            self.target.usage,
            env!("CARGO_PKG_VERSION"),
            holo_core::visible(&self.input.file_name().unwrap_or_default().to_string_lossy()),
        );
        folder.add(README, holo_io::write_file(folder.file(README), text.as_bytes())?);
        let files = folder.names();
        folder.keep();
        Ok(Exported { contents, files })
    }

    /// Refuses to replace files of the input: `out` may neither hold it nor lie in it if it has files.
    fn check_apart(&self, out: &Path) -> Result<(), Error> {
        let places = [self.input.as_path(), out].map(|path| std::fs::canonicalize(path).ok());
        match places {
            [Some(input), Some(place)]
                if self.overwrite && (input.starts_with(&place) || place.starts_with(&input)) =>
            {
                let (input, out) = (self.input.display(), out.display());
                Err(Error::BadRequest(format!("{out} holds files of {input}, or lies in it; choose another `out`")))
            }
            _ => Ok(()),
        }
    }

    /// Refuses groups and objects that the target has not, and names that are none of folders.
    fn check_names(&self) -> Result<(), Error> {
        let (is_grouped, has_chosen) = (self.group.is_some(), !self.objects.is_empty());
        for (key, is_given, what) in [("group", is_grouped, "groups"), ("objects", has_chosen, "masks of objects")] {
            let has = |target: &ExportTarget| if key == "group" { target.has_groups } else { target.has_objects };
            if is_given && !has(self.target) {
                let others: Vec<&str> =
                    EXPORT_TARGETS.iter().filter(|target| has(target)).map(|target| target.name).collect();
                let (name, others) = (self.target.name, others.join(", "));
                return Err(Error::BadRequest(format!(
                    "`{key}`: the files for {name} have no {what}; those for {others} have"
                )));
            }
        }
        let groups = self.group.iter().map(|group| ("group", group));
        for (key, name) in groups.chain(self.names.iter().map(|(_, name)| ("names", name))) {
            if name.is_empty() || !name.chars().all(|c| c.is_alphanumeric() || "-_ ".contains(c)) {
                return Err(Error::BadRequest(format!("`{key}={}` is no name of a folder", holo_core::shown(name))));
            }
        }
        Ok(())
    }

    /// Finds what the target takes.
    fn checked(&self) -> Result<Work, Error> {
        let fields = || renamed(sources(&self.input, self.views)?, &self.names);
        Ok(match self.target.writer {
            Writer::Fields { write, check } => Work::Fields { sources: fields()?, write, check },
            Writer::Joined(write) => Work::Joined(fields()?, write),
            Writer::Posed(lists) if self.has_pinholes() => {
                self.check_single("these are single images")?;
                Work::Pinholes(lists)
            }
            Writer::Posed(lists) => Work::Views(fields()?, lists),
            Writer::Raw(tool) => {
                self.check_single("the target takes raw images")?;
                Work::Raw(plenoptic::raw_images(&self.input, tool)?, tool)
            }
            Writer::Boards => {
                self.check_single("the target takes raw images")?;
                Work::Boards(Box::new(Boards::open(&self.input)?))
            }
        })
    }

    /// Writes all files; returns how many of what.
    fn write(&self, folder: &mut OutputFolder, work: &Work, diagnostics: &dyn Diagnostics) -> Result<String, Error> {
        Ok(match work {
            Work::Fields { sources, write, check } => {
                let mut sizes = Vec::new();
                for (number, source) in sources.iter().enumerate() {
                    let loaded = source.load(number)?;
                    sizes.push(loaded.field.shape().lenses());
                    write(folder, &loaded, self)?;
                }
                if let Some(warning) = check(&sizes) {
                    diagnostics.report(About::Scene, &format!("warning: {warning}"));
                }
                counted(sizes.len(), "light field")
            }
            Work::Joined(sources, write) => {
                write(folder, sources)?;
                counted(sources.len(), "light field")
            }
            Work::Pinholes(lists) => counted(nerf::write_folder(folder, &self.input, *lists)?, "image"),
            Work::Views(sources, lists) => {
                let mut count = 0;
                for (number, source) in sources.iter().enumerate() {
                    let inner = if sources.len() == 1 { String::new() } else { format!("{}/", source.name()) };
                    count += nerf::write_field(folder, &inner, &source.load(number)?, *lists)?;
                }
                counted(count, "image")
            }
            Work::Raw(images, tool) => {
                for image in images {
                    image.write(folder, *tool)?;
                }
                counted(images.len(), "raw image")
            }
            Work::Boards(boards) => counted(boards.write(folder)?, "board"),
        })
    }

    /// Whether the input is a folder of images of pinhole cameras.
    fn has_pinholes(&self) -> bool {
        self.input.join(TRANSFORMS).is_file() && self.input.join("images").is_dir()
    }

    /// Refuses settings of light fields.
    fn check_single(&self, why: &str) -> Result<(), Error> {
        for (key, is_given) in [("views", self.views.is_some()), ("names", !self.names.is_empty())] {
            if is_given {
                return Err(Error::BadRequest(format!("`{key}` is of light fields, and {why}")));
            }
        }
        Ok(())
    }

    /// The folder of a scene in its group.
    fn scene_folder(&self, default_group: &str, scene: &str) -> String {
        format!("{}/{scene}", self.group.as_deref().unwrap_or(default_group))
    }
}

/// What an export says of itself.
const README: &str = "README.txt";

/// No warning.
fn unchecked(_: &[LoadedNote]) -> Option<String> {
    None
}

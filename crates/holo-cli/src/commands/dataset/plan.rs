//! Which jobs there are, in which order, and which of them are done.

use std::path::{Path, PathBuf};

use clap::ArgMatches;
use holo_core::{GridSize, Remainder, Split};
use holo_io::{Manifest, dataset};
use holo_scene::gallery;

use crate::arguments::DatasetOptions;
use crate::commands::asked::{self, Wish};
use crate::commands::output;
use crate::commands::source::Source;
use crate::failure::Failure;

/// The word for no scene of the gallery.
const NONE: &str = "none";

/// One scene with one split.
pub struct Job {
    pub source: Source,
    pub split: Split,
    pub wish: Wish,
}

impl Job {
    /// As in `garden 20x20`.
    pub fn name(&self) -> String {
        let views = self.split.views();
        format!("{} {}x{}", self.source.name(), views.columns, views.rows)
    }

    /// Its folder in the root.
    pub fn folder(&self) -> Result<PathBuf, Failure> {
        Ok(dataset::folder(&self.source.name(), self.split.views())?)
    }
}

/// All jobs, scene by scene: the same list on every machine.
pub fn jobs(options: &DatasetOptions, said: &ArgMatches) -> Result<Vec<Job>, Failure> {
    let sources = sources(options)?;
    let mut splits: Vec<Split> = Vec::new();
    for &views in &options.splits {
        if splits.iter().any(|split| split.views() == views) {
            return Err(Failure::Usage(format!("--splits has {} twice", in_words(views))));
        }
        splits.push(options.main_lens.sensor.split(views, Remainder::Crop)?.split);
    }
    let common: asked::Asked = asked::asked(said);
    let mut jobs = Vec::new();
    for source in &sources {
        for &split in &splits {
            let mut asked = common.clone();
            asked.insert("views".into(), in_words(split.views()));
            let mut line = vec![source.path().display().to_string(), "--out=out".into()];
            line.extend(asked::arguments(&asked));
            let mut wish = Wish::parse(line)?;
            wish.options.engine = options.engine.clone();
            jobs.push(Job { source: source.clone(), split, wish });
        }
    }
    Ok(jobs)
}

/// As it is written on the command line.
pub fn in_words(views: GridSize) -> String {
    format!("{}x{}", views.columns, views.rows)
}

fn sources(options: &DatasetOptions) -> Result<Vec<Source>, Failure> {
    let names: Vec<&str> = match options.scenes.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        [] => gallery::NAMES.to_vec(),
        [NONE] => Vec::new(),
        ref names => names.to_vec(),
    };
    let mut sources = names.into_iter().map(Source::gallery).collect::<Result<Vec<_>, _>>()?;
    for path in &options.glb {
        if !path.is_file() {
            return Err(Failure::Failed(format!("{}: there is no such scene; see --glb", path.display())));
        }
        sources.push(Source::File(path.clone()));
    }
    for (index, source) in sources.iter().enumerate() {
        let name = source.name();
        if sources[..index].iter().any(|other| other.name() == name) {
            return Err(Failure::Usage(format!(
                "two scenes are called '{name}', and would share a folder; rename one"
            )));
        }
        // A name that can be no folder is said before anything is made.
        dataset::folder(&name, GridSize::new(1, 1))?;
    }
    if sources.is_empty() {
        return Err(Failure::Usage("no scene: leave --scenes away for all of the gallery, or give --glb".into()));
    }
    Ok(sources)
}

/// The manifest of a job that is done: the same scene, options and versions, and every file as its digest says.
pub fn done(folder: &Path, identity: &Manifest) -> Option<Manifest> {
    let manifest = Manifest::read(folder.join(dataset::MANIFEST_JSON)).ok()?;
    let is_same = manifest.versions == identity.versions
        && manifest.seed == identity.seed
        && identity.settings.iter().all(|(name, value)| manifest.settings.get(name) == Some(value));
    let is_done = is_same && manifest.verify(folder).is_empty();
    if is_done {
        // A run may have been killed when it had only this left to do.
        output::clear_older(folder, &manifest);
    }
    is_done.then_some(manifest)
}

//! What was asked for, as text: the options that decide the files, as they stand on the command line.
//!
//! A manifest keeps them, so that a later run can tell whether a folder is what it would make, and `holo merge` can write what
//! `holo render` was asked for. Threads, the engine and the folder are not among them, for they decide nothing.

use std::collections::BTreeMap;

use clap::{ArgMatches, Args, Command, FromArgMatches};
use holo_io::Setting;

use crate::arguments::{JobOptions, RenderOptions, RigOptions, SkyArgument};
use crate::failure::Failure;

/// Long names and values.
pub type Asked = BTreeMap<String, String>;

/// What an environment map is called: its path is nobody's business, its digest stands elsewhere.
const MAP: &str = "map";

/// Options of a render, and what was asked for in words.
#[derive(Clone, Debug)]
pub struct Wish {
    pub options: RenderOptions,
    pub asked: Asked,
}

impl Wish {
    /// Takes what clap made of the command line of `holo render`.
    pub fn new(options: RenderOptions, matches: &ArgMatches) -> Self {
        let mut asked = asked(matches);
        if matches!(options.job.sky, SkyArgument::Map(_)) {
            asked.insert("sky".into(), MAP.into());
        }
        Self { options, asked }
    }

    /// The same from pieces of a command line.
    pub fn parse(arguments: impl IntoIterator<Item = String>) -> Result<Self, Failure> {
        let command = RenderOptions::augment_args(Command::new("holo render").no_binary_name(true));
        let parsed = command.try_get_matches_from(arguments);
        let parsed = parsed.and_then(|matches| Ok((RenderOptions::from_arg_matches(&matches)?, matches)));
        let (options, matches) = parsed.map_err(|error| Failure::Usage(error.to_string()))?;
        Ok(Self::new(options, &matches))
    }

    /// What a manifest says was asked for; `None` if it says nothing. There is no scene and no folder in it.
    pub fn of_manifest(options: &Setting) -> Option<Result<Self, Failure>> {
        let Setting::Table(options) = options else { return None };
        let text = |value: &Setting| value.as_text().map(str::to_owned);
        let asked: Option<Asked> = options.iter().map(|(name, value)| Some((name.clone(), text(value)?))).collect();
        let mut asked = asked?;
        // The light is in the picture already.
        asked.remove("sky");
        Some(Self::parse(["scene".to_owned(), "--out=out".to_owned()].into_iter().chain(arguments(&asked))))
    }

    /// For a manifest.
    pub fn setting(&self) -> Setting {
        Setting::Table(self.asked.iter().map(|(name, value)| (name.clone(), value.as_str().into())).collect())
    }
}

/// The options that decide files, among those that `matches` has.
pub fn asked(matches: &ArgMatches) -> Asked {
    let command = RigOptions::augment_args(JobOptions::augment_args(Command::new("")));
    let mut asked = Asked::new();
    for argument in command.get_arguments() {
        let (id, Some(name)) = (argument.get_id().as_str(), argument.get_long()) else { continue };
        let Ok(Some(values)) = matches.try_get_raw(id) else { continue };
        let values: Vec<_> = values.map(|value| value.to_string_lossy()).collect();
        asked.insert(name.to_owned(), values.join(","));
    }
    // Lenses stand instead of a sensor, which has a default all the same.
    if asked.contains_key("lenses") {
        asked.remove("sensor");
    }
    asked
}

/// The same as pieces of a command line.
pub fn arguments(asked: &Asked) -> impl Iterator<Item = String> {
    asked.iter().filter(|(_, value)| *value != "false").map(|(name, value)| match value.as_str() {
        "true" => format!("--{name}"),
        value => format!("--{name}={value}"),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_asked_can_be_asked_again() {
        let line = "a.glb --out x --spp 3 --write el,mat,h5 --no-indirect --views 3x2 --lenses 5x4 --sky 1,0,0 --exposure -1.5";
        let wish = Wish::parse(line.split(' ').map(str::to_owned)).unwrap();
        assert_eq!(wish.asked["write"], "el,mat,h5");
        assert_eq!(wish.asked["no-indirect"], "true");
        assert_eq!(wish.asked["no-roulette"], "false");
        assert_eq!((wish.asked["seed"].as_str(), wish.asked["bit-depth"].as_str()), ("0", "8"), "defaults too");
        for name in ["out", "threads", "backend", "quiet", "json", "shard"] {
            assert!(!wish.asked.contains_key(name), "{name}");
        }
        let again = Wish::of_manifest(&wish.setting()).unwrap().unwrap();
        let without_sky = |mut wish: Wish| {
            wish.asked.remove("sky");
            wish.asked
        };
        assert_eq!(without_sky(again), without_sky(wish));
    }

    #[test]
    fn no_path_gets_into_a_manifest() {
        let wish = Wish::parse("a.glb --out x --sky /some/where.hdr".split(' ').map(str::to_owned)).unwrap();
        assert_eq!(wish.asked["sky"], MAP);
    }
}

//! Options from a TOML file: the long names of the command line, which wins where both say something.

use std::ffi::OsString;
use std::fmt::Display;
use std::path::{Path, PathBuf};

use clap::parser::ValueSource;
use clap::{ArgMatches, Args, Command, FromArgMatches};
use holo_dataset::settings::Given;
use holo_io::CameraFile;
use toml::Value;

use super::similar::with_similar_value;
use crate::failure::Failure;

/// A file of options is at most this long.
const MAX_BYTES: u64 = 1 << 20;

/// Options whose values are files, which a TOML file names from where it lies itself.
const PATHS: [&str; 3] = ["out", "glb", "transforms"];

/// An option whose values are files or names of cameras.
const CAMERA_FILE: &str = "camera-file";

/// Adds what the file of `--config` says, if there is one.
pub fn complete<T: Args + FromArgMatches>(
    options: T,
    config: Option<PathBuf>,
    said: &ArgMatches,
) -> Result<T, Failure> {
    let Some(path) = config else { return Ok(options) };
    let text = read_text(&path)?;
    let own: Vec<OsString> = std::env::args_os().skip(2).collect();
    parse(&path, &text, said, own)
}

/// Reads settings of a render.
pub fn read(path: &Path) -> Result<Given, Failure> {
    let mut given = Given::default();
    for (key, value) in &table(path, &read_text(path)?)? {
        let mut text = words_of(path, key, value)?.join(",");
        let name = key.replace('_', "-");
        // An environment map lies where the file says.
        if name == "sky" && text.contains('.') && text.parse::<f64>().is_err() && !text.contains(',') {
            text = relative_to_file(path, vec![text]).concat();
        }
        given.insert(&name, text).map_err(|why| wrong(path, Failure::from(why).message()))?;
    }
    Ok(given)
}

/// Reads the text of a file of options.
fn read_text(path: &Path) -> Result<String, Failure> {
    let failed = |why: std::io::Error| Failure::Failed(format!("cannot read {}: {why}", path.display()));
    if path.metadata().map_err(failed)?.len() > MAX_BYTES {
        return Err(Failure::Failed(format!("{}: too long for a file of options", path.display())));
    }
    std::fs::read_to_string(path).map_err(failed)
}

fn parse<T: Args + FromArgMatches>(
    path: &Path,
    text: &str,
    said: &ArgMatches,
    own: Vec<OsString>,
) -> Result<T, Failure> {
    let table = table(path, text)?;
    let command = T::augment_args(Command::new("holo dataset").no_binary_name(true));
    let mut line: Vec<OsString> = Vec::new();
    for (key, value) in &table {
        // A key that no option has is left to the parser of the command line, which suggests one.
        let name = key.replace('_', "-");
        let is_called = |argument: &&clap::Arg| {
            let mut names = argument.get_long().into_iter().chain(argument.get_all_aliases().into_iter().flatten());
            names.any(|known| known == name)
        };
        let option = command.get_arguments().find(is_called);
        if name == "config" {
            return Err(wrong(path, "a file of options cannot name another"));
        }
        if option.is_some_and(|option| said.value_source(option.get_id().as_str()) == Some(ValueSource::CommandLine)) {
            continue;
        }
        let words = words_of(path, key, value)?;
        let words = match name.as_str() {
            name if PATHS.contains(&name) => relative_to_file(path, words),
            // In their order.
            CAMERA_FILE => words.into_iter().flat_map(|word| camera(path, word)).collect(),
            _ => words,
        };
        match words.join(",").as_str() {
            "false" if option.is_some() => {}
            "true" => line.push(format!("--{name}").into()),
            value => line.push(format!("--{name}={value}").into()),
        }
    }
    line.extend(own);
    let matches = command.try_get_matches_from(line);
    let parsed = matches.and_then(|matches| T::from_arg_matches(&matches));
    parsed.map_err(|error| wrong(path, with_similar_value(error)))
}

/// What is wrong with a file of options.
fn wrong(path: &Path, what: impl Display) -> Failure {
    Failure::Usage(format!("{}: {what}", path.display()))
}

/// The keys and values in the text of a file of options.
fn table(path: &Path, text: &str) -> Result<toml::Table, Failure> {
    text.parse().map_err(|why: toml::de::Error| wrong(path, why))
}

/// The value of a key as it would stand on the command line, in pieces.
fn words_of(path: &Path, key: &str, value: &Value) -> Result<Vec<String>, Failure> {
    let refused = || wrong(path, format!("`{key}` is neither a number, a text, yes or no, nor a list of these"));
    words(value).ok_or_else(refused)
}

/// A value as it would stand on the command line, in pieces; tables and times cannot.
fn words(value: &Value) -> Option<Vec<String>> {
    Some(match value {
        Value::String(text) => vec![text.clone()],
        Value::Integer(number) => vec![number.to_string()],
        Value::Float(number) => vec![number.to_string()],
        Value::Boolean(yes) => vec![yes.to_string()],
        Value::Array(values) => values.iter().map(words).collect::<Option<Vec<_>>>()?.concat(),
        Value::Datetime(_) | Value::Table(_) => return None,
    })
}

/// A camera, as a preset or a path relative to the folder of the file.
fn camera(path: &Path, word: String) -> Vec<String> {
    if CameraFile::preset(&word).is_some() { vec![word] } else { relative_to_file(path, vec![word]) }
}

/// Paths that are relative to the folder of the file.
fn relative_to_file(path: &Path, words: Vec<String>) -> Vec<String> {
    let folder = path.parent().unwrap_or(Path::new(""));
    words.into_iter().map(|word| folder.join(word).to_string_lossy().into_owned()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::arguments::DatasetOptions;
    use holo_dataset::Spacing;

    fn read(text: &str, own: &str) -> Result<DatasetOptions, String> {
        let own: Vec<OsString> = own.split_whitespace().map(OsString::from).collect();
        let command = DatasetOptions::augment_args(Command::new("holo dataset").no_binary_name(true));
        let said = command.try_get_matches_from(&own).unwrap();
        parse(Path::new("some/set.toml"), text, &said, own).map_err(|error| error.message())
    }

    #[test]
    fn a_file_says_what_the_command_line_could() {
        let options = read(
            "out = \"data\"\nscenes = [\"garden\", \"chess\"]\nviews = [20, \"4x3\"]\nspp = 3\nno-indirect = true\nquiet = false\nf_number = 2.8\nglb = [\"own/a.glb\"]\n",
            "--spp 5",
        )
        .unwrap();
        assert_eq!(options.collection.out.as_deref(), Some(Path::new("some/data")));
        assert_eq!(options.scenes, ["garden", "chess"]);
        assert_eq!(options.collection.view_counts, [holo_core::GridSize::new(20, 20), holo_core::GridSize::new(3, 4)]);
        let (_, settings) = options.settings().unwrap();
        assert_eq!(
            (settings.light.samples, settings.light.indirect, options.collection.quiet),
            (Some(5.into()), false, false)
        );
        let spacing = settings.camera.rig().unwrap().spacing;
        assert_eq!((spacing, options.glb), (Spacing::FNumber(2.8), vec!["some/own/a.glb".into()]));
    }

    #[test]
    fn cameras_of_a_file_are_presets_or_lie_beside_it() {
        let options = read("camera_file = [\"own.toml\", \"lytro-illum\"]\ntransforms = \"t.json\"", "").unwrap();
        assert_eq!(options.collection.camera_file, ["some/own.toml", "lytro-illum"]);
        assert_eq!(options.transforms.as_deref(), Some(Path::new("some/t.json")));
        let error = read("camera_file = \"lytro-illum\"\nviews = 3", "").unwrap_err();
        assert!(error.contains("--views") && error.contains("--camera-file"), "{error}");
    }

    #[test]
    fn the_key_of_version_0_1_0_is_the_same_option() {
        let views = |text: &str, own: &str| read(text, own).unwrap().collection.view_counts;
        assert_eq!(views("splits = 3", ""), [holo_core::GridSize::new(3, 3)]);
        assert_eq!(views("splits = 3", "--views 5"), [holo_core::GridSize::new(5, 5)]);
        assert_eq!(views("views = 3", "--splits 5"), [holo_core::GridSize::new(5, 5)]);
    }

    #[test]
    fn unknown_keys_and_values_are_errors_with_a_suggestion() {
        for (text, part) in [
            ("scens = [\"garden\"]", "'--scenes'"),
            ("viewss = 20", "'--views'"),
            ("zzz = 1", "'--zzz'"),
            ("zzz = false", "'--zzz'"),
            ("config = \"x\"", "cannot name another"),
            ("spp = 0", "--spp"),
            ("spp = \"many\"", "--spp"),
            ("spp = {a = 1}", "`spp` is neither"),
            ("spp = ", "set.toml"),
        ] {
            let error = read(text, "").unwrap_err();
            assert!(error.contains(part) && error.contains("some/set.toml"), "{text}: {error}");
        }
    }
}

//! The settings of renders as arguments: one for every row of the table of `holo-dataset` that a command has.

use std::marker::PhantomData;

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser, ValueParser};
use clap::parser::ValueSource;
use clap::{Arg, ArgAction, ArgMatches, Args, Command, FromArgMatches};
use holo_dataset::settings::{Given, Group, Kind, Setting, table};

use super::headings;
use crate::failure::Failure;

/// Which settings a command has.
pub trait Scope: Clone + std::fmt::Debug {
    /// Whether it has a setting.
    fn has(setting: &Setting) -> bool;

    /// The help of a setting whose default or effect is another one here than the table says.
    fn help(_: &str) -> Option<String> {
        None
    }
}

/// The focal length of a common lens, mm, where no scene has a camera.
pub const FOCAL_MM: f64 = 50.0;

/// The settings of a scope that were given, and nothing of the others.
#[derive(Clone, Debug)]
pub struct Settings<S> {
    given: Given,
    scope: PhantomData<S>,
}

/// `holo render`: all of them.
#[derive(Clone, Debug)]
pub struct OfRender;

/// `holo dataset`: those of a rig whose numbers of views are the dataset's, or of a plenoptic camera.
#[derive(Clone, Debug)]
pub struct OfDataset;

/// `holo info`: those of the scene file and the rig.
#[derive(Clone, Debug)]
pub struct OfInfo;

/// `holo preview`: those that its page can change.
#[derive(Clone, Debug)]
pub struct OfPreview;

/// `holo optics`: those of a rig without a scene.
#[derive(Clone, Debug)]
pub struct OfOptics;

impl Scope for OfRender {
    fn has(_: &Setting) -> bool {
        true
    }
}

impl Scope for OfDataset {
    fn has(setting: &Setting) -> bool {
        let of_all = ["sensor", "lenses", "f-number", "focus-m", "disparity"];
        of_all.contains(&setting.key()) || !matches!(setting.group(), Group::Rig | Group::Viewpoint)
    }

    fn help(key: &str) -> Option<String> {
        let lenses =
            "Pixels of a view, columns x rows, instead of `sensor`; with `transforms` where the file says no size";
        (key == "lenses").then(|| lenses.to_owned())
    }
}

impl Scope for OfInfo {
    fn has(setting: &Setting) -> bool {
        matches!(setting.group(), Group::Scene | Group::Viewpoint | Group::Rig)
    }
}

impl Scope for OfPreview {
    fn has(_: &Setting) -> bool {
        true
    }
}

impl Scope for OfOptics {
    fn has(setting: &Setting) -> bool {
        setting.group() == Group::Rig && !["lens-shifts", "projection", "subset"].contains(&setting.key())
    }

    fn help(key: &str) -> Option<String> {
        (key == "focal-mm").then(|| format!("Focal length, mm [default: {FOCAL_MM}]"))
    }
}

impl<S: Scope> Settings<S> {
    /// The settings that were given.
    pub fn given(&self) -> &Given {
        &self.given
    }

    fn table() -> impl Iterator<Item = &'static Setting> {
        table().filter(|setting| S::has(setting))
    }
}

impl<S: Scope> FromArgMatches for Settings<S> {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        let mut given = Given::default();
        for setting in Self::table() {
            let key = setting.key();
            if matches.value_source(key) != Some(ValueSource::CommandLine) {
                continue;
            }
            let values = matches.get_raw(key).into_iter().flatten();
            let text = values.map(|value| value.to_string_lossy()).collect::<Vec<_>>().join(",");
            let text = if text.is_empty() { "true".to_owned() } else { text };
            // The keys are those of the table.
            given.insert(key, text).map_err(|why| clap::Error::raw(clap::error::ErrorKind::UnknownArgument, why))?;
        }
        Ok(Self { given, scope: PhantomData })
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}

impl<S: Scope> Args for Settings<S> {
    fn augment_args(command: Command) -> Command {
        Self::table().fold(command, |command, setting| command.arg(argument::<S>(setting)))
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

/// Makes the argument of a setting of a command with these settings.
fn argument<S: Scope>(setting: &'static Setting) -> Arg {
    let others = table().filter(|other| S::has(other) && setting.excludes(other)).map(Setting::key);
    let help = S::help(setting.key()).map_or_else(|| setting.help(), |own| vec![own]);
    let paragraphs: Vec<String> = help.iter().map(|text| Failure::spelled(text)).collect();
    let mut argument = Arg::new(setting.key())
        .long(setting.key())
        .help(headings::brief(&paragraphs[0]).to_owned())
        .long_help(without_stop(&paragraphs.join("\n\n")))
        .help_heading(headings::of(setting.group()))
        .hide_short_help(!headings::is_common(setting.key()))
        // Numbers may be negative.
        .allow_hyphen_values(matches!(
            setting.kind(),
            Kind::Integer | Kind::Number | Kind::Range | Kind::Size | Kind::Other(_)
        ))
        .conflicts_with_all(others.collect::<Vec<_>>());
    if !setting.form().is_empty() {
        argument = argument.value_name(setting.form());
    }
    if let Some(default) = setting.default().filter(|default| !default.is_empty()) {
        argument = argument.default_value(default);
    }
    let check = move |text: &str| setting.check(text).map(|()| text.to_owned());
    match setting.kind() {
        Kind::Flag => argument.action(ArgAction::SetTrue),
        Kind::Word(words) => argument.value_parser(one_of(words)),
        Kind::Words(words) => argument.value_parser(one_of(words)).value_delimiter(',').action(ArgAction::Append),
        _ => argument.value_parser(ValueParser::new(check)),
    }
}

/// Clap ends no help with a full stop.
fn without_stop(text: &str) -> String {
    text.strip_suffix('.').unwrap_or(text).to_owned()
}

/// A parser of words.
fn one_of(words: &'static [holo_dataset::settings::Word]) -> ValueParser {
    let values = words.iter().map(|word| {
        let value = PossibleValue::new(word.name).help(Failure::spelled(word.help));
        // The British spelling of version 0.1.0.
        if word.name == "color" { value.alias("colour") } else { value }
    });
    ValueParser::new(PossibleValuesParser::new(values.collect::<Vec<_>>()).map(|word| word))
}

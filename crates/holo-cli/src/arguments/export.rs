//! The arguments of `holo export`.

use std::path::PathBuf;
use std::str::FromStr;

use clap::Args;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser, ValueParser};
use holo_core::GridSize;
use holo_dataset::{EXPORT_TARGETS, ExportTarget};

#[derive(Args, Debug)]
pub struct ExportOptions {
    /// A dataset of `holo dataset`, a folder or file with one light field, a folder of `holo render`, or one of `holo target`.
    pub input: PathBuf,
    /// What reads the files.
    #[arg(long = "for", value_name = "NAME", value_parser = targets())]
    pub target: &'static ExportTarget,
    /// Folder for the files; it must be empty or missing.
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
    /// Replace files in DIR, such as those of an export that was killed.
    #[arg(long)]
    pub overwrite: bool,
    /// Views of the light fields, columns x rows, of a dataset that has several numbers of them.
    #[arg(long, value_name = "SxT", value_parser = GridSize::from_str)]
    pub views: Option<GridSize>,
    /// Group of the scenes, a folder that some readers expect [default: that of the readers' own examples].
    #[arg(long, value_name = "NAME")]
    pub group: Option<String>,
    /// Other names of scenes, such as chess=boxes,garden=cotton.
    #[arg(long, value_name = "OURS=THEIRS,..", value_delimiter = ',', value_parser = pair_of_names)]
    pub names: Vec<(String, String)>,
    /// Objects that masks show, by the names of the scene; BALL* for all that begin so.
    #[arg(long, value_name = "NAME,..", value_delimiter = ',')]
    pub objects: Vec<String>,
}

fn pair_of_names(text: &str) -> Result<(String, String), String> {
    let pair = text.split_once('=').filter(|(ours, theirs)| !ours.is_empty() && !theirs.is_empty());
    let (ours, theirs) = pair.ok_or("names are OURS=THEIRS, such as chess=boxes")?;
    Ok((ours.to_owned(), theirs.to_owned()))
}

/// A parser of the names of targets.
fn targets() -> ValueParser {
    let values: Vec<PossibleValue> =
        EXPORT_TARGETS.iter().map(|target| PossibleValue::new(target.name).help(target.help)).collect();
    let parser = PossibleValuesParser::new(values);
    ValueParser::new(parser.try_map(|name| ExportTarget::by_name(&name).ok_or("there is no such target")))
}

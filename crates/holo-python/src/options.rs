//! Options as text, by the names of the command line.

use std::collections::BTreeMap;

use holo_core::{Effort, Layout, ViewOrder};
use holo_dataset::{EngineSpec, RenderSpec, Sky};
use holo_render::Backend;

use crate::failure::Failure;

/// Parses a specification; the sky is a path if it ends as one.
pub fn spec(options: &BTreeMap<String, String>) -> Result<RenderSpec, Failure> {
    let mut options = options.clone();
    let sky = options.remove("sky");
    let mut spec = RenderSpec::from_options(&options)?;
    if let Some(sky) = sky {
        spec.sky = sky.parse::<Sky>().map_err(|why| Failure::Usage(format!("sky='{sky}': {why}")))?;
    }
    Ok(spec)
}

/// The value of `word` among `choices`; the error names them.
pub fn choice<T: Copy>(name: &str, word: &str, choices: &[(&str, T)]) -> Result<T, Failure> {
    match choices.iter().find(|(known, _)| *known == word) {
        Some((_, value)) => Ok(*value),
        None => {
            let known: Vec<&str> = choices.iter().map(|(known, _)| *known).collect();
            Err(Failure::Usage(format!("{name}='{word}': give {}", known.join(", "))))
        }
    }
}

pub fn engine(backend: &str, threads: usize) -> Result<EngineSpec, Failure> {
    let choices = [("auto", Backend::Auto), ("embree", Backend::Embree), ("bvh", Backend::Bvh)];
    Ok(EngineSpec { backend: choice("backend", backend, &choices)?, threads })
}

pub fn layout(word: &str) -> Result<Layout, Failure> {
    choice("layout", word, &[("el", Layout::ElementalGrid), ("vpi", Layout::ViewpointGrid)])
}

pub fn order(word: &str) -> Result<ViewOrder, Failure> {
    choice("order", word, &[("row-major", ViewOrder::RowMajor), ("serpentine", ViewOrder::Serpentine)])
}

pub fn effort(word: &str) -> Result<Effort, Failure> {
    let choices = [
        ("draft", Effort::Draft),
        ("fast", Effort::Fast),
        ("balanced", Effort::Balanced),
        ("thorough", Effort::Thorough),
    ];
    choice("effort", word, &choices)
}

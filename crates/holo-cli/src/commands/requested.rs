//! What was requested, as it was typed: the options that decide files, for manifests.

use clap::{ArgMatches, Args, Command};
use holo_dataset::options::Options;

use crate::arguments::{JobOptions, RigOptions};

/// The options that decide files, among those that `matches` has, with their defaults.
pub fn requested(matches: &ArgMatches) -> Options {
    let command = RigOptions::augment_args(JobOptions::augment_args(Command::new("")));
    let mut requested = Options::new();
    for argument in command.get_arguments() {
        let (id, Some(name)) = (argument.get_id().as_str(), argument.get_long()) else { continue };
        let Ok(Some(values)) = matches.try_get_raw(id) else { continue };
        let values: Vec<_> = values.map(|value| value.to_string_lossy()).collect();
        requested.insert(name.to_owned(), values.join(","));
    }
    // Lenses stand instead of a sensor, which has a default all the same.
    if requested.contains_key("lenses") {
        requested.remove("sensor");
    }
    requested
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::arguments::RenderOptions;
    use clap::FromArgMatches;
    use holo_dataset::RenderSpec;

    fn parse(line: &str) -> (RenderOptions, Options) {
        let command = RenderOptions::augment_args(Command::new("holo render").no_binary_name(true));
        let matches = command.try_get_matches_from(line.split(' ')).unwrap();
        (RenderOptions::from_arg_matches(&matches).unwrap(), requested(&matches))
    }

    #[test]
    fn what_is_kept_says_what_was_parsed() {
        let (options, words) = parse(
            "a.glb --out x --spp 3 --write el,mat,h5 --no-indirect --indirect-limit 2.5 --transparent-shadows --no-multiple-scattering --cull --views 3x2 --lenses 5x4 --sky 1,0,0 --exposure -1.5 \
             --light-units auto --solid-glass --material-variant red --frame 2-7 --fps 30 --animation walk --subset 1,0;2,1 --lens-shifts 2 --disparity -1,1.5 \
             --layers color,hit-mask --integrator path --projection orthographic --camera 2 --ground-truth all --sensor-model imx250 --iso 400",
        );
        assert_eq!(words["write"], "el,mat,h5");
        assert_eq!(words["no-indirect"], "true");
        assert_eq!(words["no-roulette"], "false");
        assert_eq!((words["seed"].as_str(), words["bit-depth"].as_str()), ("0", "8"), "defaults too");
        for name in ["out", "threads", "backend", "quiet", "json", "shard"] {
            assert!(!words.contains_key(name), "{name}");
        }
        assert_eq!(RenderSpec::from_options(&words).unwrap(), options.spec());
        assert_eq!(options.spec().to_options(), words);
    }

    #[test]
    fn the_command_line_and_the_library_have_the_same_defaults() {
        let (options, words) = parse("a.glb --out x");
        assert_eq!(options.spec(), RenderSpec::default());
        assert_eq!(words, RenderSpec::default().to_options());
    }
}

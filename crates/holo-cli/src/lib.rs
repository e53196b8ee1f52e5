//! The command line of `holo`: a glTF scene becomes a raw holoscopic image with ground truth.
//!
//! This crate parses arguments, shows progress and turns errors into exit codes; everything else is in the libraries.
//! It prints, listens for Ctrl-C and may end the process: [`run`] is for programs that are `holo`, under whatever name
//! they are installed, and for nothing else.
#![forbid(unsafe_code)]

mod arguments;
mod budget;
mod commands;
mod console;
mod failure;
mod interrupt;
mod progress;
mod quantities;

use std::ffi::OsString;
use std::path::Path;

use clap::{ArgMatches, CommandFactory, FromArgMatches};

use arguments::{Arguments, Benchmark, Command, with_similar_value};
use console::say;
use failure::Failure;

/// Runs a command line, whose first word is the name of the program, and returns the exit code: 0 done, 1 failed (the
/// message says what, where and what to do), 2 wrong use. Help, the version and malformed options end the process.
pub fn run(words: impl IntoIterator<Item = OsString>) -> u8 {
    let matches = Arguments::command().try_get_matches_from(words);
    let matches = matches.unwrap_or_else(|error| with_similar_value(error).exit());
    let arguments = Arguments::from_arg_matches(&matches).unwrap_or_else(|error| error.exit());
    // The words of the command, for those that read a configuration too.
    let words = matches.subcommand().map(|(_, words)| words.clone()).unwrap_or_default();
    stay_silent_while_a_guard_watches();
    interrupt::install();
    if let Err(why) = budget::limit(arguments.memory_gb) {
        say!("holo: {why}");
        return 2;
    }
    remove_leftovers(&words);
    let result = match arguments.command {
        Command::Render(options) => commands::render::run(&options),
        Command::Dataset(options) => commands::dataset::run(*options, &words),
        Command::Generate(options) => commands::dataset::generate(*options, &words),
        Command::Merge(options) => commands::merge::run(&options),
        Command::Info(options) => commands::info::run(&options),
        Command::Remap(options) => commands::remap::run(&options),
        Command::Extract(options) => commands::extract::run(&options),
        Command::Compose(options) => commands::compose::run(&options),
        Command::RotateElements(options) => commands::rotate::run(&options),
        Command::Quilt(options) => commands::quilt::run(&options),
        Command::Display(options) => commands::display::run(&options),
        Command::Animate(options) => commands::animate::run(&options),
        Command::Refocus(options) => commands::refocus::run(&options),
        Command::Synthesize(options) => commands::synthesize::run(&options),
        Command::Correspond(options) => commands::correspond::run(&options),
        Command::Depth(options) => commands::depth::run(&options),
        Command::Eval(options) => commands::eval::run(&options),
        Command::Epi(options) => commands::epi::run(&options),
        Command::View(options) => commands::view::run(&options),
        Command::Preview(options) => commands::preview::run(&options),
        Command::Scene(options) => commands::scene::run(&options),
        Command::Optics(options) => commands::optics::run(&options),
        Command::Array(options) => commands::array::run(&options),
        Command::Camera(options) => commands::camera::run(&options),
        Command::White(options) => commands::camera::white(&options),
        Command::Target(options) => commands::camera::target(&options),
        Command::Benchmark(Benchmark::Calibration(options)) => commands::benchmark::calibration(&options),
        Command::Calibrate(options) => commands::camera::calibrate(&options),
        Command::EvalCalibration(options) => commands::camera::eval_calibration(&options),
        Command::Decode(options) => commands::camera::decode(&options),
        Command::Develop(options) => commands::develop::run(&options),
        Command::Demosaic(options) => commands::develop::demosaic(&options),
        Command::Export(options) => commands::export::run(&options),
        Command::Pack(options) => commands::pack::run(&options),
        Command::Verify(options) => commands::verify::run(&options),
    };
    match result {
        Ok(()) => 0,
        Err(failure) => {
            // What is still open here was left by a failing writer of another thread.
            let _held = holo_io::remove_temporary_files();
            if interrupt::requested() {
                interrupt::say_stopped();
                return 1;
            }
            say!("holo: {failure}");
            match failure {
                Failure::Usage(_) => 2,
                Failure::Failed(_) => 1,
            }
        }
    }
}

/// Removes the temporary files that killed commands left in the folders of the outputs. Errors do no harm.
fn remove_leftovers(words: &ArgMatches) {
    for name in ["out", "output", "error_map", "confidence"] {
        let Ok(Some(mut given)) = words.try_get_raw(name) else { continue };
        let Some(path) = given.next().map(Path::new) else { continue };
        let parent = path.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."));
        let _ = holo_io::remove_stale_temporary_files(if path.is_dir() { path } else { parent });
    }
}

/// The readers of scenes and images turn a panic inside a decoder into an error, which is printed: the panic need not be.
fn stay_silent_while_a_guard_watches() {
    let print = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |info| {
        if !holo_scene::gltf::is_guarding() && !holo_io::is_guarding() {
            print(info);
        }
    }));
}

//! The table of settings, and the files of this repository that follow from it.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use holo_dataset::settings::{Given, Kind, Setting, table};
use holo_dataset::{Camera, LayerChoice, Output, RenderSettings, Tool};
use holo_io::CameraFile;

fn given(pairs: &[(&str, &str)]) -> RenderSettings {
    let mut given = Given::default();
    pairs.iter().for_each(|(key, text)| given.insert(key, *text).expect("a setting"));
    let mut settings = RenderSettings::default();
    settings.apply(&given).expect("settings");
    settings
}

#[test]
fn the_same_value_in_another_form_is_the_same_setting() {
    for [a, b] in [
        [("views", "20"), ("views", "20x20")],
        [("target-error", "2%"), ("target-error", "0.02")],
        [("focal-mm", "50"), ("focal-mm", "50.0")],
        [("sky", "0.5"), ("sky", "0.5,0.5,0.5")],
        [("write", "el,vpi"), ("write", "el,vpi")],
        [("f-number", "5"), ("views", "100")],
    ] {
        assert_eq!(given(&[a]), given(&[b]), "{a:?} {b:?}");
    }
}

#[test]
fn settings_that_cannot_be_are_refused() {
    for (pairs, part) in [
        (&[("sensor", "hd"), ("lenses", "3x2")][..], "exclude"),
        (&[("baseline-m", "1"), ("f-number", "2")], "exclude"),
        (&[("disparity", "-1,1"), ("focus-m", "2")], "exclude"),
        (&[("spp", "0")], "`spp=0`"),
        (&[("spp", "65537")], "65536"),
        (&[("spp", "1/3")], "`spp=1/3`"),
        (&[("spp", "1/128")], "1/64"),
        (&[("spp", "0.3")], "1/64"),
        (&[("target-error", "0%")], "2%"),
        (&[("views", "0x3")], "COLUMNSxROWS"),
        (&[("write", "el,x")], "vpi"),
        (&[("sky", "sky.gif")], ".exr"),
        (&[("sensor-model", "x")], "imx250"),
        (&[("frame", "5-4")], "A-B"),
        (&[("bit-depth", "9")], "8 or 16"),
    ] {
        let mut given = Given::default();
        pairs.iter().for_each(|(key, text)| given.insert(key, *text).expect("a setting"));
        let error = RenderSettings::default().apply(&given).expect_err("refused");
        assert!(error.is_bad_request() && error.to_string().contains(part), "{pairs:?}: {error}");
    }
}

/// A camera without a grid of views shares no light between views: to ask for it is an error, not to want it is none.
#[test]
fn reuse_is_of_views() {
    let plenoptic: Camera = CameraFile::preset("lytro-illum").expect("a preset").into();
    for camera in [plenoptic, Camera::Pinhole] {
        let apply = |word: &str| {
            let mut given = Given::default();
            given.insert("reuse", word).expect("a setting");
            RenderSettings::default().camera(camera.clone()).apply(&given)
        };
        let error = apply("views").expect_err("refused");
        assert!(error.is_bad_request() && error.to_string().contains("`reuse views`"), "{error}");
        apply("off").expect("what it does anyway");
    }
}

/// Every word has a help, and every value that it names comes back from it.
#[test]
fn words_are_read_back() {
    for setting in table() {
        if let Kind::Word(words) | Kind::Words(words) = setting.kind() {
            for word in words {
                assert!(!word.help.is_empty() && setting.check(word.name).is_ok(), "{} {}", setting.key(), word.name);
            }
        }
        assert!(!setting.help()[0].is_empty(), "{} has no help", setting.key());
    }
    let keyword = |key: &str| Setting::by_key(key).expect("a setting").keyword();
    assert_eq!((keyword("for"), keyword("focus-m")), ("tools".into(), "focus_m".into()));
    assert_eq!((Output::El.name(), Tool::Lytro.name(), LayerChoice::All.name()), ("el", "lytro", "all"));
}

/// The type of a setting in Python.
fn python_type(setting: &Setting) -> String {
    let words = |words: &[holo_dataset::settings::Word]| {
        let names: Vec<String> = words.iter().map(|word| format!("\"{}\"", word.name)).collect();
        format!("Literal[{}]", names.join(", "))
    };
    match setting.kind() {
        Kind::Flag => "bool".into(),
        Kind::Integer => "int".into(),
        Kind::Number => "float".into(),
        Kind::Size => "int | tuple[int, int] | str".into(),
        Kind::Range => "tuple[float, float]".into(),
        Kind::Word(all) => words(all),
        Kind::Words(all) => format!("Sequence[{}] | str", words(all)),
        Kind::Other(python) => python.into(),
        _ => "str".into(),
    }
}

fn python() -> String {
    let mut text = String::from(
        "\"\"\"The settings of renders. This file follows from the table of settings in holo-dataset: see its tests.\"\"\"\n\n\
         from __future__ import annotations\n\nimport os\nfrom collections.abc import Sequence\n\
         from typing import TYPE_CHECKING, Literal, TypedDict\n\n\nclass Settings(TypedDict, total=False):\n    \
         \"\"\"The settings of a render, as keywords of `render`, `render_to` and `render_raw`. Pairs are (rows, columns), text is columns x rows.\n\n",
    );
    for setting in table() {
        let default = setting.default().map_or_else(String::new, |default| format!(" Default: {default}."));
        let help = setting.help().join(" ").replace('\\', "\\\\");
        let _ = writeln!(text, "    {}: {help}{default}", setting.keyword());
    }
    text.push_str("    \"\"\"\n\n");
    for setting in table() {
        let _ = writeln!(text, "    {}: {} | None", setting.keyword(), python_type(setting));
    }
    text.replace("import TYPE_CHECKING, Literal", "import Literal")
}

fn guide() -> String {
    let mut text = String::from(
        "# Settings\n\nEvery setting of a render, for the command line (`--views 20x20`), for a configuration file \
         (`views = \"20x20\"`) and for Python (`views=(20, 20)`, rows first; `_` for `-`, `tools` for `for`). A setting that is given replaces \
         that of a configuration, that of a preset, and the default, in this order.\n\n",
    );
    text += "```sh\nprintf 'views = 3\\nlenses = \"60x40\"\\nspp = 1\\n' > own.toml\n\
             holo render garden.glb --config own.toml --disparity -1,1 --write el --out configured\n```\n\n\
             ![Three images of a garden, the left one blurred](images/settings.png)\n\n\
             *`--preset draft`, the default, `--preset clean`.*\n\n";
    text += "| setting | value | default | meaning |\n|---|---|---|---|\n";
    for setting in table() {
        let value = match setting.kind() {
            Kind::Flag => "flag".to_owned(),
            Kind::Word(words) | Kind::Words(words) if setting.form().is_empty() => {
                words.iter().map(|word| format!("`{}`", word.name)).collect::<Vec<_>>().join(", ")
            }
            _ => format!("`{}`", setting.form()).replace('|', "\\|"),
        };
        let default = setting.default().map_or_else(String::new, |default| format!("`{default}`"));
        let help = setting.help().join(" ").replace('|', "\\|");
        let _ = writeln!(text, "| `{}` | {value} | {default} | {help} |", setting.key());
    }
    text
}

/// `HOLO_UPDATE=1` writes the files anew.
#[test]
fn files_follow_from_the_table() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let files: [(PathBuf, String); 2] =
        [("crates/holo-python/python/holo/_settings.py".into(), python()), ("guide/src/settings.md".into(), guide())];
    for (file, expected) in files {
        let path = root.join(&file);
        if !path.parent().is_some_and(Path::is_dir) {
            println!("not run: {} is not in this package", file.display());
            continue;
        }
        if std::env::var_os("HOLO_UPDATE").is_some_and(|value| value == "1") {
            std::fs::write(&path, &expected).expect("a file");
        }
        let found = std::fs::read_to_string(&path).unwrap_or_default();
        assert!(found == expected, "{} is not that of the table; HOLO_UPDATE=1 writes it", file.display());
    }
}

/// A setting is declared in one file: the row of the table, whose field, default, help and key it has. Every other file of
/// the repository that names the key in quotes uses the setting, or follows from the table.
#[test]
fn a_setting_is_declared_once() {
    let source = include_str!("../../src/settings/table.rs");
    for setting in table() {
        let key = format!("\"{}\"", setting.key());
        assert_eq!(source.matches(&key).count(), 1, "{key}");
    }
}

//! Settings as people give them: texts by key, from a command line, a configuration file, a preset or a program.

use std::collections::BTreeMap;

use super::{RenderSettings, Setting, table};
use crate::Error;

/// Some settings as text, by key. Later ones replace earlier ones.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Given(BTreeMap<&'static str, String>);

/// Settings with a name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Preset {
    /// The name.
    pub name: &'static str,
    /// What it is for.
    pub help: &'static str,
    settings: &'static [(&'static str, &'static str)],
}

/// All presets.
pub const PRESETS: &[Preset] = &[
    Preset {
        name: "draft",
        help: "The fastest image: one pixel of 16 has a sample, and all share them",
        settings: &[("spp", "1/16"), ("denoise", "views")],
    },
    Preset {
        name: "clean",
        help: "An error of about 2 %: more samples where the estimated error is larger",
        settings: &[("denoise", "views"), ("target-error", "2%")],
    },
    Preset {
        name: "reference",
        help: "Ground truth of light: 1024 independent, unbiased samples per pixel",
        settings: &[("spp", "1024"), ("denoise", "off"), ("reuse", "off")],
    },
    Preset {
        name: "paper-8k",
        help: "The raw image of the paper: 100 x 100 views behind an f/5 lens and a sensor of 8K",
        settings: &[("views", "100"), ("sensor", "8k"), ("f-number", "5"), ("write", "el,vpi,mat,depth,disparity")],
    },
    Preset {
        name: "hci",
        help: "A scene as in the HCI benchmark: 9 x 9 views of 512 x 512 px, disparities within 1.5 px, its folder and the truth",
        settings: &[
            ("views", "9"),
            ("lenses", "512x512"),
            ("disparity", "-1.5,1.5"),
            ("write", "hci,depth,disparity,masks"),
            ("layers", "hit-mask"),
        ],
    },
    Preset {
        name: "urbanlf",
        help: "Views as in UrbanLF: 9 x 9 of 640 x 480 px, disparities from -0.5 to 1.5 px, and the truth",
        settings: &[
            ("views", "9"),
            ("lenses", "640x480"),
            ("disparity", "-0.5,1.5"),
            ("write", "hci,depth,disparity,masks"),
            ("layers", "hit-mask"),
        ],
    },
];

/// Other names that messages mention as settings: the arguments of commands.
const ARGUMENTS: [&str; 19] = [
    "backend",
    "camera-file",
    "checkpoint",
    "config",
    "depths-m",
    "gallery",
    "glb",
    "lens-pitch-mm",
    "out",
    "overwrite",
    "poses",
    "preset",
    "scene",
    "scenes",
    "shard",
    "threads",
    "transforms",
    "transforms-up",
    "white",
];

impl Preset {
    /// Returns the preset of a name; `None` for an unknown one.
    #[must_use]
    pub fn by_name(name: &str) -> Option<&'static Self> {
        PRESETS.iter().find(|preset| preset.name == name)
    }

    /// Returns its settings.
    #[must_use]
    pub fn given(&self) -> Given {
        Given(self.settings.iter().map(|(key, text)| (*key, (*text).to_owned())).collect())
    }
}

impl Given {
    /// Adds a setting.
    ///
    /// # Errors
    /// [`Error::BadRequest`] for an unknown key, with the most similar one.
    pub fn insert(&mut self, key: &str, text: impl Into<String>) -> Result<(), Error> {
        let Some(setting) = Setting::by_key(key) else {
            let similar = table().map(|setting| (strsim::jaro_winkler(key, setting.key), setting.key));
            let best = similar.max_by(|a, b| a.0.total_cmp(&b.0)).filter(|(score, _)| *score > 0.75);
            let advice = best.map_or_else(String::new, |(_, key)| format!("; did you mean `{key}`?"));
            return Err(Error::BadRequest(format!("there is no setting '{key}'{advice}")));
        };
        self.0.insert(setting.key, text.into());
        Ok(())
    }

    /// Removes a setting, and returns its text.
    pub fn remove(&mut self, key: &str) -> Option<String> {
        self.0.remove(key)
    }

    /// Returns the text of a setting, if it is given.
    #[must_use]
    pub fn get(&self, key: &str) -> Option<&str> {
        self.0.get(key).map(String::as_str)
    }

    /// Returns keys and texts.
    pub fn iter(&self) -> impl Iterator<Item = (&'static str, &str)> {
        self.0.iter().map(|(key, text)| (*key, text.as_str()))
    }

    /// Returns these settings, and those of `lower` that they neither replace nor exclude.
    #[must_use]
    pub fn over(mut self, lower: Self) -> Self {
        let excludes = |a: &str, b: &str| match (Setting::by_key(a), Setting::by_key(b)) {
            (Some(a), Some(b)) => a.excludes(b),
            _ => false,
        };
        let own: Vec<&str> = self.0.keys().copied().collect();
        for (key, text) in lower.0 {
            if own.iter().all(|own| *own != key && !excludes(own, key)) {
                self.0.insert(key, text);
            }
        }
        self
    }
}

impl RenderSettings {
    /// Applies settings that were given as text.
    ///
    /// # Errors
    /// [`Error::BadRequest`] if a value is malformed, the camera does not have the setting, or two settings exclude each
    /// other.
    pub fn apply(&mut self, given: &Given) -> Result<(), Error> {
        let settings: Vec<&Setting> = given.0.keys().filter_map(|key| Setting::by_key(key)).collect();
        for (k, setting) in settings.iter().enumerate() {
            if let Some(other) = settings[..k].iter().find(|other| other.excludes(setting)) {
                let (a, b) = (other.key, setting.key);
                return Err(Error::BadRequest(format!("`{a}` and `{b}` exclude each other; give one of them")));
            }
        }
        for setting in settings {
            let text = given.0[setting.key].as_str();
            (setting.set)(self, text).map_err(|why| Error::BadRequest(format!("`{}={text}`: {why}", setting.key)))?;
        }
        self.check_effect(given)
    }
}

/// Rewrites the names of settings in a message of this crate as their users spell them. Messages have them in backticks:
/// `` `spp` ``, `` `spp=3` ``, `` `integrator depth` ``. `spell` gets the key and what follows it.
#[must_use]
pub fn spelled(message: &str, spell: impl Fn(&str, &str) -> String) -> String {
    let mut out = String::with_capacity(message.len());
    let mut rest = message;
    while let Some((before, quoted)) = rest.split_once('`') {
        let Some((inner, after)) = quoted.split_once('`') else { break };
        let length = inner.bytes().take_while(|byte| byte.is_ascii_alphanumeric() || *byte == b'-').count();
        let (key, value) = inner.split_at(length);
        out.push_str(before);
        // `camera_model` is no setting.
        let is_whole = value.is_empty() || value.starts_with([' ', '=']);
        match is_whole && (Setting::by_key(key).is_some() || ARGUMENTS.contains(&key)) {
            true => out.push_str(&spell(key, value)),
            false => out.extend(["`", inner, "`"]),
        }
        rest = after;
    }
    out.push_str(rest);
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_name_settings_as_their_users_do() {
        let flag = |key: &str, value: &str| format!("--{key}{value}");
        assert_eq!(
            spelled("`spp=x`: bad; see `holo info` or remove `vpi` from `write`", flag),
            "--spp=x: bad; see `holo info` or remove `vpi` from --write"
        );
        assert_eq!(spelled("an odd ` and `focus-m inf`", flag), "an odd ` and `focus-m inf`");
        assert_eq!(spelled("`camera_angle_x` is missing", flag), "`camera_angle_x` is missing");
    }

    #[test]
    fn presets_are_settings_and_give_way() {
        for preset in PRESETS {
            let mut settings = RenderSettings::default();
            settings.apply(&preset.given()).unwrap_or_else(|why| panic!("{}: {why}", preset.name));
        }
        let mut own = Given::default();
        own.insert("baseline-m", "0.1").unwrap();
        let both = own.over(Preset::by_name("hci").unwrap().given());
        assert_eq!((both.get("disparity"), both.get("lenses")), (None, Some("512x512")));
    }

    #[test]
    fn higher_settings_replace_whole_alternatives() {
        let given = |pairs: &[(&str, &str)]| {
            let mut given = Given::default();
            pairs.iter().for_each(|(key, text)| given.insert(key, *text).unwrap());
            given
        };
        let lower = given(&[("baseline-m", "0.1"), ("lenses", "5x4"), ("spp", "3"), ("focus-m", "2")]);
        let merged = given(&[("disparity", "-1,1"), ("sensor", "hd")]).over(lower);
        assert_eq!(merged, given(&[("disparity", "-1,1"), ("sensor", "hd"), ("spp", "3")]));
        let mut settings = RenderSettings::default();
        settings.apply(&merged).unwrap();
        let error = settings.apply(&given(&[("lenses", "5x4"), ("sensor", "hd")])).unwrap_err().to_string();
        assert!(error.contains("`lenses` and `sensor`"), "{error}");
        // What contradicts itself stays so.
        let lower = given(&[("lenses", "5x4"), ("sensor", "hd")]);
        assert_eq!(
            given(&[("spp", "3")]).over(lower.clone()),
            given(&[("spp", "3"), ("lenses", "5x4"), ("sensor", "hd")])
        );
        let error = Given::default().insert("viewss", "3").unwrap_err().to_string();
        assert!(error.contains("`views`"), "{error}");
    }
}

//! A dataset as WebDataset archives, which training programs read one after another, also from a web server.
//!
//! A sample is a light field, or the raw image of a plenoptic camera. Its files share a key, and what follows the first dot of a name is the field: of
//! `garden/20x20/scene_el.png` the archive has `garden_20x20.el.png`, of `garden/20x20/masks/fine.png`
//! `garden_20x20.masks.fine.png`, and beside the files of every folder `garden_20x20.json`, its record in `croissant.json`. Archives are tar files without owners and times, so that equal
//! datasets give equal bytes; a new one begins where the limit of bytes would be exceeded.
//!
//! # Source
//! The conventions of <https://github.com/webdataset/webdataset>.

use std::collections::BTreeSet;
use std::fs::File;
use std::io::{BufRead, BufReader, Read, Write};
use std::path::Path;

use holo_io::dataset::{CAMERA_TOML, DatasetIndex, ELEMENTAL_PNG, LIGHT_FIELD_MAT, PARAMETERS_CFG, VIEWPOINT_PNG};
use holo_io::{AtomicFile, Destination, Folder};
use tar::{Builder, EntryType, Header};

use super::catalog::{Record, records};
use super::verify::is_dataset;
use crate::output::{OutputFolder, Rollback, existing};
use crate::{Error, settings::text};

/// What the names of files begin with that hold the pixels of `scene_el.png` again.
const COPIES: [&str; 3] = [VIEWPOINT_PNG, LIGHT_FIELD_MAT, "hci/input_Cam"];

/// What the archives of a dataset contain.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct WebDataset {
    /// The fields of every sample, such as `el.png` and `masks.fine.png`, each without `scene_`; `None`: all files, but
    /// beside `el.png` neither `vpi.png`, `5d.mat` nor views of `hci`, which have its pixels in another order.
    pub fields: Option<Vec<String>>,
    /// The largest size of the files of light fields in an archive, bytes. A sample is never divided.
    pub max_bytes: u64,
}

/// An archive that was written.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Archive {
    /// Its name, such as `train-000000.tar`.
    pub name: String,
    /// The number of light fields in it.
    pub samples: usize,
    /// Its size, bytes.
    pub bytes: u64,
}

/// A file of a light field: its name in the dataset, and the size that the manifest says.
struct FileOfSample {
    name: String,
    bytes: u64,
}

/// A light field with the files that go into an archive, by their fields.
struct Sample {
    record: Record,
    key: String,
    files: Vec<(String, FileOfSample)>,
    json: String,
}

impl Default for WebDataset {
    /// All fields, and a gigabyte an archive.
    fn default() -> Self {
        Self { fields: None, max_bytes: 1_000_000_000 }
    }
}

impl WebDataset {
    /// Writes the finished folders of the dataset `root` into the folder `out`: `train-000000.tar` and so on for the
    /// scenes for training, `test-000000.tar` for the others. Archives that an interrupted run has finished stay.
    ///
    /// # Errors
    /// [`Error::BadRequest`] if no field is requested, if a light field lacks a requested one or has no image, if two have the same key, or `out` has other archives of these names; [`Error::Failed`] if no
    /// folder is finished; [`Error::Io`] if files cannot be read or written, or have another size than their manifest
    /// says.
    pub fn write(&self, root: &Path, out: &Path, rollback: &Rollback) -> Result<Vec<Archive>, Error> {
        if !is_dataset(root) {
            return Err(Error::BadRequest(format!("{}: not a folder of `holo dataset`", root.display())));
        }
        if self.fields.as_ref().is_some_and(Vec::is_empty) {
            return Err(Error::BadRequest("`fields` names no file; without it samples have all files".into()));
        }
        let opened = Folder::open(root)?;
        let index = DatasetIndex::read_in(&opened)?;
        let samples: Vec<Sample> =
            records(&opened, &index)?.into_iter().map(|record| self.sample(record)).collect::<Result<_, _>>()?;
        if samples.is_empty() {
            return Err(Error::Failed(format!("{}: no light field is finished; see `holo verify`", root.display())));
        }
        let mut keys = BTreeSet::new();
        if let Some(twice) = samples.iter().find(|sample| !keys.insert(&sample.key)) {
            return Err(Error::BadRequest(format!(
                "two light fields would have the key '{}'; rename a scene",
                twice.key
            )));
        }
        let (mut planned, older) = (Vec::new(), existing(out, "")?);
        for (split, is_test) in [("train", false), ("test", true)] {
            let of_split: Vec<&Sample> = samples.iter().filter(|sample| sample.record.is_test == is_test).collect();
            for (number, samples) in self.divide(&of_split).into_iter().enumerate() {
                let name = format!("{split}-{number:06}.tar");
                let kept = match &older {
                    Some(older) if older.kind(&name)?.is_some() => {
                        Some(check_archive(&opened, older, &name, &samples)?)
                    }
                    _ => None,
                };
                planned.push((name, samples, kept));
            }
        }
        let folder = OutputFolder::create_plain(out, rollback)?;
        let mut archives = Vec::new();
        for (name, samples, kept) in planned {
            let bytes = match kept {
                Some(bytes) => bytes,
                None => {
                    let place = folder.file(&name);
                    let archive = write_archive(&opened, place.path(), AtomicFile::create(&place)?, &samples)?;
                    archive.commit()?.bytes
                }
            };
            archives.push(Archive { name, samples: samples.len(), bytes });
        }
        folder.keep();
        Ok(archives)
    }

    fn sample(&self, record: Record) -> Result<Sample, Error> {
        let listed = record.manifest.files.iter();
        let has_raw_image = record.manifest.files.contains_key(ELEMENTAL_PNG);
        let file = |name: &str, bytes: u64| FileOfSample { name: format!("{}/{name}", record.folder), bytes };
        let mut files: Vec<(String, FileOfSample)> = listed
            .filter(|(name, _)| {
                self.fields.is_some() || !has_raw_image || !COPIES.iter().any(|copy| name.starts_with(copy))
            })
            .map(|(name, written)| (field(name), file(name, written.bytes)))
            .collect();
        if let Some(fields) = &self.fields {
            if let Some(missing) = fields.iter().find(|field| !files.iter().any(|(own, ..)| own == *field)) {
                let own: Vec<&str> = files.iter().map(|(field, ..)| field.as_str()).collect();
                let (folder, own) = (&record.folder, own.join(", "));
                return Err(Error::BadRequest(format!("{folder} has no {missing}; it has {own}")));
            }
            files.retain(|(field, ..)| fields.contains(field));
        }
        // None describes an image of its own.
        let is_image = |own: &str| !own.ends_with(PARAMETERS_CFG) && own != CAMERA_TOML;
        if !files.iter().any(|(own, ..)| is_image(own)) {
            return Err(Error::BadRequest(format!("{} has no image; render one, see `write`", record.folder)));
        }
        // What follows the first dot of a name is the field.
        let key = record.folder.replace('/', "_").replace('.', "-");
        let json = serde_json::to_string_pretty(&record.to_json()).map_err(|why| Error::Failed(why.to_string()))?;
        Ok(Sample { record, key, files, json: format!("{json}\n") })
    }

    /// Runs of samples of at most so many bytes.
    fn divide<'a>(&self, samples: &[&'a Sample]) -> Vec<Vec<&'a Sample>> {
        let mut archives: Vec<Vec<&Sample>> = Vec::new();
        let mut bytes = 0;
        for sample in samples {
            let own: u64 = sample.files.iter().map(|(_, file)| file.bytes).sum();
            match archives.last_mut() {
                Some(archive) if bytes + own <= self.max_bytes => {
                    archive.push(sample);
                    bytes += own;
                }
                _ => {
                    archives.push(vec![sample]);
                    bytes = own;
                }
            }
        }
        archives
    }
}

/// The field of a file: its name without `scene_`, with dots between folders.
fn field(name: &str) -> String {
    name.strip_prefix("scene_").unwrap_or(name).replace('/', ".")
}

/// Checks that an archive is the one that would be written; returns its size.
fn check_archive(root: &Folder, out: &Folder, name: &str, samples: &[&Sample]) -> Result<u64, Error> {
    let file = out.open_regular(name, u64::MAX)?;
    let path = out.path_of(name);
    let bytes = file.metadata().map_err(|why| Error::Failed(format!("{}: {why}", path.display())))?.len();
    let mut compared = Compared { file: BufReader::new(file), own: Vec::new(), is_equal: true };
    let written = write_archive(root, &path, &mut compared, samples).map(drop);
    let is_at_end = compared.file.fill_buf().is_ok_and(<[u8]>::is_empty);
    if !compared.is_equal || written.is_ok() && !is_at_end {
        let path = path.display();
        return Err(Error::BadRequest(format!("{path}: exists already and is another archive; give another folder")));
    }
    written.map(|()| bytes)
}

/// A place that compares what is written with a file, and takes no more after the first difference.
struct Compared {
    file: BufReader<File>,
    /// What was read of the file.
    own: Vec<u8>,
    is_equal: bool,
}

impl Write for Compared {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        self.own.resize(bytes.len(), 0);
        self.is_equal = self.is_equal && self.file.read_exact(&mut self.own).is_ok() && self.own == bytes;
        if self.is_equal { Ok(bytes.len()) } else { Err(std::io::Error::other("it is another archive")) }
    }

    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}

/// Writes an archive of files below `root` and returns where; `path` is for messages. Regular files of the size that their manifests say go into it,
/// and nothing that a link leads to: an archive is passed on.
fn write_archive<W: Write>(root: &Folder, path: &Path, place: W, samples: &[&Sample]) -> Result<W, Error> {
    let failed = |why: std::io::Error| Error::Failed(format!("{}: {why}", path.display()));
    let mut archive = Builder::new(place);
    for sample in samples {
        for (field, FileOfSample { name, bytes }) in &sample.files {
            let source = root.path_of(name);
            let differs = |what: String| Error::Failed(format!("{}: {what}; see `holo verify`", source.display()));
            let file = match root.open_regular(name, *bytes) {
                Err(holo_io::Error::TooLarge { needed, allowed, .. }) => {
                    return Err(differs(format!("{needed} bytes, but its manifest says {allowed}")));
                }
                other => other?,
            };
            let found = file.metadata().map_err(|why| differs(why.to_string()))?.len();
            if found != *bytes {
                return Err(differs(format!("{found} bytes, but its manifest says {bytes}")));
            }
            append(&mut archive, &format!("{}.{field}", sample.key), *bytes, file).map_err(failed)?;
        }
        let json = sample.json.as_bytes();
        append(&mut archive, &format!("{}.json", sample.key), json.len() as u64, json).map_err(failed)?;
    }
    archive.finish().map_err(failed)?;
    archive.into_inner().map_err(failed)
}

/// Appends a file without owner and time.
fn append(archive: &mut Builder<impl Write>, name: &str, bytes: u64, data: impl Read) -> std::io::Result<()> {
    // The file may grow or shrink while it is read.
    let mut data = data.take(bytes);
    let mut header = Header::new_ustar();
    header.set_entry_type(EntryType::Regular);
    header.set_size(bytes);
    header.set_mode(0o644);
    header.set_mtime(0);
    header.set_uid(0);
    header.set_gid(0);
    archive.append_data(&mut header, name, &mut data)?;
    match data.limit() {
        0 => Ok(()),
        left => Err(std::io::Error::other(format!("the file of {name} became {left} bytes shorter while it was read"))),
    }
}

impl std::fmt::Display for Archive {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let fields = text::counted(self.samples, "light field");
        write!(f, "{}: {fields}, {}", self.name, text::bytes(self.bytes))
    }
}

#[cfg(test)]
mod tests {
    use holo_core::GridSize;

    use super::*;
    use crate::{DatasetPlan, EngineSettings, Output, Pixels, RenderSettings, RigSettings, RunOptions, SceneSource};

    /// Five scenes, the last of them for tests, with 3 x 3 views.
    fn dataset(root: &Path, write: &[Output]) {
        let sources: Vec<SceneSource> = ["plaster", "chess", "tiles", "billiards", "mountains"]
            .map(|name| SceneSource::gallery(name).unwrap())
            .to_vec();
        let pixels = Pixels::Sensor(holo_core::Sensor::Other(GridSize::new(12, 18)));
        let rig = RigSettings { pixels, ..RigSettings::default() };
        let mut settings = RenderSettings { camera: rig.into(), ..RenderSettings::default() };
        settings.light.samples = Some(1.into());
        settings.output.write = write.to_vec();
        let views = [GridSize::new(3, 3)];
        let plan = DatasetPlan::new(&sources, &views, settings, EngineSettings::default()).unwrap();
        plan.describe(root, &(), &Rollback::default()).unwrap();
        let mut run = plan.run();
        for job in plan.jobs() {
            run.job(job, root, &RunOptions::new()).unwrap();
        }
    }

    fn entries(archive: &Path) -> Vec<(String, Vec<u8>)> {
        let mut archive = tar::Archive::new(File::open(archive).unwrap());
        let entries = archive.entries().unwrap().map(|entry| {
            let mut entry = entry.unwrap();
            let mut bytes = Vec::new();
            entry.read_to_end(&mut bytes).unwrap();
            (entry.path().unwrap().display().to_string(), bytes)
        });
        entries.collect()
    }

    #[test]
    fn samples_have_the_bytes_of_their_folders() {
        let folder = tempfile::tempdir().unwrap();
        let [root, out] = ["dataset", "out"].map(|name| folder.path().join(name));
        dataset(&root, &[]);
        let web = WebDataset { fields: Some(vec!["el.png".into(), "disparity.pfm".into()]), max_bytes: 1 };
        let archives = web.write(&root, &out, &Rollback::default()).unwrap();
        let names: Vec<&str> = archives.iter().map(|archive| archive.name.as_str()).collect();
        let expected =
            ["train-000000.tar", "train-000001.tar", "train-000002.tar", "train-000003.tar", "test-000000.tar"];
        assert_eq!(names, expected);
        let found = entries(&out.join("test-000000.tar"));
        let names: Vec<&str> = found.iter().map(|(name, _)| name.as_str()).collect();
        assert_eq!(names, ["mountains_3x3.disparity.pfm", "mountains_3x3.el.png", "mountains_3x3.json"]);
        for (name, file) in [(0, "scene_disparity.pfm"), (1, "scene_el.png")] {
            assert_eq!(found[name].1, std::fs::read(root.join("mountains/3x3").join(file)).unwrap());
        }
        let record: serde_json::Value = serde_json::from_slice(&found[2].1).unwrap();
        assert_eq!((record["scene"].as_str(), record["split"].as_str()), (Some("mountains"), Some("test")));

        // In one archive, with everything that is no copy.
        let whole = folder.path().join("whole");
        let archives = WebDataset::default().write(&root, &whole, &Rollback::default()).unwrap();
        // The only image stays.
        let manifest = root.join("mountains/3x3/manifest.json");
        let mut without = holo_io::Manifest::read(&manifest).unwrap();
        without.files.remove(ELEMENTAL_PNG);
        without.write(&manifest).unwrap();
        let other = folder.path().join("other");
        WebDataset::default().write(&root, &other, &Rollback::default()).unwrap();
        assert!(entries(&other.join("test-000000.tar")).iter().any(|(name, _)| name.ends_with("vpi.png")));
        without.files.retain(|name, _| name == PARAMETERS_CFG);
        without.write(&manifest).unwrap();
        let none = folder.path().join("none");
        let why = WebDataset::default().write(&root, &none, &Rollback::default()).unwrap_err().to_string();
        assert!(why.contains("mountains/3x3 has no image") && !none.exists(), "{why}");
        assert_eq!(archives.iter().map(|archive| archive.samples).collect::<Vec<_>>(), [4, 1]);
        let names: Vec<String> = entries(&whole.join("train-000000.tar")).into_iter().map(|(name, _)| name).collect();
        assert!(names.contains(&"chess_3x3.parameters.cfg".to_owned()), "{names:?}");
        assert!(!names.iter().any(|name| name.ends_with("5d.mat") || name.ends_with("vpi.png")), "{names:?}");
        let of_other = std::fs::read(other.join("train-000000.tar")).unwrap();
        assert!(std::fs::read(whole.join("train-000000.tar")).unwrap() == of_other, "equal datasets, equal archives");
    }

    #[test]
    fn files_in_subfolders_are_fields_too() {
        let folder = tempfile::tempdir().unwrap();
        let [root, out] = ["dataset", "out"].map(|name| folder.path().join(name));
        dataset(&root, &[Output::Hci]);
        WebDataset::default().write(&root, &out, &Rollback::default()).unwrap();
        let found = entries(&out.join("test-000000.tar"));
        let view = found.iter().find(|(name, _)| name == "mountains_3x3.hci.input_Cam008.png").expect("a view");
        assert_eq!(view.1, std::fs::read(root.join("mountains/3x3/hci/input_Cam008.png")).unwrap());
        // Beside the raw image the views are copies.
        let [root, out] = ["both", "out of both"].map(|name| folder.path().join(name));
        dataset(&root, &[Output::El, Output::Hci]);
        WebDataset::default().write(&root, &out, &Rollback::default()).unwrap();
        let names: Vec<String> = entries(&out.join("test-000000.tar")).into_iter().map(|(name, _)| name).collect();
        assert!(names.contains(&"mountains_3x3.hci.parameters.cfg".to_owned()), "{names:?}");
        assert!(!names.iter().any(|name| name.contains("input_Cam")), "{names:?}");
    }

    #[test]
    fn what_is_missing_is_named_and_nothing_stays() {
        let folder = tempfile::tempdir().unwrap();
        let [root, out] = ["dataset", "out"].map(|name| folder.path().join(name));
        dataset(&root, &[]);
        let web = WebDataset { fields: Some(vec!["normal.pfm".into()]), ..WebDataset::default() };
        let why = web.write(&root, &out, &Rollback::default()).unwrap_err().to_string();
        assert!(why.contains("plaster/3x3 has no normal.pfm; it has parameters.cfg, 5d.mat, depth.pfm"), "{why}");
        let nothing = WebDataset { fields: Some(Vec::new()), ..WebDataset::default() };
        assert!(matches!(nothing.write(&root, &out, &Rollback::default()), Err(Error::BadRequest(_))));
        // A truncated file.
        std::fs::write(root.join("tiles/3x3/scene_el.png"), b"short").unwrap();
        let why = WebDataset::default().write(&root, &out, &Rollback::default()).unwrap_err().to_string();
        assert!(why.contains("5 bytes, but its manifest says"), "{why}");
        assert!(!out.exists());
        // An archive is not overwritten.
        std::fs::create_dir(&out).unwrap();
        std::fs::write(out.join("train-000000.tar"), b"own").unwrap();
        let web = WebDataset { fields: Some(vec!["depth.pfm".into()]), ..WebDataset::default() };
        let why = web.write(&root, &out, &Rollback::default()).unwrap_err().to_string();
        assert!(why.contains("exists already"), "{why}");
        assert_eq!(std::fs::read(out.join("train-000000.tar")).unwrap(), b"own");
        assert!(!out.join("test-000000.tar").exists());
    }
}

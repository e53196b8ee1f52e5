//! Shards of an image: some of its rows as exact float maps, in a folder that `holo merge` reads.
//!
//! | file | contents |
//! |---|---|
//! | `color.pfm` | linear radiance: lens rows of the elemental image array |
//! | `error.pfm` | its estimated relative error, if requested: the same |
//! | `visibility.pfm` | visibility of the central view, if requested |
//! | `central_LAYER.pfm`, `all_LAYER.pfm` | layers of the central view, and of all views as an elemental image array |
//! | `parameters.cfg`, `manifest.json` | as of the complete image; the manifest also contains the number of the shard |
//!
//! A shard of the images of pinhole cameras has every N-th image as it is. A shard of the raw image of a plenoptic camera
//! has some rows of its pixels: `color.pfm`, `error.pfm`, `raw_LAYER.pfm` and `camera.toml`.

mod images;
mod raw;
mod views;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use holo_core::{GridSize, LightFieldOwned};
use holo_io::{Folder, Limits, Manifest, ManifestValue, dataset};
use holo_render::{ErrorDistribution, Integrator, RayCounts};
use ndarray::{Array3, ArrayView3, Axis, Slice};

use super::checkpoint::finished_manifest;
use crate::Error;
use crate::output::layers::write_pfm;
use crate::output::raw::CAMERA_TOML;
use crate::output::{self, Exposed, Finished, OutputFolder, Rollback, Statistics, Traced, TracedCamera, exposure_ev};
use crate::settings::{SettingType, Shard};
use crate::watch::Diagnostics;

const COLOR: &str = "color.pfm";

/// The key in the settings of a manifest that identifies a shard.
const PART: &str = "part";

/// The key in the label of a shard for the distribution of the estimated error: pairs of class and number of pixels.
const ERRORS: &str = "errors";

/// Writes a float map of a name.
type Put<'a> = dyn FnMut(String, ArrayView3<f32>) -> Result<(), Error> + 'a;

/// The number of a shard, and the statistics of its render.
pub(crate) struct Label {
    shard: Shard,
    rays: [u64; 3],
    samples: u64,
    why: String,
    errors: Option<ErrorDistribution>,
}

impl Label {
    pub fn new(shard: Shard, rays: RayCounts, samples: u64, why: &str) -> Self {
        let RayCounts { primary, shadow, secondary } = rays;
        Self { shard, rays: [primary, shadow, secondary], samples, why: why.to_owned(), errors: None }
    }

    /// With the distribution of the estimated error of the rows.
    fn with_errors(self, errors: Option<ErrorDistribution>) -> Self {
        Self { errors, ..self }
    }

    fn setting(&self) -> ManifestValue {
        let count = |count: u64| ManifestValue::Integer(i64::try_from(count).unwrap_or(i64::MAX));
        let mut table = BTreeMap::from([
            ("number".to_owned(), self.shard.part.into()),
            ("of".to_owned(), self.shard.of.into()),
            ("rays".to_owned(), ManifestValue::List(self.rays.map(count).to_vec())),
            ("samples".to_owned(), count(self.samples)),
            ("why".to_owned(), self.why.clone().into()),
        ]);
        if let Some(errors) = &self.errors {
            let pair = |(class, pixels)| ManifestValue::List(vec![u32::from(class).into(), count(pixels)]);
            table.insert(ERRORS.into(), ManifestValue::List(errors.counts().map(pair).collect()));
        }
        ManifestValue::Table(table)
    }

    fn read(setting: &ManifestValue) -> Option<Self> {
        let ManifestValue::Table(table) = setting else { return None };
        let count = |setting: &ManifestValue| match setting {
            ManifestValue::Integer(count) => u64::try_from(*count).ok(),
            _ => None,
        };
        let number = |name: &str| usize::try_from(count(table.get(name)?)?).ok();
        let shard = Shard { part: number("number")?, of: number("of")? };
        let ManifestValue::List(rays) = table.get("rays")? else { return None };
        let rays: Vec<u64> = rays.iter().map(count).collect::<Option<_>>()?;
        let why = table.get("why")?.as_text()?.to_owned();
        let pair = |pair: &ManifestValue| match pair {
            ManifestValue::List(pair) => Some((u16::try_from(count(pair.first()?)?).ok()?, count(pair.get(1)?)?)),
            _ => None,
        };
        let errors = match table.get(ERRORS) {
            Some(ManifestValue::List(pairs)) => {
                Some(ErrorDistribution::from_counts(pairs.iter().map(pair).collect::<Option<Vec<_>>>()?))
            }
            _ => None,
        };
        let (rays, samples) = (rays.try_into().ok()?, count(table.get("samples")?)?);
        let is_one = (1..=shard.of).contains(&shard.part);
        is_one.then_some(Self { shard, rays, samples, why, errors })
    }
}

/// An open shard: its manifest and label, without its pixels.
struct Part {
    folder: Folder,
    manifest: Manifest,
    label: Label,
}

/// Merges the shards of an image into the folder `out`. `parts` are the folders of the shards, in any order. Returns
/// the names of the files in `out`.
///
/// # Errors
/// [`Error::BadRequest`] if a folder is no shard, or if a shard is missing or given twice; [`Error::Failed`] if shards
/// are damaged or of different images; [`Error::Io`] if files cannot be read or written.
pub fn merge(
    out: &Path,
    parts: &[PathBuf],
    diagnostics: &dyn Diagnostics,
    rollback: &Rollback,
) -> Result<Vec<String>, Error> {
    let folder = OutputFolder::create(out, rollback, diagnostics)?;
    let parts = Parts::open(parts)?;
    if images::is_images(&parts) {
        return images::merge(&parts, folder);
    }
    let (traced, settings) = if raw::is_raw(&parts) { raw::traced(&parts)? } else { views::traced(&parts)? };
    let ev = exposure_ev(settings.output.exposure, &traced.rendered);
    // Only a job with one shot has rows as parts.
    let exposed = Exposed { ev, electrons: None };
    Ok(output::write(&settings, traced, exposed, folder)?.files)
}

/// Writes a shard.
pub(crate) fn write(traced: Traced, shard: Shard, mut folder: OutputFolder) -> Result<Finished, Error> {
    let Traced { rendered, mut manifest, camera, .. } = traced;
    folder.unseal()?;
    let mut put = |name: String, image: ArrayView3<f32>| -> Result<(), Error> {
        let path = folder.file(&name);
        folder.add(name, write_pfm(path, image)?);
        Ok(())
    };
    if let Some(color) = &rendered.color {
        put(COLOR.into(), grid(color)?)?;
    }
    match &camera {
        TracedCamera::Rig(views) => views::write(&rendered, views, &mut put)?,
        TracedCamera::Plenoptic { .. } => raw::write(&rendered, &mut put)?,
    }
    match &camera {
        TracedCamera::Rig(views) => {
            let written = views.parameters.write(folder.file(dataset::PARAMETERS_CFG))?;
            folder.add(dataset::PARAMETERS_CFG, written);
        }
        TracedCamera::Plenoptic { file, .. } => {
            folder.add(CAMERA_TOML, holo_io::write_file(folder.file(CAMERA_TOML), file.to_toml().as_bytes())?);
        }
    }
    let label =
        Label::new(shard, rendered.rays, rendered.samples, &rendered.why).with_errors(rendered.error_distribution);
    self::label(&mut manifest, &label);
    Ok(Finished { disparity_px: None, statistics: Statistics::default(), files: folder.seal(manifest)? })
}

/// Adds the label of a shard to its manifest.
pub(crate) fn label(manifest: &mut Manifest, label: &Label) {
    manifest.settings.insert(PART.into(), label.setting());
}

/// The elemental image array, which has the memory order of the render.
fn grid(field: &LightFieldOwned<f32>) -> Result<ArrayView3<'_, f32>, Error> {
    field.as_elemental_grid().ok_or_else(|| {
        Error::Failed("the light field does not have the memory order of an elemental image array".into())
    })
}

/// All shards of an image, in order.
struct Parts {
    parts: Vec<Part>,
    /// The manifest that they have in common.
    manifest: Manifest,
}

impl Parts {
    /// Opens the shards of an image; errors as [`merge`].
    fn open(folders: &[PathBuf]) -> Result<Self, Error> {
        let mut parts = folders.iter().map(|folder| open(folder)).collect::<Result<Vec<_>, _>>()?;
        parts.sort_by_key(|part| part.label.shard.part);
        let manifest = same(&parts)?;
        Ok(Self { parts, manifest })
    }

    /// The folder of the first shard.
    fn folder(&self) -> &Folder {
        &self.parts[0].folder
    }

    /// Whether the shards have a file.
    fn has(&self, name: &str) -> bool {
        self.parts[0].manifest.files.contains_key(name)
    }

    fn integrator(&self) -> Integrator {
        let name = self.manifest.settings.get("integrator").and_then(ManifestValue::as_text);
        name.and_then(|name| Integrator::parse(name).ok()).unwrap_or(Integrator::Depth)
    }

    fn why(&self) -> String {
        self.parts[0].label.why.clone()
    }

    fn rays(&self) -> RayCounts {
        let sum = |of: fn(&Label) -> u64| self.parts.iter().map(|part| of(&part.label)).sum();
        RayCounts { primary: sum(|l| l.rays[0]), shadow: sum(|l| l.rays[1]), secondary: sum(|l| l.rays[2]) }
    }

    fn samples(&self) -> u64 {
        self.parts.iter().map(|part| part.label.samples).sum()
    }

    /// The distribution of the estimated error of all rows, if the shards have one.
    fn error_distribution(&self) -> Option<ErrorDistribution> {
        let mut all = ErrorDistribution::default();
        for part in &self.parts {
            all.merge(part.label.errors.as_ref()?);
        }
        Some(all)
    }

    /// Reads one array of all shards, whose rows of pixels together make an array of this size. A shard has a multiple of
    /// `step` of them.
    fn gather(&self, name: &str, size: GridSize, step: usize, channels: usize) -> Result<Array3<f32>, Error> {
        let mut grid = Array3::<f32>::zeros((size.rows, size.columns, channels));
        let mut first = 0;
        for part in &self.parts {
            let path = part.folder.path_of(name);
            let image = holo_io::read_pfm_in(&part.folder, name, &Limits::default())?.values;
            let (rows, columns, found) = image.dim();
            if rows % step != 0 || first + rows > size.rows || (columns, found) != (size.columns, channels) {
                let what = format!("{}: {columns} x {rows} pixels are no rows of this image", path.display());
                return Err(Error::Failed(what));
            }
            grid.slice_axis_mut(Axis(0), Slice::from(first..first + rows)).assign(&image);
            first += rows;
        }
        if first != size.rows {
            return Err(Error::Failed(format!("{name}: the parts have {first} of {} rows of pixels", size.rows)));
        }
        Ok(grid)
    }
}

/// Why the image of a manifest is another shard than this, if it is.
pub(crate) fn other(manifest: &Manifest, shard: Option<Shard>) -> Option<String> {
    let own = manifest.settings.get(PART).and_then(Label::read).map(|label| label.shard);
    (own != shard).then(|| "it is another part of an image".to_owned())
}

fn open(path: &Path) -> Result<Part, Error> {
    let folder = Folder::open(path)?;
    let manifest = finished_manifest(&folder)?;
    let label = manifest.settings.get(PART).and_then(Label::read).ok_or_else(|| {
        Error::BadRequest(format!("{}: not a part; a render of a `shard` makes parts", path.display()))
    })?;
    let mismatches = manifest.verify_in(&folder);
    match mismatches.first() {
        Some(mismatch) => {
            let Shard { part, of } = label.shard;
            Err(Error::Failed(format!("{}: {mismatch}; render it again with `shard={part}/{of}`", path.display())))
        }
        None => Ok(Part { folder, manifest, label }),
    }
}

/// The manifest that all shards have in common.
fn same(parts: &[Part]) -> Result<Manifest, Error> {
    let plain = |part: &Part| {
        let mut manifest = Manifest { files: BTreeMap::new(), libraries: BTreeMap::new(), ..part.manifest.clone() };
        manifest.settings.remove(PART);
        manifest
    };
    let first = plain(&parts[0]);
    let of = parts[0].label.shard.of;
    for part in &parts[1..] {
        if part.label.shard.of != of || plain(part) != first {
            return Err(Error::Failed(format!(
                "{} and {} are parts of different images: scene, settings, versions and N must be the same",
                parts[0].folder.path().display(),
                part.folder.path().display()
            )));
        }
    }
    let numbers: Vec<usize> = parts.iter().map(|part| part.label.shard.part).collect();
    if let Some(twice) = numbers.windows(2).find(|pair| pair[0] == pair[1]) {
        return Err(Error::BadRequest(format!("part {} of {of} is given twice", twice[0])));
    }
    let missing: Vec<String> =
        (1..=of).filter(|number| !numbers.contains(number)).map(|number| format!("{number}/{of}")).collect();
    if !missing.is_empty() {
        return Err(Error::BadRequest(format!("{} missing; give all {of} parts", missing.join(", "))));
    }
    let libraries = parts.iter().flat_map(|part| part.manifest.libraries.clone()).collect();
    Ok(Manifest { libraries, ..first })
}

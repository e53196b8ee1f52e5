//! Shards of an image: some of its lens rows as exact float maps, in a folder that `holo merge` reads.
//!
//! | file | contents |
//! |---|---|
//! | `color.pfm` | linear radiance: lens rows of the elemental image array |
//! | `error.pfm` | its estimated relative error, if requested: the same |
//! | `central_LAYER.pfm`, `all_LAYER.pfm` | layers of the central view, and of all views as an elemental image array |
//! | `parameters.cfg`, `manifest.json` | as of the complete image; the manifest also contains the number of the shard |

use std::collections::BTreeMap;
use std::ops::Range;
use std::path::{Path, PathBuf};

use holo_core::{GridSize, LightField, LightFieldOwned, LightFieldShape};
use holo_io::{FileDigest, Limits, Manifest, ManifestValue, ParametersCfg, dataset};
use holo_render::{Integrator, Layer, Layers, RayCounts, Rendered};
use ndarray::{Array3, ArrayView3, Axis, Slice};

use crate::Error;
use crate::checkpoint::finished_manifest;
use crate::files::{self, Finished, Traced, exposure_ev};
use crate::layers::Wanted;
use crate::options::integrator_from_name;
use crate::output_folder::{OutputFolder, Rollback};
use crate::spec::{RenderSpec, Shard};

const COLOR: &str = "color.pfm";
const ERROR: &str = "error.pfm";

/// The key in the settings of a manifest that identifies a shard.
const PART: &str = "part";

fn central_file(layer: Layer) -> String {
    format!("central_{}.pfm", layer.name())
}

fn all_file(layer: Layer) -> String {
    format!("all_{}.pfm", layer.name())
}

/// Writes a shard.
pub(crate) fn write(traced: Traced, shard: Shard, mut folder: OutputFolder) -> Result<Finished, Error> {
    let Traced { rendered, mut manifest, parameters, .. } = traced;
    folder.unseal()?;
    let mut put = |name: String, image: ArrayView3<f32>| -> Result<(), Error> {
        let path = folder.file(&name);
        folder.add(name, write_pfm(&path, image)?);
        Ok(())
    };
    if let Some(color) = &rendered.color {
        put(COLOR.into(), grid(color)?.view())?;
    }
    if let Some(error) = &rendered.error {
        put(ERROR.into(), grid(error)?.view())?;
    }
    for (layer, image) in rendered.central.iter() {
        put(central_file(layer), image.view())?;
    }
    for (layer, field) in rendered.all.iter().flat_map(Layers::iter) {
        put(all_file(layer), grid(field)?.view())?;
    }
    folder.add(dataset::PARAMETERS_CFG, parameters.write(folder.file(dataset::PARAMETERS_CFG))?);
    manifest.settings.insert(PART.into(), Label::new(shard, &rendered).setting());
    Ok(Finished { disparity_px: None, files: folder.seal(manifest)? })
}

fn write_pfm(path: &Path, image: ArrayView3<f32>) -> Result<FileDigest, Error> {
    Ok(match image.dim().2 {
        1 => holo_io::write_pfm(path, image.index_axis(Axis(2), 0))?,
        _ => holo_io::write_pfm_rgb(path, image)?,
    })
}

/// The elemental image array, which has the memory order of the render.
fn grid(field: &LightFieldOwned<f32>) -> Result<ArrayView3<'_, f32>, Error> {
    field.as_elemental_grid().ok_or_else(|| {
        Error::Failed("the light field does not have the memory order of an elemental image array".into())
    })
}

/// The number of a shard, and the statistics of its render.
struct Label {
    shard: Shard,
    rays: [u64; 3],
    samples: u64,
    why: String,
}

impl Label {
    fn new(shard: Shard, rendered: &Rendered) -> Self {
        let RayCounts { primary, shadow, secondary } = rendered.rays;
        Self { shard, rays: [primary, shadow, secondary], samples: rendered.samples, why: rendered.why.clone() }
    }

    fn setting(&self) -> ManifestValue {
        let count = |count: u64| ManifestValue::Integer(i64::try_from(count).unwrap_or(i64::MAX));
        ManifestValue::Table(BTreeMap::from([
            ("number".to_owned(), self.shard.part.into()),
            ("of".to_owned(), self.shard.of.into()),
            ("rays".to_owned(), ManifestValue::List(self.rays.map(count).to_vec())),
            ("samples".to_owned(), count(self.samples)),
            ("why".to_owned(), self.why.clone().into()),
        ]))
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
        let is_one = (1..=shard.of).contains(&shard.part);
        is_one.then_some(Self { shard, rays: rays.try_into().ok()?, samples: count(table.get("samples")?)?, why })
    }
}

/// An open shard: its manifest and label, without its pixels.
struct Part<'a> {
    folder: &'a Path,
    manifest: Manifest,
    label: Label,
}

/// Merges the shards of an image into the folder `out`. `parts` are the folders of the shards, in any order. Returns
/// the names of the files in `out`.
///
/// # Errors
/// [`Error::BadRequest`] if a folder is no shard, or if a shard is missing or given twice; [`Error::Failed`] if shards
/// are damaged or of different images; [`Error::Io`] if files cannot be read or written.
pub fn merge(out: &Path, parts: &[PathBuf], rollback: &Rollback) -> Result<Vec<String>, Error> {
    let folder = OutputFolder::create(out, rollback)?;
    let (traced, spec) = read(parts)?;
    let exposure_ev = exposure_ev(&spec, &traced.rendered);
    Ok(files::write(&spec, traced, exposure_ev, folder)?.files)
}

/// Reads and merges shards; errors as [`merge`].
pub(crate) fn read(folders: &[PathBuf]) -> Result<(Traced, RenderSpec), Error> {
    let mut parts = folders.iter().map(|folder| open(folder)).collect::<Result<Vec<_>, _>>()?;
    parts.sort_by_key(|part| part.label.shard.part);
    let manifest = same(&parts)?;
    let spec = spec(&manifest)?;
    let parameters = ParametersCfg::read(parts[0].folder.join(dataset::PARAMETERS_CFG))?;
    let broken = |what: String| Error::Failed(format!("{}: {what}", parts[0].folder.display()));
    let rig = manifest.rig.ok_or_else(|| broken("the manifest has no rig".into()))?;
    let shape = *rig.shape();
    let wanted = Wanted::new(&spec);

    let has = |name: &str| parts[0].manifest.files.contains_key(name);
    let color = has(COLOR).then(|| gather(&parts, COLOR, shape, 3)).transpose()?;
    let error = has(ERROR).then(|| gather(&parts, ERROR, shape, 1)).transpose()?;
    let one = LightFieldShape::new(GridSize::new(1, 1), shape.lenses())?;
    let mut central: Layers<Array3<f32>> = Layers::default();
    let mut all: Layers<LightFieldOwned<f32>> = Layers::default();
    for layer in Layer::ALL {
        let name = central_file(layer);
        if has(&name) {
            let image = gather(&parts, &name, one, layer.channels())?;
            central.extend([(layer, image.into_elemental_grid().or_else(|field| field.to_elemental_grid())?)]);
        }
        let name = all_file(layer);
        if has(&name) {
            all.extend([(layer, gather(&parts, &name, shape, layer.channels())?)]);
        }
    }
    let integrator =
        manifest.settings.get("integrator").and_then(ManifestValue::as_text).and_then(integrator_from_name);
    let integrator = integrator.unwrap_or(Integrator::Depth);
    let sum = |of: fn(&Label) -> u64| parts.iter().map(|part| of(&part.label)).sum();
    let rays = RayCounts { primary: sum(|l| l.rays[0]), shadow: sum(|l| l.rays[1]), secondary: sum(|l| l.rays[2]) };
    let all = (!all.set().is_empty()).then_some(all);
    let why = parts[0].label.why.clone();
    let rendered = Rendered { color, error, central, all, integrator, why, rays, samples: sum(|l| l.samples) };
    Ok((Traced { rendered, wanted, rig, manifest, parameters, highres_depth_m: None, warnings: Vec::new() }, spec))
}

/// The specification of the shards. Their color is rendered already, so the sky need not be known.
fn spec(manifest: &Manifest) -> Result<RenderSpec, Error> {
    let unknown = || Error::Failed("the manifests of the parts do not contain their options".into());
    let Some(ManifestValue::Table(options)) = manifest.settings.get("options") else { return Err(unknown()) };
    let text = |(name, value): (&String, &ManifestValue)| Some((name.clone(), value.as_text()?.to_owned()));
    let options: Option<_> = options.iter().map(text).collect();
    RenderSpec::from_options(&options.ok_or_else(unknown)?)
}

/// The shard that a manifest belongs to; `None` for a complete image.
pub(crate) fn of_manifest(manifest: &Manifest) -> Option<Shard> {
    manifest.settings.get(PART).and_then(Label::read).map(|label| label.shard)
}

fn open(folder: &Path) -> Result<Part<'_>, Error> {
    let manifest = finished_manifest(folder)?;
    let label = manifest.settings.get(PART).and_then(Label::read).ok_or_else(|| {
        Error::BadRequest(format!("{}: not a part; `holo render --shard K/N` makes parts", folder.display()))
    })?;
    let mismatches = manifest.verify(folder);
    match mismatches.first() {
        Some(mismatch) => {
            let Shard { part, of } = label.shard;
            Err(Error::Failed(format!("{}: {mismatch}; render it again with --shard {part}/{of}", folder.display())))
        }
        None => Ok(Part { folder, manifest, label }),
    }
}

/// The manifest that all shards have in common.
fn same(parts: &[Part<'_>]) -> Result<Manifest, Error> {
    let plain = |part: &Part<'_>| {
        let mut manifest = Manifest { files: BTreeMap::new(), ..part.manifest.clone() };
        manifest.settings.remove(PART);
        manifest
    };
    let first = plain(&parts[0]);
    let of = parts[0].label.shard.of;
    for part in &parts[1..] {
        if part.label.shard.of != of || plain(part) != first {
            return Err(Error::Failed(format!(
                "{} and {} are parts of different images: scene, options, versions and N must be the same",
                parts[0].folder.display(),
                part.folder.display()
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
    Ok(first)
}

/// Reads one array of all shards as a light field.
fn gather(
    parts: &[Part<'_>],
    name: &str,
    shape: LightFieldShape,
    channels: usize,
) -> Result<LightFieldOwned<f32>, Error> {
    let (views, lenses) = (shape.views(), shape.lenses());
    let size = shape.raw_size();
    let mut grid = Array3::<f32>::zeros((size.rows, size.columns, channels));
    let mut first = 0;
    for part in parts {
        let path = part.folder.join(name);
        let image = holo_io::read_pfm(&path, &Limits::default())?.values;
        let (rows, columns, found) = image.dim();
        let lens_rows: Range<usize> = first..first + rows / views.rows;
        if rows % views.rows != 0 || lens_rows.end > lenses.rows || (columns, found) != (size.columns, channels) {
            let what = format!("{}: {columns} x {rows} pixels are not lens rows of this image", path.display());
            return Err(Error::Failed(what));
        }
        let place = Slice::from(first * views.rows..first * views.rows + rows);
        grid.slice_axis_mut(Axis(0), place).assign(&image);
        first = lens_rows.end;
    }
    if first != lenses.rows {
        return Err(Error::Failed(format!("{name}: the parts have {first} of {} lens rows", lenses.rows)));
    }
    Ok(LightField::from_elemental_grid(grid, shape)?)
}

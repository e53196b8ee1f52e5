//! The light fields of an export: those of a dataset, or one.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use holo_core::Rig;
use holo_core::{DynLightField, GridSize, LightFieldOwned};
use holo_io::dataset::{DISPARITY_PFM, DatasetCamera, DatasetIndex, HCI_FOLDER, HIT_MASK_PNG, MANIFEST_JSON};
use holo_io::{
    Folder, HciFolder, HciQuantity, HciResolution, LightFieldReader, Limits, Manifest, ManifestValue, ReadOptions,
};
use holo_render::exposure;
use ndarray::Array2;

use crate::Error;
use crate::describe::{is_dataset, shots_of};
use crate::score::{Objects, RegionMask, mask_files, read_mask};

/// The numbers of what the central view sees, from 1.
const OBJECT_IDS: &str = "scene_object_id.pfm";

/// The objects that a message names at most.
const SHOWN_OBJECTS: usize = 12;

/// A light field that is not read yet.
pub(super) struct SourceField {
    name: String,
    path: PathBuf,
}

/// A light field with its truth.
pub(super) struct LoadedField {
    /// The name of its scene.
    pub name: String,
    /// Its place among all light fields of an export.
    pub number: usize,
    /// 8-bit codes on the sRGB curve, 3 channels.
    pub field: LightFieldOwned<u8>,
    /// The rig, if it is known.
    pub rig: Option<Rig>,
    /// Disparity of the central view, px; depth, m.
    pub disparity_px: Option<Array2<f32>>,
    pub depth_m: Option<Array2<f32>>,
    /// What the central view hits.
    pub hits: Option<Array2<bool>>,
    /// Regions of the central view that are files.
    pub regions: Vec<RegionMask>,
    /// What the central view sees, if the scene is a stratified one.
    pub objects: Option<Objects>,
    path: PathBuf,
}

/// The light fields of a dataset with these views, those of the poses and frames of a folder, or that of a folder or file.
pub(super) fn sources(input: &Path, views: Option<GridSize>) -> Result<Vec<SourceField>, Error> {
    if !is_dataset(input) {
        let shots = if input.is_dir() && !input.join(MANIFEST_JSON).is_file() { shots_of(input)? } else { Vec::new() };
        if shots.iter().any(|shot| input.join(shot).is_dir()) {
            let parts = |shot: &Path| shot.iter().map(|part| part.to_string_lossy()).collect::<Vec<_>>().join("_");
            let field = |shot: PathBuf| SourceField { name: plain(&parts(&shot)), path: input.join(shot) };
            return Ok(shots.into_iter().map(field).collect());
        }
        let path = std::path::absolute(input).unwrap_or_else(|_| input.to_owned());
        let stem = if path.is_dir() { path.file_name() } else { path.file_stem() };
        let name = stem.map_or_else(|| "scene".into(), |name| name.to_string_lossy().into_owned());
        return Ok(vec![SourceField { name: plain(&name), path: input.to_owned() }]);
    }
    let index = DatasetIndex::read(input)?;
    let counts: Vec<GridSize> = index
        .cameras
        .iter()
        .filter_map(|camera| match camera {
            DatasetCamera::Rig(shape) => Some(shape.views()),
            _ => None,
        })
        .collect();
    let wanted = match (views, &counts[..]) {
        (Some(views), _) if counts.contains(&views) => views,
        (None, [views]) => *views,
        _ => {
            let all: Vec<String> = counts.iter().map(ToString::to_string).collect();
            return Err(Error::BadRequest(match all.is_empty() {
                true => format!("{}: the dataset has no light fields of a rig", input.display()),
                false => format!("choose `views` among those of the dataset: {}", all.join(", ")),
            }));
        }
    };
    let mut out = Vec::new();
    for scene in &index.scenes {
        for camera in &index.cameras {
            if !matches!(camera, DatasetCamera::Rig(shape) if shape.views() == wanted) {
                continue;
            }
            let path = input.join(camera.folder(&scene.name)?);
            if path.join(MANIFEST_JSON).is_file() {
                out.push(SourceField { name: plain(&scene.name), path });
            }
        }
    }
    match out.is_empty() {
        true => Err(Error::Failed(format!("{}: no light field is finished; see `holo verify`", input.display()))),
        false => Ok(out),
    }
}

impl SourceField {
    /// The name of its scene.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Reads the samples and the truth.
    /// `number` is its place among all light fields of an export.
    pub fn load(&self, number: usize) -> Result<LoadedField, Error> {
        let reader = LightFieldReader::open(&self.path, &ReadOptions::default())?;
        let (mut disparity_px, mut depth_m) = (reader.central_disparity_px()?, reader.central_depth_m()?);
        if let Some(folder) = hci_folder(&self.path) {
            // Where the files that are read have none.
            let truth = |quantity| folder.central_truth(quantity, HciResolution::Low, &Limits::default());
            disparity_px = disparity_px.map_or_else(|| truth(HciQuantity::Disparity), |map| Ok(Some(map)))?;
            depth_m = depth_m.map_or_else(|| truth(HciQuantity::Depth), |map| Ok(Some(map)))?;
        }
        let folder = Folder::open(&self.path).ok();
        let hits = match folder.filter(|folder| folder.has_file(HIT_MASK_PNG)) {
            Some(folder) => Some(read_mask(&folder.path_of(HIT_MASK_PNG))?),
            // The depth of what is not hit is infinite, its disparity is not.
            None => depth_m.as_ref().map(|depth| depth.mapv(f32::is_finite)),
        };
        let size = depth_m.as_ref().map(|depth| depth.dim());
        let map = self.path.join(DISPARITY_PFM);
        let regions = size.map_or(Ok(Vec::new()), |size| mask_files(&map, size))?;
        let objects = size.map_or(Ok(None), |size| Objects::read(&map, size))?;
        let read = reader.read()?;
        let rig = read.rig;
        let field = codes(read.light_field.without_alpha()?)?;
        Ok(LoadedField {
            name: self.name.clone(),
            number,
            field,
            rig,
            disparity_px,
            depth_m,
            hits,
            regions,
            objects,
            path: self.path.clone(),
        })
    }
}

/// The light fields under other names; one that is not there is an error.
pub(super) fn renamed(fields: Vec<SourceField>, names: &[(String, String)]) -> Result<Vec<SourceField>, Error> {
    if let Some((ours, _)) = names.iter().find(|(ours, _)| fields.iter().all(|field| field.name != *ours)) {
        let known: Vec<&str> = fields.iter().map(|field| field.name.as_str()).collect();
        let ours = holo_core::shown(ours);
        return Err(Error::BadRequest(format!("`names`: there is no scene {ours}; there are {}", known.join(", "))));
    }
    let new = |name: &str| names.iter().find(|(ours, _)| ours == name).map_or(name, |(_, new)| new).to_owned();
    let fields: Vec<SourceField> =
        fields.into_iter().map(|field| SourceField { name: new(&field.name), ..field }).collect();
    let repeated = fields.iter().enumerate().find(|(k, field)| fields[..*k].iter().any(|one| one.name == field.name));
    match repeated {
        Some((_, field)) => Err(Error::BadRequest(format!("`names`: two scenes would be {}", field.name))),
        None => Ok(fields),
    }
}

/// The folder of the HCI benchmark that a folder is, or has.
fn hci_folder(path: &Path) -> Option<HciFolder> {
    [path.join(HCI_FOLDER), path.to_owned()].iter().find_map(|path| HciFolder::open(path).ok())
}

impl LoadedField {
    /// The folder of the HCI benchmark that the light field is, or has.
    pub fn hci_folder(&self) -> Option<HciFolder> {
        hci_folder(&self.path)
    }

    /// Where the central view sees one of the objects.
    ///
    /// # Errors
    /// [`Error::BadRequest`] if its objects are not known, or it sees none of these; the message names those that it sees.
    pub fn sees(&self, objects: &[String]) -> Result<Array2<bool>, Error> {
        let folder = Folder::open(&self.path).ok().filter(|folder| folder.has_file(OBJECT_IDS));
        let names = match &folder {
            Some(folder) => Manifest::read_in(folder)?.settings.remove("objects"),
            None => None,
        };
        let Some(ManifestValue::List(names)) = names else {
            return Err(self.lacks("it has no numbers of objects", "render it with `layers` depth,disparity,object-id"));
        };
        // 0 is what is not hit; what has no name is named by its number.
        let name = |id: f32| match names.get((id as usize).wrapping_sub(1)) {
            Some(ManifestValue::Text(name)) if !name.is_empty() => name.clone(),
            Some(_) => format!("object-{id}"),
            None => String::new(),
        };
        let is_chosen = |name: &str| {
            objects.iter().any(|object| match object.strip_suffix('*') {
                Some(start) => !name.is_empty() && name.starts_with(start),
                None => name == object,
            })
        };
        let ids = holo_io::read_pfm_gray(self.path.join(OBJECT_IDS), &Limits::default())?;
        let mask = ids.mapv(|id| is_chosen(&name(id)));
        if mask.iter().any(|is_in| *is_in) {
            return Ok(mask);
        }
        let mut counts: BTreeMap<String, usize> = BTreeMap::new();
        ids.iter().for_each(|id| *counts.entry(name(*id)).or_default() += 1);
        let mut seen: Vec<_> = counts.into_iter().filter(|(name, _)| !name.is_empty()).collect();
        seen.sort_by_key(|(_, count)| std::cmp::Reverse(*count));
        let share = |(name, count): &(String, usize)| {
            format!("{} ({:.0} %)", holo_core::shown(name), 100.0 * *count as f64 / ids.len() as f64)
        };
        let seen: Vec<String> = seen.iter().take(SHOWN_OBJECTS).map(share).collect();
        let what =
            if objects.is_empty() { "masks show chosen objects" } else { "the central view sees none of `objects`" };
        Err(self.lacks(what, &format!("choose `objects` among {}", seen.join(", "))))
    }

    /// The error that this light field lacks something.
    pub fn lacks(&self, what: &str, advice: &str) -> Error {
        Error::BadRequest(format!("{}: {what}; {advice}", self.path.display()))
    }
}

/// 8-bit codes: those that are there, 16 bits rounded, radiance at automatic exposure.
fn codes(field: DynLightField) -> Result<LightFieldOwned<u8>, Error> {
    Ok(match field {
        DynLightField::U8(field) => field,
        DynLightField::U16(field) => field.map(|&code| ((u32::from(code) * 255 + 32767) / 65535) as u8)?,
        field => {
            let field = field.into_f32()?;
            exposure::encode_8bit(&field, exposure::automatic_exposure(&field))?
        }
    })
}

/// A name that is one folder on every system.
fn plain(name: &str) -> String {
    let name: String = name.chars().map(|c| if c.is_alphanumeric() || "-_.".contains(c) { c } else { '_' }).collect();
    if name.starts_with('.') || name.is_empty() { format!("scene{name}") } else { name }
}

//! The folders of the HCI benchmark, as learned methods and the evaluation toolkit read them.
//!
//! | target | files |
//! |---|---|
//! | `hci` | `OUT/<group>/<scene>/`: `input_Cam000.png` on, `gt_disp_lowres.pfm`, `gt_depth_lowres.pfm`, `parameters.cfg`, and `valid_mask.png`, 255 where the central view hits something; truth of all views and of high resolution where it was rendered; `OUT/additional_invalid_area/` for the three scenes whose masks EPINET reads |
//! | `hci-toolkit` | `OUT/data/<group>/<scene>/`: the same, with truth of high resolution and the masks of the scores in both resolutions; `OUT/algo_results/method/` with `disp_maps` and `runtimes`, for results |

use holo_core::{GridSize, LightFieldOwned};
use holo_io::{
    ColorEncoding, Compression, HciFolder, HciHighResolution, HciImage, HciQuantity, HciResolution, HciTruth, Limits,
    ParametersCfg,
};
use ndarray::{Array2, Array3, ArrayView2};

use super::source::LoadedField;
use super::{ExportJob, ExportTarget, LoadedNote, Writer};
use crate::Error;
use crate::output::OutputFolder;
use crate::score::hci_mask;

const SIDE: usize = 9;

/// Readers have scene indices up to 15.
const SCENES: usize = 16;

const GROUP: &str = "training";

/// EPINET reads masks of pixels that mirror light or let it pass for three scenes of this group.
const ADDITIONAL: &str = "additional";
const WITH_INVALID_AREA: [&str; 3] = ["kitchen", "museum", "vinyl"];
const INVALID_AREA: &str = "additional_invalid_area";

pub(super) const TARGET: ExportTarget = ExportTarget {
    name: "hci",
    help: "EPINET, LFattNet, SubFocal, OACC-Net, DistgDisp, LF2Disp: folders of the HCI benchmark",
    usage: "Readers take the folder that contains the group, `training` unless another was given, as their dataset.",
    has_groups: true,
    has_objects: false,
    writer: Writer::Fields { write: write_scene, check },
};

pub(super) const TOOLKIT: ExportTarget = ExportTarget {
    name: "hci-toolkit",
    help: "the evaluation toolkit of the HCI benchmark: truth of high resolution, masks of its scores",
    usage: "The toolkit takes `data` and `algo_results` in place of its own. A method writes disp_maps/SCENE.pfm and \
            runtimes/SCENE.txt, seconds.",
    has_groups: true,
    has_objects: false,
    writer: Writer::Fields { write: write_for_toolkit, check: super::unchecked },
};

/// What the methods of a submission write.
const RESULTS: [&str; 2] = ["algo_results/method/disp_maps", "algo_results/method/runtimes"];

/// Truth beside that of the central view.
#[derive(Default)]
struct MoreTruth {
    /// Disparity and depth of the central view with more rows and columns.
    high: Option<[Array2<f32>; 2]>,
    /// The same of all views.
    all: Option<[LightFieldOwned<f32>; 2]>,
}

impl MoreTruth {
    /// What was rendered of it.
    fn read(loaded: &LoadedField) -> Result<Self, Error> {
        let Some(folder) = loaded.hci_folder() else { return Ok(Self::default()) };
        let limits = Limits::default();
        let both = [HciQuantity::Disparity, HciQuantity::Depth];
        let high = |folder: &HciFolder| -> Result<Option<[Array2<f32>; 2]>, Error> {
            let [disparity, depth] = both.map(|quantity| folder.central_truth(quantity, HciResolution::High, &limits));
            Ok(disparity?.zip(depth?).map(|(disparity, depth)| [disparity, depth]))
        };
        let [disparity, depth] = both.map(|quantity| folder.truth_of_all_views(quantity, &limits));
        let all = disparity?.zip(depth?).map(|(disparity, depth)| [disparity, depth]);
        Ok(Self { high: high(&folder)?, all })
    }
}

fn write_scene(folder: &mut OutputFolder, loaded: &LoadedField, job: &ExportJob) -> Result<(), Error> {
    let more = MoreTruth::read(loaded)?;
    write(folder, loaded, &job.scene_folder(GROUP, &loaded.name), GROUP, &more)?;
    match job.group.as_deref() == Some(ADDITIONAL) && WITH_INVALID_AREA.contains(&loaded.name.as_str()) {
        true => write_invalid_area(folder, loaded),
        false => Ok(()),
    }
}

/// Writes what EPINET leaves out of its training: alpha is not 0 where the surface mirrors light or lets it pass.
fn write_invalid_area(folder: &mut OutputFolder, loaded: &LoadedField) -> Result<(), Error> {
    let regions = loaded.regions.iter().filter(|(name, _)| ["reflective", "transparent"].contains(&name.as_str()));
    let masks: Vec<&Array2<bool>> = regions.map(|(_, mask)| mask).collect();
    let lenses = loaded.field.shape().lenses();
    let is_invalid = |v: usize, u: usize| masks.iter().any(|mask| mask[[v, u]]);
    let code = |(v, u, _)| if is_invalid(v, u) { 255_u8 } else { 0 };
    let rgba = Array3::from_shape_fn((lenses.rows, lenses.columns, 4), code);
    let inner = format!("{INVALID_AREA}/{}", loaded.name);
    folder.subfolder(&inner)?;
    let name = format!("{inner}/input_Cam040_invalid_ver2.png");
    let written = holo_io::write_png(folder.file(&name), rgba.view(), ColorEncoding::Srgb, Compression::Fast)?;
    folder.add(name, written);
    Ok(())
}

fn write_for_toolkit(folder: &mut OutputFolder, loaded: &LoadedField, job: &ExportJob) -> Result<(), Error> {
    let more = MoreTruth::read(loaded)?;
    let Some([disparity, _]) = &more.high else {
        let advice = "render it with `preset hci` and `write` hci-highres and masks";
        return Err(loaded.lacks("the toolkit needs truth of high resolution", advice));
    };
    if loaded.regions.is_empty() {
        return Err(loaded.lacks("it has no masks, by which the toolkit scores", "render it with `write` masks"));
    }
    let scene = format!("data/{}", job.scene_folder(GROUP, &loaded.name));
    let (rows, columns) = disparity.dim();
    write(folder, loaded, &scene, job.group.as_deref().unwrap_or(GROUP), &more)?;
    let region = |name: &str, mask: &Array2<bool>| hci_mask(name).map(|name| (name, codes(mask)));
    let mut masks: Vec<(&str, Array2<u8>)> =
        loaded.regions.iter().filter_map(|(name, mask)| region(name, mask)).collect();
    if let Some(objects) = &loaded.objects {
        masks.extend(objects.toolkit_masks());
        let textureless = loaded.regions.iter().find(|(name, _)| name == "textureless");
        masks.extend(textureless.map(|(_, mask)| ("mask_low_texture", codes(mask))));
    }
    for (name, mask) in masks {
        let (own_rows, own_columns) = mask.dim();
        let of = |(v, u): (usize, usize)| mask[[v * own_rows / rows, u * own_columns / columns]];
        let large = Array2::from_shape_fn((rows, columns), of);
        write_mask(folder, &format!("{scene}/{name}_lowres.png"), mask.view(), 1)?;
        write_mask(folder, &format!("{scene}/{name}_highres.png"), large.view(), 1)?;
    }
    for inner in RESULTS {
        folder.subfolder(inner)?;
    }
    Ok(())
}

/// A mask as codes: 0 and 255.
fn codes(mask: &Array2<bool>) -> Array2<u8> {
    mask.mapv(|is_in| if is_in { 255 } else { 0 })
}

/// Writes a mask as an image.
fn write_mask(folder: &mut OutputFolder, name: &str, mask: ArrayView2<u8>, channels: usize) -> Result<(), Error> {
    let (rows, columns) = mask.dim();
    let codes = Array3::from_shape_fn((rows, columns, channels), |(v, u, _)| mask[[v, u]]);
    let written = holo_io::write_png(folder.file(name), codes.view(), ColorEncoding::Linear, Compression::Fast)?;
    folder.add(name, written);
    Ok(())
}

/// Writes a scene of a category into the folder `scene`.
fn write(
    folder: &mut OutputFolder,
    loaded: &LoadedField,
    scene: &str,
    category: &str,
    more: &MoreTruth,
) -> Result<(), Error> {
    let advice = "render it with `preset hci`";
    let views = loaded.field.shape().views();
    if views != GridSize::new(SIDE, SIDE) {
        let what = format!("the readers take {SIDE} x {SIDE} views, and it has {} x {}", views.columns, views.rows);
        return Err(loaded.lacks(&what, advice));
    }
    let (Some(disparity), Some(depth), Some(rig)) = (&loaded.disparity_px, &loaded.depth_m, &loaded.rig) else {
        return Err(loaded.lacks("the readers need disparity, depth and camera", advice));
    };
    let inner = folder.subfolder(scene)?;
    let mut parameters = ParametersCfg::from_rig(rig);
    parameters.scene.clone_from(&loaded.name);
    category.clone_into(&mut parameters.category);
    let finite = disparity.iter().filter(|value| value.is_finite()).map(|value| f64::from(*value));
    let (low, high) = finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), d| (low.min(d), high.max(d)));
    (parameters.disp_min, parameters.disp_max) = ((low <= high).then_some(low), (low <= high).then_some(high));
    if let Some([high, _]) = &more.high {
        parameters.depth_map_scale = Some(high.nrows() as f64 / disparity.nrows() as f64);
    }
    let image = HciImage {
        views: Some(loaded.field.as_light_field_ref().into()),
        parameters: &parameters,
        disparity_px: match &more.all {
            Some([disparity, _]) => HciTruth::All(disparity.as_light_field_ref()),
            None => HciTruth::Central(disparity.view()),
        },
        depth_m: match &more.all {
            Some([_, depth]) => HciTruth::All(depth.as_light_field_ref()),
            None => HciTruth::Central(depth.view()),
        },
        high_resolution: more
            .high
            .as_ref()
            .map(|[disparity, depth]| HciHighResolution { disparity_px: disparity.view(), depth_m: depth.view() }),
    };
    image.file_names().iter().for_each(|file| drop(folder.file(&format!("{scene}/{file}"))));
    for (file, written) in image.write_in(&inner, Compression::Fast)? {
        folder.add(format!("{scene}/{file}"), written);
    }
    let hits = loaded.hits.clone().unwrap_or_else(|| depth.mapv(f32::is_finite));
    write_mask(folder, &format!("{scene}/valid_mask.png"), codes(&hits).view(), 3)
}

fn check(sizes: &[LoadedNote]) -> Option<String> {
    if sizes.iter().any(|size| *size != GridSize::new(512, 512)) {
        return Some("EPINET and its relatives take views of 512 x 512 px alone; render with `preset hci`".into());
    }
    let count = sizes.len();
    (count < SCENES).then(|| format!("OACC-Net and DistgDisp need {SCENES} scenes, and these are {count}"))
}

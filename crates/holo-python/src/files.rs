//! Files: light fields of any format, and images.

pub(crate) mod array;
pub(crate) mod display;

use std::path::PathBuf;

use holo_core::{DynImage, DynLightFieldRef, GridSize, Layout, for_each_sample};
use holo_dataset::{Diagnostics, EXPORT_TARGETS, ExportJob, ExportTarget, Rollback};
use holo_io::{
    ColorEncoding, Compression, ExrCompression, ExrSamples, ExrWriter, HciImage, HciTruth, LightFieldReader, Limits,
    MatOptions, MatOrder, ParametersCfg, ReadOptions,
};
use ndarray::Axis;
use numpy::PyReadonlyArray2;
use pyo3::prelude::*;

use crate::arrays::{Field, Image, give, give_field, give_image};
use crate::cameras::rig::{Rig, Size};
use crate::failure::Failure;
use crate::images::grid;
use crate::options;
use crate::render::{Told, listening};

/// A light field whose headers have been read, but not its samples.
#[pyclass(frozen, module = "holo._holo")]
pub struct Reader {
    reader: LightFieldReader,
    path: PathBuf,
    options: ReadOptions,
}

#[pymethods]
impl Reader {
    #[new]
    fn new(path: PathBuf, views: Option<Size>, layout: Option<&str>, order: Option<&str>) -> Result<Self, Failure> {
        let mut read = ReadOptions::default()
            .views(views.map(|(rows, columns)| GridSize::new(rows, columns)))
            .layout(layout.map(options::layout).transpose()?);
        if let Some(order) = order {
            read = read.order(options::order(order)?);
        }
        Ok(Self { reader: LightFieldReader::open(&path, &read)?, path, options: read })
    }

    #[getter]
    fn rig(&self) -> Option<Rig> {
        self.reader.rig().map(|rig| Rig(*rig))
    }

    #[getter]
    fn disparity_range_px(&self) -> Option<(f64, f64)> {
        self.reader.disparity_range_px()
    }

    /// The samples, axes (v, u, t, s, c), whether they are on the sRGB curve, and all warnings.
    fn read<'py>(&self, py: Python<'py>) -> Result<(Bound<'py, PyAny>, bool, Vec<String>), Failure> {
        let file = py.detach(|| LightFieldReader::open(&self.path, &self.options)?.read())?;
        Ok((give_field(py, file.light_field), file.color_encoding == ColorEncoding::Srgb, file.warnings))
    }

    /// One view, axes (row, column, channel). Of an HDF5 file only its chunks are read.
    fn read_view<'py>(&self, py: Python<'py>, t: usize, s: usize) -> Result<Bound<'py, PyAny>, Failure> {
        Ok(give_image(py, py.detach(|| self.view(t, s))?))
    }
}

impl Reader {
    fn view(&self, t: usize, s: usize) -> Result<DynImage, Failure> {
        // Where a view can be read alone.
        if let Some(view) = self.reader.read_view(t, s)? {
            return Ok(view);
        }
        let field = LightFieldReader::open(&self.path, &self.options)?.read()?.light_field;
        Ok(for_each_sample!(DynLightField, &field, field => field.view(t, s)?.to_owned().into()))
    }
}

/// What is exported, for what, and where to.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct ExportRequest {
    input: PathBuf,
    target: String,
    out: PathBuf,
    views: Option<Size>,
    group: Option<String>,
    names: Vec<(String, String)>,
    objects: Vec<String>,
    overwrite: bool,
}

/// Writes the light fields of a dataset, a folder or a file for another program; returns the names of the files, and
/// diagnostics.
#[pyfunction]
pub fn export(py: Python<'_>, request: ExportRequest) -> Result<Told<Vec<String>>, Failure> {
    let ExportRequest { input, target, out, views, group, names, objects, overwrite } = request;
    let choices: Vec<(&str, &ExportTarget)> = EXPORT_TARGETS.iter().map(|target| (target.name, target)).collect();
    let target = options::choice("target", &target, &choices)?;
    let views = views.map(|(rows, columns)| GridSize::new(rows, columns));
    let job = ExportJob::new(input, target).views(views).group(group).names(names);
    let job = job.objects(objects).overwrite(overwrite);
    let run = |tell: &dyn Diagnostics| Ok(job.run(out, &Rollback::default(), tell)?.files);
    Ok(py.detach(|| listening(run))?)
}

/// The programs that light fields are exported for: names, and what they are.
#[pyfunction]
pub fn export_targets() -> Vec<(&'static str, &'static str)> {
    EXPORT_TARGETS.iter().map(|target| (target.name, target.help)).collect()
}

/// Writes a light field; the ending of the path says how.
#[pyfunction]
pub fn write_light_field(
    py: Python<'_>,
    path: PathBuf,
    field: Field<'_>,
    rig: Option<Rig>,
    is_srgb: bool,
    views_first: bool,
) -> Result<(), Failure> {
    let field = field.borrow()?;
    let ending = path.extension().map(|ending| ending.to_string_lossy().to_ascii_lowercase()).unwrap_or_default();
    let rig = rig.map(|rig| rig.0);
    py.detach(|| match ending.as_str() {
        "mat" => {
            let order = if views_first { MatOrder::LightFieldToolbox } else { MatOrder::Lenses };
            for_each_sample!(DynLightFieldRef, field, field =>
                holo_io::write_mat_light_field(&path, &field, rig.as_ref(), order, &MatOptions::default()))?;
            Ok(())
        }
        "h5" | "hdf5" => write_hdf5(&path, field, rig),
        "png" | "tif" | "tiff" | "exr" => {
            let layout = holo_io::layout_of_file_name(&path).ok_or_else(|| {
                let what = "end the name in _el (elemental images) or _vpi (views), such as scene_el.png";
                Failure::Usage(format!("{}: {what}", path.display()))
            })?;
            write_grid(&path, field, layout, is_srgb, ending == "exr")
        }
        _ => Err(Failure::Usage(format!(
            "{}: end the name in .h5, .mat, _el.png, _vpi.png, or the same with .tif or .exr",
            path.display()
        ))),
    })
}

#[cfg(feature = "hdf5")]
fn write_hdf5(path: &PathBuf, field: DynLightFieldRef<'_>, rig: Option<holo_core::Rig>) -> Result<(), Failure> {
    let rig = rig.ok_or_else(|| Failure::Usage("HDF5 files contain a rig; give one".into()))?;
    let options = holo_io::Hdf5Options::default();
    for_each_sample!(DynLightFieldRef, field, field => holo_io::write_hdf5(path, &field, &rig, &[], &[], &options))?;
    Ok(())
}

#[cfg(not(feature = "hdf5"))]
fn write_hdf5(_: &PathBuf, _: DynLightFieldRef<'_>, _: Option<holo_core::Rig>) -> Result<(), Failure> {
    Err(Failure::Usage("this build of holo has no HDF5; install it with pip, whose wheels have it".into()))
}

fn write_grid(
    path: &PathBuf,
    field: DynLightFieldRef<'_>,
    layout: Layout,
    is_srgb: bool,
    is_exr: bool,
) -> Result<(), Failure> {
    if is_exr {
        let DynLightFieldRef::F32(field) = field else {
            return Err(Failure::Usage("OpenEXR files are linear; save the light field of linear()".into()));
        };
        let image = grid(&field, layout)?;
        let (rows, columns, channels) = image.dim();
        let names: &[&str] = if channels == 1 { &["Y"] } else { &["R", "G", "B"] };
        let channels: Vec<_> = names.iter().map(|name| (*name, ExrSamples::Float)).collect();
        let mut exr = ExrWriter::create(path, GridSize::new(rows, columns), &channels, ExrCompression::Zip)?;
        let planes: Vec<_> = (0..names.len()).map(|channel| image.index_axis(Axis(2), channel)).collect();
        exr.write_rows(&planes)?;
        exr.finish()?;
        return Ok(());
    }
    let encoding = if is_srgb { ColorEncoding::Srgb } else { ColorEncoding::Linear };
    let image: DynImage = match field {
        DynLightFieldRef::U8(field) => grid(&field, layout)?.into(),
        DynLightFieldRef::U16(field) => grid(&field, layout)?.into(),
        _ => return Err(Failure::Usage("PNG and TIFF files hold integers; save the light field of encode()".into())),
    };
    if path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("png")) {
        holo_io::write_png(path, image.as_image_ref(), encoding, Compression::Best)?;
    } else {
        holo_io::write_image(path, image.as_image_ref())?;
    }
    Ok(())
}

/// Writes a folder of the HCI benchmark; the maps, if there are any, are those of the central view, axes (row, column).
#[pyfunction]
pub fn write_hci(
    py: Python<'_>,
    folder: PathBuf,
    field: Field<'_>,
    rig: Rig,
    disparity_px: Option<PyReadonlyArray2<'_, f32>>,
    depth_m: Option<PyReadonlyArray2<'_, f32>>,
) -> Result<(), Failure> {
    let views = field.borrow()?;
    let (disparity_px, depth_m) = (disparity_px.as_ref(), depth_m.as_ref());
    let (disparity_px, depth_m) = (disparity_px.map(|map| map.as_array()), depth_m.map(|map| map.as_array()));
    let mut parameters = ParametersCfg::from_rig(&rig.0);
    if let Some(map) = &disparity_px {
        let finite = || map.iter().filter(|value| value.is_finite()).map(|&value| f64::from(value));
        let (min, max) = (finite().fold(f64::INFINITY, f64::min), finite().fold(-f64::INFINITY, f64::max));
        if min <= max {
            parameters.set_disparity_range_px(min, max);
        }
    }
    let image = HciImage {
        views: Some(views),
        parameters: &parameters,
        disparity_px: disparity_px.map_or(HciTruth::None, HciTruth::Central),
        depth_m: depth_m.map_or(HciTruth::None, HciTruth::Central),
        high_resolution: None,
    };
    std::fs::create_dir_all(&folder).map_err(|why| Failure::Failed(format!("{}: {why}", folder.display())))?;
    py.detach(|| image.write(&folder, Compression::Best))?;
    Ok(())
}

/// Writes an image: integers into PNG or TIFF, floats into PFM.
#[pyfunction]
pub fn write_image(py: Python<'_>, path: PathBuf, image: Image<'_>) -> Result<(), Failure> {
    let image = image.borrow();
    py.detach(|| holo_io::write_image(&path, image))?;
    Ok(())
}

/// Reads a PNG, PFM or OpenEXR image (its colors), axes (row, column, channel).
#[pyfunction]
pub fn read_image(py: Python<'_>, path: PathBuf) -> Result<Bound<'_, PyAny>, Failure> {
    use holo_io::FileFormat;

    let limits = Limits::default();
    Ok(match holo_io::detect_format(&path)? {
        FileFormat::Pfm => {
            let pfm = py.detach(|| holo_io::read_pfm(&path, &limits))?;
            give(py, pfm.values)
        }
        FileFormat::Exr => give(py, py.detach(|| holo_io::read_exr_rgb(&path, &limits))?),
        FileFormat::Tiff | FileFormat::Dng => give_image(py, py.detach(|| holo_io::read_tiff(&path, &limits))?),
        _ => {
            let image: DynImage = py.detach(|| holo_io::read_png(&path, &limits))?;
            give_image(py, image)
        }
    })
}

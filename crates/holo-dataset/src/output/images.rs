//! Writes the color of a render: raw PNGs, 5D arrays, EXR and HCI folders.
//!
//! HDF5, EXR and PFM contain linear radiance. Exposure and the sRGB curve are applied for all integers.

use holo_core::{Layout, LightField, LightFieldOwned, Rig, Sample};
use holo_io::{
    ColorEncoding, Compression, FolderFile, HciHighResolution, HciImage, HciTruth, MatOptions, ParametersCfg, dataset,
};
use holo_render::{GroundTruth, Layer, Rendered, exposure};
use ndarray::{Array2, Array3, ArrayView3, Axis};

use super::folder::OutputFolder;
use super::statistics::ColorStatistics;
use super::wanted::Wanted;
use super::{codes, exr, layers, subset};
use crate::Error;
use crate::settings::{Output, OutputSettings, ViewSubset};

/// The resolution of ground truth of high resolution, relative to that of a view: the scale at which the evaluation
/// toolkit of the HCI benchmark scores.
pub(crate) const HIGHRES_SCALE: usize = 10;

/// What determines how color is written.
pub(crate) struct Images<'a> {
    pub settings: &'a OutputSettings,
    /// The views that were rendered, if not all.
    pub subset: Option<&'a ViewSubset>,
    /// The image sensor whose codes are written too.
    pub sensor: Option<codes::Exposing>,
    pub outputs: &'a [Output],
    pub rig: &'a Rig,
    pub parameters: &'a ParametersCfg,
    /// Depth of the central view in [`HIGHRES_SCALE`] times the resolution, m.
    pub highres_depth_m: Option<&'a Array2<f32>>,
}

impl Images<'_> {
    /// Writes all outputs that contain color; returns the statistics of the integers, if there are any.
    pub fn write(
        &self,
        folder: &mut OutputFolder,
        wanted: &Wanted,
        rendered: &mut Rendered,
        exposure_ev: Option<f64>,
    ) -> Result<Option<ColorStatistics>, Error> {
        if self.wants(Output::Exr) {
            exr::write_central(folder, rendered)?;
            let grids = [(Output::El, Layout::ElementalGrid), (Output::Vpi, Layout::ViewpointGrid)];
            for (_, layout) in grids.into_iter().filter(|(output, _)| self.wants(*output)) {
                if let Some(color) = &rendered.color {
                    exr::write_grid(folder, color, layout)?;
                }
            }
        }
        let all = self.settings.ground_truth == GroundTruth::All;
        if let Some(color) = rendered.color.as_ref().filter(|_| wanted.color) {
            layers::write_views(folder, layers::COLOR, color, all)?;
        }
        if let Some(error) = rendered.error.take() {
            layers::write_views(folder, layers::ERROR, &error, all)?;
        }
        if self.wants(Output::H5) {
            self.write_hdf5(folder, rendered)?;
        }
        if let (Some(color), Some(exposing)) = (&rendered.color, self.sensor) {
            codes::write(folder, color, exposing)?;
        }
        // Radiance takes four times the memory of 8-bit codes, so it is dropped as soon as it is encoded.
        if let (Some(color), Some(ev)) = (rendered.color.take(), exposure_ev) {
            if self.settings.bit_depth == 16 {
                let coded = exposure::encode_16bit(&color, ev)?;
                drop(color);
                self.write_coded(folder, &coded, rendered)?;
                return Ok(Some(ColorStatistics::new(&coded)));
            }
            let coded = exposure::encode_8bit(&color, ev)?;
            drop(color);
            self.write_coded(folder, &coded, rendered)?;
            return Ok(Some(ColorStatistics::new(&coded)));
        }
        if self.wants_hci() {
            self.write_hci::<u8>(folder, None, rendered)?;
        }
        Ok(None)
    }

    fn wants_hci(&self) -> bool {
        self.wants(Output::Hci) || self.wants(Output::HciHighres)
    }

    fn wants(&self, output: Output) -> bool {
        self.outputs.contains(&output)
    }

    /// Writes the files of integers, in parallel.
    fn write_coded<T: Sample>(
        &self,
        folder: &mut OutputFolder,
        coded: &LightFieldOwned<T>,
        rendered: &Rendered,
    ) -> Result<(), Error> {
        if let Some(views) = self.subset {
            let views = views.views(self.rig.shape().views());
            return subset::write(folder, coded, &views, self.parameters);
        }
        let write_png = |path: FolderFile, image: ArrayView3<T>| {
            holo_io::write_png(path, image, ColorEncoding::Srgb, Compression::Best)
        };
        let write_copy =
            |path: FolderFile, image: Result<Array3<T>, holo_core::Error>| Ok(write_png(path, image?.view())?);
        let elemental = || {
            let path = self.wants(Output::El).then(|| folder.file(dataset::ELEMENTAL_PNG))?;
            Some(match coded.as_elemental_grid() {
                Some(image) => write_png(path, image).map_err(Error::from),
                None => write_copy(path, coded.to_elemental_grid()),
            })
        };
        let viewpoint = || {
            let path = self.wants(Output::Vpi).then(|| folder.file(dataset::VIEWPOINT_PNG))?;
            Some(write_copy(path, coded.to_viewpoint_grid()))
        };
        let mat = || {
            let path = self.wants(Output::Mat).then(|| folder.file(dataset::LIGHT_FIELD_MAT))?;
            let (order, options) = (self.settings.mat_order, MatOptions::default());
            Some(holo_io::write_mat_light_field(path, coded, Some(self.rig), order, &options).map_err(Error::from))
        };
        let ((elemental, viewpoint), mat) = rayon::join(|| rayon::join(elemental, viewpoint), mat);
        let names = [dataset::ELEMENTAL_PNG, dataset::VIEWPOINT_PNG, dataset::LIGHT_FIELD_MAT];
        for (name, written) in names.into_iter().zip([elemental, viewpoint, mat]) {
            if let Some(written) = written {
                folder.add(name, written?);
            }
        }
        if self.wants_hci() {
            self.write_hci(folder, Some(coded), rendered)?;
        }
        Ok(())
    }

    /// Writes an HCI folder, with ground truth of all views if it was rendered, else of the central view; without views
    /// ground truth alone.
    fn write_hci<T: Sample>(
        &self,
        folder: &mut OutputFolder,
        views: Option<&LightFieldOwned<T>>,
        rendered: &Rendered,
    ) -> Result<(), Error> {
        let truth = |layer: Layer| {
            Ok::<_, Error>(match &rendered.all {
                Some(all) => HciTruth::All(LightField::new(all[layer].samples())?),
                None => HciTruth::Central(rendered.central[layer].index_axis(Axis(2), 0)),
            })
        };
        // The HCI tools need these keys too. Their preview of the frustum shows the range of the scene here.
        let mut parameters = self.parameters.clone();
        (parameters.frustum_disp_min, parameters.frustum_disp_max) = (parameters.disp_min, parameters.disp_max);
        let highres_px = self.highres_depth_m.map(|depth_m| self.rig.disparity().map_from_depth_m(depth_m));
        if highres_px.is_some() {
            parameters.depth_map_scale = Some(HIGHRES_SCALE as f64);
        }
        let high_resolution = self.highres_depth_m.zip(highres_px.as_ref());
        let image = HciImage {
            views: views.map(|views| views.as_light_field_ref().into()),
            parameters: &parameters,
            disparity_px: truth(Layer::Disparity)?,
            depth_m: truth(Layer::Depth)?,
            high_resolution: high_resolution.map(|(depth_m, disparity_px)| HciHighResolution {
                disparity_px: disparity_px.view(),
                depth_m: depth_m.view(),
            }),
        };
        let inner = folder.subfolder(dataset::HCI_FOLDER)?;
        let name = |file: &str| format!("{}/{file}", dataset::HCI_FOLDER);
        // Registered before they are written, so that an interrupted run removes them.
        image.file_names().iter().for_each(|file| drop(folder.file(&name(file))));
        let written = image.write_in(&inner, Compression::Best)?;
        written.into_iter().for_each(|(file, written)| folder.add(name(&file), written));
        Ok(())
    }

    /// Writes linear radiance, if there is any, and the rendered maps: of all views if there are any, else of the central
    /// view.
    #[cfg(feature = "hdf5")]
    fn write_hdf5(&self, folder: &mut OutputFolder, rendered: &Rendered) -> Result<(), Error> {
        use holo_io::{Hdf5Map, Hdf5Options};

        let kind = |layer: Layer| match layer {
            Layer::Depth => Some(Hdf5Map::Depth),
            Layer::RayLength => Some(Hdf5Map::RayLength),
            Layer::Disparity => Some(Hdf5Map::Disparity),
            _ => None,
        };
        let all = rendered.all.iter().flat_map(holo_render::Layers::iter);
        let maps: Vec<_> = all
            .filter_map(|(layer, field)| Some((kind(layer)?, field.samples().index_axis_move(Axis(4), 0))))
            .collect();
        let central = rendered.central.iter().filter(|_| maps.is_empty());
        let central: Vec<_> =
            central.filter_map(|(layer, image)| Some((kind(layer)?, image.index_axis(Axis(2), 0)))).collect();
        let (name, rig) = (dataset::LIGHT_FIELD_HDF5, self.rig);
        let options = Hdf5Options::default();
        let path = folder.file(name);
        folder.add(
            name,
            match &rendered.color {
                Some(color) => holo_io::write_hdf5(path, color, rig, &maps, &central, &options)?,
                None => holo_io::write_hdf5_maps(path, rig, &maps, &central, &options)?,
            },
        );
        Ok(())
    }

    #[cfg(not(feature = "hdf5"))]
    fn write_hdf5(&self, _: &mut OutputFolder, _: &Rendered) -> Result<(), Error> {
        Err(super::wanted::without_hdf5())
    }
}

//! A light field at a pose, whose views are cameras.

use std::path::PathBuf;
use std::sync::{Arc, Mutex};

use holo_core::{LightFieldOwned, Pinhole, Rig, SampleKind};
use ndarray::{Array2, Array3};

use crate::cameras::transforms::ArrayCamera;
use crate::{Error, LightFieldReader, Limits, ReadOptions};

/// A light field at a pose. Its samples are read when a view of it is needed, and kept until those of another one are.
#[derive(Debug, Clone)]
pub(super) struct PosedField {
    path: PathBuf,
    rig: Rig,
    axes_and_position: [[f64; 3]; 4],
    reader: Arc<LightFieldReader>,
}

/// The light field that was read last, with its number.
#[derive(Debug, Default)]
pub(super) struct LastRead(Mutex<Option<(usize, Arc<LinearField>)>>);

#[derive(Debug)]
pub(super) struct LinearField {
    pub light_field: LightFieldOwned<f32>,
    pub kind: SampleKind,
}

impl PosedField {
    /// Opens the light field of a folder at the pose of a camera.
    pub fn open(path: PathBuf, camera: &ArrayCamera) -> Result<Self, Error> {
        let reader = LightFieldReader::open(&path, &ReadOptions::default())?;
        let Some(&rig) = reader.rig() else {
            let what = "its camera is unknown, so its views have no place; put its parameters.cfg there";
            return Err(Error::unsupported(&path, what));
        };
        Ok(Self { path, rig, axes_and_position: camera.axes_and_position, reader: Arc::new(reader) })
    }

    pub fn rig(&self) -> &Rig {
        &self.rig
    }

    pub fn pinhole(&self, (t, s): (usize, usize)) -> Result<Pinhole, holo_core::Error> {
        let [x, y, z, position_m] = self.axes_and_position;
        self.rig.pinhole(t, s, [x, y, z], position_m)
    }

    /// The image of a view, from the light field with this number.
    pub fn image(
        &self,
        number: usize,
        (t, s): (usize, usize),
        last: &LastRead,
        limits: &Limits,
    ) -> Result<Array3<f32>, Error> {
        Ok(self
            .light(number, last, limits)?
            .light_field
            .view(t, s)
            .map_err(|why| Error::core(&self.path, why))?
            .to_owned())
    }

    /// All views in linear light.
    pub fn light(&self, number: usize, last: &LastRead, limits: &Limits) -> Result<Arc<LinearField>, Error> {
        let mut light = last.0.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        if let Some((_, light)) = light.as_ref().filter(|(held, _)| *held == number) {
            return Ok(Arc::clone(light));
        }
        // One at a time in memory.
        *light = None;
        let file = LightFieldReader::open(&self.path, &ReadOptions::default().limits(*limits))?.read()?;
        let kind = file.light_field.kind();
        let light_field = file.into_linear().map_err(|why| Error::core(&self.path, why))?;
        let read = Arc::new(LinearField { light_field, kind });
        *light = Some((number, Arc::clone(&read)));
        Ok(read)
    }

    /// The depth of a view, if the files have it.
    pub fn depth_m(&self, view: (usize, usize)) -> Result<Option<Array2<f32>>, Error> {
        self.reader.depth_m_of_view(view)
    }
}

//! Images of the benchmark as a sensor records them, with noise and without.

use holo_core::ColorEncoding;
use holo_core::sensor::{Exposure, SensorModel};
use holo_io::Compression;
use ndarray::{Array2, Array3, ArrayView3, Axis};

use crate::Error;
use crate::output::OutputFolder;

/// The share of a full well that the brightest pixel of a white image fills.
const FILLED: f64 = 0.9;

/// A sensor in gray.
pub(super) struct Recorder {
    sensor: SensorModel,
    /// The brightest value of the white image.
    pub brightest: f32,
}

impl Recorder {
    pub fn new(sensor: SensorModel, white: &Array2<f32>) -> Self {
        let brightest = white.iter().fold(f32::MIN_POSITIVE, |most, &light| most.max(light));
        Self { sensor, brightest }
    }

    /// Writes `NAME.png` and `NAME_noisy.png`, and for COMPOTE the same in 8 bits of color.
    pub fn write(&self, folder: &mut OutputFolder, name: &str, frame: u64, image: &Array3<f32>) -> Result<(), Error> {
        folder.subfolder("compote")?;
        // Boards are gray.
        let gray = image.slice_axis(Axis(2), (0..1).into());
        let exposure = Exposure {
            electrons_at_one: FILLED * self.sensor.saturation_e(self.sensor.base_iso) / f64::from(self.brightest),
            time_s: 0.0,
            iso: self.sensor.base_iso,
            camera_seed: 0,
            seed: 0,
            frame,
        };
        let codes = self.sensor.expose(gray, &exposure, 1)?;
        let (black, white) = (self.sensor.black, f64::from(self.sensor.white()));
        let seen = codes.mapv(|code| ((f64::from(code) - black) / (white - black)) as f32);
        let clean = gray.mapv(|value| (65_535.0 * value).round().clamp(0.0, 65_535.0) as u16);
        for (noise, codes, image) in [("", clean, gray), ("_noisy", codes, seen.view())] {
            let mut write = |name: String, image: holo_core::DynImageRef<'_>| -> Result<(), Error> {
                let path = folder.file(&name);
                folder.add(name, holo_io::write_png(path, image, ColorEncoding::Linear, Compression::Fast)?);
                Ok(())
            };
            write(format!("{name}{noise}.png"), codes.view().into())?;
            write(format!("compote/{name}{noise}.png"), color(image).view().into())?;
        }
        Ok(())
    }
}

/// Gray as 8 bits of red, green and blue.
fn color(gray: ArrayView3<f32>) -> Array3<u8> {
    let (rows, columns, _) = gray.dim();
    let code = |(row, column, _)| (255.0 * gray[[row, column, 0]]).round().clamp(0.0, 255.0) as u8;
    Array3::from_shape_fn((rows, columns, 3), code)
}

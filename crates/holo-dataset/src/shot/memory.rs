//! The memory that a render needs, checked before it begins.

use holo_core::{GridSize, LightFieldShape};

use crate::Error;
use crate::output::{Wanted, is_room};
use crate::settings::RenderSettings;

/// Allocates the memory that a render needs and frees it untouched, so that impossible sizes are refused first.
pub(super) fn validate_memory(
    shape: &LightFieldShape,
    settings: &RenderSettings,
    wanted: &Wanted,
) -> Result<(), Error> {
    /// Room for tables over the rows and columns of lenses and views.
    const LINE_BYTES: usize = 64;
    let (views, lenses, raw) = (shape.views(), shape.lenses(), shape.raw_size());
    let lines = [views.rows, views.columns, lenses.rows, lenses.columns];
    let [sample_bytes, lens_bytes] = memory(settings, wanted);
    let bytes = lines.iter().map(|count| count.saturating_mul(LINE_BYTES)).fold(
        shape.sample_count().saturating_mul(sample_bytes).saturating_add(lenses.count().saturating_mul(lens_bytes)),
        usize::saturating_add,
    );
    if !is_room(bytes) {
        return Err(Error::OutOfMemory(format!(
            "a light field of {} x {} views of {} x {} px ({} x {} in all) needs {:.0} GB of memory, more than there \
             is; use fewer views or lenses",
            views.columns,
            views.rows,
            lenses.columns,
            lenses.rows,
            raw.columns,
            raw.rows,
            bytes as f64 / 1e9
        )));
    }
    Ok(())
}

/// The same for the raw image of a plenoptic camera.
pub(super) fn validate_raw_memory(size: GridSize, settings: &RenderSettings, wanted: &Wanted) -> Result<(), Error> {
    let bytes = size.count().saturating_mul(raw_memory(settings, wanted));
    if is_room(bytes) {
        return Ok(());
    }
    Err(Error::OutOfMemory(format!(
        "a raw image of {} x {} px needs {:.0} GB of memory, more than there is; use a smaller sensor",
        size.columns,
        size.rows,
        bytes as f64 / 1e9
    )))
}

/// What is known of a pixel beside its color: how far its samples disagree, its disparity, their number.
const GUIDES: usize = 3;

/// The memory that a raw image needs of every pixel, bytes.
fn raw_memory(settings: &RenderSettings, wanted: &Wanted) -> usize {
    /// Weight, hits, mean and spread of the inverse depth.
    const STATISTICS: usize = 4;
    /// The samples of a pixel, and the microlens that owns it.
    const SOURCE: usize = 8;
    // The white image is always computed.
    let white = 1;
    let color = if wanted.integrator == holo_render::Integrator::Depth { 0 } else { 3 };
    let is_denoised = settings.light.denoise == holo_render::Denoise::Views;
    let has_guides = color > 0 && (is_denoised || wanted.error);
    let statistics = usize::from(has_guides || wanted.raw.iter().any(|layer| layer.needs_samples())) * STATISTICS;
    let guides = if has_guides { GUIDES + SOURCE } else { 0 };
    // In rounds the values of all packets stay in memory. Some packets have fewer pixels than lanes.
    let is_in_rounds = has_guides && is_denoised && settings.light.target_error.is_some();
    let rounds = if is_in_rounds { (color + GUIDES + STATISTICS) * 5 / 4 } else { 0 };
    let error = usize::from(wanted.error || is_in_rounds);
    (white + color + statistics + guides + rounds + error + wanted.central.channels()) * size_of::<f32>()
}

/// The memory that a render needs: of every sample of the light field, and of every pixel of the central view, bytes.
fn memory(settings: &RenderSettings, wanted: &Wanted) -> [usize; 2] {
    let light = &settings.light;
    let color = if wanted.integrator == holo_render::Integrator::Depth { 0 } else { 3 };
    let is_denoised = light.denoise == holo_render::Denoise::Views;
    let error = usize::from(wanted.error || is_denoised && light.target_error.is_some());
    let guides = if color > 0 && (is_denoised || wanted.error) { GUIDES + error } else { 0 };
    [color + guides + wanted.all.channels(), wanted.central.channels()].map(|floats| floats * size_of::<f32>())
}

//! `holo array`: cameras on a plane, a cylinder or a sphere, for `holo render --transforms`.

use holo_core::CameraJitter;
use holo_dataset::{Placement, Surface, jittered};

use crate::arguments::{ArrayOptions, SurfaceArgument};
use crate::console::say;
use crate::failure::Failure;

pub fn run(options: &ArrayOptions) -> Result<(), Failure> {
    let count = options.count;
    let surface = match options.surface {
        SurfaceArgument::Plane => Surface::Plane { count, spacing_m: options.spacing_m },
        SurfaceArgument::Cylinder => {
            Surface::Cylinder { count, span_rad: options.span_deg.to_radians(), spacing_m: options.spacing_m[0] }
        }
        SurfaceArgument::Sphere if count.rows > 1 => {
            return Err(Failure::Usage("--count of a sphere is one number: its cameras are in no rows".into()));
        }
        SurfaceArgument::Sphere => {
            let (low, high) = options.elevation_deg;
            Surface::Sphere { count: count.columns, elevation_rad: [low.to_radians(), high.to_radians()] }
        }
    };
    let focal_px = Placement::focal_px(options.size.columns, options.angle_deg.to_radians())?;
    let (target_m, radius_m, size) = (options.target_m, options.radius_m, options.size);
    let meant = Placement { surface, target_m, radius_m, size, focal_px }.cameras()?;
    let jitter = CameraJitter {
        position_m: options.jitter_position_m,
        rotation_rad: options.jitter_rotation_deg.to_radians(),
        focal: options.jitter_focal,
        gain: options.jitter_gain,
        color: options.jitter_color,
        time_s: options.jitter_time_s,
    };
    let array = jittered(meant, &jitter, options.seed)?;
    array.write(&options.out, options.transforms_up)?;
    say!("wrote {} ({} cameras): see `holo render --transforms`", options.out.display(), array.cameras.len());
    Ok(())
}

//! `holo preview`: a scene live in a browser.

use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use holo_dataset::SceneSource;
use holo_io::{CameraArray, WorldUp};
use holo_preview::Preview;

use crate::arguments::{PreviewOptions, open_camera};
use crate::console::{out, say};
use crate::failure::Failure;
use crate::interrupt;

pub fn run(options: &PreviewOptions) -> Result<(), Failure> {
    if let Some(scene) = &options.scene {
        // A page cannot say so as soon.
        let source = SceneSource::file(scene);
        source.load(&Default::default()).map_err(|why| Failure::Failed(why.to_string()))?;
    }
    let mut given = options.settings.given().clone();
    if let Some(preset) = options.preset {
        given = given.over(preset.given());
    }
    let camera = options.camera_file.as_deref().map(open_camera).transpose()?;
    let poses = options.transforms.as_deref().map(|path| read_poses(path, options.transforms_up)).transpose()?;
    let preview = Preview::new()
        .scene(options.scene.as_ref().map(SceneSource::file))
        .camera(camera)
        .poses(poses)
        .given(given)
        .out(std::path::absolute(&options.out).unwrap_or_else(|_| options.out.clone()))
        .rollback(interrupt::rollback())
        .engine(options.engine.settings())
        .listen(options.listen);
    let server = preview.bind(options.port).map_err(|why| Failure::Failed(why.to_string()))?;
    let address = server.address();
    out!("{address}")?;
    if options.no_open {
        say!("open this address in a browser; Ctrl-C ends the preview");
    } else if let Err(why) = open::that_detached(&address) {
        say!("note: no browser could be opened ({why}); open the address above yourself");
    }
    let stop = AtomicBool::new(false);
    std::thread::scope(|scope| {
        scope.spawn(|| {
            while !stop.load(Ordering::SeqCst) {
                if interrupt::requested() {
                    stop.store(true, Ordering::SeqCst);
                }
                std::thread::sleep(Duration::from_millis(20));
            }
        });
        let served = server.run(&stop);
        stop.store(true, Ordering::SeqCst);
        served
    })
    .map_err(|why| Failure::Failed(why.to_string()))
}

/// The poses of a file. Its axes may be rounded, but neither scaled nor mirrored.
fn read_poses(path: &Path, up: WorldUp) -> Result<CameraArray, Failure> {
    let mut poses = CameraArray::read(path, up, None)?;
    for camera in &mut poses.cameras {
        let [x, y, z, position_m] = camera.axes_and_position;
        let [x, y, z] = holo_core::rotation_near([x, y, z]).map_err(|why| {
            let (path, name) = (path.display(), holo_core::visible(&camera.name));
            Failure::Failed(format!("{path}: camera '{name}': {why}"))
        })?;
        camera.axes_and_position = [x, y, z, position_m];
    }
    Ok(poses)
}

//! Every error of every library: a message with all causes in it, and a chain of causes that repeats none of them.

use std::error::Error;
use std::io;
use std::path::PathBuf;

use holo_core::GridSize;

/// The messages of an error and its causes.
fn chain(error: &dyn Error) -> Vec<String> {
    let mut messages = Vec::new();
    let mut next = Some(error);
    while let Some(error) = next {
        messages.push(error.to_string());
        next = error.source();
    }
    messages
}

fn check(error: &dyn Error) {
    let messages = chain(error);
    assert!(!messages[0].is_empty(), "{error:?}");
    for (index, message) in messages.iter().enumerate() {
        for cause in &messages[index + 1..] {
            assert!(!message.contains(cause.as_str()), "{error:?} says '{cause}' twice");
        }
    }
}

fn core_errors() -> Vec<holo_core::Error> {
    use holo_core::Error as E;
    let (what, size) = ("thing", GridSize::new(2, 3));
    vec![
        E::ZeroCount { what },
        E::TooLarge { what },
        E::OutOfMemory { what, bytes: 7 },
        E::Shape { what, expected: vec![1], found: vec![2] },
        E::OutOfRange { what, index: 3, count: 2, first: 0 },
        E::BadRange { what, start: 1, end: 1, count: 4 },
        E::NotDense { shape: vec![1], strides: vec![2] },
        E::NotDivisible { sensor: size, views: size, border: size },
        E::SensorTooSmall { sensor: size, views: size },
        E::BadNumber { what, value: f64::NAN, need: "finite" },
        E::OrthographicFocus { focus_distance_m: f64::INFINITY },
        E::NoBaseline,
        E::TooManyPlanes { low_px: -1.0, high_px: 1.0, planes: 5000, most: 4096 },
        E::NothingToMeasure { what, shape: [2, 2], border_px: 1 },
        E::ImpossibleRange { why: "reason" },
    ]
}

fn io_errors() -> Vec<holo_io::Error> {
    use holo_io::Error as E;
    let path = || PathBuf::from("some/file");
    let mut errors = vec![
        E::Broken { path: path(), format: "PFM", what: "reason".into() },
        E::Unsupported { path: path(), what: "reason".into() },
        E::TooLarge { path: path(), what: "image", needed: 9, allowed: 8 },
        E::OutOfMemory { path: path(), what: "image", bytes: 9 },
        E::BadInput { path: path(), what: "reason".into() },
        E::MissingOption { path: path(), option: "views", what: "reason".into() },
        E::NoLightField { path: path(), what: "reason".into() },
    ];
    for kind in [io::ErrorKind::NotFound, io::ErrorKind::StorageFull, io::ErrorKind::PermissionDenied] {
        errors.push(E::Io { action: "write", path: path(), error: kind.into() });
        errors.push(E::Io { action: "read", path: path(), error: io::Error::other(io::Error::from(kind)) });
    }
    errors.extend(core_errors().into_iter().map(|error| E::Core { path: path(), error }));
    errors
}

fn render_errors() -> Vec<holo_render::Error> {
    use holo_render::Error as E;
    let mut errors = vec![E::BadSetting("reason".into()), E::Embree("reason".into()), E::Cancelled];
    errors.extend(core_errors().into_iter().map(E::Core));
    errors.extend(scene_errors().into_iter().map(E::Scene));
    errors
}

fn scene_errors() -> Vec<holo_scene::Error> {
    use holo_scene::Error as E;
    let (at, what) = (|| "meshes[2]".to_owned(), || "reason".to_owned());
    vec![
        E::Read { path: "scene.glb".into(), error: std::io::ErrorKind::PermissionDenied.into() },
        E::BadFile { at: at(), what: what() },
        E::Unsupported { at: at(), what: what() },
        E::BadScene { at: at(), what: what() },
    ]
}

#[test]
fn no_cause_is_said_twice() {
    core_errors().iter().for_each(|error| check(error));
    scene_errors().iter().for_each(|error| check(error));
    render_errors().iter().for_each(|error| check(error));
    io_errors().iter().for_each(|error| check(error));
    check(&"3x".parse::<GridSize>().unwrap_err());
    for error in io_errors() {
        check(&holo_viewer::Error::Io(error));
    }
    for error in io_errors() {
        check(&holo_dataset::Error::Io(error));
    }
    for error in render_errors() {
        check(&holo_viewer::Error::Render(error));
    }
    for error in render_errors() {
        check(&holo_dataset::Error::Render(error));
    }
    for error in core_errors() {
        check(&holo_viewer::Error::Core(error.clone()));
        check(&holo_dataset::Error::Core(error));
    }
    for error in scene_errors() {
        check(&holo_dataset::Error::Scene(error));
    }
    let (view, found) = (GridSize::new(2, 3), GridSize::new(3, 2));
    check(&holo_viewer::Error::TooLarge { size: view });
    check(&holo_viewer::Error::EstimateSize { view, found });
    check(&holo_dataset::Error::BadRequest("reason".into()));
    check(&holo_dataset::Error::Failed("reason".into()));
}

/// The cause is in the message, once, also where a program prints the chain.
#[test]
fn messages_are_complete() {
    let system = io::Error::from(io::ErrorKind::NotFound).to_string();
    let error = holo_io::read_png("no/such/file.png", &holo_io::Limits::default()).unwrap_err();
    assert_eq!(chain(&error).len(), 1, "{error}");
    let error = holo_io::Error::Io { action: "read", path: "x".into(), error: io::ErrorKind::NotFound.into() };
    assert_eq!(chain(&holo_dataset::Error::Io(error)), [format!("cannot read x: {system}")]);
}

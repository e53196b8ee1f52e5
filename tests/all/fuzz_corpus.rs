//! The fuzz targets on their corpora, on the stable toolchain: regression tests for the findings of libFuzzer.

use std::path::Path;

fn run(target: &str, function: fn(&[u8])) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz").join("corpus").join(target);
    let mut count = 0;
    for entry in std::fs::read_dir(&folder).expect("the corpus is part of the project") {
        let path = entry.expect("a readable folder").path();
        let bytes = std::fs::read(&path).expect("a readable file");
        // Whole, and truncated at several lengths.
        for length in [bytes.len(), bytes.len() / 2, bytes.len().saturating_sub(1), bytes.len().min(13)] {
            function(&bytes[..length]);
        }
        count += 1;
    }
    assert!(count >= 3, "{}: {count} files", folder.display());
}

#[test]
fn gltf() {
    run("gltf", holo_fuzz::gltf);
}

#[test]
fn draco() {
    run("draco", holo_fuzz::draco);
}

#[test]
fn meshopt() {
    run("meshopt", holo_fuzz::meshopt);
}

#[test]
fn png() {
    run("png", holo_fuzz::io::png);
}

#[test]
fn pfm() {
    run("pfm", holo_fuzz::io::pfm);
}

#[test]
fn exr() {
    run("exr", holo_fuzz::io::exr);
}

#[test]
fn hdr() {
    run("hdr", holo_fuzz::io::hdr);
}

#[test]
fn tiff() {
    run("tiff", holo_fuzz::io::tiff);
}

#[test]
fn mat() {
    run("mat", holo_fuzz::io::mat);
}

#[cfg(feature = "hdf5")]
#[test]
fn hdf5() {
    run("hdf5", holo_fuzz::hdf5);
}

#[test]
fn camera() {
    run("camera", holo_fuzz::io::camera);
}

#[test]
fn parameters_cfg() {
    run("parameters_cfg", holo_fuzz::io::parameters_cfg);
}

#[cfg(unix)]
#[test]
fn folder() {
    run("folder", holo_fuzz::folder);
}

#[test]
fn manifest() {
    run("manifest", holo_fuzz::io::manifest);
}

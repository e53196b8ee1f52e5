//! `.mat` files exchanged with GNU Octave in both directions.
//!
//! Needs `octave-cli`; without it the test says so and passes, or fails with `HOLO_REQUIRE_PEERS=1`.

use crate::python::peer;
use std::process::Command;

use holo_core::{DynLightField, GridSize, LightField, LightFieldShape, Rig, Sample};
use holo_io::{Limits, MatOptions, MatOrder, MatVersion, read_mat_light_field, write_mat_light_field};
use ndarray::Array5;

/// (v, u, t, s, c): all different, none square.
const SHAPE: (usize, usize, usize, usize, usize) = (4, 6, 2, 5, 3);

fn value((v, u, t, s, c): (usize, usize, usize, usize, usize)) -> u8 {
    ((v * 97 + u * 31 + t * 11 + s * 5 + c * 3) % 256) as u8
}

/// Prints what `load` returns, and saves the same numbers. Indices of MATLAB count from 1.
const SCRIPT: &str = r#"
args = argv();
load(args{1});
elemental = squeeze(H(2, 3, :, :, :));
view = squeeze(H(:, :, 2, 4, :));
printf("%s %s\n", class(H), mat2str(size(H)));
printf("elemental %s view %s\n", mat2str(size(elemental)), mat2str(size(view)));
[v, u, t, s, c] = ndgrid(0:3, 0:5, 0:1, 0:4, 0:2);
expected = mod(v * 97 + u * 31 + t * 11 + s * 5 + c * 3, 256);
printf("equal %d\n", all(double(H(:)) == expected(:)));
printf("elemental(1,5,2) %d view(4,6,3) %d\n", elemental(1, 5, 2), view(4, 6, 3));
printf("views %s lenses %s order %s focus %g\n", mat2str(views), mat2str(lenses), axis_order, focus_distance_m);
printf("baseline %s projection %s\n", mat2str(baseline_m), projection);
save("-v6", args{2}, "H");
save("-v7", args{3}, "H");
"#;

fn rig() -> Rig {
    Rig::builder(LightFieldShape::new(GridSize::new(SHAPE.2, SHAPE.3), GridSize::new(SHAPE.0, SHAPE.1)).unwrap())
        .focal_length_m(0.05)
        .sensor_size_m(0.036)
        .baseline_x_m(1e-3)
        .baseline_y_m(2e-3)
        .focus_distance_m(4.25)
        .build()
        .unwrap()
}

/// Writes a light field, lets Octave read and write it, and returns what it wrote with `-v6` and `-v7`.
fn through_octave<T: Sample>(class: &str, convert: fn(u8) -> T, is_compressed: bool) -> [DynLightField; 2] {
    let folder = tempfile::tempdir().unwrap();
    let names = ["ours.mat", "v6.mat", "v7.mat"].map(|name| folder.path().join(name));
    let field = LightField::new(Array5::from_shape_fn(SHAPE, |at| convert(value(at)))).unwrap();
    let options = MatOptions::new().version(MatVersion::V5).compressed(is_compressed);
    write_mat_light_field(&names[0], &field, Some(&rig()), MatOrder::Lenses, &options).unwrap();
    let script = folder.path().join("script.m");
    std::fs::write(&script, SCRIPT).unwrap();
    let output = Command::new("octave-cli")
        .args(["--quiet", "--no-history", "--norc"])
        .arg(&script)
        .args(&names)
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let expected = format!(
        "{class} [4 6 2 5 3]\nelemental [2 5 3] view [4 6 3]\nequal 1\nelemental(1,5,2) {} view(4,6,3) {}\nviews [2 5] lenses [4 6] order vutsc focus 4.25\nbaseline [0.002 0.001] projection perspective\n",
        value((1, 2, 0, 4, 1)),
        value((3, 5, 1, 3, 2)),
    );
    assert_eq!(String::from_utf8(output.stdout).unwrap(), expected);
    [&names[1], &names[2]].map(|path| read_mat_light_field(path, &Limits::default()).unwrap().light_field)
}

#[test]
fn octave_shows_elemental_images_and_views_and_its_own_files_are_read() {
    if Command::new("octave-cli").arg("--version").output().is_err() {
        peer::missing("octave-cli (Debian's package octave)");
        return;
    }
    macro_rules! round {
        ($type:ty, $class:literal, $variant:ident) => {
            for is_compressed in [false, true] {
                let expected = Array5::from_shape_fn(SHAPE, |at| <$type>::from(value(at)));
                for read in through_octave::<$type>($class, <$type>::from, is_compressed) {
                    assert_eq!(read, DynLightField::$variant(LightField::new(expected.clone()).unwrap()), $class);
                }
            }
        };
    }
    round!(u8, "uint8", U8);
    round!(u16, "uint16", U16);
    round!(f32, "single", F32);
    round!(f64, "double", F64);
}

/// Reads a folder with `matlab/holo_read.m` and prints what the structure holds.
const READ_FOLDER: &str = r#"
args = argv();
addpath(args{1});
field = holo_read(args{2});
printf("%s\n", strjoin(fieldnames(field)', " "));
if isempty(field.H)
  printf("no H\n");
else
  [v, u, t, s, c] = ndgrid(0:3, 0:5, 0:1, 0:4, 0:2);
  expected = mod(v * 97 + u * 31 + t * 11 + s * 5 + c * 3, 256);
  printf("%s %s equal %d\n", class(field.H), mat2str(size(field.H)), all(double(field.H(:)) == expected(:)));
end
rig = field.rig;
printf("views %s lenses %s baseline %s focus %g\n", mat2str(rig.views), mat2str(rig.lenses), mat2str(rig.baseline_m), ...
       rig.focus_distance_m);
printf("focal %g sensor %g %s\n", rig.focal_length_mm, rig.sensor_size_mm, rig.projection);
printf("depth %s %s %g %g\n", class(field.depth), mat2str(size(field.depth)), field.depth(1, 2), field.depth(4, 6));
printf("disparity %s\n", mat2str(size(field.disparity)));
"#;

/// The files of a render, one by one: whichever holds the light field, the structure is the same.
#[test]
fn holo_read_returns_light_field_rig_and_ground_truth() {
    use holo_io::{ColorEncoding, Compression, Manifest, dataset, write_pfm, write_png};

    if Command::new("octave-cli").arg("--version").output().is_err() {
        peer::missing("octave-cli (Debian's package octave)");
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    let read = || {
        let script = path("script.m");
        std::fs::write(&script, READ_FOLDER).unwrap();
        let output = Command::new("octave-cli")
            .args(["--quiet", "--no-history", "--norc"])
            .arg(&script)
            .arg(concat!(env!("CARGO_MANIFEST_DIR"), "/matlab"))
            .arg(folder.path())
            .output()
            .unwrap();
        (
            output.status.success(),
            String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr),
        )
    };
    let (is_read, message) = read();
    assert!(!is_read && message.contains("no manifest.json"), "{message}");

    let rig = rig().to_builder().focus_distance_m(f64::INFINITY).build().unwrap();
    Manifest { rig: Some(rig), ..Manifest::default() }.write(path(dataset::MANIFEST_JSON)).unwrap();
    // Depth 1, 2, 3 ... in reading order, and nothing in the last pixel.
    let depth = ndarray::Array2::from_shape_fn((4, 6), |(v, u)| match (v, u) {
        (3, 5) => f32::INFINITY,
        _ => (v * 6 + u) as f32 + 1.0,
    });
    write_pfm(path(dataset::DEPTH_PFM), depth.view()).unwrap();
    let field = LightField::new(Array5::from_shape_fn(SHAPE, value)).unwrap();
    let rest = "views [2 5] lenses [4 6] baseline [0.002 0.001] focus Inf\nfocal 50 sensor 36 perspective\n\
                depth single [4 6] 2 Inf\n";
    let check = |light_field: &str, disparity: &str| {
        let (is_read, message) = read();
        assert!(is_read, "{message}");
        assert_eq!(message, format!("rig H depth disparity\n{light_field}\n{rest}disparity {disparity}\n"));
    };
    check("no H", "[0 0]");
    write_pfm(path(dataset::DISPARITY_PFM), depth.view()).unwrap();
    let expected = "uint8 [4 6 2 5 3] equal 1";
    let png = |name: &str, grid: ndarray::Array3<u8>| {
        write_png(path(name), grid.view(), ColorEncoding::Srgb, Compression::Fast).unwrap();
    };
    png(dataset::VIEWPOINT_PNG, field.to_viewpoint_grid().unwrap());
    check(expected, "[4 6]");
    std::fs::remove_file(path(dataset::VIEWPOINT_PNG)).unwrap();
    png(dataset::ELEMENTAL_PNG, field.to_elemental_grid().unwrap());
    check(expected, "[4 6]");
    std::fs::remove_file(path(dataset::ELEMENTAL_PNG)).unwrap();
    for order in [MatOrder::Lenses, MatOrder::LightFieldToolbox] {
        let mat = path(dataset::LIGHT_FIELD_MAT);
        write_mat_light_field(&mat, &field, Some(&rig), order, &MatOptions::new()).unwrap();
        check(expected, "[4 6]");
    }
}

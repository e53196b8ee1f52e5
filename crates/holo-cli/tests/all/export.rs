//! `holo export`: what it writes has the values, names and orders that its readers' own code expects.

use crate::common::{Bench, Outcome, SCENE, read_u8};
use holo_core::LightFieldOwned;
use holo_io::{LightFieldReader, Limits, ReadOptions};

fn ok(outcome: Outcome) -> Outcome {
    assert_eq!(outcome.code, Some(0), "{outcome:?}");
    outcome
}

/// A folder of 9 x 9 views of 16 x 12 px, and its codes.
fn rendered(bench: &Bench) -> LightFieldOwned<u8> {
    ok(bench.run(&format!("render {SCENE} --out lf --views 9 --lenses 16x12 --disparity -1,1 --spp 1 --quiet")));
    match LightFieldReader::open(bench.path("lf"), &ReadOptions::default()).unwrap().read().unwrap().light_field {
        holo_core::DynLightField::U8(field) => field,
        other => panic!("{:?}", other.kind()),
    }
}

#[test]
fn hci_folders_have_views_truth_and_mask() {
    let bench = Bench::new();
    let field = rendered(&bench);
    let said = ok(bench.run("export lf --for hci --out out"));
    assert!(said.stderr.contains("512 x 512"), "{said:?}");
    // Nothing but the scene lies in the group.
    assert!(bench.list("out/training").iter().all(|name| name.starts_with("lf/")));
    for (k, (t, s)) in [(0, (0, 0)), (40, (4, 4)), (74, (8, 2))] {
        let view = read_u8(bench.path(format!("out/training/lf/input_Cam{k:03}.png")));
        assert_eq!(view, field.view(t, s).unwrap());
    }
    let truth = holo_io::read_pfm_gray(bench.path("lf/scene_disparity.pfm"), &Limits::default()).unwrap();
    let found = holo_io::read_pfm_gray(bench.path("out/training/lf/gt_disp_lowres.pfm"), &Limits::default()).unwrap();
    assert_eq!(found, truth);
    let (hits, mask) =
        (read_u8(bench.path("lf/scene_hit_mask.png")), read_u8(bench.path("out/training/lf/valid_mask.png")));
    assert_eq!(mask.dim(), (12, 16, 3));
    assert!(mask.indexed_iter().all(|((v, u, _), code)| *code == hits[[v, u, 0]]));
}

#[test]
fn arrays_have_views_first() {
    let bench = Bench::new();
    let field = rendered(&bench);
    ok(bench.run("export lf --for npy --out npy"));
    let bytes = std::fs::read(bench.path("npy/lf.npy")).unwrap();
    let length = 10 + usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
    let header = std::str::from_utf8(&bytes[10..length]).unwrap();
    assert!(header.contains("'shape': (9, 9, 12, 16, 3,)") && header.ends_with('\n') && length % 64 == 0, "{header}");
    let expected: Vec<u8> = field.samples().permuted_axes([2, 3, 0, 1, 4]).iter().copied().collect();
    assert_eq!(bytes[length..], expected);

    ok(bench.run("export lf --for jpeg-pleno --out ppm"));
    let view = std::fs::read(bench.path("ppm/lf/002_007.ppm")).unwrap();
    let pixels = view.strip_prefix(b"P6\n16 12\n255\n").unwrap();
    assert_eq!(pixels, field.view(2, 7).unwrap().iter().copied().collect::<Vec<u8>>());
    assert_eq!(bench.list("ppm").iter().filter(|name| name.ends_with(".ppm")).count(), 81);

    ok(bench.run("export lf --for basiclfsr --out sr --group EPFL"));
    let path = bench.path("sr/datasets/EPFL/training/lf.mat");
    let info = holo_io::read_mat_info(&path).unwrap();
    let variable = info.iter().find(|variable| variable.name == "LF").unwrap();
    assert_eq!((&variable.size[..], variable.class.name()), (&[9, 9, 12, 16, 3][..], "single"));
    let read = LightFieldReader::open(&path, &ReadOptions::default()).unwrap().read().unwrap().light_field;
    let read = read.into_f32().unwrap();
    assert!(read.samples().iter().zip(field.samples()).all(|(value, code)| *value == f32::from(*code) / 255.0));
}

#[test]
fn datasets_are_exported_whole_and_wrong_use_is_refused() {
    let bench = Bench::new();
    let line = format!("dataset --out set --scenes plaster --glb {SCENE} --views 9,2 --sensor 144x108 --spp 1 --quiet");
    ok(bench.run(&line));
    let refused = bench.run("export set --for hci --out out");
    assert!(refused.code == Some(2) && refused.stderr.contains("9x9, 2x2"), "{refused:?}");
    assert!(!bench.path("out").exists());
    let said = ok(bench.run("export set --for hci --views 9 --out out --group test"));
    assert!(said.stderr.contains("2 light fields"), "{said:?}");
    for scene in ["plaster", "tiny"] {
        assert!(bench.path(format!("out/test/{scene}/input_Cam080.png")).is_file(), "{scene}");
    }
    for (arguments, code, words) in [
        ("export set --for hci --views 9 --out out", 2, "has files already"),
        ("export set --for hci --views 2 --out two", 2, "9 x 9 views"),
        ("export set --for epinet --out two", 2, "jpeg-pleno"),
        ("export set --for npy --views 9 --group ../up --out two", 2, "no name of a folder"),
        ("export missing --for npy --out two", 1, "missing"),
    ] {
        let refused = bench.run(arguments);
        assert!(refused.code == Some(code) && refused.stderr.contains(words), "{arguments}: {refused:?}");
        let left = bench.path("two");
        assert!(!left.exists(), "{arguments} left {:?}", bench.list("two"));
    }
}

//! `holo remap` and `holo extract`: the same samples in another order, bit by bit.

use crate::common;
use crate::common::{Bench, patterned, read_u8, read_u16, small_split};
use holo_core::{LightField, LightFieldOwned};
use holo_io::{ColorEncoding, Compression, write_png};

fn write_8(bench: &Bench, name: &str, field: &LightFieldOwned<u8>) {
    let image = field.to_elemental_grid().unwrap();
    write_png(bench.path(name), image.view(), ColorEncoding::Srgb, Compression::Fast).unwrap();
}

fn ok(bench: &Bench, arguments: &str) {
    let outcome = bench.run(arguments);
    assert_eq!((outcome.code, outcome.stdout.as_str()), (Some(0), ""), "{outcome:?}");
}

#[test]
fn there_and_back_is_the_identity_with_parameters_beside() {
    let bench = Bench::new();
    for (out, bits) in [("eight", "8"), ("sixteen", "16")] {
        bench.render(out, &format!("--bit-depth {bits}"));
        // The copies lie beside the same parameters.cfg; layouts are told by the names.
        ok(&bench, &format!("remap {out}/scene_el.png {out}/copy_vpi.png"));
        ok(&bench, &format!("remap {out}/copy_vpi.png {out}/copy_el.png"));
        let files = bench.bytes(out);
        assert!(files["copy_vpi.png"] == files["scene_vpi.png"], "{bits} bits: the render's own other grid");
        assert!(files["copy_el.png"] == files["scene_el.png"], "{bits} bits: there and back");
        assert!(files["copy_el.png"] != files["copy_vpi.png"]);
    }
}

#[test]
fn there_and_back_is_the_identity_with_views_given() {
    let bench = Bench::new();
    let fine = patterned(40_503);
    let coarse = fine.map(|x| *x as u8).unwrap();
    write_8(&bench, "eight.png", &coarse);
    write_png(
        bench.path("sixteen.png"),
        fine.to_elemental_grid().unwrap().view(),
        ColorEncoding::Srgb,
        Compression::Fast,
    )
    .unwrap();
    for name in ["eight", "sixteen"] {
        ok(&bench, &format!("remap {name}.png {name}_a.png --from el --to vpi --views 5x4"));
        ok(&bench, &format!("remap {name}_a.png {name}_b.png --from vpi --views 5x4"));
        ok(&bench, &format!("remap {name}.png {name}_same.png --from el --to el --views 5x4"));
    }
    assert_eq!(read_u8(bench.path("eight_a.png")), coarse.to_viewpoint_grid().unwrap());
    assert_eq!(read_u8(bench.path("eight_b.png")), coarse.to_elemental_grid().unwrap());
    assert_eq!(read_u8(bench.path("eight_same.png")), coarse.to_elemental_grid().unwrap());
    assert_eq!(read_u16(bench.path("sixteen_a.png")), fine.to_viewpoint_grid().unwrap());
    assert_eq!(read_u16(bench.path("sixteen_b.png")), fine.to_elemental_grid().unwrap());
    assert_eq!(read_u16(bench.path("sixteen_same.png")), fine.to_elemental_grid().unwrap());
}

#[test]
fn one_view_and_one_elemental_image() {
    let bench = Bench::new();
    bench.render("out", "");
    let viewpoint = read_u8(bench.path("out/scene_vpi.png"));
    let field = LightField::from_viewpoint_grid(viewpoint.view(), small_split()).unwrap();
    for (column, row) in [(0, 0), (4, 0), (0, 3), (3, 2)] {
        // A view is the block of the viewpoint grid at its row and column; x comes first on the command line.
        let block = viewpoint.slice(ndarray::s![row * 8..(row + 1) * 8, column * 12..(column + 1) * 12, ..]);
        for raw in ["scene_vpi.png", "scene_el.png"] {
            ok(&bench, &format!("extract out/{raw} --view {column},{row} --out view.png"));
            assert_eq!(read_u8(bench.path("view.png")), block, "view {column},{row} of {raw}");
        }
    }
    for (column, row) in [(0, 0), (11, 0), (0, 7), (9, 3)] {
        for raw in ["scene_vpi.png", "scene_el.png"] {
            ok(&bench, &format!("extract out/{raw} --lens {column},{row} --out lens.png"));
            let lens = read_u8(bench.path("lens.png"));
            assert_eq!(lens.dim(), (4, 5, 3));
            assert_eq!(lens, field.elemental_image(row, column).unwrap(), "lens {column},{row} of {raw}");
        }
    }
}

#[test]
fn extracting_with_views_given_and_in_16_bits() {
    let bench = Bench::new();
    let field = patterned(977);
    write_png(bench.path("raw.png"), field.to_viewpoint_grid().unwrap().view(), ColorEncoding::Srgb, Compression::Fast)
        .unwrap();
    ok(&bench, "extract raw.png --from vpi --views 5x4 --view 4,1 --out view.png");
    assert_eq!(read_u16(bench.path("view.png")), field.view(1, 4).unwrap());
    ok(&bench, "extract raw.png --from vpi --views 5x4 --lens 11,2 --out lens.png");
    assert_eq!(read_u16(bench.path("lens.png")), field.elemental_image(2, 11).unwrap());
}

#[test]
fn grey_images_have_a_layout_too() {
    let bench = Bench::new();
    let colour = patterned(31).map(|x| *x as u8).unwrap();
    let samples = colour.samples().slice(ndarray::s![.., .., .., .., ..1]).to_owned();
    let grey = LightField::new(samples).unwrap();
    write_8(&bench, "grey_el.png", &grey);
    ok(&bench, "remap grey_el.png grey_vpi.png --views 5x4");
    assert_eq!(read_u8(bench.path("grey_vpi.png")), grey.to_viewpoint_grid().unwrap());
}

#[test]
fn what_is_missing_or_does_not_fit_is_said() {
    let bench = Bench::new();
    write_8(&bench, "raw_el.png", &patterned(3).map(|x| *x as u8).unwrap());
    write_8(&bench, "raw.png", &patterned(3).map(|x| *x as u8).unwrap());
    let before = bench.list("");
    for (arguments, code, words) in [
        ("remap raw_el.png x.png", 2, &["--views", "parameters.cfg"][..]),
        ("remap raw.png x.png --views 5x4", 2, &["--from", "_el", "_vpi"]),
        ("remap raw_el.png x.png --views 7x4", 2, &["60x32", "7x4"]),
        ("remap raw_el.png x.png --views 0x4", 2, &["COLUMNSxROWS"]),
        ("remap missing_el.png x.png --views 5x4", 1, &["cannot read missing_el.png"]),
        ("remap tiny.glb x.png --from el --views 5x4", 1, &["tiny.glb", "PNG"]),
        ("extract raw_el.png --views 5x4 --out x.png", 2, &["--view <S,T>", "--lens <U,V>"]),
        ("extract raw_el.png --views 5x4 --out x.png --view 1,1 --lens 1,1", 2, &["--view", "--lens"]),
        ("extract raw_el.png --views 5x4 --out x.png --view 5,0", 2, &["view column 5", "there are 5"]),
        ("extract raw_el.png --views 5x4 --out x.png --view 0,4", 2, &["view row 4", "there are 4"]),
        ("extract raw_el.png --views 5x4 --out x.png --lens 12,0", 2, &["lens column 12"]),
        ("extract raw_el.png --views 5x4 --out x.png --view -1,0", 2, &["'-1'", "from 0"]),
        ("extract raw_el.png --views 5x4 --out x.png --view 1", 2, &["COLUMN,ROW"]),
    ] {
        let outcome = bench.run(arguments);
        assert_eq!(outcome.code, Some(code), "{arguments}: {outcome:?}");
        assert!(words.iter().all(|word| outcome.stderr.contains(word)), "{arguments}: {outcome:?}");
        assert_eq!(bench.list(""), before, "{arguments}");
    }
}

#[test]
fn the_name_of_the_output_decides_unless_told_otherwise() {
    let bench = Bench::new();
    bench.render("out", "--write el");
    let before = bench.bytes("out");
    // In place: the file keeps the layout that its name promises.
    ok(&bench, "remap out/scene_el.png out/scene_el.png");
    assert!(bench.bytes("out") == before);
    ok(&bench, "remap out/scene_el.png out/other.png");
    assert_eq!(bench.run("remap out/other.png x_el.png --views 5x4 --from vpi").code, Some(0));
    assert!(bench.bytes("")["x_el.png"] == before["scene_el.png"]);
    let outcome = bench.run("remap out/scene_el.png out/odd_el.png --to vpi");
    assert_eq!(outcome.code, Some(0), "{outcome:?}");
    assert!(outcome.stderr.contains("warning:") && outcome.stderr.contains("--from"), "{outcome:?}");
    assert!(bench.bytes("out")["odd_el.png"] == bench.bytes("out")["other.png"]);
}

#[test]
fn parameters_of_another_image_are_noticed() {
    let bench = Bench::new();
    bench.render("out", "");
    // A render clears away what its manifest named before, and leaves what it did not.
    std::fs::copy(bench.path("out/scene_el.png"), bench.path("out/own_el.png")).unwrap();
    // 2 x 2 views divide 60 x 32 pixels too, but into views of another size.
    let arguments =
        format!("render {} --out out --lenses 6x4 --views 2 --spp 1 --write depth --overwrite", common::SCENE);
    assert_eq!(bench.run(&arguments).code, Some(0));
    assert!(!bench.list("out").contains(&"scene_el.png".to_owned()));
    let outcome = bench.run("extract out/own_el.png --view 0,0 --out x.png");
    assert_eq!(outcome.code, Some(2), "{outcome:?}");
    assert!(outcome.stderr.contains("2x2 views of 6x4 px") && outcome.stderr.contains("--views"), "{outcome:?}");
    ok(&bench, "extract out/own_el.png --view 0,0 --out x.png --views 5x4");
}

#[test]
fn a_damaged_image_is_an_error_and_leaves_nothing() {
    let bench = Bench::new();
    bench.render("out", "--write el");
    let bytes = std::fs::read(bench.path("out/scene_el.png")).unwrap();
    std::fs::write(bench.path("out/cut_el.png"), &bytes[..bytes.len() / 2]).unwrap();
    let before = bench.list("out");
    let outcome = bench.run("remap out/cut_el.png out/cut_vpi.png");
    assert_eq!(outcome.code, Some(1), "{outcome:?}");
    assert!(outcome.stderr.contains("out/cut_el.png") && !outcome.stderr.contains("panicked"), "{outcome:?}");
    assert_eq!(bench.list("out"), before);
}

/// Whatever holds the light field, the same view comes out of it.
#[test]
fn a_view_is_the_same_from_every_kind_of_file() {
    let bench = Bench::new();
    bench.render("out", "--write el,vpi,mat,hci --ground-truth all");
    ok(&bench, "extract out/scene_el.png --view 3,1 --out one.png");
    let expected = read_u8(bench.path("one.png"));
    for input in ["out", "out/scene_vpi.png", "out/scene_5d.mat", "out/hci"] {
        ok(&bench, &format!("extract {input} --view 3,1 --out other.png"));
        assert_eq!(read_u8(bench.path("other.png")), expected, "{input}");
        ok(&bench, &format!("remap {input} again.png --to el"));
        assert_eq!(read_u8(bench.path("again.png")), read_u8(bench.path("out/scene_el.png")), "{input}");
    }
    // Of 5 x 4 views; each has its truth.
    let hci = bench.list("out/hci");
    assert_eq!(hci.len(), 20 + 2 * 21 + 1, "{hci:?}");
    for name in ["input_Cam019.png", "gt_disp_lowres.pfm", "gt_depth_lowres_Cam000.pfm", "parameters.cfg"] {
        assert!(hci.iter().any(|file| file == name), "{name}");
    }
    assert_eq!(bench.run("verify out").code, Some(0));
    for (arguments, words) in [
        ("extract out/hci --view 3,1 --out other.png --views 4x4", &["5x4 views", "--views"][..]),
        ("extract . --view 3,1 --out other.png", &["does not specify", "--views"]),
        ("extract out/hci --view 3,1 --out other.pfm", &["integers", ".png"]),
        ("remap out/hci again.png", &["--to", "_el"]),
    ] {
        let outcome = bench.run(arguments);
        assert_eq!(outcome.code, Some(2), "{arguments}: {outcome:?}");
        assert!(words.iter().all(|word| outcome.stderr.contains(word)), "{arguments}: {outcome:?}");
    }
}

/// An .h5 holds linear floats: they come out as a PFM and as nothing else.
#[cfg(feature = "hdf5")]
#[test]
fn floats_come_out_as_floats() {
    let bench = Bench::new();
    bench.render("out", "--write h5 --layers color");
    // Column 2 of 5, row 2 of 4: the central view.
    ok(&bench, "extract out/scene_5d.h5 --view 2,2 --out view.pfm");
    assert!(bench.bytes("")["view.pfm"] == bench.bytes("out")["scene_color.pfm"]);
    let outcome = bench.run("extract out/scene_5d.h5 --view 2,2 --out view.png");
    assert!(outcome.code == Some(2) && outcome.stderr.contains(".pfm"), "{outcome:?}");
}

//! `holo view`: the page is whole, refers to nothing, holds the raw image's own bytes; and a browser, where there is one,
//! shows with it what the files say.

use std::fmt::Write as _;
use std::process::Command;

use crate::common::{Bench, ok, patterned, peer, read_u8};
use holo_core::LightFieldOwned;
use holo_io::{ColorEncoding, Compression, Limits};
use ndarray::{Array2, Array3, s};

/// What base64 says, with padding only at the end.
fn decoded(text: &str) -> Vec<u8> {
    let digit = |letter: u8| match letter {
        b'A'..=b'Z' => letter - b'A',
        b'a'..=b'z' => letter - b'a' + 26,
        b'0'..=b'9' => letter - b'0' + 52,
        b'+' => 62,
        b'/' => 63,
        other => panic!("{other} is no digit of base64"),
    };
    let mut bytes = Vec::new();
    for group in text.as_bytes().chunks(4) {
        let filled: Vec<u8> = group.iter().filter(|letter| **letter != b'=').map(|letter| digit(*letter)).collect();
        let bits = filled.iter().chain(&[0; 3]).take(4).fold(0_u32, |bits, value| bits << 6 | u32::from(*value));
        bytes.extend(&bits.to_be_bytes()[1..filled.len()]);
    }
    bytes
}

/// The bytes of all blocks of that name in a page.
fn embedded(page: &str, name: &str) -> Vec<u8> {
    let start = format!("<script type=\"text/plain\" data-block=\"{name}\">");
    page.split(&start).skip(1).flat_map(|rest| decoded(rest.split("</script>").next().unwrap())).collect()
}

fn numbers(page: &str) -> serde_json::Value {
    let rest = page.split("<script type=\"application/json\" id=\"numbers\">").nth(1).unwrap();
    serde_json::from_str(rest.split("</script>").next().unwrap()).unwrap()
}

fn floats(bytes: &[u8]) -> Vec<f32> {
    bytes.chunks_exact(4).map(|value| f32::from_le_bytes(value.try_into().unwrap())).collect()
}

#[test]
fn the_page_holds_the_files_as_they_are() {
    let bench = Bench::new();
    bench.render("out", "");
    ok(bench.run("view out -o page.html"));
    let page = std::fs::read_to_string(bench.path("page.html")).unwrap();
    assert!(embedded(&page, "image") == bench.bytes("out")["scene_el.png"]);
    for (name, file) in [("depth", "out/scene_depth.pfm"), ("disparity", "out/scene_disparity.pfm")] {
        let map = holo_io::read_pfm_gray(bench.path(file), &Limits::default()).unwrap();
        assert!(
            floats(&embedded(&page, name)).iter().map(|x| x.to_bits()).eq(map.iter().map(|x| x.to_bits())),
            "{name}"
        );
    }
    assert!(embedded(&page, "estimate").is_empty());
    let numbers = numbers(&page);
    assert_eq!(numbers["views"], serde_json::json!({"columns": 5, "rows": 4}));
    assert_eq!(numbers["lenses"], serde_json::json!({"columns": 12, "rows": 8}));
    assert!(numbers["rig"]["scale_m_px"]["x"].as_f64().unwrap() > 0.0);
    // The raw image alone, or the other grid, lead to the same light field.
    ok(bench.run("view out/scene_el.png -o again.html"));
    let again = std::fs::read_to_string(bench.path("again.html")).unwrap();
    assert!(embedded(&again, "image") == embedded(&page, "image"));
    assert!(embedded(&again, "depth") == embedded(&page, "depth"));
    ok(bench.run("view out/scene_vpi.png --from vpi -o other.html"));
    let other = std::fs::read_to_string(bench.path("other.html")).unwrap();
    std::fs::write(bench.path("other.png"), embedded(&other, "image")).unwrap();
    assert_eq!(read_u8(bench.path("other.png")), read_u8(bench.path("out/scene_el.png")));
}

#[test]
fn equal_inputs_give_equal_pages() {
    let bench = Bench::new();
    bench.render("out", "");
    ok(bench.run("view out -o one.html"));
    ok(bench.run("view out -o two.html"));
    assert!(bench.bytes("")["one.html"] == bench.bytes("")["two.html"]);
}

#[test]
fn other_kinds_become_eight_bits() {
    let bench = Bench::new();
    let field: LightFieldOwned<u16> = patterned(977);
    let grid = field.to_elemental_grid().unwrap();
    holo_io::write_png(bench.path("raw_el.png"), grid.view(), ColorEncoding::Srgb, Compression::Fast).unwrap();
    ok(bench.run("view raw_el.png --views 5x4 -o page.html"));
    let page = std::fs::read_to_string(bench.path("page.html")).unwrap();
    std::fs::write(bench.path("shown.png"), embedded(&page, "image")).unwrap();
    // 65535 = 257 * 255: the nearest code, without a tie.
    let expected = grid.mapv(|code| (f64::from(code) / 257.0).round() as u8);
    assert_eq!(read_u8(bench.path("shown.png")), expected);
    assert!(numbers(&page)["rig"].is_null());
    // Alpha goes, colors stay as they are stored.
    let with_alpha =
        Array3::from_shape_fn((32, 60, 4), |(row, column, channel)| (row * 7 + column * 3 + channel * 50) as u8);
    holo_io::write_png(bench.path("a_el.png"), with_alpha.view(), ColorEncoding::Srgb, Compression::Fast).unwrap();
    ok(bench.run("view a_el.png --views 5x4 -o page.html"));
    let page = std::fs::read_to_string(bench.path("page.html")).unwrap();
    std::fs::write(bench.path("shown.png"), embedded(&page, "image")).unwrap();
    assert_eq!(read_u8(bench.path("shown.png")), with_alpha.slice(s![.., .., ..3]));
}

#[test]
fn what_cannot_be_shown_is_refused_and_nothing_is_made() {
    let bench = Bench::new();
    bench.render("out", "");
    holo_io::write_pfm(bench.path("small.pfm"), Array2::<f32>::zeros((7, 12)).view()).unwrap();
    let before = bench.list("");
    for (arguments, code, words) in [
        ("view out", 2, &["--out <FILE>"][..]),
        ("view out -o page.png", 2, &[".html"]),
        ("view out -o page.html --estimate small.pfm", 1, &["small.pfm", "12x8", "12x7"]),
        ("view out -o page.html --estimate none.pfm", 1, &["none.pfm"]),
        ("view none -o page.html", 1, &["none"]),
        ("view out/scene_depth.pfm -o page.html", 1, &["scene_depth.pfm"]),
        ("view out -o nowhere/page.html", 1, &["nowhere/page.html"]),
    ] {
        let outcome = bench.run(arguments);
        assert_eq!(outcome.code, Some(code), "{arguments}: {outcome:?}");
        assert!(words.iter().all(|word| outcome.stderr.contains(word)), "{arguments}: {outcome:?}");
        assert_eq!(bench.list(""), before, "{arguments}");
    }
}

/// Runs `viewer/check.py`; reports it and returns `false` where there is no browser.
fn browse(bench: &Bench, arguments: &[&str]) -> bool {
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/viewer/check.py");
    let python = std::env::var("HOLO_PYTHON").unwrap_or_else(|_| "python3".to_owned());
    let run = Command::new(&python).arg("-B").arg(script).args(arguments).current_dir(bench.path("")).output();
    let missing = match &run {
        Ok(output) if output.status.code() == Some(77) => "chromium (HOLO_CHROMIUM names it)".to_owned(),
        Err(why) => format!("{python}: {why}"),
        Ok(output) => {
            assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
            let mut told = String::new();
            write!(told, "{}", String::from_utf8_lossy(&output.stdout)).unwrap();
            println!("{told}");
            return true;
        }
    };
    peer::missing(&missing);
    false
}

/// A dataset with ground truth and an estimate, an even count of view rows, both ways of drawing.
#[test]
fn a_browser_shows_what_the_files_say() {
    let bench = Bench::new();
    bench.render("out", "--baseline-m 0.03");
    let truth = holo_io::read_pfm_gray(bench.path("out/scene_disparity.pfm"), &Limits::default()).unwrap();
    let mut estimate = truth;
    estimate.indexed_iter_mut().for_each(|((row, column), value)| *value += 0.01 * (row as f32 - column as f32));
    holo_io::write_pfm(bench.path("estimate.pfm"), estimate.view()).unwrap();
    ok(bench.run("view out -o page.html --estimate estimate.pfm"));
    let common = ["page.html", "out/scene_el.png", "--truth", "out/scene_disparity.pfm", "--estimate", "estimate.pfm"];
    if browse(&bench, &common) {
        // Tiles of 17 pixels cut through lenses and views.
        browse(&bench, &[&common[..], &["--address-part", "#tile=17"]].concat());
        browse(&bench, &[&common[..], &["--address-part", "#canvas", "--renderer", "canvas"]].concat());
    }
}

/// The smallest counts there are, one view and one lens; gray; no rig.
#[test]
fn a_browser_shows_one_view_and_one_lens() {
    let bench = Bench::new();
    for views in ["1x1", "9x6"] {
        let image = Array3::from_shape_fn((6, 9, 1), |(row, column, _)| (row * 40 + column * 5) as u8);
        holo_io::write_png(bench.path("raw_el.png"), image.view(), ColorEncoding::Srgb, Compression::Fast).unwrap();
        ok(bench.run(&format!("view raw_el.png --views {views} -o page.html")));
        if !browse(&bench, &["page.html", "raw_el.png"]) {
            return;
        }
    }
}

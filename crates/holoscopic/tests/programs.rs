//! The programs of the README: at most twelve lines of code, shown as they are, and their steps work one after the other.

/// The programs by name.
const PROGRAMS: [(&str, &str); 4] = [
    ("render_to_hdf5", include_str!("../examples/render_to_hdf5.rs")),
    ("decode_raw", include_str!("../examples/decode_raw.rs")),
    ("refocus_at_distance", include_str!("../examples/refocus_at_distance.rs")),
    ("estimate_and_score", include_str!("../examples/estimate_and_score.rs")),
];

#[test]
fn programs_have_at_most_twelve_lines_of_code() {
    for (name, text) in PROGRAMS {
        let code = text.lines().map(str::trim).filter(|line| !line.is_empty() && !line.starts_with("//"));
        let count = code.count();
        assert!(count <= 12, "{name} has {count} lines of code");
        assert!(text.lines().all(|line| line.len() <= 120 && line.matches(';').count() <= 1), "{name} has dense lines");
    }
}

#[test]
fn readmes_show_the_programs_as_they_are() {
    // That of the project has the first.
    for (readme, count) in [("README.md", PROGRAMS.len()), ("../../README.md", 1)] {
        let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join(readme);
        let shown = std::fs::read_to_string(&path).expect("a readme");
        for (name, text) in &PROGRAMS[..count] {
            let (_, program) = text.split_once("\n\n").expect("a comment and a program");
            assert!(shown.contains(&format!("\n{program}```\n")), "{} does not show {name}", path.display());
        }
    }
}

#[cfg(feature = "render")]
mod steps {
    use std::error::Error;
    use std::path::{Path, PathBuf};

    use holoscopic::io::read_png_info;
    use holoscopic::prelude::*;
    use holoscopic::scene::gallery;

    /// An unfocused camera of 120 x 90 pixels.
    const CAMERA: &str = r#"
name = "small"
[sensor]
size_px = [120, 90]
pixel_um = 5.0
[mla]
grid = "square"
pitch_um = 71.2
gap_um = 400.0
[main_lens]
focal_mm = 40.0
f_number = 5.8
focus_m = 0.8
"#;

    fn scene_file(folder: &Path) -> Result<PathBuf, Box<dyn Error>> {
        let path = folder.join("mountains.glb");
        std::fs::write(&path, gallery::to_glb("mountains").ok_or("there is no such scene")??)?;
        Ok(path)
    }

    #[test]
    fn a_rendered_light_field_is_refocused_and_its_disparity_is_estimated() -> Result<(), Box<dyn Error>> {
        let folder = tempfile::tempdir()?;
        let (scene, out) = (scene_file(folder.path())?, folder.path().join("out"));
        let rig = RigSettings::default().views(5).lenses([32, 48]).disparities_px((-1.0, 1.0));
        let mut files = vec![Output::El, Output::Disparity];
        if cfg!(feature = "hdf5") {
            files.push(Output::H5);
        }
        let settings = RenderSettings::default().camera(rig).samples(8).write(files);
        RenderJob::new(SceneSource::file(&scene), settings).run(&out, &RunOptions::default())?;

        let reader = LightFieldReader::open(&out, &ReadOptions::default())?;
        let truth_px = reader.central_disparity_px()?.ok_or("there is no ground truth")?;
        let file = reader.read()?;
        let options = file.plane_sweep_options();
        let (least, most) = truth_px.iter().fold((f32::MAX, f32::MIN), |(a, b), d| (a.min(*d), b.max(*d)));
        // Rounded outward to tenths, and a tenth more.
        let margins = [least - options.disparity_min_px, options.disparity_max_px - most];
        assert!(margins.iter().all(|margin| (0.09..0.21).contains(margin)), "{margins:?}");
        let estimate = plane_sweep(&file.light_field.to_f32()?, &options)?;
        let scores = disparity_scores(&estimate.disparity_px, &truth_px, &Region::with_border(4))?;
        // The range is two pixels wide.
        assert!(scores.mean_absolute_error_px < 0.3, "{scores:?}");

        let rig: Rig = file.rig.ok_or("there is no rig")?;
        let light_field = file.into_linear()?;
        let sharp =
            Refocus::new(light_field.shape().views())?.at_distance_m(&light_field, &rig, rig.focus_distance_m())?;
        // Views coincide at the focus distance: the image is their mean.
        let mean = light_field.views().map(|(_, view)| view[[16, 24, 1]]).sum::<f32>() / 25.0;
        assert!((sharp[[16, 24, 1]] - mean).abs() < 1e-5 * (1.0 + mean), "{} {mean}", sharp[[16, 24, 1]]);
        let png = folder.path().join("sharp.png");
        write_image(&png, &DynImage::from_linear(sharp.view(), SampleKind::U8)?)?;
        assert_eq!(read_png_info(&png)?.size, GridSize::new(32, 48));

        if cfg!(feature = "hdf5") {
            let reader = LightFieldReader::open(out.join("scene_5d.h5"), &ReadOptions::default())?;
            assert_eq!(reader.shape(), light_field.shape());
            assert_eq!(reader.central_disparity_px()?, Some(truth_px));
        }
        Ok(())
    }

    #[test]
    fn the_raw_image_of_a_plenoptic_camera_is_decoded_to_views() -> Result<(), Box<dyn Error>> {
        let folder = tempfile::tempdir()?;
        let (scene, camera, out) =
            (scene_file(folder.path())?, folder.path().join("small.toml"), folder.path().join("out"));
        std::fs::write(&camera, CAMERA)?;
        let settings = RenderSettings::default().camera(CameraFile::read(&camera)?).samples(2);
        RenderJob::new(SceneSource::file(&scene), settings).run(&out, &RunOptions::default())?;

        let light_field = read_light_field(out.join("raw.exr"), &ReadOptions::default())?.into_linear()?;
        assert!(light_field.shape().views().count() > 1, "{}", light_field.shape().views());
        let ((row, column), view) = light_field.views().next_back().ok_or("there are no views")?;
        let png = folder.path().join(format!("view_{row:02}_{column:02}.png"));
        write_image(&png, &DynImage::from_linear(view, SampleKind::U16)?)?;
        assert_eq!(read_png_info(&png)?.size, light_field.shape().lenses());
        Ok(())
    }
}

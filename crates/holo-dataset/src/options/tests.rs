use super::*;
use crate::spec::{Frames, RigSpec, SceneSpec};
use holo_core::GridSize;

#[test]
fn a_specification_reads_back_from_its_text() {
    let rig = RigSpec {
        views: GridSize::new(2, 3),
        lenses: Some(GridSize::new(4, 5)),
        lens_shifts: Some(3),
        baseline_m: Some(1e-3),
        disparity_px: Some((-1.5, 2.0)),
        focal_mm: Some(35.5),
        focus: Focus::Meters(f64::INFINITY),
        projection: Projection::Orthographic,
        camera: Some("front".into()),
        subset: Some("1,0;0,2".parse().unwrap()),
        ..RigSpec::default()
    };
    let scene = SceneSpec {
        light_units: LightUnits::Auto,
        solid_glass: true,
        material_variant: Some("red, or blue".into()),
        frames: Some(Frames { first: 3, last: 50 }),
        fps: Some(29.97),
        animation: Some("walk".into()),
    };
    let spec = RenderSpec {
        scene,
        rig,
        integrator: Integrator::Path,
        samples: Some(3),
        target_error: Some(0.05),
        roulette: false,
        indirect_limit: 2.5,
        transparent_shadows: true,
        reuse: Reuse::Off,
        texture_filter: TextureFilter::Off,
        denoise: Denoise::Views,
        multiple_scattering: false,
        cull: true,
        sky: Sky::Constant([1.0, 0.25, 0.0]),
        exposure: Exposure::Ev(-1.5),
        ground_truth: GroundTruth::All,
        layers: vec![LayerChoice::Color, LayerChoice::One(Layer::HitMask), LayerChoice::Error],
        outputs: vec![Output::El, Output::H5],
        mat_order: MatOrder::LightFieldToolbox,
        bit_depth: 16,
        sensor_model: Some("imx250".into()),
        iso: Some(400.0),
        seed: u64::MAX,
        ..RenderSpec::default()
    };
    for spec in [spec, RenderSpec::default()] {
        assert_eq!(RenderSpec::from_options(&spec.to_options()).unwrap(), spec);
    }
}

#[test]
fn no_path_gets_into_a_manifest() {
    let spec = RenderSpec { sky: "/some/where.hdr".parse().unwrap(), ..RenderSpec::default() };
    assert_eq!(spec.to_options()["sky"], MAP);
    let typed = Options::from([("sky".to_owned(), "/some/where.hdr".to_owned())]);
    assert_eq!(without_paths(typed, &spec)["sky"], MAP);
}

#[test]
fn invalid_options_are_named() {
    for (name, value, part) in [("spp", "x", "--spp=x"), ("zzz", "1", "unknown option"), ("write", "el,x", "'x'")] {
        let error = RenderSpec::from_options(&Options::from([(name.to_owned(), value.to_owned())])).unwrap_err();
        assert!(error.to_string().contains(part), "{error}");
        assert!(error.is_bad_request());
    }
}

#[test]
fn values_are_parsed() {
    assert_eq!("inf".parse(), Ok(Focus::Meters(f64::INFINITY)));
    assert!("0".parse::<Focus>().is_err() && "nan".parse::<Focus>().is_err());
    assert_eq!("-1.5".parse(), Ok(Exposure::Ev(-1.5)));
    assert_eq!("0.2, 0.3,1".parse(), Ok(Sky::Constant([0.2, 0.3, 1.0])));
    assert!("1,2".parse::<Sky>().is_err() && "1,2,-3".parse::<Sky>().is_err());
    assert_eq!("a,b/Sky.HDR".parse(), Ok(Sky::Map("a,b/Sky.HDR".into())));
    assert_eq!("0.5".parse::<Sky>(), Ok(Sky::Constant([0.5; 3])));
    assert!("1,2".parse::<Sky>().is_err() && "".parse::<Sky>().is_err());
    assert_eq!("auto".parse(), Ok(Sky::Automatic));
    for name in ["sky.png", "a/SKY.JPG", "sky.jpeg"] {
        assert_eq!(name.parse(), Ok(Sky::Map(name.into())));
    }
    assert!("sky.gif".parse::<Sky>().unwrap_err().contains(".exr"));
    assert_eq!(("7".parse(), "0-47".parse()), (Ok(Frames::one(7)), Ok(Frames { first: 0, last: 47 })));
    assert!(["", "-3", "0-1000000", "5-4", "1-2-3", "x"].iter().all(|text| text.parse::<Frames>().is_err()));
    assert_eq!(parse_range("-2,2.5"), Ok((-2.0, 2.5)));
    assert!(parse_range("2,-2").is_err() && parse_range("1").is_err() && parse_range("0,inf").is_err());
    assert_eq!(parse_light_units("auto"), Ok(LightUnits::Auto));
    assert!(parse_light_units("watt").is_err());
}

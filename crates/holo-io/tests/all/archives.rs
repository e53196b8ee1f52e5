//! Light fields of public archives, as their own documents and readers order them, from files made by hand.

use holo_core::{DynLightField, GridSize, LightFieldShape};
use holo_io::{
    ColorEncoding, Compression, LightFieldFormat, Limits, ReadOptions, read_light_field, read_rig, write_png,
};
use ndarray::Array3;

/// The light field of `u8` samples: `(v, u, t, s, c)`.
fn samples(field: &DynLightField) -> ndarray::Array5<u16> {
    match field {
        DynLightField::U8(field) => field.samples().mapv(u16::from),
        DynLightField::U16(field) => field.samples().to_owned(),
        other => panic!("{:?}", other.kind()),
    }
}

/// Lytro's ESLF: pixel (14 v + t, 14 u + s), whose last row may be missing.
#[test]
fn eslf_files_have_fourteen_views() {
    let folder = tempfile::tempdir().unwrap();
    for (name, rows) in [("flowers_1_eslf.png", 42), ("IMG_0001.eslf.png", 41)] {
        let image = Array3::from_shape_fn((rows, 56, 4), |(row, column, c)| {
            [(row % 14 * 4000) as u16, (column % 14 * 4000) as u16, (row / 14 * 1000 + column / 14) as u16, 65_535][c]
        });
        let path = folder.path().join(name);
        write_png(&path, image.view(), ColorEncoding::Srgb, Compression::Fast).unwrap();
        let file = read_light_field(&path, &ReadOptions::default()).unwrap();
        let shape = LightFieldShape::new(GridSize::new(14, 14), GridSize::new(3, 4)).unwrap();
        assert_eq!((file.light_field.shape(), file.format), (shape, LightFieldFormat::Eslf));
        let found = samples(&file.light_field);
        for ((v, u, t, s, c), &value) in found.indexed_iter() {
            let expected = match [(t * 4000) as u16, (s * 4000) as u16, (v * 1000 + u) as u16, 65_535][c] {
                _ if 14 * v + t >= rows => 0,
                expected => expected,
            };
            assert_eq!(value, expected, "{name} {v} {u} {t} {s} {c}");
        }
    }
    // Another size of the blocks.
    let file =
        read_light_field(folder.path().join("flowers_1_eslf.png"), &ReadOptions::default().views(GridSize::new(7, 7)));
    assert_eq!(file.unwrap().light_field.shape().lenses(), GridSize::new(6, 8));
}

/// The MIT archive: rows are counted from below, and a near square moves left from column to column.
#[test]
fn mit_folders_have_their_rig_and_rows_from_below() {
    let root = tempfile::tempdir().unwrap();
    let folder = root.path().join("dragons_5x5_ap5");
    std::fs::create_dir(&folder).unwrap();
    // By the numbers of the README: view NN is at ((NN - 1) % 5, (NN - 1) / 5), x to the right and y up. The point moves by
    // -2 px for every step to the right and by +2 px down the image for every step up.
    for number in 0..25usize {
        let (x, y) = (number as i64 % 5 - 2, number as i64 / 5 - 2);
        let (row, column) = ((7 + 2 * y) as usize, (10 - 2 * x) as usize);
        let image = Array3::from_shape_fn((14, 20, 3), |(r, c, _)| if (r, c) == (row, column) { 255u8 } else { 0 });
        let path = folder.join(format!("dragons-{:02}.png", number + 1));
        write_png(path, image.view(), ColorEncoding::Srgb, Compression::Fast).unwrap();
    }
    let file = read_light_field(&folder, &ReadOptions::default()).unwrap();
    assert_eq!(file.format, LightFieldFormat::MitFolder);
    let found = samples(&file.light_field);
    for t in 0..5usize {
        for s in 0..5usize {
            // Disparity 2: to the left from column to column and up from row to row.
            let (v, u) = (7 - 2 * (t as i64 - 2), 10 - 2 * (s as i64 - 2));
            assert_eq!(found[[v as usize, u as usize, t, s, 0]], 255, "{t} {s}");
        }
    }
    let rig = file.rig.expect("a rig");
    assert_eq!(read_rig(&folder, &Limits::default()).unwrap(), Some(rig));
    // d = b W / 0.5 m (1.27 m / Z - 1), b = 12.5 mm: 0.5 px per 1.27 / Z - 1.
    assert!((rig.disparity().from_depth_m(1.0) - 0.0125 * 20.0 / 0.5 * 0.27).abs() < 1e-9);
    assert!(rig.disparity().from_depth_m(1.27).abs() < 1e-12);
    std::fs::remove_file(folder.join("dragons-07.png")).unwrap();
    assert!(read_light_field(&folder, &ReadOptions::default()).is_err());
}

/// An SGI image, whose lower row comes first and whose channels are apart; with run lengths: literal ones and repeats.
fn sgi(image: &Array3<u8>, is_run_length_coded: bool) -> Vec<u8> {
    let (rows, columns, channels) = image.dim();
    let mut file = vec![0x01, 0xda, u8::from(is_run_length_coded), 1, 0, 3];
    for size in [columns, rows, channels] {
        file.extend((size as u16).to_be_bytes());
    }
    file.extend([0, 0, 0, 0, 0, 0, 0, 255]);
    file.resize(512, 0);
    let lines: Vec<Vec<u8>> = (0..channels * rows)
        .map(|k| (0..columns).map(|column| image[[rows - 1 - k % rows, column, k / rows]]).collect())
        .collect();
    if !is_run_length_coded {
        file.extend(lines.concat());
        return file;
    }
    let coded: Vec<Vec<u8>> = lines
        .iter()
        .map(|line| {
            let repeats = line.iter().take_while(|&&value| value == line[0]).count();
            let mut out = vec![repeats as u8, line[0]];
            if repeats < columns {
                out.push(0x80 | (columns - repeats) as u8);
                out.extend(&line[repeats..]);
            }
            out.push(0);
            out
        })
        .collect();
    let mut start = 512 + 8 * coded.len();
    for line in &coded {
        file.extend((start as u32).to_be_bytes());
        start += line.len();
    }
    coded.iter().for_each(|line| file.extend((line.len() as u32).to_be_bytes()));
    file.extend(coded.concat());
    file
}

/// A file of LightPack. The u of its cameras runs to the left, their v runs up; the t of its images runs up.
const LID: &str = "# LIF1.0\nSLAB 0 data/lion\n\
    SLAB_UV\t 2 -2 4 1 0 0\n -2 -2 4 1 1 0\n -2 2 4 1 1 1\n 2 2 4 1 0 1   # four corners\n\
    SLAB_ST -1 -1 0 1 0 0  1 -1 0 1 1 0  1 1 0 1 1 1  -1 1 0 1 0 1\n\
    SAMPLES_UV 4 3\nSAMPLES_ST 7 5\nFORMAT RGB\n";

#[test]
fn light_pack_names_the_images_of_its_cameras() {
    let root = tempfile::tempdir().unwrap();
    std::fs::create_dir(root.path().join("data")).unwrap();
    let lid = root.path().join("lion.lid");
    std::fs::write(&lid, LID).unwrap();
    let of_camera = |u: usize, v: usize| {
        Array3::from_shape_fn((5, 7, 3), |(row, column, c)| {
            if column < 3 { (40 * u + v) as u8 } else { [10 * row, column, 100 * v + u][c] as u8 }
        })
    };
    let name = |u: usize, v: usize| root.path().join(format!("data/lion.{u}.{v}.rgb"));
    for (u, v) in (0..4).flat_map(|u| (0..3).map(move |v| (u, v))) {
        std::fs::write(name(u, v), sgi(&of_camera(u, v), (u + v) % 2 == 1)).unwrap();
    }
    let file = read_light_field(&lid, &ReadOptions::default()).unwrap();
    let shape = LightFieldShape::new(GridSize::new(3, 4), GridSize::new(5, 7)).unwrap();
    assert_eq!((file.light_field.shape(), file.format, file.rig), (shape, LightFieldFormat::LightPack, None));
    let found = samples(&file.light_field);
    for ((v, u, t, s, c), &value) in found.indexed_iter() {
        // The upper row of views is that of the greatest v; the left column that of the greatest u.
        assert_eq!(value, u16::from(of_camera(3 - s, 2 - t)[[v, u, c]]), "{v} {u} {t} {s} {c}");
    }
    // Missing, of another size, or a link that leads elsewhere.
    let whole = std::fs::read(name(2, 1)).unwrap();
    std::fs::remove_file(name(2, 1)).unwrap();
    assert!(read_light_field(&lid, &ReadOptions::default()).unwrap_err().to_string().contains("lion.2.1.rgb"));
    std::fs::write(name(2, 1), sgi(&Array3::zeros((5, 6, 3)), false)).unwrap();
    assert!(read_light_field(&lid, &ReadOptions::default()).is_err());
    #[cfg(unix)]
    {
        std::fs::remove_file(name(2, 1)).unwrap();
        std::fs::write(root.path().join("elsewhere"), &whole).unwrap();
        std::os::unix::fs::symlink(root.path().join("elsewhere"), name(2, 1)).unwrap();
        assert!(read_light_field(&lid, &ReadOptions::default()).is_err());
        std::fs::remove_file(name(2, 1)).unwrap();
    }
    std::fs::write(name(2, 1), &whole).unwrap();
    for (text, words) in [
        (LID.replace("data/lion", "../data/lion"), "folder"),
        (LID.replace("data/lion", "/etc/lion"), "folder"),
        (LID.replace("SAMPLES_ST 7 5", "SAMPLES_ST 5 7"), "SAMPLES_ST"),
    ] {
        std::fs::write(&lid, text).unwrap();
        let why = read_light_field(&lid, &ReadOptions::default()).unwrap_err().to_string();
        assert!(why.contains(words), "{why}");
    }
}

/// Damaged files are errors or other samples, in time that fits their size.
#[test]
fn damaged_files_of_light_pack_do_no_harm() {
    let root = tempfile::tempdir().unwrap();
    let (lid, image) = (root.path().join("a.lid"), root.path().join("a.0.0.rgb"));
    let text = LID.replace("data/lion", "a").replace("SAMPLES_UV 4 3", "SAMPLES_UV 1 1");
    let pixels = Array3::from_shape_fn((5, 7, 3), |(row, column, c)| (row * column * (c + 1)) as u8);
    let good = [text.as_bytes().to_vec(), sgi(&pixels, false), sgi(&pixels, true)];
    let mut seed = 1u64;
    let mut random = |below: usize| {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 33) as usize % below
    };
    let limits = ReadOptions::default().limits(Limits { max_bytes: 1 << 20 });
    let mut read = 0;
    for round in 0..3000 {
        let mut files = good.clone();
        let file = &mut files[round % 3];
        for _ in 0..1 + random(3) {
            // Most bytes matter in headers and tables.
            let at = if random(2) == 0 { random(12) } else { random(file.len()) };
            file[at] = random(256) as u8;
        }
        let length = if random(4) == 0 { random(file.len()) } else { file.len() };
        file.truncate(length);
        std::fs::write(&lid, &files[0]).unwrap();
        std::fs::write(&image, &files[1 + round % 2]).unwrap();
        read += usize::from(read_light_field(&lid, &limits).is_ok());
    }
    assert!((300..2900).contains(&read), "{read}");
}

#[cfg(feature = "hdf5")]
mod hdf5_files {
    use super::*;
    use holo_io::LightFieldReader;
    use ndarray::{Array4, Array5};

    /// The old HCI benchmark: view columns are stored from right to left.
    #[test]
    fn old_hci_files_have_their_depth_and_rig() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("lf.h5");
        let file = hdf5::File::create(&path).unwrap();
        // (view row, view column, row, column, channel)
        let stored = Array5::from_shape_fn((3, 5, 4, 7, 3), |(t, h, v, u, c)| (t * 50 + h * 10 + v * 7 + u + c) as u8);
        file.new_dataset_builder().with_data(stored.view()).create("LF").unwrap();
        let depth =
            Array4::from_shape_fn((3, 5, 4, 7), |(t, h, v, u)| 8.0 + (t * 5 + h) as f32 * 0.1 + (v + u) as f32 * 0.01);
        file.new_dataset_builder().with_data(depth.view()).create("GT_DEPTH").unwrap();
        for (name, value) in [("dH", 3.5), ("dV", 3.5), ("focalLength", 1.2), ("shift", 0.42)] {
            file.new_attr::<f64>().create(name).unwrap().write_scalar(&value).unwrap();
        }
        drop(file);
        let reader = LightFieldReader::open(&path, &ReadOptions::default()).unwrap();
        assert_eq!(reader.format(), LightFieldFormat::OldHci);
        let central = reader.central_depth_m().unwrap().unwrap();
        let disparity = reader.central_disparity_px().unwrap().unwrap();
        for ((v, u), &found) in central.indexed_iter() {
            assert_eq!(found, depth[[1, 5 - 1 - 2, v, u]]);
            let expected = 3.5 * 1.2 / f64::from(found) - 0.42;
            assert!((f64::from(disparity[[v, u]]) - expected).abs() < 1e-6);
        }
        let rig = *reader.rig().expect("a rig");
        assert!((rig.disparity().from_depth_m(8.0) - (4.2 / 8.0 - 0.42)).abs() < 1e-9);
        let file = reader.read().unwrap();
        for ((v, u, t, s, c), &found) in samples(&file.light_field).indexed_iter() {
            assert_eq!(found, u16::from(stored[[t, 4 - s, v, u, c]]));
        }
    }

    /// LFToolbox's decoded light field has the weight of every sample as a fourth channel.
    #[test]
    fn decoded_files_of_the_toolbox_have_weights() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("IMG_0001__Decoded.mat");
        let file = hdf5::FileBuilder::new().with_fcpl(|properties| properties.userblock(512)).create(&path).unwrap();
        // LF(t, s, v, u, c) in MATLAB; an HDF5 reader sees the axes reversed.
        let value =
            |t: usize, s: usize, v: usize, u: usize, c: usize| (10_000 * t + 1000 * s + 100 * v + 10 * u + c) as u16;
        let stored = Array5::from_shape_fn((4, 7, 4, 5, 3), |(c, u, v, s, t)| value(t, s, v, u, c));
        let dataset = file.new_dataset_builder().with_data(stored.view()).create("LF").unwrap();
        let class = hdf5::types::FixedAscii::<6>::from_ascii("uint16").unwrap();
        dataset.new_attr::<hdf5::types::FixedAscii<6>>().create("MATLAB_class").unwrap().write_scalar(&class).unwrap();
        drop((dataset, file));
        let mut bytes = std::fs::read(&path).unwrap();
        let mut header = b"MATLAB 7.3 MAT-file, Platform: GLNXA64".to_vec();
        header.resize(116, b' ');
        header.extend([0; 8]);
        header.extend([0, 2, b'I', b'M']);
        bytes[..128].copy_from_slice(&header);
        std::fs::write(&path, &bytes).unwrap();
        let file = read_light_field(&path, &ReadOptions::default()).unwrap();
        assert_eq!(file.format, LightFieldFormat::Mat);
        for ((v, u, t, s, c), &found) in samples(&file.light_field).indexed_iter() {
            assert_eq!(found, value(t, s, v, u, c));
        }
        assert_eq!(file.light_field.channels(), 4);
        assert_eq!(file.light_field.without_alpha().unwrap().channels(), 3);
    }
}

//! Materials, textures and extensions.

use holo_scene::gltf::{Limits, load_slice};
use holo_scene::{Filter, Texture, Wrap};
use serde_json::{Value, json};

use super::support::{File, assert_contains, base64, png, triangle};

const TEXELS: [[u8; 4]; 6] =
    [[255, 0, 0, 255], [0, 255, 0, 255], [0, 0, 255, 255], [9, 8, 7, 6], [128, 127, 126, 0], [1, 2, 3, 200]];

/// A triangle whose material's base color is an embedded image.
fn textured(image: &[u8]) -> File {
    let mut file = triangle();
    let view = file.view(image);
    file.push("images", json!({ "bufferView": view, "mimeType": "image/png", "name": "picture" }));
    file.push("textures", json!({ "source": 0 }));
    file.push(
        "materials",
        lambert(json!({ "baseColorTexture": { "index": 0 }, "baseColorFactor": [0.5, 0.25, 1, 1] })),
    );
    file.json["meshes"][0]["primitives"][0]["material"] = json!(0);
    let coordinates = file.floats(&[[0.0_f32, 0.0], [1.0, 0.0], [0.0, 1.0]]);
    file.json["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"] = json!(coordinates);
    file
}

/// A material that is Lambertian.
fn lambert(surface: Value) -> Value {
    let mut surface = surface;
    surface["metallicFactor"] = json!(0);
    json!({ "pbrMetallicRoughness": surface, "extensions": { "KHR_materials_specular": { "specularFactor": 0 } } })
}

fn only_texture(file: &File) -> Texture {
    let textures = file.load().unwrap().scene.textures;
    assert_eq!(textures.len(), 1);
    textures.into_iter().next().unwrap()
}

#[test]
fn embedded_png() {
    let file = textured(&png(3, 2, &TEXELS));
    let loaded = file.load().unwrap();
    assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
    let scene = loaded.scene;
    assert_eq!(scene.materials[0].base_color, [0.5, 0.25, 1.0, 1.0]);
    assert_eq!(scene.materials[0].base_color_texture.map(|used| used.texture), Some(0));
    let texture = &scene.textures[0];
    assert_eq!((texture.width, texture.height, texture.name.as_str()), (3, 2, "picture"));
    assert_eq!(texture.texels, TEXELS);
    assert_eq!((texture.wrap_u, texture.wrap_v), (Wrap::Repeat, Wrap::Repeat));
}

#[test]
fn wrap_modes() {
    let mut file = textured(&png(3, 2, &TEXELS));
    file.json["textures"][0]["sampler"] = json!(0);
    let modes = [(10497, Wrap::Repeat), (33071, Wrap::Clamp), (33648, Wrap::Mirror)];
    for (code_u, wrap_u) in modes {
        for (code_v, wrap_v) in modes {
            file.json["samplers"] = json!([{ "wrapS": code_u, "wrapT": code_v }]);
            let texture = only_texture(&file);
            assert_eq!((texture.wrap_u, texture.wrap_v), (wrap_u, wrap_v));
        }
    }
    file.json["samplers"] = json!([{ "wrapT": 10496 }]);
    assert_contains(&file.error(), &["samplers[0].wrapT", "10496"]);
}

#[test]
fn filters() {
    let mut file = textured(&png(3, 2, &TEXELS));
    assert_eq!(only_texture(&file).filter, Filter::Linear);
    file.json["textures"][0]["sampler"] = json!(0);
    let cases = [
        (json!({ "magFilter": 9728 }), Filter::Nearest),
        (json!({ "magFilter": 9728, "minFilter": 9987 }), Filter::Nearest),
        (json!({ "magFilter": 9729, "minFilter": 9728 }), Filter::Linear),
        (json!({}), Filter::Linear),
    ];
    for (sampler, filter) in cases {
        file.json["samplers"] = json!([sampler]);
        let loaded = file.load().unwrap();
        assert_eq!((loaded.scene.textures[0].filter, loaded.warnings), (filter, vec![]), "{sampler}");
    }
}

#[test]
fn images_of_other_bit_depths_become_8_bit() {
    let bytes = |image: image::DynamicImage, format| {
        let mut bytes = std::io::Cursor::new(Vec::new());
        image.write_to(&mut bytes, format).unwrap();
        bytes.into_inner()
    };
    let deep = image::ImageBuffer::<image::Rgb<u16>, _>::from_raw(1, 1, vec![65535_u16, 0x80_80, 0]).unwrap();
    let texture = only_texture(&textured(&bytes(deep.into(), image::ImageFormat::Png)));
    assert_eq!(texture.texels, [[255, 128, 0, 255]]);
    let gray = image::GrayImage::from_raw(1, 1, vec![77]).unwrap();
    let texture = only_texture(&textured(&bytes(gray.into(), image::ImageFormat::Png)));
    assert_eq!(texture.texels, [[77, 77, 77, 255]]);
    // JPEG, although its MIME type is PNG.
    let flat = image::RgbImage::from_pixel(16, 8, image::Rgb([200, 100, 50]));
    let texture = only_texture(&textured(&bytes(flat.into(), image::ImageFormat::Jpeg)));
    assert_eq!((texture.width, texture.height), (16, 8));
    assert!(texture.texels.iter().all(|t| t[0].abs_diff(200) < 4 && t[1].abs_diff(100) < 4 && t[2].abs_diff(50) < 4));
}

#[test]
fn textures_that_share_an_image() {
    let mut file = textured(&png(3, 2, &TEXELS));
    file.push("samplers", json!({ "wrapS": 33071 }));
    file.push("textures", json!({ "source": 0, "sampler": 0, "name": "other" }));
    let textures = file.load().unwrap().scene.textures;
    assert_eq!(textures.len(), 2);
    assert_eq!(textures[0].texels, textures[1].texels);
    assert_eq!((textures[1].wrap_u, textures[1].name.as_str()), (Wrap::Clamp, "other"));
}

/// The texture is left out of the scene and of the material, with a warning.
#[track_caller]
fn assert_drawn_without(file: &File, words: &[&str]) {
    let loaded = file.load().unwrap();
    assert!(loaded.scene.textures.is_empty() && loaded.scene.materials[0].base_color_texture.is_none());
    assert_eq!(loaded.warnings.len(), 1, "{:?}", loaded.warnings);
    assert_contains(&loaded.warnings[0], words);
    assert_contains(&loaded.warnings[0], &["drawn without it"]);
}

#[test]
fn textures_without_a_usable_image_are_left_out() {
    let whole = png(3, 2, &TEXELS);
    assert_drawn_without(&textured(&whole[..whole.len() - 30]), &["textures[0] (images[0])", "cannot be decoded"]);
    let kinds: [(&[u8], &str); 8] = [
        (b"GIF89a", "GIF"),
        (b"DDS |\0\0\0", "DDS"),
        (b"II*\0........", "TIFF"),
        (b"\xABKTX 20\xBB\r\n\x1A\n....", "KTX2 image (decode it with `npx @gltf-transform/cli ktxdecompress"),
        (b"version https://git-lfs.github.com/spec/v1\n", "git lfs pull"),
        (b"<!DOCTYPE html><html>", "HTML"),
        (b"8BPS\0\x01", "Photoshop"),
        (b"nothing at all", "neither PNG nor JPEG nor WebP"),
    ];
    for (bytes, kind) in kinds {
        assert_drawn_without(&textured(bytes), &["images[0]", kind]);
    }
    let mut file = textured(&whole);
    file.json["images"][0] = json!({ "uri": "missing.png" });
    assert_drawn_without(&file, &["missing.png", "load the scene from its path"]);
    for uri in ["../up.png", "/etc/up.png", "http://example.org/up.png"] {
        file.json["images"][0] = json!({ "uri": uri });
        assert_drawn_without(&file, &["up.png"]);
    }
    file.json["images"][0] = json!({});
    assert_drawn_without(&file, &["images[0]", "neither bufferView nor uri"]);
    file.json["textures"][0] = json!({});
    assert_drawn_without(&file, &["textures[0]", "no image"]);
}

#[test]
fn missing_image_files_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let mut file = textured(&png(3, 2, &TEXELS));
    file.json["images"][0] = json!({ "uri": "textures/wood.png" });
    let path = folder.path().join("scene.glb");
    std::fs::write(&path, file.glb()).unwrap();
    let loaded = holo_scene::gltf::load(&path, &Limits::default()).unwrap();
    assert!(loaded.scene.textures.is_empty());
    assert_contains(
        &loaded.warnings.join("\n"),
        &["textures[0] (images[0] 'textures/wood.png')", "cannot be read", "drawn without it"],
    );
    // A folder in its place.
    std::fs::create_dir_all(folder.path().join("textures/wood.png")).unwrap();
    let loaded = holo_scene::gltf::load(&path, &Limits::default()).unwrap();
    assert_contains(&loaded.warnings.join("\n"), &["not a file", "drawn without it"]);
    // The limit of bytes is no missing file.
    std::fs::remove_dir(folder.path().join("textures/wood.png")).unwrap();
    std::fs::write(folder.path().join("textures/wood.png"), vec![0; 100_000]).unwrap();
    let limits = Limits { max_bytes: 50_000, ..Limits::default() };
    assert_contains(&holo_scene::gltf::load(&path, &limits).unwrap_err().to_string(), &["limit"]);
}

#[test]
fn wrong_references_of_textures_are_errors() {
    let mut file = textured(&png(3, 2, &TEXELS));
    file.json["textures"][0]["source"] = json!(4);
    assert_contains(&file.error(), &["textures[0].source", "images[4]"]);
    file.json["textures"][0] = json!({ "source": 0, "extensions": { "EXT_texture_webp": { "source": 5 } } });
    assert_contains(&file.error(), &["EXT_texture_webp.source", "images[5]"]);
    file.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]["index"] = json!(1);
    assert_contains(&file.error(), &["materials[0].pbrMetallicRoughness.baseColorTexture.index", "textures[1]"]);
}

/// A lossless WebP of one color.
fn webp(texel: [u8; 4]) -> Vec<u8> {
    let mut bytes = std::io::Cursor::new(Vec::new());
    image::RgbaImage::from_pixel(1, 1, image::Rgba(texel)).write_to(&mut bytes, image::ImageFormat::WebP).unwrap();
    bytes.into_inner()
}

#[test]
fn webp_and_ktx2_images_with_fallback() {
    let mut file = textured(&png(3, 2, &TEXELS));
    let good = file.view(&webp([10, 20, 30, 40]));
    let damaged = file.view(&webp([10, 20, 30, 40])[..24]);
    let ktx = file.view(b"\xABKTX 20\xBB\r\n\x1A\n....");
    for view in [good, damaged, ktx] {
        file.push("images", json!({ "bufferView": view }));
    }
    file.json["extensionsRequired"] = json!(["EXT_texture_webp", "KHR_texture_basisu"]);
    let mut load = |texture: Value| {
        file.json["textures"][0] = texture;
        let loaded = file.load().unwrap();
        (loaded.scene.textures.first().map(|texture| texture.texels[0]), loaded.warnings.join("\n"))
    };
    let with = |name: &str, source: u64| json!({ name: { "source": source } });
    assert_eq!(load(json!({ "extensions": with("EXT_texture_webp", 1) })), (Some([10, 20, 30, 40]), String::new()));
    // The image in the extension is preferred.
    let both = json!({ "source": 0, "extensions": with("EXT_texture_webp", 1) });
    assert_eq!(load(both), (Some([10, 20, 30, 40]), String::new()));
    let (texel, warnings) = load(json!({ "source": 0, "extensions": with("EXT_texture_webp", 2) }));
    assert_eq!(texel, Some(TEXELS[0]));
    assert_contains(&warnings, &["images[2]", "cannot be decoded", "fallback is used"]);
    let (texel, warnings) = load(json!({ "source": 0, "extensions": with("KHR_texture_basisu", 3) }));
    assert_eq!(texel, Some(TEXELS[0]));
    assert_contains(&warnings, &["images[3]", "KTX2", "fallback is used"]);
    let (texel, warnings) = load(json!({ "extensions": with("KHR_texture_basisu", 3) }));
    assert_eq!(texel, None);
    assert_contains(&warnings, &["KTX2", "npx @gltf-transform/cli ktxdecompress", "drawn without it"]);
    // WebP without the extension, as some exporters write it.
    assert_eq!(load(json!({ "source": 1 })), (Some([10, 20, 30, 40]), String::new()));
}

/// Many textures may fall back to one image; each has its own copy.
#[test]
fn copies_of_fallback_images_count() {
    let mut file = textured(&png(3, 2, &TEXELS));
    let ktx = file.view(b"\xABKTX 20\xBB\r\n\x1A\n....");
    file.push("images", json!({ "bufferView": ktx }));
    for _ in 0..4 {
        file.push("textures", json!({ "source": 0, "extensions": { "KHR_texture_basisu": { "source": 1 } } }));
    }
    let limits = |max_texture_pixels| Limits { max_texture_pixels, ..Limits::default() };
    assert_eq!(load_slice(&file.glb(), &limits(30)).unwrap().scene.textures.len(), 5);
    assert_contains(
        &load_slice(&file.glb(), &limits(29)).unwrap_err().to_string(),
        &["images[0]", "limit of 29 pixels"],
    );
}

#[test]
fn huge_images_are_rejected_before_decoding() {
    let file = textured(&png(3, 2, &TEXELS));
    let limits = |max_texture_pixels| Limits { max_texture_pixels, ..Limits::default() };
    assert!(load_slice(&file.glb(), &limits(6)).is_ok());
    assert_contains(&load_slice(&file.glb(), &limits(5)).unwrap_err().to_string(), &["images[0]", "limit of 5 pixels"]);
    // Only the header has 2^31 - 1 x 2^31 - 1 pixels.
    let mut bytes = png(3, 2, &TEXELS);
    bytes[16..24].copy_from_slice(&[0x7F, 0xFF, 0xFF, 0xFF, 0x7F, 0xFF, 0xFF, 0xFF]);
    assert_drawn_without(&textured(&bytes), &["images[0]", "cannot be decoded"]);
}

/// A mesh has two sets of coordinates; a file may have more.
#[test]
fn textures_select_their_coordinates() {
    let mut file = textured(&png(3, 2, &TEXELS));
    for set in 1..4 {
        let coordinates = file.floats(&[[set as f32, 0.5]; 3]);
        file.json["meshes"][0]["primitives"][0]["attributes"][format!("TEXCOORD_{set}")] = json!(coordinates);
    }
    // The sets of base color, metallic-roughness and emission in the file; u of both loaded sets; the loaded set of
    // each use.
    let mut check = |sets: [u64; 3], mesh: [f32; 2], read: [Option<usize>; 3]| {
        file.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"] =
            json!({ "index": 0, "texCoord": sets[0] });
        file.json["materials"][0]["pbrMetallicRoughness"]["metallicRoughnessTexture"] =
            json!({ "index": 0, "texCoord": sets[1] });
        file.json["materials"][0]["emissiveTexture"] = json!({ "index": 0, "texCoord": sets[2] });
        let loaded = file.load().unwrap();
        let scene = &loaded.scene;
        // The second vertex of TEXCOORD_0 is (1, 0), those of the others are (set, 0.5).
        let [u, v] = scene.meshes[0].texture_coordinates[1];
        assert_eq!(
            [if v == 0.0 { 0.0 } else { u }, scene.meshes[0].second_texture_coordinates[1][0]],
            mesh,
            "{sets:?}"
        );
        let material = &scene.materials[0];
        let uses = [material.base_color_texture, material.metallic_roughness_texture, material.emission_texture];
        assert_eq!(uses.map(|used| used.map(|used| used.set)), read, "{sets:?}");
        loaded.warnings.join("\n")
    };
    assert_eq!(check([0, 0, 0], [0.0, 1.0], [Some(0), Some(0), Some(0)]), "");
    assert_eq!(check([1, 1, 0], [0.0, 1.0], [Some(1), Some(1), Some(0)]), "");
    assert_eq!(check([2, 2, 2], [2.0, 1.0], [Some(0), Some(0), Some(0)]), "");
    assert_eq!(check([3, 0, 3], [0.0, 3.0], [Some(1), Some(0), Some(1)]), "");
    assert_eq!(check([3, 1, 1], [3.0, 1.0], [Some(0), Some(1), Some(1)]), "");
    assert_eq!(check([3, 2, 3], [2.0, 3.0], [Some(1), Some(0), Some(1)]), "");
    let warnings = check([2, 0, 1], [0.0, 1.0], [None, Some(0), Some(1)]);
    assert_contains(&warnings, &["materials[0]", "more than two sets of coordinates"]);
}

#[test]
fn missing_coordinates_cause_a_warning() {
    let mut file = textured(&png(3, 2, &TEXELS));
    file.json["materials"][0]["emissiveTexture"] = json!({ "index": 0, "texCoord": 1 });
    let loaded = file.load().unwrap();
    assert!(loaded.scene.meshes[0].second_texture_coordinates.is_empty());
    assert_contains(&loaded.warnings.join("\n"), &["meshes[0].primitives[0]", "no coordinates"]);
    file.json["materials"][0]["emissiveTexture"]["texCoord"] = json!(u64::MAX);
    assert_contains(&file.load().unwrap().warnings.join("\n"), &["no coordinates"]);
    // As many as there are vertices, or none.
    let two = file.floats(&[[0.0_f32, 0.0]; 2]);
    file.json["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_1"] = json!(two);
    file.json["materials"][0]["emissiveTexture"]["texCoord"] = json!(1);
    assert_contains(&file.error(), &["meshes[0].primitives[0].attributes", "TEXCOORD has 2 elements"]);
}

#[test]
fn unused_textures_are_not_decoded() {
    let mut file = textured(&png(3, 2, &TEXELS));
    file.push("images", json!({ "uri": "missing.png" }));
    file.push("textures", json!({ "source": 1 }));
    file.json["materials"][0]["extensions"]["ACME_materials_paint"] = json!({ "paintTexture": { "index": 1 } });
    let loaded = file.load().unwrap();
    assert_eq!(loaded.scene.textures.len(), 1);
    assert_contains(&loaded.warnings.join("\n"), &["ACME_materials_paint"]);
    // A texture that a normal map uses is decoded.
    file.json["materials"][0]["normalTexture"] = json!({ "index": 1 });
    assert_contains(
        &file.load().unwrap().warnings.join("\n"),
        &["textures[1] (images[1] 'missing.png')", "drawn without it"],
    );
    // A texture without a supported image is omitted wherever it is used, with a warning.
    let mut file = textured(&png(3, 2, &TEXELS));
    file.json["textures"][0] = json!({ "extensions": { "MSFT_texture_dds": { "source": 0 } } });
    file.json["materials"][0]["normalTexture"] = json!({ "index": 0 });
    let loaded = file.load().unwrap();
    assert!(loaded.scene.textures.is_empty() && loaded.scene.materials[0].base_color_texture.is_none());
    assert_eq!(loaded.scene.materials[0].normal_map, None);
    assert_contains(&loaded.warnings.join("\n"), &["MSFT_texture_dds", "drawn without it"]);
}

#[test]
fn images_as_data_uris() {
    let mut file = textured(&png(3, 2, &TEXELS));
    let uri = format!("data:image/png;base64,{}", base64(&png(3, 2, &TEXELS)));
    file.json["images"][0] = json!({ "uri": uri });
    assert_eq!(only_texture(&file).texels, TEXELS);
}

#[test]
fn changes_cause_one_warning_per_kind() {
    let mut file = triangle();
    for _ in 0..500 {
        file.push("materials", json!({ "name": "mirror", "extensions": { "KHR_materials_ior": { "ior": 0 } } }));
        let volume = json!({ "thicknessFactor": 1, "thicknessTexture": { "index": 0 } });
        file.push("materials", json!({ "extensions": { "KHR_materials_volume": volume } }));
    }
    let lines = file.load().unwrap().warnings;
    assert_eq!(lines.len(), 2, "{lines:#?}");
    assert_contains(&lines[0], &["materials[0] 'mirror' and 499 more: an index of refraction"]);
    assert_contains(&lines[1], &["materials[1] '' and 499 more: thickness"]);
}

#[test]
fn extensions_are_supported_warned_about_or_rejected() {
    let mut file = triangle();
    file.json["extensionsUsed"] = json!(["KHR_lights_punctual", "KHR_materials_specular"]);
    file.json["extensionsRequired"] = json!(["KHR_lights_punctual", "KHR_materials_specular", "KHR_lights_punctual"]);
    let loaded = file.load().unwrap();
    assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
    assert_eq!(loaded.summary.extensions_required, ["KHR_lights_punctual", "KHR_materials_specular"]);

    file.json["extensionsUsed"] = json!(["KHR_materials_volume_scatter", "MSFT_texture_dds", "ACME_x", "ACME_x"]);
    let lines = file.load().unwrap().warnings;
    assert_eq!(lines.len(), 2, "{lines:?}");
    assert_contains(&lines[0], &["KHR_materials_volume_scatter, MSFT_texture_dds", "drawn without"]);
    assert_contains(&lines[1], &["ACME_x: used but not handled"]);

    file.json["extensionsRequired"] = json!(["KHR_lights_punctual", "ACME_x"]);
    let message = file.error();
    assert_contains(&message, &["extensionsRequired", "ACME_x", "not supported"]);
    assert!(!message.contains("KHR_lights_punctual"));
    file.json["extensionsRequired"] = json!([7]);
    assert_contains(&file.error(), &["extensionsRequired[0]", "string"]);

    // Used without being declared.
    let mut file = triangle();
    file.json["nodes"][0]["extensions"] = json!({ "ACME_undeclared": {} });
    file.json["nodes"][0]["extras"] = json!({ "extensions": { "ACME_not_one": {} } });
    let lines = file.load().unwrap().warnings.join("\n");
    assert_contains(&lines, &["ACME_undeclared"]);
    assert!(!lines.contains("ACME_not_one"));
}

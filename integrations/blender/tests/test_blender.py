# SPDX-License-Identifier: GPL-3.0-or-later
"""The extension in Blender without a window: `cargo xtask blender --test`.

Needs the module `bpy`, and the variables HOLO (the program) and HOLOSCOPIC_ZIP (the archive).
"""

import json
import math
import os
import pathlib
import subprocess
import sys
import types
import zipfile

import bpy
import numpy as np
import pytest

import compare
import scenes

# Mean brightness and RMSE relative to Cycles, both at 256 samples, without the 1 % of pixels that differ most. What is
# wider than noise: panels block other light (metal), the fit of edges (spot), the interpolation of textures.
MEAN, RMSE = 0.004, 0.03
WIDER = {"metal": (0.025, 0.04), "spot": (0.004, 0.03), "texture_and_modifiers": (0.006, 0.03), "world_image": (0.004, 0.05)}


@pytest.fixture(scope="session", autouse=True)
def extension(tmp_path_factory):
    """The archive, unpacked as Blender does, registered without stored preferences."""
    home = tmp_path_factory.mktemp("extensions")
    with zipfile.ZipFile(os.environ["HOLOSCOPIC_ZIP"]) as archive:
        assert "blender_manifest.toml" in archive.namelist()
        archive.extractall(home / "holoscopic")
    sys.path.insert(0, str(home))
    import holoscopic

    holoscopic.register()
    yield holoscopic
    holoscopic.unregister()
    assert not hasattr(bpy.types.Camera, "holoscopic")


@pytest.fixture
def scene():
    scenes.empty()
    scenes.light("SUN", 3.0, rotation=(0.5, 0.3, 0.0), angle=0.0)
    return bpy.context.scene


def render(folder, **options):
    return bpy.ops.render.holoscopic("EXEC_DEFAULT", directory=str(folder), **options)


@pytest.mark.parametrize("make", scenes.ALL, ids=lambda make: make.__name__)
def test_light_is_that_of_cycles(make, tmp_path, record):
    make()
    reference = compare.cycles(tmp_path)
    image = compare.holo(tmp_path)
    ratio, rmse = compare.differences(image, reference)
    record(make.__name__, ratio, rmse, reference, image)
    mean_bound, rmse_bound = WIDER.get(make.__name__, (MEAN, RMSE))
    assert abs(ratio - 1.0) < mean_bound and rmse < rmse_bound, (ratio, rmse)


@pytest.fixture(scope="session")
def record():
    """Collects rows of the table and pairs of images, and writes both beside HOLOSCOPIC_REPORT."""
    rows, images = [], []

    def add(name, ratio, rmse, reference, image):
        rows.append(f"| {name.replace('_', ' ')} | {ratio:.4f} | {100 * rmse:.2f} % |")
        images.append((reference, image))

    yield add
    if os.environ.get("HOLOSCOPIC_REPORT"):
        report = pathlib.Path(os.environ["HOLOSCOPIC_REPORT"])
        report.mkdir(parents=True, exist_ok=True)
        head = "| scene | mean / that of Cycles | RMSE / mean |\n|---|---|---|"
        (report / "cycles.md").write_text("\n".join([head, *rows]) + "\n")
        compare.side_by_side(report / "cycles.png", images)


def test_images_are_loaded(scene, tmp_path):
    assert render(tmp_path, views="5x4", lenses="60x40", spp=2) == {"FINISHED"}
    raw = bpy.data.images["Holoscopic Raw"]
    assert tuple(raw.size) == (5 * 60, 4 * 40) and raw.colorspace_settings.name == "sRGB"
    assert tuple(bpy.data.images["Holoscopic Views"].size) == (300, 160)
    assert bpy.data.images["Holoscopic Disparity"].colorspace_settings.name == "Non-Color"
    before = [image.name for image in bpy.data.images]
    assert render(tmp_path, views="3", lenses="60x40", spp=1) == {"FINISHED"}
    assert [image.name for image in bpy.data.images] == before, "images are replaced"
    assert tuple(raw.size) == (180, 120)
    scene_is_clean = {"Eye", "Plane", "Ball", "Sun"}
    assert {item.name for item in scene.objects} == scene_is_clean


def test_few_samples_are_shared_between_views(scene, tmp_path):
    from holoscopic import geometry

    texts = {1 / 64: "1/64", 0.25: "1/4", 0.3: "1/4", 0.5: "1/2", 0.9: "1", 1: "1", 16.0: "16", 1e-9: "1/64"}
    assert {spp: geometry.samples_text(spp) for spp in texts} == texts
    assert render(tmp_path, views="6", lenses="60x40", spp=0.25) == {"FINISHED"}
    pixels = bpy.data.images["Holoscopic Raw"].pixels[:]
    assert sum(pixels[0::4]) > 0.05 * len(pixels) / 4, "light reaches pixels without samples"


def test_the_panel_says_what_is_rendered(scene, tmp_path):
    camera = scene.camera
    settings = camera.data.holoscopic
    settings.sensor, settings.width, settings.height = "OTHER", 250, 170
    settings.views_x, settings.views_y = 4, 4
    settings.quality, settings.spp, settings.denoise = "SAMPLES", 1, False
    bpy.context.view_layer.objects.active = camera
    assert bpy.ops.holoscopic.measure() == {"FINISHED"}
    lines = drawn(camera)
    assert "Elemental images: 62 x 42, each 4 x 4 px" in lines
    assert "248 x 168 px of the sensor are used" in lines
    from holoscopic import properties

    for spacing, focus in (("DISPARITY", "AUTO"), ("AUTO", "AUTO"), ("OWN", "OWN"), ("OWN", "DOF")):
        settings.spacing, settings.focus, settings.baseline_mm = spacing, focus, 30.0
        camera.data.dof.focus_distance = 5.0
        low, high = properties.disparities(camera)
        assert render(tmp_path) == {"FINISHED"}
        manifest = json.loads((tmp_path / "manifest.json").read_text())
        rig = manifest["rig"]
        baseline_m, focus_m = properties.rig_of(camera)
        # A grid of rays misses the last pixel of a silhouette.
        assert math.isclose(rig["baseline_m"]["x"], baseline_m, rel_tol=0.03), (spacing, rig, baseline_m)
        assert math.isclose(rig["focus_distance_m"], focus_m, rel_tol=0.03), (spacing, focus)
        # What misses the scene has the disparity of infinity, which the panel leaves out.
        disparity = compare.read_pfm(tmp_path / "scene_disparity.pfm")
        seen = disparity[np.isfinite(compare.read_pfm(tmp_path / "scene_depth.pfm"))]
        span = seen.max() - seen.min()
        assert abs(seen.min() - low) < 0.04 * span and abs(seen.max() - high) < 0.04 * span, (spacing, low, high)


def drawn(camera):
    """The labels that the panel draws for a camera."""
    from holoscopic import panel

    labels = []

    class Layout:
        use_property_split = True

        def label(self, text="", icon=""):
            labels.append(text)

        def prop(self, owner, name, **_):
            assert name in owner.bl_rna.properties, name

        def operator(self, name, **_):
            return types.SimpleNamespace()

        column = row = box = lambda self, align=False: Layout()

    context = types.SimpleNamespace(camera=camera.data, object=camera, scene=bpy.context.scene)
    assert panel.HOLOSCOPIC_PT_camera.poll(context)
    panel.HOLOSCOPIC_PT_camera.draw(types.SimpleNamespace(layout=Layout()), context)
    return labels


def test_the_overlay_is_the_plane_of_zero_disparity(scene):
    from holoscopic import overlay

    camera = scene.camera
    settings = camera.data.holoscopic
    settings.spacing, settings.focus, settings.focus_m = "OWN", "OWN", 4.0
    bpy.context.view_layer.update()
    pairs = overlay.lines(camera, scene)
    assert len(pairs) == 10
    inverse = camera.matrix_world.inverted()
    eye = [0.0, 0.0, 0.0]
    depths = {round(-(inverse @ point).z, 4) for pair in pairs for point in pair if (inverse @ point).length > 1e-6}
    assert depths == {4.0} and any((inverse @ pair[0]).to_tuple(5) == tuple(eye) for pair in pairs)
    settings.spacing, settings.near_m = "DISPARITY", 0.0
    assert overlay.lines(camera, scene) == [], "without depths there is no focus yet"


def test_what_is_lost_is_listed(scene):
    from holoscopic import losses

    light = scenes.light("AREA", 10.0, spread=1.0)
    noise = scenes.material("noise", (1.0, 1.0, 1.0))
    node = noise.node_tree.nodes.new("ShaderNodeTexNoise")
    noise.node_tree.links.new(node.outputs[0], noise.node_tree.nodes["Principled BSDF"].inputs["Base Color"])
    bpy.data.objects["Ball"].data.materials.append(noise)
    scene.camera.data.dof.use_dof = True
    lines = losses.of_scene(bpy.context)
    for words in (f"{light.name}: spread", "noise: Noise Texture; bake", "Eye: depth of field"):
        assert any(line.startswith(words) for line in lines), (words, lines)
    labels = drawn(scene.camera)
    assert "Not exported" in labels and lines[0] in labels


def test_qualities_are_those_of_the_preview(scene):
    from holoscopic import operators, properties

    camera = scene.camera
    settings = camera.data.holoscopic
    page = (pathlib.Path(__file__).parents[3] / "crates/holo-preview/src/page/controls.js").read_text()
    for key, (_, _, options) in properties.QUALITIES.items():
        settings.quality = key
        found = operators.quality_options(camera)
        if options is None:
            assert found == {"spp": "16", "denoise": "views"}
            continue
        assert found == options
        words = ", ".join(f"'{name}': '{value}'" if "-" in name else f"{name}: '{value}'" for name, value in options.items())
        assert f"{key.lower()}: {{ {words} }}" in page, words
    settings.quality = "DRAFT"
    assert operators.quality_options(camera, 4) == {"spp": "4", "denoise": "views"}


def test_a_camera_file_of_ones_own(scene, tmp_path):
    settings = scene.camera.data.holoscopic
    settings.kind, settings.preset = "PLENOPTIC", "OWN"
    with pytest.raises(RuntimeError, match="camera file"):
        render(tmp_path, spp=1)
    mine = tmp_path / "mine.toml"
    subprocess.run([os.environ["HOLO"], "camera", "h3dv", "--out", str(mine)], check=True, capture_output=True)
    settings.camera_file = str(mine)
    assert render(tmp_path / "out", spp=1, options="--integrator=direct") == {"FINISHED"}
    assert tuple(bpy.data.images["Plenoptic Raw"].size) == (1920, 1088)


def test_presets_are_those_of_the_program():
    from holoscopic import properties

    listed = subprocess.run([os.environ["HOLO"], "camera"], capture_output=True, text=True, check=True).stdout
    assert {line.split()[0] for line in listed.splitlines()} == {name for name, *_ in properties.PRESETS} - {"OWN"}


def test_a_plenoptic_camera(scene, tmp_path):
    settings = scene.camera.data.holoscopic
    settings.kind, settings.preset, settings.focus, settings.focus_m = "PLENOPTIC", "h3dv", "OWN", 5.0
    assert "Camera" not in drawn(scene.camera)
    assert render(tmp_path, spp=1, options="--integrator=direct") == {"FINISHED"}
    assert tuple(bpy.data.images["Plenoptic Raw"].size) == (1920, 1088)


def test_animation_renders_every_frame(scene, tmp_path):
    ball = bpy.data.objects["Ball"]
    scene.frame_start, scene.frame_end = 1, 3
    scene.frame_set(2)
    for frame, x in ((1, -1.0), (3, 1.0)):
        ball.location.x = x
        ball.keyframe_insert("location", frame=frame)
    assert render(tmp_path, views="2", lenses="30x20", spp=1, animation=True) == {"FINISHED"}
    depths = [compare.read_pfm(tmp_path / f"frame_{frame:04d}" / "scene_depth.pfm") for frame in (1, 2, 3)]
    assert scene.frame_current == 2
    # The ball is nearer than the floor, and moves from left to right.
    left = [np.argmin(depth[10, :, 0]) for depth in depths]
    assert left[0] < left[1] < left[2], left


def test_the_program_is_found_in_order(monkeypatch, tmp_path):
    from holoscopic import preferences

    assert preferences.find() == os.environ["HOLO"]
    monkeypatch.setenv("HOLO", str(tmp_path / "none"))
    with pytest.raises(FileNotFoundError, match="HOLO names"):
        preferences.find()
    monkeypatch.delenv("HOLO")
    monkeypatch.setenv("PATH", str(tmp_path))
    bundled = pathlib.Path(preferences.__file__).parent / "bin" / preferences.PROGRAM
    if not bundled.is_file():
        with pytest.raises(FileNotFoundError, match="set its path"):
            preferences.find()
        (tmp_path / preferences.PROGRAM).write_text("#!/bin/sh\n")
        (tmp_path / preferences.PROGRAM).chmod(0o755)
        assert preferences.find() == str(tmp_path / preferences.PROGRAM)


def test_errors_are_those_of_the_program(scene, tmp_path):
    with pytest.raises(RuntimeError, match="no-such-option"):
        render(tmp_path / "a", views="2", lenses="30x20", options="--no-such-option")
    with pytest.raises(RuntimeError, match="views"):
        render(tmp_path / "b", views="two", lenses="30x20")
    scene.camera.data.holoscopic.views_x = 100_000
    with pytest.raises(RuntimeError, match="too small"):
        render(tmp_path / "c")
    assert {item.name for item in scene.objects} == {"Eye", "Plane", "Ball", "Sun"}


def test_a_canceled_render_leaves_nothing(scene, tmp_path):
    from holoscopic import export, preferences, program

    exported = export.write(bpy.context, tmp_path)
    out = tmp_path / "out"
    options = {"views": "20", "lenses": "300x200", "spp": 512, "checkpoint": 0}
    run = program.Run(program.words(preferences.find(), exported, out, options))
    while run.is_running() and run.process.poll() is None and not out.is_dir():
        pass
    run.stop()
    with pytest.raises(RuntimeError, match="stopped"):
        run.finish()
    assert not out.is_dir() or not list(out.iterdir())

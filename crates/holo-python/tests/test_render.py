"""Renders: the same samples as the command line, options and their errors, Ctrl-C."""

import json
import os
import pickle
import signal
import subprocess
import sys
import threading
import time

import holo
import numpy as np
import pytest

COMMAND = [sys.executable, "-m", "holo"]


def run(*words, code=0):
    done = subprocess.run([*COMMAND, *map(str, words)], capture_output=True, text=True, env=os.environ)
    assert done.returncode == code, done.stderr
    return done


def test_samples_and_files_are_those_of_the_command_line(tmp_path, garden, rendering, options):
    garden.save(tmp_path / "garden.glb")
    words = ["--views", "4x5", "--lenses", "72x48", "--spp", "2", "--seed", "7", "--disparity=-1,1", "--quiet"]
    run("render", tmp_path / "garden.glb", "--out", tmp_path / "cli", *words, "--write", "el,h5,disparity")
    # Linear samples.
    field = holo.open(tmp_path / "cli" / "scene_5d.h5")
    assert np.array_equal(field.array, rendering.light_field.array) and field.rig == rendering.rig
    # Integers.
    raw = holo.read_image(tmp_path / "cli" / "scene_el.png")
    assert np.array_equal(raw, rendering.light_field.encode().elemental_grid())
    assert np.array_equal(holo.read_image(tmp_path / "cli" / "scene_disparity.pfm"), rendering.disparity)
    # Files, and what the manifest says of them.
    report = holo.render_to(
        tmp_path / "python", tmp_path / "garden.glb", write=["el", "h5", "disparity"], **options
    )
    names = sorted(path.name for path in (tmp_path / "cli").iterdir())
    assert sorted(path.name for path in (tmp_path / "python").iterdir()) == names
    for name in names:
        assert (tmp_path / "cli" / name).read_bytes() == (tmp_path / "python" / name).read_bytes(), name
    assert set(report["files"]) <= set(names) and report["rig"]["views"] == {"columns": 4, "rows": 5}


def test_threads_and_backends(garden, rendering, options):
    one = holo.render(garden, threads=1, **options)
    assert np.array_equal(one.light_field.array, rendering.light_field.array)
    slow = holo.render(garden, backend="bvh", integrator="depth", **options)
    assert slow.color is None
    with pytest.raises(holo.UsageError, match="no color"):
        slow.light_field.lenses  # noqa: B018
    assert np.mean(np.abs(slow.disparity - rendering.disparity) < 1e-4) > 0.99


def test_ground_truth_of_all_views(garden, options):
    result = holo.render(garden, integrator="depth", layers=["depth", "disparity"], ground_truth="all", **options)
    assert result.depth.shape == (48, 72, 5, 4)
    assert np.array_equal(result.depth[:, :, 2, 2], result.central_layers["depth"])
    expected = result.rig.disparity_from_depth(result.depth)
    assert np.nanmax(np.abs(expected - result.disparity)) < 1e-5


def test_scenes_of_arrays():
    corners = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], dtype=float)
    wall = holo.Mesh(corners, [[0, 1, 2], [0, 2, 3]], base_color=(0.2, 0.5, 0.8))
    scene = holo.Scene.from_meshes(wall, camera=((0, 0, 3), (0, 0, 0)), angle_of_view_deg=20)
    flat = dict(views=(3, 3), lenses=(20, 20), sky=1.0, spp=4, focus_m=3.0, baseline_m=0.01)
    with pytest.warns(holo.HoloWarning, match="hardly differ"):
        result = holo.render(scene, **flat)
    # A white sky on a Lambertian plane: radiance is the base color.
    assert np.allclose(result.light_field.array, np.float32([0.2, 0.5, 0.8]), atol=2e-3)
    assert np.allclose(result.depth, 3.0, rtol=1e-6) and np.allclose(result.disparity, 0.0, atol=1e-6)
    copied = holo.Scene.from_glb(scene.to_glb(), "wall")
    with pytest.warns(holo.HoloWarning, match="hardly differ"):
        again = holo.render(copied, **flat)
    assert np.array_equal(again.light_field.array, result.light_field.array)
    assert pickle.loads(pickle.dumps(scene)).to_glb() == scene.to_glb()
    with pytest.raises(holo.UsageError, match=r"faces of shape \(2, 2\)"):
        holo.Scene.from_meshes(holo.Mesh(corners, [[0, 1], [0, 2]]))
    with pytest.raises(holo.Error, match="9"):
        holo.Scene.from_meshes(holo.Mesh(corners, [[0, 1, 9]]))


def test_plenoptic_camera(tmp_path):
    camera = holo.PlenopticCamera.open("lytro-illum")
    assert camera.name == "lytro-illum" and camera.name in holo.PlenopticCamera.presets()
    assert pickle.loads(pickle.dumps(camera)).to_toml() == camera.to_toml()
    assert camera.adjusted(focus_m=0.5).optics()["focus_distance_m"] == pytest.approx(0.5)
    small = holo.PlenopticCamera.from_toml(SMALL_CAMERA, "small")
    scene = holo.Scene.gallery("plaster")
    raw = holo.render_raw(scene, small, spp=4, layers=["depth", "coverage", "white", "lens-row"])
    rows, columns = small.sensor
    assert raw.image.shape == (rows, columns, 3) and raw.layers["depth"].shape == (rows, columns)
    assert np.array_equal(raw.layers["white"], small.white_image()) and raw.layers["coverage"].max() <= 1.0
    assert set(np.unique(raw.layers["lens-row"])) <= set(small.micro_images()["row"].astype(np.float32))
    holo.render_to(tmp_path / "raw", scene, camera_file=small, spp=4, write=["raw"])
    written = holo.read_image(tmp_path / "raw" / "raw.exr")
    assert np.allclose(written, raw.image, rtol=1e-3, atol=1e-4)
    centers = small.micro_images()
    assert len(centers["x"]) == len(centers["row"]) > 10
    decoded = raw.decode()
    assert decoded.light_field.rig is not None and decoded.weight.shape == decoded.light_field.array.shape[:4]
    assert decoded.depth is None
    with pytest.raises(holo.Error, match="need no depth"):
        raw.decode(depth=raw.layers["depth"])
    codes, info = holo.develop(raw.image, "imx250")
    assert codes.shape == (rows, columns) and codes.dtype == np.uint16 and info["name"] == "imx250"
    assert "imx250" in holo.sensor_models()
    color = holo.demosaic(codes.astype(np.float32), "RGGB")
    assert color.shape == (rows, columns, 3)
    with pytest.raises(holo.UsageError, match="no effect"):
        holo.render_raw(scene, small, views=(3, 3))


def test_views_of_a_focused_camera():
    """From micro-images views are rendered, along an estimate of the depth or along the rendered one."""
    text = SMALL_CAMERA.replace('focal_um = "pupil"', "focal_um = [430.0]").replace("[120, 90]", "[240, 200]").replace("6.0", "3.0")
    camera = holo.PlenopticCamera.from_toml(text, "focused")
    raw = holo.render_raw(holo.Scene.gallery("plaster"), camera, spp=16, layers=["depth"])
    for depth in (None, raw.layers["depth"]):
        decoded = raw.decode(views=3, depth=depth)
        field = decoded.light_field
        assert field.views == (3, 3) and decoded.depth.shape == field.lenses and (decoded.weight > 0).all()
        assert field.rig.views == (3, 3) and 0.5 < field.array.mean() / field.central.mean() < 2.0
    depths = raw.layers["depth"]
    assert depths.min() * 0.99999 <= decoded.depth.min() and decoded.depth.max() <= depths.max() * 1.00001


SMALL_CAMERA = """
[sensor]
size_px = [120, 90]
pixel_um = 6.0
[mla]
pitch_um = 60.0
gap_um = 300.0
focal_um = "pupil"
grid = "square"
[main_lens]
focal_mm = 20.0
f_number = 5.0
focus_m = 1.5
"""


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"views": (3,)}, "rows, columns"),
        ({"views": "3y"}, "views=3y"),
        ({"sensr": "8k"}, "sensr"),
        ({"spp": "many"}, "spp=many"),
        ({"layers": ["depth", "smell"]}, "smell"),
        ({"integrator": "photon"}, "photon"),
        ({"sky": (1, 2)}, "sky"),
        ({"backend": "gpu"}, "auto, embree, bvh"),
        ({"write": ["el"]}, "render_to"),
        ({"lenses": (10, 10), "integrator": "depth", "layers": ["color"]}, "color"),
    ],
)
def test_wrong_options(garden, options, words):
    with pytest.raises(holo.UsageError, match=words):
        holo.render(garden, **options)


def test_errors_name_keywords_of_python(tmp_path, garden, options):
    # On the command line it is --for, which is a word of Python.
    with pytest.raises(holo.UsageError, match="^tools=lftoolbox is of a plenoptic camera; give one with camera_file"):
        holo.render_to(tmp_path / "a", garden, tools=["lftoolbox"], **options)


def test_scenes_that_are_not_there(tmp_path):
    with pytest.raises(holo.UsageError, match="the gallery has no scene 'gardn'"):
        holo.Scene.gallery("gardn")
    with pytest.raises(holo.Error, match="no such file"):
        holo.render(tmp_path / "scene.glb")
    (tmp_path / "broken.glb").write_bytes(b"glTF")
    with pytest.raises(holo.Error, match="broken.glb"):
        holo.render(tmp_path / "broken.glb")


def test_a_folder_with_another_image_is_kept(tmp_path, garden, options):
    holo.render_to(tmp_path / "a", garden, write=["el"], **options)
    with pytest.raises(holo.UsageError, match="overwrite"):
        holo.render_to(tmp_path / "a", garden, write=["el"], **{**options, "seed": 8})
    holo.render_to(tmp_path / "a", garden, write=["el"], overwrite=True, **{**options, "seed": 8})


def test_warnings_are_warnings(options):
    far = holo.Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
    scene = holo.Scene.from_meshes(far, camera=((0, 0, -3), (0, 0, -9)))
    with pytest.warns(holo.HoloWarning, match="nothing is hit"):
        holo.render(scene, views=(3, 3), lenses=(8, 8), focus_m=2.0, baseline_m=0.01)


def test_without_embree_it_says_so_once(garden, options):
    code = (
        "import warnings, holo\n"
        "warnings.simplefilter('always')\n"
        "for _ in range(2):\n"
        "    holo.render(holo.Scene.gallery('plaster'), views=(2, 2), lenses=(8, 8), spp=1, disparity=(-1, 1))\n"
    )
    environment = {**os.environ, "HOLO_EMBREE_LIB": "/nonexistent/libembree4.so"}
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, env=environment, check=True)
    assert done.stderr.count("its extra `embree`") == 1, done.stderr


def test_progress_and_its_exceptions(garden, options):
    seen = []
    holo.render(garden, progress=lambda done, total: seen.append((done, total)), **{**options, "spp": 8})
    assert seen and all(done <= total for done, total in seen) and seen == sorted(seen)

    def stop(done, total):
        raise RuntimeError("enough")

    with pytest.raises(RuntimeError, match="enough"):
        holo.render(garden, progress=stop, **{**options, "lenses": (200, 300), "spp": 64})


def test_progress_runs_once_over_all_frames(tmp_path):
    seen = []
    options = {"views": (2, 3), "lenses": (40, 60), "spp": 64, "integrator": "direct", "write": ["el"], "layers": ["depth"]}
    scene = holo.Scene.gallery("pendulum")
    report = holo.render_to(tmp_path, scene, frame="4-6", progress=lambda *now: seen.append(now), **options)
    assert report["made"] == 3
    assert seen and seen == sorted(seen) and {total for _, total in seen} == {3000}


def test_other_threads_run_and_ctrl_c_stops(garden, options):
    # A process that a shell started in the background ignores the signal.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    ticks = []
    stopping = threading.Event()

    def tick():
        while not stopping.wait(0.01):
            ticks.append(time.perf_counter())

    def interrupt():
        time.sleep(1.0)
        os.kill(os.getpid(), signal.SIGINT)

    for work in (tick, interrupt):
        threading.Thread(target=work, daemon=True).start()
    start = time.perf_counter()
    with pytest.raises(KeyboardInterrupt):
        holo.render(garden, **{**options, "lenses": (200, 300), "spp": 4096})
    stopping.set()
    assert time.perf_counter() - start < 20
    assert len(ticks) > 10, "the interpreter was not free"


def test_command_line():
    assert "holo" in run("--version").stdout
    assert "Usage" in run("render", "--help").stdout
    assert "--no-such" in run("render", "--no-such", code=2).stderr
    assert json.loads(run("optics", "--focal-mm", "50", "--views", "9x9", "--lenses", "100x80", "--focus-m", "2", "--json").stdout)


def test_datasets(tmp_path):
    run("dataset", "--out", tmp_path / "d", "--scenes", "plaster,mountains", "--views", "3x2", "--sensor", "60x40", "--spp", "1",
        "--write", "el,h5,disparity,depth", "--quiet")
    dataset = holo.Dataset(tmp_path / "d")
    assert [job.scene for job in dataset] == ["plaster", "mountains"] and dataset[0].views == (2, 3)
    for job in dataset:
        field = job.light_field
        assert field.views == (2, 3) and field.array.dtype == np.float32
        assert np.array_equal(job.view(1, 2), field.view(1, 2))
        assert job.disparity.shape == job.depth.shape == field.lenses
        assert job.manifest["rig"]["views"] == {"columns": 3, "rows": 2}
    assert len(holo.Dataset(tmp_path / "d", scenes=["plaster"])) == 1
    assert len(holo.Dataset(tmp_path / "d", views=[(9, 9)])) == 0
    with pytest.raises(holo.Error, match="dataset.json"):
        holo.Dataset(tmp_path)


def test_frames_go_into_folders(tmp_path):
    scene = holo.Scene.gallery("pendulum")
    options = {"frame": "4-6", "views": (2, 3), "lenses": (8, 12), "spp": 1, "integrator": "direct", "write": ["el", "h5"]}
    report = holo.render_to(tmp_path / "whole", scene, **options)
    assert (report["made"], report["kept"]) == (3, 0)
    written = [path for path in (tmp_path / "whole").rglob("*") if path.is_file()]
    assert sorted(report["files"]) == sorted(path.relative_to(tmp_path / "whole").as_posix() for path in written)
    assert {"sequence_5d.h5", "frame_0004/scene_el.png"} < set(report["files"])
    assert [frame["frame"] for frame in report["frames"]] == [4, 5, 6]
    for part in ("2/2", "1/2"):
        holo.render_to(tmp_path / "parts", scene, shard=part, **options)
    for name in ("sequence_5d.h5", "frame_0005/scene_el.png", "frame_0006/manifest.json"):
        assert (tmp_path / "whole" / name).read_bytes() == (tmp_path / "parts" / name).read_bytes(), name
    assert holo.render_to(tmp_path / "whole", scene, **options)["kept"] == 3
    assert holo.open(tmp_path / "whole" / "frame_0005").rig.views == (2, 3)
    with pytest.raises(Exception, match="3 frames; choose one"):
        holo.open(tmp_path / "whole")
    # Lenses between those of the array.
    finer = holo.render(scene, frame=4, views=(2, 3), lenses=(8, 12), lens_shifts=2, spp=1, integrator="depth")
    assert finer.rig.lenses == (16, 24)


def test_missing_memory_is_a_memory_error(garden):
    with pytest.raises(MemoryError, match="GB of memory") as caught:
        holo.render(garden, views=1000, lenses=(20000, 20000))
    assert isinstance(caught.value, holo.OutOfMemoryError) and not isinstance(caught.value, holo.UsageError)


def test_the_calibration_benchmark_names_its_cameras(tmp_path):
    with pytest.raises(holo.UsageError, match="r12-d"):
        holo.calibration_benchmark(tmp_path / "out", cameras=["r13"])


def test_grids_that_other_programs_find_are_scored(tmp_path):
    """A grid as LFToolbox writes it, moved by half a pixel, against the camera of a folder."""
    text = (
        '[sensor]\nsize_px = [180, 120]\npixel_um = 10.0\n[mla]\ngrid = "square"\npitch_um = 100.0\ngap_um = 400.0\n'
        '[main_lens]\nprescription = "telephoto"\nfocus_group = [8, 11]\nfocus_m = 5.0\n'
    )
    (tmp_path / "camera.toml").write_text(text)
    camera = holo.PlenopticCamera.open(str(tmp_path / "camera.toml"))
    assert camera.optics()["focus_distance_m"] == pytest.approx(5.0)
    centers, pitch = camera.micro_images(), camera.optics()["micro_image_pitch_px"]
    inside = (centers["x"] > 0) & (centers["y"] > 0)
    grid = {
        "HSpacing": pitch, "VSpacing": pitch, "Rot": 0.0, "Orientation": "horz", "FirstPosShiftRow": 13, "UMax": 17,
        "VMax": 11, "HOffset": centers["x"][inside].min() + 1.0, "VOffset": centers["y"][inside].min() + 0.5,
    }
    path = tmp_path / "white.grid.json"
    path.write_text(json.dumps({"LensletGridModel": grid}))
    score = holo.PlenopticCamera.score_grid(path, tmp_path)
    # Behind glass micro-images lie on no lattice.
    assert score["microlenses"] > 100 and score["centers_px"][0] == pytest.approx(0.5, abs=0.05)
    with pytest.raises(holo.Error, match="nowhere"):
        holo.PlenopticCamera.score_grid(tmp_path / "nowhere.json", tmp_path)


def test_lytro_files_are_those_that_imageio_reads(tmp_path):
    """A container of an Illum as imageio reads it: its codes, and what they decode to."""
    imageio = pytest.importorskip("imageio.v2")
    rows, columns = 5368, 7728
    camera = holo.PlenopticCamera.open("lytro-illum")
    squares = (np.arange(rows)[:, None] // 500 + np.arange(columns) // 500) % 2
    white = camera.white_image()
    light = np.where(squares, np.float32(0.3), np.float32(0.8)) * (white / white.max())
    codes = np.rint(64 + 959 * light).astype(np.uint16)
    groups = codes.reshape(-1, 4)
    low = sum((groups[:, k] & 3) << (2 * k) for k in range(4))
    packed = np.stack([*(groups[:, k] >> 2 for k in range(4)), low], axis=1).astype(np.uint8).tobytes()

    def section(kind, name=b"", data=b""):
        out = b"\x89LF" + kind + b"\r\n\x1a\n\0\0\0" + bytes([kind == b"P"]) + len(data).to_bytes(4, "big")
        if data:
            out += name.ljust(80, b"\0") + data
            out += b"\0" * (-len(out) % 16)
        return out

    def name(number):
        return b"sha1-" + f"{number:040x}".encode()

    every = lambda code: {"r": code, "gr": code, "gb": code, "b": code}  # noqa: E731
    metadata = {
        "image": {"width": columns, "height": rows, "pixelPacking": {"endianness": "little", "bitsPerPixel": 10},
                  "pixelFormat": {"black": every(64), "white": every(1023)}, "mosaic": {"upperLeftPixel": "gr"},
                  "color": {"ccm": [1, 0, 0, 0, 1, 0, 0, 0, 1], "whiteBalanceGain": every(1)}},
        "devices": {"sensor": {"pixelPitch": 1.4e-6},
                    "lens": {"focalLength": 24.199e-3, "fNumber": 2.2, "exitPupilOffset": {"z": 97.2856e-3}},
                    "mla": {"lensPitch": 20e-6, "rotation": -0.000543, "scaleFactor": {"x": 1, "y": 1.000343},
                            "sensorOffset": {"x": 8.42e-6, "y": -0.95e-6, "z": 37e-6}}},
        "camera": {"model": "ILLUM"},
    }  # fmt: skip
    frame = {"imageRef": name(2).decode(), "metadataRef": name(3).decode(), "privateMetadataRef": name(4).decode()}
    table = json.dumps({"frames": [{"frame": frame}], "thumbnails": []}).encode()
    parts = [section(b"P"), section(b"C", name(2), packed)]
    parts += [section(b"C", name(3), json.dumps(metadata).encode()), section(b"C", name(4), b"{}")]
    # An Illum has eleven sections of data, and their table after them.
    parts += [*(section(b"C", name(k), b"-") for k in range(5, 13)), section(b"M", name(1), table)]
    path = tmp_path / "shot.lfr"
    path.write_bytes(b"".join(parts))
    theirs = imageio.imread(path, format="lytro-lfr", include_thumbnail=False)
    assert np.array_equal(np.rint(theirs * 1023), codes)
    found = holo.decode(path, views=3)
    assert found.light_field.views == (3, 3)
    gray = (codes.astype(np.float32) - 64) / 959
    own = holo.decode(np.repeat(gray[..., None], 3, axis=2), camera, views=3)
    view, expected = found.light_field[1, 1], own.light_field[1, 1]
    lit = np.isfinite(view) & np.isfinite(expected)
    # All colors are equal, but at the edges of the squares, where neighbors of a color differ.
    assert np.median(np.abs(view - expected)[lit]) < 2e-3 and np.mean(np.abs(view - expected)[lit] > 0.02) < 0.05
    with pytest.raises(holo.UsageError, match="camera"):
        holo.decode(np.zeros((4, 4, 3), np.float32))

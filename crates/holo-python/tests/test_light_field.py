"""Light fields: axes, memory, files, what is computed from them."""

import json
import pickle
import subprocess
import sys

import holo
import numpy as np
import pytest


@pytest.fixture
def numbered():
    """A light field whose samples say where they are."""
    v, u, t, s, c = np.indices((5, 7, 3, 4, 3))
    return holo.LightField(((((v * 7 + u) * 3 + t) * 4 + s) * 3 + c).astype(np.uint16))


def test_axes_and_memory(numbered):
    assert (numbered.views, numbered.lenses) == ((3, 4), (5, 7))
    view = numbered.view(1, 2)
    assert view.shape == (5, 7, 3) and np.shares_memory(view, numbered.array)
    assert view[4, 6, 0] == numbered.array[4, 6, 1, 2, 0]
    assert np.array_equal(numbered.elemental(4, 6)[1, 2], view[4, 6])
    assert np.array_equal(numbered.epi_row(4, 1)[2], view[4])
    assert np.array_equal(numbered.epi_column(6, 2)[1], view[:, 6])
    assert np.shares_memory(np.asarray(numbered), numbered.array)


def test_grids_are_there_and_back(numbered):
    raw, views = numbered.elemental_grid(), numbered.viewpoint_grid()
    assert raw.shape == (15, 28, 3) and views.shape == (15, 28, 3)
    assert np.array_equal(raw[4 * 3 + 1, 6 * 4 + 2], numbered.array[4, 6, 1, 2])
    assert np.array_equal(views[1 * 5 + 4, 2 * 7 + 6], numbered.array[4, 6, 1, 2])
    for back in (
        holo.LightField.from_elemental_grid(raw, (3, 4)),
        holo.LightField.from_viewpoint_grid(views, (3, 4)),
    ):
        assert np.array_equal(back.array, numbered.array)
    back = holo.LightField.from_elemental_grid(raw, (3, 4))
    assert np.shares_memory(back.elemental_grid(), raw), "in their own order no sample moves"
    with pytest.raises(holo.UsageError, match="no whole number"):
        holo.LightField.from_elemental_grid(raw, (4, 4))


@pytest.mark.parametrize("name", ["lf.h5", "lf.mat", "scene_el.png", "scene_vpi.png", "scene_el.tif"])
def test_files_return_what_was_saved(tmp_path, numbered, name, rendering):
    field = numbered
    if name == "lf.h5":
        field = rendering.light_field
    field.save(tmp_path / name)
    if name.endswith(".tif"):
        assert (tmp_path / name).read_bytes()[:2] == b"II", "a TIFF, not a PNG by another name"
    needs_views = name.startswith("scene")
    back = holo.open(tmp_path / name, views=field.views if needs_views else None)
    assert back.array.dtype == field.array.dtype and np.array_equal(back.array, field.array)
    assert back.is_srgb == field.is_srgb
    assert back.rig == (field.rig if name == "lf.h5" else None)


def test_exr_is_linear(tmp_path, rendering, numbered):
    rendering.light_field.save(tmp_path / "a_vpi.exr")
    image = holo.read_image(tmp_path / "a_vpi.exr")
    assert np.array_equal(image, rendering.light_field.viewpoint_grid())
    with pytest.raises(holo.UsageError, match="linear"):
        numbered.save(tmp_path / "b_vpi.exr")
    with pytest.raises(holo.UsageError, match="_el"):
        numbered.save(tmp_path / "b.png")
    with pytest.raises(holo.UsageError, match="ending|end the name"):
        numbered.save(tmp_path / "b.xyz")
    assert list(tmp_path.iterdir()) == [tmp_path / "a_vpi.exr"], "nothing half-written stays"


def test_hci_folders(tmp_path, rendering, numbered):
    field = rendering.light_field
    field.save_hci(tmp_path / "hci", rendering.disparity)
    back = holo.open(tmp_path / "hci")
    assert np.array_equal(back.array, field.encode().array) and back.views == (5, 4)
    assert np.isclose(back.rig.baseline_m, field.rig.baseline_m)
    # parameters.cfg has a range of one digit that contains that of the map.
    low, high = back.disparity_range_px
    assert 0.0 <= np.nanmin(rendering.disparity) - low < 0.2 and 0.0 <= high - np.nanmax(rendering.disparity) < 0.2
    with pytest.raises(holo.UsageError, match="rig"):
        numbered.save_hci(tmp_path / "none")
    field.save_hci(tmp_path / "views")
    assert holo.open(tmp_path / "views").views == (5, 4)


def test_what_is_wrong_is_said(tmp_path, rendering):
    with pytest.raises(holo.UsageError, match="axes"):
        holo.LightField(np.zeros((3, 3)))
    with pytest.raises(holo.UsageError, match="int64"):
        holo.LightField(np.zeros((2, 2, 2, 2, 1), dtype=np.int64))
    with pytest.raises(holo.Error, match="nothing-there"):
        holo.open(tmp_path / "nothing-there")
    (tmp_path / "cut.h5").write_bytes(b"\x89HDF\r\n\x1a\n" + bytes(100))
    with pytest.raises(holo.Error, match="cut.h5"):
        holo.open(tmp_path / "cut.h5")
    with pytest.raises(ValueError, match="one of disparity"):
        rendering.light_field.refocus()
    with pytest.raises(holo.UsageError, match="aperture"):
        rendering.light_field.refocus(0.0, aperture="disc:x")
    with pytest.raises(holo.UsageError, match="distance_m"):
        rendering.light_field.refocus(0.0, tilt_deg=(1, 0))
    with pytest.raises(holo.UsageError, match="give draft, fast"):
        rendering.light_field.disparity(effort="quick")


def test_refocus_estimate_evaluate(rendering):
    field = rendering.light_field
    flat = holo.LightField(np.full((20, 30, 3, 3, 1), 0.25, dtype=np.float32))
    assert np.allclose(flat.refocus(0.7), 0.25, atol=1e-6)
    assert field.refocus(0.0).shape == (48, 72, 3)
    at = field.refocus(distance_m=field.rig.focus_distance_m)
    assert np.array_equal(at, field.refocus(0.0)), "disparity is 0 at the focus distance"
    assert field.refocus(rendering.disparity).shape == (48, 72, 3)
    straight = field.refocus(distance_m=1.0, tilt_deg=(1e-9, 0))
    assert np.allclose(straight, field.refocus(distance_m=1.0), atol=1e-4)
    assert not np.allclose(straight, field.refocus(distance_m=1.0, tilt_deg=(40, 0)), atol=1e-2)
    truth = rendering.disparity
    estimate, confidence = field.disparity(confidence=True)
    assert estimate.shape == confidence.shape == truth.shape
    scores = holo.evaluate(estimate, truth, rig=field.rig)
    assert scores["border_px"] == 15 and scores["compared"] == np.isfinite(truth[15:-15, 15:-15]).sum()
    assert scores["mean_absolute_error_px"] < 0.3, scores
    perfect = holo.evaluate(truth, truth, border=0)
    assert perfect["compared"] == np.isfinite(truth).sum()
    assert perfect["mean_absolute_error_px"] == 0.0 and perfect["bad_pixels_0.01_percent"] == 0.0
    score = holo.compare(field.central, field.central)
    assert score.psnr_db == np.inf and abs(score.ssim - 1.0) < 1e-12
    unknown = holo.LightField(field.array)
    with pytest.warns(holo.HoloWarning, match="range"):
        unknown.disparity(effort="draft")


def test_views_are_synthesized(rendering):
    field = rendering.light_field
    central = field.linear()[1, 1]
    for disparity in (None, rendering.disparity, 0.25):
        view = field.synthesize((1, 1), disparity)
        assert np.array_equal(view.image, central) and not view.holes.any()
    middle = field.synthesize((0.5, 0.5), 0.0).image
    mean = np.mean([field.linear()[t, s] for t in (0, 1) for s in (0, 1)], axis=0)
    assert np.allclose(middle, mean, atol=1e-6)
    half = field.synthesize((0.5, 1), rendering.disparity)
    assert half.disparity.shape == half.holes.shape == (48, 72)
    maps = np.broadcast_to(np.float32(0.5), (48, 72, *field.shape[2:4]))
    # Between pixels a surface is sampled by both views at once, a plane by each alone, unless the kernel is bilinear.
    by_maps, by_plane = (field.synthesize((0.5, 1), where, kernel="bilinear").image for where in (maps, 0.5))
    assert np.array_equal(by_maps, by_plane)
    by_maps, by_plane = (field.synthesize((0.5, 1), where).image for where in (maps, 0.5))
    assert 0.0 < np.abs(by_maps - by_plane).mean() < 0.01
    with pytest.raises(ValueError, match="view row"):
        field.synthesize((7, 0), 0.0)
    with pytest.raises(ValueError, match="2 or 4 axes"):
        field.synthesize((0, 0), np.zeros(3))


def test_regions_are_scored():
    truth = np.zeros((20, 20), np.float32)
    estimate = truth.copy()
    estimate[:, 5:10] = 0.2
    estimate[np.arange(20) % 4 < 2, 10:] = -0.2
    columns = np.broadcast_to(np.arange(20), (20, 20))
    regions = {"fine": columns >= 5, "fine_surrounding": columns < 10, "plane": columns < 3, "mine": columns == 5,
               "empty": columns < 0}
    scores = holo.evaluate(estimate, truth, border=2, regions=regions)
    assert scores["fine_thinning_percent"] == pytest.approx(100 * 4 / 13)
    assert scores["fine_fattening_percent"] == pytest.approx(100 * 5 / 8)
    assert scores["plane_bumpiness"] == 0
    assert scores["mine_bad_pixels_0.07_percent"] == 100
    assert not any(name.startswith("empty") for name in scores)
    with pytest.raises(holo.Error):
        holo.evaluate(estimate, truth, border=2, regions={"fine": np.zeros((3, 3), bool)})


def test_images_show_their_order(tmp_path):
    rows, columns = np.mgrid[:30, :40]
    wave = lambda t, s: 128 + 60 * np.sin(0.6 * (columns + 0.7 * s) + 0.3 * (rows + 0.7 * t))  # noqa: E731
    for index in range(9):
        t, s = index // 3, index % 3
        s = 2 - s if t % 2 else s
        holo.write_image(tmp_path / f"view_{index // 3}_{index % 3}.png", wave(t, s)[..., None].astype(np.uint8))
    with pytest.warns(holo.HoloWarning, match="of serpentine"):
        field = holo.open(tmp_path)
    assert field.views == (3, 3)
    with pytest.warns(holo.HoloWarning, match="9 images") as said:
        holo.open(tmp_path, order="serpentine")
    assert len(said) == 1


def test_pickles_images_and_xarray(rendering):
    field = pickle.loads(pickle.dumps(rendering.light_field))
    assert np.array_equal(field.array, rendering.light_field.array) and field.rig == rendering.rig
    assert field.disparity_range_px == rendering.light_field.disparity_range_px
    assert field._repr_png_().startswith(b"\x89PNG") and rendering._repr_png_() == field._repr_png_()
    assert "5 x 4 views of 48 x 72 px" in repr(field)
    pytest.importorskip("xarray")
    array = field.to_xarray()
    assert array.dims == ("v", "u", "t", "s", "c") and np.shares_memory(array.values, field.array)


def test_clip_keeps_the_rig_where_it_stays_one(rendering):
    field = rendering.light_field
    inner = field.clip(views=(slice(1, 4), slice(1, 3)))
    assert inner.views == (3, 2) and inner.rig.baseline_m == field.rig.baseline_m
    assert np.shares_memory(inner.array, field.array)
    assert field.clip(views=(slice(0, 3), slice(0, 3))).rig is None
    assert field.clip(lenses=(slice(0, 9), slice(None))).lenses == (9, 72)


def test_rig_is_that_of_the_equations(rendering):
    rig = rendering.rig
    again = pickle.loads(pickle.dumps(rig))
    assert again == rig and hash(again) == hash(rig) and eval(repr(rig), {"Rig": holo.Rig}) == rig
    depth = np.array([[1.0, 2.5], [rig.focus_distance_m, np.inf]])
    disparity = rig.disparity_from_depth(depth)
    # Eq. 3: d = b f N / s (1 / Z - 1 / F), s the larger side of N pixels.
    pixels = rig.focal_length_m / rig.sensor_size_m * max(rig.lenses)
    expected = rig.baseline_m * pixels * (1 / depth - 1 / rig.focus_distance_m)
    assert np.allclose(disparity, expected, rtol=1e-12, atol=1e-12)
    assert np.allclose(rig.depth_from_disparity(disparity)[0], depth[0], rtol=1e-9)
    origin, direction = rig.ray(10, 20, 1, 3)
    point = [o + 2.0 * d for o, d in zip(origin, direction)]
    row, column = rig.project(point, 1, 3)
    assert abs(row - 10.5) < 1e-9 and abs(column - 20.5) < 1e-9
    planned = holo.optics(focal_mm=50, views=(9, 9), lenses=(100, 150), baseline_m=0.01, focus_m=2.0)
    assert planned.views == (9, 9) and planned.lenses == (100, 150) and planned.focal_length_m == 0.05
    assert planned.optics((1.0, 3.0))["baseline_mm"] == 10.0


def test_order_of_axes():
    array = np.arange(2 * 3 * 4 * 5 * 3, dtype=np.float32).reshape(2, 3, 4, 5, 3)
    with pytest.warns(holo.HoloWarning, match="4 x 5 views of 2 x 3"):
        holo.LightField(array)
    field = holo.LightField(array, axes="tsvuc")
    assert (field.views, field.lenses, field.shape) == ((2, 3), (4, 5), (4, 5, 2, 3, 3))
    assert np.array_equal(field.view(1, 2), array[1, 2]) and np.shares_memory(field.array, array)
    assert holo.LightField(array[..., 0], axes="vust").views == (5, 4)
    for axes in ("tsvu", "tsvux", "ttvuc", ""):
        with pytest.raises(holo.UsageError, match="each axis once"):
            holo.LightField(array, axes=axes)


def test_views_by_index(rendering):
    field = rendering.light_field
    assert np.array_equal(field[1, 2], field.view(1, 2))
    some = field[:2, 1:]
    assert some.views == (2, field.views[1] - 1) and np.array_equal(some[0, 0], field[0, 1])
    with pytest.raises(holo.UsageError, match="two numbers"):
        field[0, :]
    with pytest.raises(holo.UsageError, match="row and the column"):
        field[0]


def test_plot(rendering):
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("Agg")
    figure = rendering.light_field.plot(rendering.disparity)
    assert len(figure.axes) == 4 and figure.axes[0].get_title() == "central view", "three images and a scale"
    assert len(rendering.light_field.plot().axes) == 2


def test_placed_camera(garden):
    options = {"views": 1, "lenses": (12, 18), "spp": 1, "integrator": "depth", "layers": ["depth"]}
    near, far = (holo.render(garden, eye=(0.0, 0.4, z), target=(0.0, 0.1, 0.0), fov_deg=40, **options) for z in (1.0, 1.2))
    assert near.depth.shape == (12, 18) and not np.array_equal(near.depth, far.depth)
    with pytest.raises(holo.UsageError, match="direction up"):
        holo.render(garden, eye=(0.0, 2.0, 0.0), target=(0.0, 0.0, 0.0), **options)


def test_cameras_are_placed_as_on_the_command_line(tmp_path):
    jitter = dict(jitter_position_m=0.01, jitter_focal=0.02, seed=3)
    path = holo.place_cameras("plane", (2, 3), tmp_path / "poses.json", spacing_m=(0.2, 0.1), target=(0, 0.5, 0), size=(40, 60), **jitter)
    line = "array plane --count 3x2 --spacing-m 0.2,0.1 --target 0,0.5,0 --size 60x40 --jitter-position-m 0.01 --jitter-focal 0.02 --seed 3"
    subprocess.run([sys.executable, "-m", "holo", *line.split(), "--out", tmp_path / "own.json"], check=True)
    assert path.read_text() == (tmp_path / "own.json").read_text()
    ring = json.loads(holo.place_cameras("sphere", 5, tmp_path / "ring.json", radius_m=2.0, transforms_up="y").read_text())
    places = np.array([frame["transform_matrix"] for frame in ring["frames"]])[:, :3, 3]
    assert np.allclose(np.linalg.norm(places, axis=1), 2.0)
    with pytest.raises(holo.UsageError, match="180 degrees"):
        holo.place_cameras("plane", 3, tmp_path / "none.json", fov_deg=180.0)
    with pytest.raises(holo.UsageError, match="one number"):
        holo.place_cameras("sphere", (2, 3), tmp_path / "none.json")
    with pytest.raises(holo.UsageError, match="cylinder"):
        holo.place_cameras("ring", 3, tmp_path / "none.json")


def test_cameras_anywhere(tmp_path):
    """What numpy makes of the images of an array is what `CameraArray` makes of them."""
    eyes = [(0.1 * (k % 3 - 1), 0.1 * (k // 3 - 1), 1.5 + 0.02 * k) for k in range(9)]
    frames = [
        {"file_path": f"images/{k}.png", "gain": [1.0, 0.8 + 0.05 * k, 1.1],
         "transform_matrix": [[1, 0, 0, x], [0, 1, 0, y], [0, 0, 1, z], [0, 0, 0, 1]]}
        for k, (x, y, z) in enumerate(eyes)
    ]  # fmt: skip
    poses = tmp_path / "poses.json"
    poses.write_text(json.dumps({"fl_x": 80.0, "w": 60, "h": 40, "frames": frames}))
    out = tmp_path / "array"
    holo.render_to(out, holo.Scene.gallery("garden"), transforms=poses, transforms_up="y", spp=8, layers=["depth"], exposure="-1")
    array = holo.CameraArray(out, transforms_up="y")
    assert len(array) == 9 and array.names[3] == "3" and array.camera(3).size == (40, 60)
    assert np.allclose(array.camera(3).position_m, eyes[3]) and np.allclose(array.camera(3).axes, np.eye(3))
    # Gains, which differ by 40 % in green, are undone: cameras agree on the color of the scene.
    means = np.array([array.image(k).mean(axis=(0, 1)) for k in range(9)])
    ratios = means[:, 1] / means[:, 0]
    assert np.allclose(ratios / ratios.mean(), 1.0, atol=0.08)
    # The plane of focus through the nearest pixels, without interpolation between them.
    distance, view = 1.4, array.view()
    rows, columns = np.mgrid[0:40, 0:60]
    x, y = (columns - 29.5) / 80.0 * distance, (19.5 - rows) / 80.0 * distance
    point = view.position_m + np.stack([x, y, np.full_like(x, -distance)], axis=-1)
    total, count = np.zeros((40, 60, 3)), np.zeros((40, 60, 1))
    for k in range(9):
        seen = point - array.camera(k).position_m
        column = np.rint(29.5 - 80.0 * seen[..., 0] / seen[..., 2]).astype(int)
        row = np.rint(19.5 + 80.0 * seen[..., 1] / seen[..., 2]).astype(int)
        inside = (column >= 0) & (column < 60) & (row >= 0) & (row < 40)
        total[inside] += array.image(k)[row[inside], column[inside]]
        count[inside] += 1
    ours = array.refocus(distance_m=distance, kernel="bilinear")
    assert ours.dtype == np.float32 and np.nanmean(np.abs(ours - total / count)) < 0.02
    assert np.allclose(array.refocus(depth=np.full((40, 60), distance)), array.refocus(distance_m=distance), atol=1e-5)
    between = array.synthesize(holo.Pose(eye=(0.05, 0.05, 1.55)))
    assert between.image.shape == (40, 60, 3) and between.depth.shape == between.holes.shape == (40, 60)
    own = array.synthesize(holo.Pose(eye=eyes[4]))
    assert np.allclose(own.image, array.image(4), atol=1e-5)
    with pytest.raises(holo.UsageError, match="one of distance_m"):
        array.refocus()
    with pytest.raises(holo.Error, match="nothing"):
        holo.CameraArray(tmp_path / "nothing")


def test_displays(tmp_path):
    """What an eye sees of a display is the view from its place; between the views it is their mean."""
    shape = {"views": (5, 5), "lenses": (24, 32), "spp": 16, "denoise": "off"}
    rendering = holo.render(holo.Scene.gallery("garden"), disparity=(-0.6, 0.6), **shape)
    field = rendering.light_field
    file = tmp_path / "bench.toml"
    file.write_text(
        "[panel]\nsize_px = [160, 120]\npixel_um = 200.0\n[lenses]\ngrid = 'square'\npitch_mm = 1.0\ngap_mm = 3.0\n"
        "offset_mm = [0.5, 0.5]\n"
    )
    display = holo.Display(file)
    assert display.name == "bench" and display.panel_size == (120, 160) and np.allclose(display.size_m, (0.032, 0.024))
    panel = display.panel_image(field)
    # Five pixels behind a lens for viewers far away: the elemental images turned around.
    raw = field.linear().elemental_grid().reshape(24, 5, 32, 5, 3)[:, ::-1, :, ::-1].reshape(120, 160, 3)
    assert np.allclose(panel, raw, atol=1e-5)
    # From far away, two pixels to the left of the middle of each lens is the rightmost view.
    seen = display.seen_from(panel, (400.0 / 3.0 * 0.999, 0.0, 1000.0))
    assert seen.shape == (24, 32, 3) and np.allclose(seen, field.linear().view(2, 4), atol=1e-4)
    scaled = display.panel_image(field, to_scale=True, distance_m=float(field.rig.focus_distance_m))
    assert scaled.shape == panel.shape
    with pytest.raises(holo.Error, match="finer than the light field"):
        display.panel_image(field[:, :4])
    with pytest.raises(holo.UsageError, match="rig is unknown"):
        display.panel_image(holo.LightField(field.array), to_scale=True)
    with pytest.raises(holo.Error, match="none"):
        holo.Display(tmp_path / "none.toml")


def test_correspondences_of_rigs(tmp_path):
    """The matrices of transforms.json lead from the pixels of a view to their places in a view of another rig, to 1e-9 px."""
    frames = [
        {"file_path": f"images/{name}.png", "transform_matrix": [[c, 0, s, x], [0, 1, 0, 0.25], [-s, 0, c, 1.2], [0, 0, 0, 1]]}
        for name, x, c, s in (("a", -0.1, np.cos(0.07), -np.sin(0.07)), ("b", 0.2, np.cos(0.2), np.sin(0.2)))
    ]  # fmt: skip
    poses, out = tmp_path / "poses.json", tmp_path / "rigs"
    poses.write_text(json.dumps({"fl_x": 80.0, "w": 60, "h": 40, "frames": frames}))
    options = dict(views=3, baseline_m=0.02, focus_m=1.4, spp=4, layers=["depth"], ground_truth="all", exposure=0.0)
    holo.render_to(out, holo.Scene.gallery("garden"), transforms=poses, transforms_up="y", **options)
    array = holo.CameraArray(out, transforms_up="y")
    assert len(array) == 18 and array.names[5] == "a:2,1" and array.central == [4, 13] and array.position("b") == 13
    found = array.correspondences("a:0,1", "b:2,2")
    matrices = [np.array(frame["transform_matrix"]) for frame in json.loads((out / "transforms.json").read_text())["frames"]]
    focal = 80.0
    first, second = array.depth(array.position("a:0,1")), array.camera(array.position("b:2,2"))
    rows, columns = np.mgrid[0:40, 0:60]
    # View a:0,1 stands 2 cm to the left; all views see the plane at 1.4 m with the same pixels.
    x = (columns - 29.5) / focal + 0.02 / 1.4
    y = (19.5 - rows) / focal
    rays = np.stack([x, y, -np.ones_like(x)], axis=-1) * first[..., None].astype(float)
    world = (rays + [-0.02, 0, 0]) @ matrices[0][:3, :3].T + matrices[0][:3, 3]
    seen = (world - matrices[1][:3, 3]) @ matrices[1][:3, :3] - [0.02, -0.02, 0]
    column = 29.5 + focal * (-seen[..., 0] / seen[..., 2] + 0.02 / 1.4)
    row = 19.5 + focal * (seen[..., 1] / seen[..., 2] + 0.02 / 1.4)
    hit = np.isfinite(first)
    assert np.abs(found.places[..., 0] - row)[hit].max() < 1e-9 and np.abs(found.places[..., 1] - column)[hit].max() < 1e-9
    assert np.allclose(found.depth[hit], -seen[..., 2][hit], rtol=1e-12)
    assert np.allclose(second.principal_point, (19.5 + focal * 0.02 / 1.4, 29.5 + focal * 0.02 / 1.4))
    assert 0.3 < found.visible.mean() < 0.95
    with pytest.raises(holo.UsageError, match="no camera 'c'"):
        array.correspondences("a", "c")

"""Datasets as other programs read them: the catalog by mlcroissant, archives as WebDataset does, lists as text."""
import csv
import io
import json
import subprocess
import sys
import tarfile
import types

import numpy as np
import pytest
from PIL import Image

import holo

SCENES = ["plaster", "mountains", "tiles", "chess", "billiards"]


def run(*words):
    # In a process of its own: the program has a handler of Ctrl-C.
    subprocess.run([sys.executable, "-m", "holo", *map(str, words)], check=True)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("data")
    options = ["--views", "3,2", "--sensor", "48x32", "--spp", 2, "--denoise", "views", "--quiet"]
    layers = ["--layers", "depth,disparity,visibility"]
    run("dataset", "--out", folder / "set", "--scenes", ",".join(SCENES), *options, *layers)
    return folder


def test_mlcroissant_reads_the_records(folder, monkeypatch):
    # A dependency for files that are JSON, which this dataset has none of; it is no wheel.
    lexer = types.ModuleType("jsonpath_rw.lexer")
    package = types.ModuleType("jsonpath_rw")
    package.lexer = lexer
    monkeypatch.setitem(sys.modules, "jsonpath_rw", package)
    monkeypatch.setitem(sys.modules, "jsonpath_rw.lexer", lexer)
    import mlcroissant

    dataset = mlcroissant.Dataset(str(folder / "set" / "croissant.json"))
    assert not dataset.metadata.ctx.issues.errors
    records = list(dataset.records(record_set="light_fields"))
    assert len(records) == 10
    for record, row in zip(records, csv.DictReader((folder / "set" / "light_fields.csv").open())):
        text = {name.split("/")[1]: value for name, value in record.items()}
        assert text["folder"] == row["folder"]
        assert text["error_median"] == pytest.approx(float(row["error_median"])) and text["reconstructed"]
    # Fields without a value.
    run("dataset", "--out", folder / "plain", "--scenes", "plaster", "--views", 2, "--sensor", "24x16", "--spp", 1, "--quiet")
    plain = mlcroissant.Dataset(str(folder / "plain" / "croissant.json"))
    (record,) = plain.records(record_set="light_fields")
    assert record["light_fields/samples"] == 1 and record["light_fields/seen_by_all_views"] is None
    files = {file.id: file for file in dataset.metadata.file_objects}
    assert files["plaster/3x3/scene_el.png"].sha256


def test_statistics_are_those_of_the_files(folder):
    with open(folder / "set" / "light_fields.csv") as file:
        rows = list(csv.DictReader(file))
    for row in rows:
        job = folder / "set" / row["folder"]
        image = np.asarray(Image.open(job / "scene_el.png"), dtype=float) / 255
        for channel, name in enumerate(["red", "green", "blue"]):
            assert float(row[f"mean_{name}"]) == pytest.approx(image[..., channel].mean(), abs=1e-12)
            assert float(row[f"deviation_{name}"]) == pytest.approx(image[..., channel].std(), abs=1e-9)
    splits = {name: (folder / "set" / f"{name}.txt").read_text().split() for name in ("train", "test")}
    assert [row["folder"] for row in rows if row["split"] == "test"] == splits["test"] == ["billiards/3x3", "billiards/2x2"]
    assert len(splits["train"]) == 8


def test_archives_are_samples_of_files_with_one_key(folder):
    run("pack", folder / "set", "--out", folder / "archives", "--fields", "el.png,visibility.pfm", "--quiet")
    samples = {}
    with tarfile.open(folder / "archives" / "train-000000.tar") as archive:
        for entry in archive:
            key, field = entry.name.split(".", 1)
            samples.setdefault(key, {})[field] = archive.extractfile(entry).read()
            assert (entry.uid, entry.gid, entry.mtime, entry.mode) == (0, 0, 0, 0o644)
    assert len(samples) == 8 and set(samples["plaster_3x3"]) == {"el.png", "visibility.pfm", "json"}
    record = json.loads(samples["plaster_3x3"]["json"])
    size = (record["lens_columns"] * record["view_columns"], record["lens_rows"] * record["view_rows"])
    assert Image.open(io.BytesIO(samples["plaster_3x3"]["el.png"])).size == size


def test_export_is_that_of_the_command_line(folder, tmp_path):
    assert {"hci", "npy", "nerf"} <= set(holo.export_targets())
    files = holo.export(folder / "set", "npy", tmp_path / "npy", views=3)
    assert tmp_path / "npy" / "plaster.npy" in files and all(file.is_file() for file in files)
    (job,) = holo.Dataset(folder / "set", scenes=["plaster"], views=[(3, 3)])
    exported = np.load(tmp_path / "npy" / "plaster.npy")
    holo.export(folder / "set", "npy", tmp_path / "named", views=3, names={"plaster": "boxes"})
    assert (np.load(tmp_path / "named" / "boxes.npy") == exported).all()
    assert (exported[1, 2] == job.view(1, 2)).all()
    assert (np.load(tmp_path / "npy" / "plaster_disparity.npy") == job.disparity).all()
    plaster = holo.Scene.gallery("plaster")
    options = dict(views=3, lenses=(16, 24), spp=1, layers=["depth", "disparity", "object-id"])
    seen = tmp_path / "seen"
    holo.render_to(seen, plaster, **options)
    holo.export(seen, "lfsd", tmp_path / "saliency", objects=plaster.objects)
    mask = np.asarray(Image.open(tmp_path / "saliency" / "train_masks" / "seen.png"))
    assert mask.shape == (16, 24) and mask.max() == 255
    assert (tmp_path / "saliency" / "train_focals" / "seen.mat").is_file()
    image = np.asarray(Image.open(tmp_path / "saliency" / "train_images" / "seen.jpg"), dtype=int)
    assert np.abs(image - holo.open(seen).array[:, :, 1, 1]).mean() < 6
    with pytest.raises(holo.UsageError, match="objects"):
        holo.export(seen, "lfsd", tmp_path / "none")
    with pytest.raises(holo.UsageError, match="9 x 9"):
        holo.export(folder / "set", "hci", tmp_path / "hci", views=3)
    with pytest.raises(holo.UsageError, match="views"):
        holo.export(folder / "set", "npy", tmp_path / "two")
    with pytest.raises(holo.UsageError, match="basiclfsr"):
        holo.export(folder / "set", "epinet", tmp_path / "two")
    assert not (tmp_path / "two").exists() and not (tmp_path / "hci").exists()


def test_visibility_is_a_layer(folder):
    scene = holo.Scene.gallery("plaster")
    rendering = holo.render(scene, views=3, lenses="24x16", spp=1, layers=["visibility"])
    visibility = rendering.layers["visibility"]
    assert visibility.shape == (16, 24) and visibility.max() == 1 and visibility.min() >= np.float32(1 / 9)


CAMERA = """
name = "small"
[sensor]
size_px = [60, 45]
pixel_um = 5.0
[mla]
grid = "square"
pitch_um = 71.2
gap_um = 400.0
[main_lens]
focal_mm = 40.0
f_number = 5.8
focus_m = 0.8
"""


def test_datasets_of_plenoptic_cameras(tmp_path):
    (tmp_path / "camera.toml").write_text(CAMERA)
    run("dataset", "--out", tmp_path / "set", "--scenes", "plaster", "--camera-file", tmp_path / "camera.toml",
        "--spp", 1, "--sky", "1,1,1", "--layers", "depth", "--quiet")
    (job,) = dataset = holo.Dataset(tmp_path / "set")
    assert repr(dataset).endswith("1 raw images>") and "camera 'small'" in repr(job)
    assert (job.scene, job.views, job.camera, job.path.name) == ("plaster", None, "small", "small")
    assert job.raw.shape == (45, 60, 3) and job.depth.shape == (45, 60)
    assert not len(holo.Dataset(tmp_path / "set", views=[(3, 3)]))
    assert len(holo.Dataset(tmp_path / "set", cameras=["small"])) == 1

"""The notebook and the examples of the readme run."""

import json
import pathlib
import re

import holo
import pytest

HERE = pathlib.Path(__file__).parent.parent


def test_notebook(tmp_path, monkeypatch):
    pytest.importorskip("matplotlib")
    monkeypatch.chdir(tmp_path)
    notebook = json.loads((HERE / "examples" / "first_light_field.ipynb").read_text(encoding="utf-8"))
    names = {}
    for cell in notebook["cells"]:
        if cell["cell_type"] == "code":
            exec(compile("".join(cell["source"]), cell["id"], "exec"), names)
    for image in ("views.png", "refocused.png", "disparity.png"):
        assert holo.read_image(tmp_path / image).std() > 10, image
    scores = holo.evaluate(names["estimate"], names["result"].disparity)
    assert scores["bad_pixels_0.07_percent"] < 30, scores


def test_readme(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    blocks = re.findall(r"```python\n(.*?)```", (HERE / "README.md").read_text(encoding="utf-8"), re.DOTALL)
    assert blocks
    for block in blocks:
        exec(block, {})
    assert holo.open(tmp_path / "garden.h5").views == (9, 9)


def test_training(tmp_path):
    pytest.importorskip("torch")
    import runpy

    import numpy as np

    train = runpy.run_path(str(HERE.parent.parent / "examples" / "training" / "train.py"))
    # A texture at a disparity of 1 px: turned and reflected, it still moves by its disparity in all four directions.
    texture = np.random.default_rng(1).random((40, 40))
    v, u = np.mgrid[8:32, 8:32]
    steps = np.arange(9) - 4
    ways = [(0 * steps, steps), (steps, 0 * steps), (steps, steps), (-steps, steps)]
    views = np.stack([np.stack([texture[v + t, u + s] for t, s in zip(*way)]) for way in ways])
    for number in range(8):
        part, _ = train["turned"](views, np.ones((24, 24)), number)
        for stream, way in zip(part, ways):
            for view, t, s in zip(stream, *way):
                inner = stream[4][4 + t : 20 + t, 4 + s : 20 + s]
                np.testing.assert_array_equal(view[4:20, 4:20], inner)
    folder = tmp_path / "set"
    holo.Dataset.generate(folder, count=2, recipe="hci-like", lenses=(64, 64), spp=1, integrator="direct", seed=1)
    words = [str(folder), "--test", str(folder), "--out", str(tmp_path / "model"), "--steps"]
    train["main"]([*words, "2"])
    first = (tmp_path / "model" / "curve.csv").read_text().splitlines()
    train["main"]([*words, "4"])
    lines = (tmp_path / "model" / "curve.csv").read_text().splitlines()
    # It goes on where it stopped.
    assert lines[: len(first)] == first and int(lines[-1].split(",")[0]) > int(first[-1].split(",")[0])
    assert len((tmp_path / "model" / "scores.csv").read_text().splitlines()) == 3


def test_torch_dataset(tmp_path):
    pytest.importorskip("torch")
    import runpy

    holo.render_to(tmp_path / "plaster" / "3x3", holo.Scene.gallery("plaster"), views=(3, 3), lenses=(8, 12), spp=1, write=["h5"])
    (tmp_path / "dataset.json").write_text(
        json.dumps({"scenes": [{"name": "plaster"}], "splits": [{"views": {"columns": 3, "rows": 3}}]})
    )
    example = runpy.run_path(str(HERE / "examples" / "torch_dataset.py"))
    assert example["CrossViews"](tmp_path)[0]["views"].shape == (5, 3, 8, 12)

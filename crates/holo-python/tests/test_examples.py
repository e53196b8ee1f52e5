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


def test_torch_dataset(tmp_path):
    pytest.importorskip("torch")
    import runpy

    holo.render_to(tmp_path / "plaster" / "3x3", holo.Scene.gallery("plaster"), views=(3, 3), lenses=(8, 12), spp=1, write=["h5"])
    (tmp_path / "dataset.json").write_text(
        json.dumps({"scenes": [{"name": "plaster"}], "splits": [{"views": {"columns": 3, "rows": 3}}]})
    )
    example = runpy.run_path(str(HERE / "examples" / "torch_dataset.py"))
    assert example["CrossViews"](tmp_path)[0]["views"].shape == (5, 3, 8, 12)

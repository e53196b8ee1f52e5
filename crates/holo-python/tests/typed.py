"""A program that a type checker reads and nobody runs: what the package returns has the types that one goes on with."""

from pathlib import Path

import holo
import numpy as np

scene = holo.Scene.gallery("plaster")
result = holo.render(scene, views=9, lenses=(24, 24), disparity=(-1.5, 1.5), spp=1, layers=["depth", "disparity"])
field: holo.LightField = result.light_field
array: np.ndarray = result.light_field.array
view: np.ndarray = field[4, 4]
some: holo.LightField = field[2:7, 2:7]
shape: tuple[int, ...] = field.shape
estimate: np.ndarray = field.disparity()
sure: np.ndarray = field.disparity((-1.5, 1.5), confidence=True).confidence
sharp = field.refocus(disparity=0.5)
scores = holo.evaluate(estimate, result.disparity)
raw: np.ndarray = holo.render_raw(scene, "lytro-illum", spp=1).image
report = holo.render_to("out", scene, views=(9, 9), denoise="views")
data = holo.Dataset.render(Path("out"), scenes=["garden"], views=[9], preset="hci", spp=1)
names: list[str] = [job.scene for job in data]
count: int = len(data)
first: holo.Job = data[0]
opened: holo.LightField = holo.open("scene.png", views=(9, 9))
files = holo.export("field", "npy", "arrays")
poses: Path = holo.place_cameras("sphere", 9, radius_m=2.0)
pose = holo.Pose(eye=(0, 1, 2), target=(0, 0, 0))
placed = holo.render(scene, pose=pose, views=3)

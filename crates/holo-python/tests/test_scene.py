"""Scenes that are changed by name, and datasets that executors render."""
import json
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor

import numpy as np
import pytest

import holo

OPTIONS = dict(views=1, lenses=(24, 32), spp=1, integrator="direct", texture_filter="off")


def wall(name="wall"):
    vertices = np.array([[-5, -5, -2], [5, -5, -2], [5, 5, -2], [-5, 5, -2]], dtype=np.float32)
    return holo.Mesh(vertices, [[0, 1, 2], [0, 2, 3]], base_color=(0.5, 0.5, 0.5), name=name)


@pytest.fixture(scope="module")
def scene():
    return holo.Scene.from_meshes(wall(), camera=((0, 0, 0), (0, 0, -1)), sun=3.0, sun_direction=(0, 0, -1))


def radiance(scene):
    return holo.render(scene, **OPTIONS).light_field.array.mean(axis=(0, 1, 2, 3))


def test_materials_and_lights_are_changed_by_name(scene):
    # A Lambertian wall that faces the sun: base color * irradiance / pi.
    assert radiance(scene) == pytest.approx([0.5 * 3 / np.pi] * 3, rel=1e-5)
    red = scene.with_material(scene.materials[0], base_color=(0.8, 0.1, 0.0))
    assert radiance(red) == pytest.approx(np.array([0.8, 0.1, 0.0]) * 3 / np.pi, rel=1e-5)
    bright = scene.with_light(scene.lights[0], intensity=6.0, color=(1.0, 0.5, 0.0))
    assert radiance(bright) == pytest.approx(0.5 * 6 / np.pi * np.array([1.0, 0.5, 0.0]), rel=1e-5)
    glowing = scene.with_material(scene.materials[0], base_color=(0, 0, 0), emission=(4.0, 2.0, 0.5))
    assert radiance(glowing) == pytest.approx([4.0, 2.0, 0.5], rel=1e-5)
    # The scene itself stays as it was.
    assert radiance(scene) == pytest.approx([0.5 * 3 / np.pi] * 3, rel=1e-5)


def test_objects_are_placed_elsewhere(scene):
    name = next(name for name in scene.objects if "wall" in name)
    moved = scene.with_object(name, translation=(0, 0, -1.5))
    for changed, depth in ((scene, 2.0), (moved, 3.5)):
        result = holo.render(changed, layers=["depth"], **{**OPTIONS, "integrator": "depth"})
        assert result.depth == pytest.approx(np.full((24, 32), depth), rel=1e-6)
    with pytest.raises(holo.UsageError, match="did you mean 'wall"):
        scene.with_object("wal", scale=(1, 1, 1))
    with pytest.raises(holo.UsageError, match="3 numbers"):
        scene.with_object(name, translation=(1, 2))


@pytest.mark.parametrize("kind", [None, ThreadPoolExecutor, ProcessPoolExecutor])
def test_executors_render_datasets(tmp_path, kind):
    options = dict(scenes=["plaster", "chess"], views=[2, 3], sensor=(32, 48), spp=1)
    if kind is None:
        dataset = holo.Dataset.render(tmp_path / "out", **options)
    else:
        with kind(2) as pool:
            dataset = holo.Dataset.render(tmp_path / "out", executor=pool, threads=1, **options)
    assert [(job.scene, job.views) for job in dataset] == [
        (scene, size) for scene in ("plaster", "chess") for size in ((2, 2), (3, 3))
    ]
    assert all(np.isfinite(job.disparity).any() for job in dataset)
    with pytest.raises(holo.Error, match="views"):
        holo.Dataset.render(tmp_path / "bad", scenes=["plaster"], views=[0])


def test_dask_and_submitit_render_datasets(tmp_path):
    import submitit
    from distributed import Client, LocalCluster

    options = dict(scenes=["plaster", "chess"], views=[2], sensor=(32, 48), spp=1, threads=1, parts=2)
    alone = holo.Dataset.render(tmp_path / "alone", **{**options, "parts": None})
    with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster, Client(cluster) as client:
        dask = holo.Dataset.render(tmp_path / "dask", executor=client.get_executor(), **options)
    # What Slurm would run, in processes of this computer.
    slurm = submitit.AutoExecutor(folder=tmp_path / "log", cluster="local")
    slurm = holo.Dataset.render(tmp_path / "slurm", executor=slurm, **options)
    for dataset in (dask, slurm):
        assert [job.scene for job in dataset] == ["plaster", "chess"]
        for job, expected in zip(dataset, alone):
            for name in ("scene_el.png", "scene_disparity.pfm"):
                assert (job.path / name).read_bytes() == (expected.path / name).read_bytes()


def test_a_pose_places_the_camera(scene):
    options = {**OPTIONS, "integrator": "depth", "layers": ["depth"]}
    pose = holo.Pose(eye=(0, 0, 1.5), target=(0, 0, -2))
    assert holo.render(scene, pose=pose, **options).depth == pytest.approx(np.full((24, 32), 3.5), rel=1e-6)
    settings = holo.render(scene, eye=(0, 0, 1.5), target=(0, 0, -2), **options)
    assert np.array_equal(settings.depth, holo.render(scene, pose=pose, **options).depth)
    with pytest.raises(holo.UsageError, match="both place"):
        holo.render(scene, pose=pose, eye=(0, 0, 0), **options)


def test_the_manifest_names_the_preset(scene, tmp_path):
    holo.render_to(tmp_path / "out", scene, preset="draft", views=2, lenses=(8, 12))
    settings = json.loads((tmp_path / "out" / "manifest.json").read_text())["settings"]
    assert settings["preset"] == {"draft": {"spp": "1/16", "denoise": "views"}}


def test_scenes_of_a_recipe_are_the_same_wherever_they_are_drawn(tmp_path):
    options = dict(recipe="hci-like", views=[3], lenses=(16, 12), spp=1, integrator="direct", seed=3)
    with ProcessPoolExecutor(2) as pool:
        parts = holo.Dataset.generate(tmp_path / "parts", count=3, executor=pool, threads=1, **options)
    assert [job.scene for job in parts] == ["000000", "000001", "000002"]
    alone = holo.Dataset.generate(tmp_path / "alone", count=2, **options)
    for job, other in zip(alone, parts):
        np.testing.assert_array_equal(job.light_field.array, other.light_field.array)
        assert job.manifest["files"] == other.manifest["files"]
        assert "objects" not in job.masks and job.masks["valid"].shape == job.objects.shape
        assert job.objects.max() <= len(job.manifest["settings"]["objects"])
    # More scenes of the same set.
    more = holo.Dataset.generate(tmp_path / "alone", count=3, **options)
    assert len(more) == 3 and more[2].manifest["files"] == parts[2].manifest["files"]
    with pytest.raises(holo.UsageError, match="hci-like"):
        holo.Dataset.generate(tmp_path / "bad", count=1, recipe="hci")

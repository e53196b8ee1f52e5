"""Runs the loading code of programs that train on light fields over what `holo export` writes, and compares values.

    cargo xtask consumers DIR

DIR has clones of their repositories, in folders of any names; one that is not there is named as not run. Nothing of them is
changed: their code runs from where it is, in Python of today, and what it imports for training or plots is left out.

    chshin10/epinet                             views and disparity of `hci`
    lightfield-analysis/evaluation-toolkit      `hci-toolkit`: truth, masks, and the scores of `holo eval`
    ZhengyuLiang24/BasicLFSR                    its patches of `basiclfsr`
    jingjin25/LFASR-geometry                    `lfasr`
    nerfstudio-project/nerfstudio               `nerfstudio`, with torch
    italoplk/Light-Field-Codec                  `jpeg-pleno`, by its reader in C++
    YingqianWang/OACC-Net                       sixteen scenes of `hci`, with torch and einops; its augmentation is left out
    hbb1/2d-gaussian-splatting                  `nerf`, by the reader it shares with 3D Gaussian splatting, with torch and plyfile
    warriordby/LFSOD                            `lfsd`, by its loader for tests, with torch, torchvision and scipy
"""
import argparse
import contextlib
import importlib
import importlib.util
import io
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import types

import h5py
import imageio.v2 as imageio
import numpy as np
import scipy.ndimage

VIEWS = 9


class Nothing(types.ModuleType):
    """Stands for a module whose functions are not needed."""

    def __init__(self, name="nothing"):
        super().__init__(name)
        self.__path__ = []

    def __getattr__(self, name):
        if name.startswith("__"):
            raise AttributeError(name)
        return Nothing(name)

    def __call__(self, *_, **__):
        return self

    def __mro_entries__(self, _):
        return (object,)

    def __deepcopy__(self, _):
        return self

    def __getitem__(self, _):
        return self


def without(*names):
    """Leaves modules out."""
    for name in names:
        sys.modules[name] = Nothing(name)


class Bench:
    def __init__(self, holo, folder):
        self.holo, self.folder = holo, pathlib.Path(folder)

    def run(self, line):
        done = subprocess.run([self.holo, *line.split()], cwd=self.folder, capture_output=True, text=True)
        if done.returncode != 0:
            sys.exit(f"holo {line}: {done.stderr}")
        return done.stdout

    def export(self, target, source="small", extra=""):
        out = f"{target}_{source.replace('/', '_')}"
        self.run(f"export {source} --for {target} --out {out} {extra}")
        return self.folder / out

    def views(self, scene, source="small"):
        """The light field by its raw image, axes (t, s, v, u, c), and the disparity of the central view."""
        folder = self.folder / source / scene / f"{VIEWS}x{VIEWS}"
        raw = imageio.imread(folder / "scene_el.png")
        rows, columns = raw.shape[0] // VIEWS, raw.shape[1] // VIEWS
        field = raw.reshape(rows, VIEWS, columns, VIEWS, 3).transpose(1, 3, 0, 2, 4)
        with open(folder / "scene_disparity.pfm", "rb") as file:
            file.readline(), file.readline(), file.readline()
            disparity = np.flipud(np.frombuffer(file.read(), "<f4").reshape(rows, columns))
        return field, disparity


def module_of(path, name):
    """A file of another project as a module."""
    spec = importlib.util.spec_from_file_location(name, path)
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    spec.loader.exec_module(module)
    return module


def epinet(repository, bench):
    util = module_of(repository / "epinet_fun/util.py", "epinet_util")
    out = bench.export("hci", "large")
    (bench.folder / "hci_dataset").symlink_to(out)
    field, disparity = bench.views("plaster", "large")
    back = os.getcwd()
    os.chdir(bench.folder)
    try:
        with contextlib.redirect_stdout(io.StringIO()):
            images, labels = util.load_LFdata(["training/plaster"])
    finally:
        os.chdir(back)
    assert np.array_equal(images[0].transpose(2, 3, 0, 1, 4), field), "views differ"
    assert np.array_equal(labels[0], disparity), "disparity differs"
    return f"81 views of {disparity.shape[1]} x {disparity.shape[0]} px and disparity are equal"


class Python2(importlib.machinery.SourceFileLoader):
    """The toolkit was written for Python 2 and an older numpy."""

    def get_data(self, path):
        data = super().get_data(path)
        if not path.endswith(".py"):
            return data
        for old, new in [
            (b"import ConfigParser", b"import configparser as ConfigParser"),
            (b"parser.readfp(", b"parser.read_file("),
            (b"np.bool)", b"bool)"), (b"np.float)", b"float)"), (b"np.int)", b"int)"),
            (b"ff.readline().rstrip()", b"ff.readline().decode().rstrip()"),
            (b"import scipy.ndimage.interpolation as sci", b"import scipy.ndimage as sci"),
        ]:
            data = data.replace(old, new)
        return data

    def path_stats(self, path):
        # Not from a compiled file: it would be of the unchanged source.
        raise OSError

    def cache_bytecode(self, *_):
        pass


class Python2Finder:
    """Finds the modules of the toolkit."""

    def __init__(self, folder):
        self.folder = pathlib.Path(folder)

    def find_spec(self, name, _path=None, _target=None):
        if name != "toolkit" and not name.startswith("toolkit."):
            return None
        place = self.folder.joinpath(*name.split("."))
        package = place.is_dir()
        file = place / "__init__.py" if package else place.with_suffix(".py")
        if not file.is_file():
            return None
        return importlib.util.spec_from_file_location(
            name, file, loader=Python2(name, str(file)),
            submodule_search_locations=[str(place)] if package else None)


def toolkit(repository, bench):
    without("matplotlib", "matplotlib.cm", "matplotlib.pyplot", "matplotlib.gridspec", "matplotlib.colors",
            "matplotlib.patches", "matplotlib.ticker", "mpl_toolkits", "mpl_toolkits.axes_grid1", "distutils", "distutils.dir_util")
    sys.meta_path.insert(0, Python2Finder(repository / "source"))
    metrics = importlib.import_module("toolkit.metrics")
    scenes = importlib.import_module("toolkit.scenes")
    files = importlib.import_module("toolkit.utils.file_io")
    files.read_img = lambda path: imageio.imread(path)
    out = bench.export("hci-toolkit", extra="--group training")
    worst, count = 0.0, 0
    for name in ["plaster", "fence"]:
        field, disparity = bench.views(name)
        folder = f"hci-toolkit_small/data/training/{name}"
        estimate = f"{name}_estimate.pfm"
        bench.run(f"depth {folder} --out {estimate} --quiet")
        scene = scenes.PhotorealisticScene(name, category="training", data_path=str(out / "data"))
        scene.set_low_gt_scale()
        assert np.array_equal(scene.get_gt(), disparity), f"{name}: disparity differs"
        assert np.array_equal(scene.get_center_view(), field[VIEWS // 2, VIEWS // 2]), f"{name}: the center view differs"
        depth = scene.disp2depth(scene.get_gt().astype(float))
        seen = np.isfinite(scene.get_depth_map())
        away = np.abs(depth - scene.get_depth_map())[seen] / depth[seen]
        assert away.max() < 1e-5, f"{name}: depth by disparity is off by {away.max()}"

        def ours(resolution):
            line = f"eval {estimate} {folder}/gt_disp_{resolution}.pfm --mask none --normals toolkit --json"
            return json.loads(bench.run(line if resolution == "lowres" else line.replace(" --normals toolkit", "")))

        low, high = ours("lowres"), ours("highres")
        result = files.read_file(str(bench.folder / estimate))
        pairs = [
            (metrics.BadPix(0.07), low["bad_pixels_0.07_percent"]), (metrics.BadPix(0.03), low["bad_pixels_0.03_percent"]),
            (metrics.BadPix(0.01), low["bad_pixels_0.01_percent"]), (metrics.MSE(), low["mean_squared_error_x100"]),
            (metrics.Quantile(25), low["q25_x100"]), (metrics.BumpinessPlanes(), low.get("plane_bumpiness")),
            (metrics.BumpinessContinSurf(), low.get("smooth_bumpiness")),
            (metrics.MAEPlanes(), low.get("plane_median_angle_toolkit_deg")),
            (metrics.MAEContinSurf(), low.get("smooth_median_angle_toolkit_deg")),
            (metrics.Discontinuities(), high.get("discontinuity_bad_pixels_0.07_percent")),
            (metrics.FineFattening(), high.get("fine_fattening_percent")),
            (metrics.FineThinning(), high.get("fine_thinning_percent")),
        ]
        for metric, own in pairs:
            is_high = metric.evaluate_on_high_resolution()
            scene.set_high_gt_scale() if is_high else scene.set_low_gt_scale()
            # In the precision of `holo eval`: the toolkit compares in that of the files.
            estimated = result.astype(float)
            if is_high:
                estimated = scipy.ndimage.zoom(estimated, scene.gt_scale, order=0)
            mask = metric.get_evaluation_mask(scene)
            if own is None:
                assert not mask.any(), f"{name}: holo has no {metric.get_id()}"
                continue
            theirs = float(metric.get_score(estimated, scene.get_gt().astype(float), scene))
            off = abs(theirs - own) / max(abs(theirs), 1.0)
            print(f"    {name:8} {metric.get_id():32} toolkit {theirs:.9f}, holo {own:.9f}")
            assert off < 1e-6, f"{name}: {metric.get_id()} is {own}, and {theirs} by the toolkit"
            worst, count = max(worst, off), count + 1
    for off in stratified(metrics, scenes, files, bench):
        worst, count = max(worst, off), count + 1
    return f"truth and views are equal; {count} scores agree within {worst:.1e}"


def stratified(metrics, scenes, files, bench):
    """The scores of the four stratified scenes, with the truth of the views: what they differ by."""
    bench.run("dataset --out four --scenes stratified --preset hci --write el,disparity,depth,masks,hci-highres "
              "--spp 1 --integrator direct --denoise off --quiet")
    out = bench.export("hci-toolkit", "four", "--group stratified")
    known = {
        "backgammon": (scenes.Backgammon, [(metrics.BackgammonFattening, "spikes_fattening_percent"),
                                           (metrics.BackgammonThinning, "spikes_thinning_percent")]),
        "dots": (scenes.Dots, [(metrics.DotsBackgroundMSE, "boxes_mean_squared_error_x100"),
                               (metrics.MissedDots, "missed_dots_percent")]),
        "pyramids": (scenes.Pyramids, [(metrics.PyramidsSlantedBumpiness, "relief_bumpiness"),
                                       (metrics.PyramidsParallelBumpiness, "base_bumpiness")]),
        "stripes": (scenes.Stripes, [(metrics.StripesLowTexture, "textureless_bad_pixels_0.07_percent"),
                                     (metrics.DarkStripes, "dark_stripes_bad_pixels_0.07_percent"),
                                     (metrics.BrightStripes, "bright_stripes_bad_pixels_0.07_percent")]),
    }
    for name, (kind, pairs) in known.items():
        folder = f"four/{name}/{VIEWS}x{VIEWS}"
        bench.run(f"depth {folder} --out {name}_estimate.pfm --effort fast --quiet")
        own = json.loads(bench.run(f"eval {name}_estimate.pfm {folder}/scene_disparity.pfm --mask none --json"))
        scene = kind(data_path=str(out / "data"))
        scene.set_low_gt_scale()
        result = files.read_file(str(bench.folder / f"{name}_estimate.pfm")).astype(float)
        for metric, key in pairs:
            metric = metric()
            theirs = float(metric.get_score(result, scene.get_gt().astype(float), scene))
            off = abs(theirs - own[key]) / max(abs(theirs), 1.0)
            print(f"    {name:10} {metric.get_id():32} toolkit {theirs:.9f}, holo {own[key]:.9f}")
            assert off < 1e-6, f"{name}: {metric.get_id()} is {own[key]}, and {theirs} by the toolkit"
            yield off


def luma(rgb):
    """As `rgb2ycbcr` of MATLAB, for codes of 8 bits."""
    return (rgb.astype(float) @ np.array([65.481, 128.553, 24.966])) / 255 + 16


def basiclfsr(repository, bench):
    out = bench.export("basiclfsr")
    script = repository / "Generate_Data_for_Training.py"
    arguments = ["--angRes", "5", "--src_data_path", f"{out}/datasets/", "--save_data_path", f"{bench.folder}/lfsr_"]
    start = ("import runpy, sys; import consumers; consumers.without(*'torch torch.nn torch.nn.functional einops xlwt option matplotlib matplotlib.pyplot'.split());"
             " sys.argv = sys.argv[1:]; runpy.run_path(sys.argv[0], run_name='__main__')")
    paths = [str(repository), str(pathlib.Path(__file__).parent), os.environ.get("PYTHONPATH", "")]
    done = subprocess.run([sys.executable, "-B", "-c", start, str(script), *arguments], cwd=bench.folder, capture_output=True,
                          text=True, env={**os.environ, "PYTHONPATH": os.pathsep.join(paths)})
    assert done.returncode == 0, done.stderr
    patches = sorted(bench.folder.glob("lfsr_data_for_training/*/HCI_new/*.h5"))
    assert patches, "no patch was made"
    # The first patch of the first file is the corner of the first scene that its walk found.
    with h5py.File(patches[0]) as file:
        found = np.array(file["Hr_SAI_y"]).T
    worst = 1.0
    for scene in ["plaster", "fence"]:
        field, _ = bench.views(scene)
        side = (VIEWS - 5) // 2
        size = found.shape[0] // 5
        corner = luma(field[side:side + 5, side:side + 5, :size, :size]) / 255
        expected = corner.transpose(0, 2, 1, 3).reshape(5 * size, 5 * size)
        worst = min(worst, float(np.abs(found - expected).max()))
    assert worst < 1e-6, f"Y is off by {worst}"
    return f"{len(patches)} patches; Y of the first within {worst:.1e}"


def lfasr(repository, bench):
    without("torch", "torch.utils", "torch.utils.data", "cv2")
    import scipy
    scipy.misc = Nothing("scipy.misc")
    sys.modules["scipy.misc"] = scipy.misc
    sys.modules["torch.utils.data"].Dataset = object
    sys.modules["torch"].from_numpy = lambda array: array
    dataset = module_of(repository / "dataset.py", "lfasr_dataset")
    out = bench.export("lfasr")
    options = types.SimpleNamespace(dataset_path=str(out / "train.h5"), angular_out=VIEWS, angular_in=3, patch_size=32)
    loaded = dataset.DatasetFromHdf5(options)
    assert len(loaded) == 2, f"{len(loaded)} light fields"
    for number, scene in enumerate(["plaster", "fence"]):
        expected = np.floor(luma(bench.views(scene)[0]) + 0.5)
        off = np.abs(loaded.LFI[number] - expected).max()
        assert off == 0, f"{scene}: Y is off by {off}"
    _, part, label = loaded[1]
    assert part.shape == (9, 32, 32) and label.shape == (81, 32, 32), (part.shape, label.shape)
    with h5py.File(out / "test.h5") as file:
        shape = file["LFI_ycbcr"].shape
    assert shape[:3] == (2, VIEWS, VIEWS) and shape[-1] == 3, shape
    return "Y of both light fields is equal; its items have their shapes"


READER = """
#include "LightField.h"
int main(int, char **names) {
    Point4D size(atoi(names[2]), atoi(names[3]), 9, 9);
    LightField field(size, names[1], false);
    fwrite(field.rgb[0], sizeof(LFSample), size.getNSamples(), stdout);
}
"""


def codec(repository, bench):
    out = bench.export("jpeg-pleno")
    field, _ = bench.views("plaster")
    rows, columns = field.shape[2:4]
    (bench.folder / "reader.cpp").write_text(READER)
    sources = [repository / "src" / name for name in ["LightField.cpp", "Point4D.cpp"]]
    build = ["c++", "-O1", "-w", f"-I{repository / 'src'}", "reader.cpp", *map(str, sources), "-o", "reader"]
    done = subprocess.run(build, cwd=bench.folder, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    done = subprocess.run(["./reader", f"{out}/plaster/", str(columns), str(rows)], cwd=bench.folder, capture_output=True)
    assert done.returncode == 0, done.stderr
    kind = np.dtype("<u2") if len(done.stdout) == 2 * field[..., 0].size else np.dtype("u1")
    red = np.frombuffer(done.stdout, kind).reshape(VIEWS, VIEWS, rows, columns)
    assert np.array_equal(red & 255, field[..., 0]), "red differs"
    return "red of all views is equal"


def nerfstudio(repository, bench):
    try:
        import torch  # noqa: F401
    except ImportError:
        return "not run: needs torch"
    # What the parser of folders imports beside it, and does not need here.
    without("cv2", "jaxtyping", "rich", "rich.console", "rich.progress", "rich.text", "torch.utils.tensorboard", "tyro", "tyro.conf",
            "viser", "viser.transforms")
    sys.path.insert(0, str(repository))
    parser = importlib.import_module("nerfstudio.data.dataparsers.nerfstudio_dataparser")
    out = bench.export("nerfstudio", f"small/plaster/{VIEWS}x{VIEWS}")
    settings = dict(orientation_method="none", center_method="none", auto_scale_poses=False, eval_mode="all")
    with contextlib.redirect_stdout(io.StringIO()):
        read = parser.NerfstudioDataParserConfig(data=out, **settings).setup().get_dataparser_outputs("train")
    field, disparity = bench.views("plaster")
    cameras, names = read.cameras, [path.stem for path in read.image_filenames]
    assert len(names) == VIEWS * VIEWS, f"{len(names)} images"
    for name, path in zip(names, read.image_filenames):
        t, s = map(int, name.split("_"))
        assert np.array_equal(imageio.imread(path), field[t, s]), f"{name} differs"
    # Points at the depths of the central view must move by their disparity from view to view.
    poses = cameras.camera_to_worlds.numpy().astype(float)
    focal, center = [np.stack([pair[0].numpy(), pair[1].numpy()], -1)[:, 0].astype(float)
                     for pair in [(cameras.fx, cameras.fy), (cameras.cx, cameras.cy)]]
    middle = names.index(f"{VIEWS // 2:03}_{VIEWS // 2:03}")
    rows, columns = disparity.shape
    with open(bench.folder / f"small/plaster/{VIEWS}x{VIEWS}/scene_depth.pfm", "rb") as file:
        file.readline(), file.readline(), file.readline()
        depth = np.flipud(np.frombuffer(file.read(), "<f4").reshape(rows, columns)).astype(float)
    u, v = np.meshgrid(np.arange(columns) + 0.5, np.arange(rows) + 0.5)
    away = np.stack([(u - center[middle, 0]) / focal[middle, 0], -(v - center[middle, 1]) / focal[middle, 1], -np.ones_like(u)])
    world = np.einsum("ij,jvu->ivu", poses[middle][:, :3], away * depth) + poses[middle][:, 3, None, None]
    worst = 0.0
    for k, name in enumerate(names):
        t, s = map(int, name.split("_"))
        x, y, z = np.einsum("ji,jvu->ivu", poses[k][:, :3], world - poses[k][:, 3, None, None])
        moved = np.stack([center[k, 0] - focal[k, 0] * x / z - u, center[k, 1] + focal[k, 1] * y / z - v])
        steps = np.array([s, t])[:, None, None] - VIEWS // 2
        worst = max(worst, np.nanmax(np.abs(moved + steps * disparity)[:, np.isfinite(depth)]))
    assert worst < 1e-3, f"points are off by {worst} px"
    return f"{len(names)} images are equal, and points of the central view fall where disparity has them, within {worst:.1e} px"


def oacc_net(repository, bench):
    try:
        import einops  # noqa: F401
        import torchvision  # noqa: F401
    except ImportError as why:
        return f"not run: needs {why.name}"
    sys.path.insert(0, str(repository))
    utils = module_of(repository / "utils.py", "oacc_utils")
    plain = "--spp 1 --integrator direct --denoise off --quiet"
    bench.run(f"dataset --out sixteen --preset hci --write el,disparity,depth {plain}")
    out = bench.export("hci", "sixteen")
    # What changes the data for training would hide what was read.
    patch, at = 96, (200, 150)
    utils.illuminance_augmentation = lambda field: field[..., 1]
    utils.scale_augmentation = lambda field, label, _: (field, label, 2)
    cut = slice(at[0], at[0] + patch), slice(at[1], at[1] + patch)
    utils.random_crop = lambda field, label, *_: (field[:, :, *cut], label[cut])
    utils.orientation_augmentation = lambda data, label: (data, label)
    loader = utils.TrainSetLoader(types.SimpleNamespace(trainset_dir=f"{out}/training/", angRes=VIEWS, patchsize=patch))
    assert len(loader.files) == 16, f"{len(loader.files)} scenes"
    for index in [0, 3, 12]:
        field, disparity = bench.views(loader.files[loader.scene_idx[index]], "sixteen")
        data, label = loader[index]
        read = data.numpy()[0].reshape(VIEWS, patch, VIEWS, patch).transpose(0, 2, 1, 3)
        assert np.array_equal(np.rint(255 * read), field[:, :, *cut, 1]), "views differ"
        assert np.array_equal(label.numpy()[0], disparity[cut]), "disparity differs"
        assert set(np.unique(label.numpy()[1])) <= {0.0, 1.0}, "the mask is none"
    return "16 scenes; views and disparity of three are equal"


def splatting(repository, bench):
    try:
        import plyfile  # noqa: F401
        import torch  # noqa: F401
    except ImportError as why:
        return f"not run: needs {why.name}"
    # Kernels for a GPU, which reading does not need.
    without("simple_knn", "simple_knn._C")
    sys.path.insert(0, str(repository))
    # The packages import all of the training, and other repositories have modules of these names.
    for name in ["scene", "utils"]:
        package = types.ModuleType(name)
        package.__path__ = [str(repository / name)]
        sys.modules[name] = package
    reader = importlib.import_module("scene.dataset_readers")
    # It takes codes for signed, as Pillow did before version 12.
    image_of = reader.Image.fromarray
    reader.Image.fromarray = lambda array, _: image_of(array.view(np.uint8))
    bench.run("scene garden --out garden.glb")
    bench.run("array plane --count 3x3 --spacing-m 0.05 --radius-m 1 --size 96x64 --fov-deg 45 --out cameras.json")
    bench.run("render garden.glb --transforms cameras.json --out posed --spp 1 --layers depth --quiet")
    out = bench.export("nerf", "posed")
    with contextlib.redirect_stdout(io.StringIO()):
        read = reader.readNerfSyntheticInfo(str(out), False, True)
    cameras = read.train_cameras + read.test_cameras
    assert (len(read.train_cameras), len(read.test_cameras)) == (7, 2), f"{len(cameras)} cameras"
    points = np.asarray(read.point_cloud.points, float)
    colors = np.rint(255 * np.asarray(read.point_cloud.colors))
    seen = 0
    for camera in cameras:
        image = imageio.imread(bench.folder / "posed/images" / f"{camera.image_name}.png")
        # Codes are divided by 255, multiplied, and cut off.
        off = np.abs(np.asarray(camera.image).astype(int) - image[..., :3]).max()
        assert off <= 1, f"{camera.image_name} differs by {off}"
        with open(bench.folder / "posed/depth" / f"{camera.image_name}.pfm", "rb") as file:
            file.readline(), file.readline(), file.readline()
            depth = np.flipud(np.frombuffer(file.read(), "<f4").reshape(camera.height, camera.width))
        x, y, z = (points @ camera.R + camera.T).T
        focal = camera.width / (2 * np.tan(camera.FovX / 2))
        column, row = focal * x / z + camera.width / 2, focal * y / z + camera.height / 2
        at = [np.floor(place).astype(int) for place in (row, column)]
        inside = (z > 0) & (at[0] >= 0) & (at[0] < camera.height) & (at[1] >= 0) & (at[1] < camera.width)
        rows, columns = at[0][inside], at[1][inside]
        middle = np.hypot(row[inside] - rows - 0.5, column[inside] - columns - 0.5)
        # A point of this camera lies in the middle of its pixel, at its depth, with its color.
        own = (middle < 1e-2) & (np.abs(z[inside] / depth[rows, columns] - 1) < 1e-5)
        same = (colors[inside][own] == image[rows[own], columns[own], :3]).all(axis=1)
        assert same.mean() > 0.99, "colors differ"
        seen += same.sum()
    assert seen >= len(points), f"{seen} of {len(points)} points lie on their pixels"
    return f"7 + 2 images are equal within a code, {len(points)} points lie on their pixels, at their depths, with their colors"


def saliency(repository, bench):
    try:
        import cv2  # noqa: F401
        import scipy.io
        import torchvision  # noqa: F401
    except ImportError as why:
        return f"not run: needs {why.name}"
    loader = module_of(repository / "bestlf/Dataloader/SODdataloader.py", "saliency_loader")
    bench.run("scene plaster --out plaster.glb")
    bench.run("render plaster.glb --preset hci --lenses 256x256 --layers depth,disparity,object-id --out seen --spp 1 --quiet")
    out = bench.export("lfsd", "seen", "--objects ball,cone,block")
    roots = [f"{out}/train_{part}/" for part in ("images", "masks", "focals")]
    image, focal, mask, name = loader.test_dataset(*roots, 256).load_data()
    assert name == "seen.png" and mask.size == (256, 256)
    stack = scipy.io.loadmat(out / "train_focals/seen.mat")["img"]
    mean, deviation = loader.test_dataset.mean_focal, loader.test_dataset.std_focal
    read = focal.numpy().transpose(1, 2, 0) * deviation + mean
    assert np.abs(255 * read - stack).max() < 1e-3, "the focal stack differs"
    central = imageio.imread(bench.folder / "seen/hci/input_Cam040.png")
    codes = 255 * (image[0].numpy().transpose(1, 2, 0) * deviation[:3] + mean[:3])
    worst = np.abs(codes - central).max()
    assert worst < 40, f"the image is off by {worst}"
    return f"the focal stack is equal, {np.mean(np.asarray(mask) > 0):.0%} of the mask is lit, the JPEG is within {worst:.0f} codes"


CONSUMERS = {
    "EPINET": ("epinet_fun/util.py", epinet),
    "HCI evaluation toolkit": ("source/toolkit/metrics/region_metrics.py", toolkit),
    "BasicLFSR": ("Generate_Data_for_Training.py", basiclfsr),
    "LFASR-geometry": ("LFData/PrepareData_train_HCI.m", lfasr),
    "nerfstudio": ("nerfstudio/data/dataparsers/nerfstudio_dataparser.py", nerfstudio),
    "Light-Field-Codec (JPEG Pleno)": ("src/LightField.cpp", codec),
    "OACC-Net": ("func_pfm.py", oacc_net),
    "3D Gaussian splatting": ("scene/dataset_readers.py", splatting),
    "LFSOD (saliency)": ("bestlf/Dataloader/SODdataloader.py", saliency),
}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("repositories", type=pathlib.Path, metavar="DIR")
    parser.add_argument("--holo", required=True, help="the program")
    parser.add_argument("--only", action="append", help="consumers with this text in their names")
    options = parser.parse_args()
    repositories = [options.repositories, *(p for p in sorted(options.repositories.glob("*")) if p.is_dir())]
    failed = []
    with tempfile.TemporaryDirectory() as folder:
        bench = Bench(os.path.abspath(options.holo), folder)
        plain = "--spp 1 --integrator direct --denoise off --quiet"
        bench.run(f"dataset --out small --scenes plaster,fence --preset hci --lenses 96x96 --write el,disparity,depth,masks,hci-highres {plain}")
        for name, (marker, check) in CONSUMERS.items():
            if options.only and not any(text.lower() in name.lower() for text in options.only):
                continue
            found = next((repository for repository in repositories if (repository / marker).is_file()), None)
            if found is None:
                print(f"{name}: not run: needs a repository with {marker}")
                continue
            if check is epinet:
                bench.run(f"dataset --out large --scenes plaster --preset hci --write el,disparity,depth {plain}")
            try:
                print(f"{name}: {check(found.resolve(), bench)}", flush=True)
            except AssertionError as why:
                failed.append(name)
                print(f"{name}: FAILED: {why}", flush=True)
    if failed:
        sys.exit(f"failed: {', '.join(failed)}")


if __name__ == "__main__":
    main()

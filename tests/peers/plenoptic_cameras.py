"""What decoders of plenoptic cameras make of raw images of `holo`: LFToolbox under GNU Octave, and PlenoptiCam.

    python3 tests/peers/plenoptic_cameras.py HOLO [--lftoolbox FOLDER] [--plenopticam]

HOLO is the program; FOLDER has LFToolbox 0.5 (https://github.com/doda42/LFToolbox); PlenoptiCam 0.9.3 is a module of this
Python, with SciPy below 1.14. Needs NumPy and SciPy. A plane with a texture of waves is rendered at 0.35 m through a square
and a hexagonal camera of 1400 x 1040 pixels. Printed are the grid that LFToolbox finds in the white image beside that of the
camera, and the disparity of the decoded views beside Eq. 3 with the lean of the cos^4 law; the program fails where the grid
is off by more than 0.02 px a pitch (a ten-thousandth for the Lytro Illum) or the disparity by more than 3 % (LFToolbox) or 12 % (PlenoptiCam, which resamples
micro-images).

Octave lacks `demosaic`, `DelaunayTri`, `nearestNeighbor` and `griddedInterpolant`: the first three are replaced by the
functions below, and instead of what needs the last the toolbox has `LFDecodeLensletImageSimple`.

Octave 7.3 with LFToolbox 0.5.3 (commit 3bf4f55) and PlenoptiCam 0.9.3 printed:

Lytro Illum: LFToolbox finds 541 x 433, pitch 14.29067, rotation 0.000542; camera 14.29115, 0.000543
square: LFToolbox decodes (15, 15, 73, 97, 3), disparity 0.2427 px, expected 0.2428, ratio 0.9993
square: PlenoptiCam decodes (73, 97), disparity 0.2681 px, expected 0.2710, ratio 0.9893
hex-rows: LFToolbox finds pitch 14.3244, rows 12.4030, rotation -0.001925; camera 14.3349, 12.4144, -0.001920
hex-rows: LFToolbox decodes (15, 15, 84, 113, 3), disparity 0.2773 px, expected 0.2804, ratio 0.9891
hex-rows: PlenoptiCam decodes (83, 112), disparity 0.3067 px, expected 0.3130, ratio 0.9799

(LFToolbox's pitch is as much too small as whole peaks of the outermost micro-images make it: less in larger images.)
"""

import argparse
import json
import os
import struct
import subprocess
import sys
import tempfile
import zlib

import numpy as np

DEPTH_M = 0.35
CAMERA = """
[sensor]
size_px = [1400, 1040]
pixel_um = 5.0
[mla]
grid = "GRID"
pitch_um = 71.2
rotation_deg = ROTATION
offset_um = [7.0, -4.0]
gap_um = 400.0
[main_lens]
focal_mm = 40.0
f_number = 5.8
exit_pupil_mm = 60.0
focus_m = 0.5
"""

# Stand-ins for functions that Octave lacks; the names are the toolbox's.
STANDINS = {
    "demosaic.m": """function rgb = demosaic(raw, order)
% Bilinear interpolation of a Bayer mosaic in the order 'grbg'.
if ~strcmpi(order, 'grbg'); error('order'); end
[h, w] = size(raw);
[c, r] = meshgrid(0:w-1, 0:h-1);
masks = {mod(r,2)==0 & mod(c,2)==1, mod(r,2)==mod(c,2), mod(r,2)==1 & mod(c,2)==0};
kernel = [1 2 1; 2 4 2; 1 2 1];
rgb = zeros(h, w, 3, class(raw));
for k = 1:3
  value = conv2(double(raw) .* masks{k}, kernel, 'same') ./ conv2(double(masks{k}), kernel, 'same');
  value(masks{k}) = raw(masks{k});
  rgb(:,:,k) = value;
end
end
""",
    # MATLAB's is real where its input is symmetric.
    "ifft2.m": """function image = ifft2(spectrum)
image = real(builtin('ifft2', spectrum));
end
""",
    "DelaunayTri.m": """function labels = DelaunayTri(y, x)
labels = zeros(max(y) + 30, max(x) + 30, 'int32');
labels(sub2ind(size(labels), y(:), x(:))) = 1:numel(y);
end
""",
    # All micro-images are nearer than 30 px to what the toolbox looks for.
    "nearestNeighbor.m": """function found = nearestNeighbor(labels, y, x)
[dx, dy] = meshgrid(-30:30);
[~, order] = sort(dx(:).^2 + dy(:).^2);
found = zeros(numel(y), 1);
for k = order'
  open = find(found == 0);
  if isempty(open); break; end
  at = [y(open)(:) + dy(k), x(open)(:) + dx(k)];
  inside = all(at >= 1, 2) & at(:,1) <= rows(labels) & at(:,2) <= columns(labels);
  open = open(inside);
  found(open) = labels(sub2ind(size(labels), at(inside,1), at(inside,2)));
end
found(found == 0) = 1;
end
""",
}


def png(image):
    """An RGB image of 8 bits as PNG."""

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    height, width, _ = image.shape
    rows = b"".join(b"\0" + row.tobytes() for row in image)
    header = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b"")


def write_plane(path):
    """A plane at DEPTH_M with waves, unlit, 60 cm wide, before a camera at the origin."""
    y, x = np.mgrid[0:1024, 0:1024] / 1024.0
    numbers = np.random.default_rng(1)
    waves = sum(
        np.cos(2 * np.pi * (a * x + b * y + c))
        for a, b, c in zip(numbers.uniform(-40, 40, 24), numbers.uniform(-40, 40, 24), numbers.uniform(0, 1, 24))
    )
    texture = png(np.repeat(np.uint8(np.clip(140 + 18 * waves, 0, 255))[..., None], 3, 2))
    half, z = 0.3, -DEPTH_M
    positions = np.array([[-half, -half, z], [half, -half, z], [half, half, z], [-half, half, z]], np.float32)
    places = np.array([[0, 1], [1, 1], [1, 0], [0, 0]], np.float32)
    triangles = np.array([0, 1, 2, 0, 2, 3], np.uint16)
    parts = [positions.tobytes(), places.tobytes(), triangles.tobytes(), texture]
    views, binary = [], b""
    for part in parts:
        views.append({"buffer": 0, "byteOffset": len(binary), "byteLength": len(part)})
        binary += part + b"\0" * (-len(part) % 4)
    accessors = [
        {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": positions.min(0).tolist(), "max": positions.max(0).tolist()},
        {"bufferView": 1, "componentType": 5126, "count": 4, "type": "VEC2"},
        {"bufferView": 2, "componentType": 5123, "count": 6, "type": "SCALAR"},
    ]
    scene = {
        "asset": {"version": "2.0"},
        "extensionsUsed": ["KHR_materials_unlit"],
        "scene": 0,
        "scenes": [{"nodes": [0, 1]}],
        "nodes": [{"mesh": 0}, {"camera": 0}],
        "cameras": [{"type": "perspective", "perspective": {"yfov": 0.7, "znear": 0.01}}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "indices": 2, "material": 0}]}],
        "materials": [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}, "extensions": {"KHR_materials_unlit": {}}}],
        "textures": [{"source": 0}],
        "images": [{"bufferView": 3, "mimeType": "image/png"}],
        "accessors": accessors,
        "bufferViews": views,
        "buffers": [{"byteLength": len(binary)}],
    }
    text = json.dumps(scene).encode()
    text += b" " * (-len(text) % 4)
    chunks = struct.pack("<II", len(text), 0x4E4F534A) + text + struct.pack("<II", len(binary), 0x004E4942) + binary
    with open(path, "wb") as file:
        file.write(struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks)


def disparity(views):
    """Pixels by which the middle of the views in a row moves from one to the next: least squares, iterated."""
    middle = len(views) // 2
    found = 0.0
    columns = np.arange(views[0].shape[1])
    for _ in range(6):
        above = below = 0.0
        for k, view in enumerate(views):
            if k == middle:
                continue
            moved = np.stack([np.interp(columns + found * (k - middle), columns, row) for row in views[middle]])
            inner = (slice(6, -6), slice(6, -6))
            slope = np.gradient(moved, axis=1)[inner] * (k - middle)
            above += (slope * (view - moved)[inner]).sum()
            below += (slope * slope).sum()
        found += above / below
    return found


def octave(folder, toolbox, standins, script):
    paths = [toolbox, os.path.join(toolbox, "SupportFunctions"), standins]
    lines = "pkg load image; warning('off', 'all');\n" + "".join(f"addpath('{path}');\n" for path in paths) + script
    run = subprocess.run(["octave-cli", "--eval", lines], cwd=folder, capture_output=True, text=True)
    if run.returncode != 0:
        sys.exit(run.stdout[-2000:] + run.stderr[-2000:])
    return run.stdout


def check_lftoolbox(folder, toolbox, standins, grid, expected):
    from scipy.io import loadmat

    model = json.load(open(os.path.join(folder, "raw.grid.json")))["LensletGridModel"]
    good = True
    if grid == "hex-rows":
        # The toolbox looks for hexagonal grids only.
        found = octave(
            folder,
            toolbox,
            standins,
            "Options = struct('ApproxLensletSpacing',14, 'FilterDiskRadiusMult',5/14, 'CropAmt',20, 'SkipStep',15, 'Orientation','horz');\n"
            "Grid = LFBuildLensletGridModel(double(imread('white.png')), Options, false);\n"
            "printf('GRID %.6f %.6f %.6f %.3f %.3f\\n', Grid.HSpacing, Grid.VSpacing, Grid.Rot, Grid.HOffset, Grid.VOffset);\n",
        )
        h, v, rot, *_ = [float(x) for x in found.split("GRID ")[1].split()[:5]]
        print(
            f"{grid}: LFToolbox finds pitch {h:.4f}, rows {v:.4f}, rotation {rot:.6f}; "
            f"camera {model['HSpacing']:.4f}, {model['VSpacing']:.4f}, {model['Rot']:.6f}"
        )
        good &= abs(h - model["HSpacing"]) < 0.02 and abs(v - model["VSpacing"]) < 0.02 and abs(rot - model["Rot"]) < 1e-3
    octave(folder, toolbox, standins, "decode\n")
    field = loadmat(os.path.join(folder, "lightfield.mat"))["LF"]
    t, s = field.shape[0] // 2, field.shape[1] // 2
    views = [np.float64(field[t, s + k, :, :, 1]) for k in range(-3, 4)]
    spacing = 2 * np.ceil(np.ceil(model["HSpacing"]) / 2)
    expected *= model["HSpacing"] / spacing * (2 / np.sqrt(3) if grid == "hex-rows" else 1)
    found = disparity(views)
    print(f"{grid}: LFToolbox decodes {field.shape}, disparity {found:.4f} px, expected {expected:.4f}, ratio {found / expected:.4f}")
    return good and abs(found / expected - 1) < 0.03


def check_illum(holo, folder, toolbox, standins):
    """The grid that LFToolbox finds in the white image of a Lytro Illum."""
    subprocess.run([holo, "white", "--camera-file", "lytro-illum", "--out", folder], check=True, capture_output=True)
    found = octave(
        folder,
        toolbox,
        standins,
        "Options = struct('ApproxLensletSpacing',14, 'FilterDiskRadiusMult',5/14, 'CropAmt',25, 'SkipStep',250, 'Orientation','horz');\n"
        "Grid = LFBuildLensletGridModel(double(imread('white.png')), Options, false);\n"
        "printf('GRID %.6f %.6f %d %d\\n', Grid.HSpacing, Grid.Rot, Grid.UMax, Grid.VMax);\n",
    )
    h, rot, columns, rows = [float(x) for x in found.split("GRID ")[1].split()[:4]]
    optics = [holo, "optics", "--camera-file", "lytro-illum", "--json"]
    pitch = json.loads(subprocess.run(optics, check=True, capture_output=True, text=True).stdout)["micro_image_pitch_px"]
    print(f"Lytro Illum: LFToolbox finds {columns:.0f} x {rows:.0f}, pitch {h:.5f}, rotation {rot:.6f}; camera {pitch:.5f}, 0.000543")
    return abs(h / pitch - 1) < 1e-4 and abs(rot - 5.43e-4) < 1e-5


def check_plenopticam(folder, grid, expected):
    from PIL import Image

    # Its command line imports its window, which needs a screen.
    command = (
        "import importlib.util, os, sys, types\n"
        "root = os.path.dirname(importlib.util.find_spec('plenopticam').origin)\n"
        "gui = types.ModuleType('plenopticam.gui')\n"
        "gui.__path__ = [os.path.join(root, 'gui')]\n"
        "window = types.ModuleType('plenopticam.gui.top_level')\n"
        "window.PlenopticamApp = None\n"
        "sys.modules.update({'plenopticam.gui': gui, 'plenopticam.gui.top_level': window})\n"
        "from plenopticam.bin.cli_script import main\n"
        "sys.exit(0 if main() else 1)\n"
    )
    # Hexagonal rows are resampled to square pixels.
    expected *= 2 / np.sqrt(3) if grid == "hex-rows" else 1
    arguments = ["-f", "raw.tiff", "-c", "white.tiff", "--meta=calibration.json", "--patch=9", "--vign", "--smpl=local"]
    run = subprocess.run([sys.executable, "-c", command, *arguments], cwd=folder, capture_output=True, text=True)
    views = os.path.join(folder, "raw", "viewpoints_9px")
    if not os.path.isdir(views):
        sys.exit(run.stdout[-2000:] + run.stderr[-3000:])
    images = [np.float64(Image.open(os.path.join(views, f"04_0{k}.png")).convert("L")) for k in range(1, 8)]
    # Contrast is stretched view by view.
    images = [(image - image.mean()) / image.std() for image in images]
    found = disparity(images)
    print(f"{grid}: PlenoptiCam decodes {images[0].shape}, disparity {found:.4f} px, expected {expected:.4f}, ratio {found / expected:.4f}")
    return abs(found / expected - 1) < 0.12


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("holo")
    parser.add_argument("--lftoolbox")
    parser.add_argument("--plenopticam", action="store_true")
    options = parser.parse_args()
    holo, good = os.path.abspath(options.holo), True
    with tempfile.TemporaryDirectory() as folder:
        scene, standins = os.path.join(folder, "plane.glb"), os.path.join(folder, "standins")
        write_plane(scene)
        os.mkdir(standins)
        for name, text in STANDINS.items():
            with open(os.path.join(standins, name), "w") as file:
                file.write(text)
        if options.lftoolbox:
            good &= check_illum(holo, os.path.join(folder, "illum"), os.path.abspath(options.lftoolbox), standins)
        for grid, rotation in [("square", "0.0"), ("hex-rows", "0.11")]:
            camera, out = os.path.join(folder, grid + ".toml"), os.path.join(folder, grid)
            with open(camera, "w") as file:
                file.write(CAMERA.replace("GRID", grid).replace("ROTATION", rotation))
            subprocess.run(
                [holo, "render", scene, "--camera-file", camera, "--out", out, "--spp", "64", "--quiet", "--exposure", "0",
                 "--integrator", "direct", "--write", "raw,white", "--for", "lftoolbox,plenopticam"],
                check=True,
            )
            optics = [holo, "optics", "--camera-file", camera, "--depths-m", f"{DEPTH_M},1", "--json"]
            numbers = json.loads(subprocess.run(optics, check=True, capture_output=True, text=True).stdout)
            expected = numbers[f"disparity_px_at_{DEPTH_M}m"] + numbers["cos4_disparity_px"]
            if options.lftoolbox:
                toolbox = os.path.abspath(options.lftoolbox)
                good &= check_lftoolbox(os.path.join(out, "lftoolbox"), toolbox, standins, grid, expected)
            if options.plenopticam:
                good &= check_plenopticam(os.path.join(out, "plenopticam"), grid, expected)
    sys.exit(0 if good else 1)


if __name__ == "__main__":
    main()

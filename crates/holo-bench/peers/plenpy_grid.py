"""The grid of micro-images that plenpy finds in a white image of a hexagonal array, as LFToolbox writes grids, for
`holo eval-calibration WHITE.grid.json --truth DIR`.

    pip install plenpy==0.9 imageio==2.9.0 torch torchvision     # it imports both, which grids do not need
    python plenpy_grid.py WHITE.png PITCH_PX GAP_MM IMAGE_DISTANCE_MM METHOD > WHITE.grid.json

WHITE.png has 8 bits of RGB, as in `white/compote` of the calibration benchmark. The numbers are those of the data sheet: the pitch of micro-images, the gap, and the distance of the exit pupil from the array. METHOD is
`own`, plenpy's, or `dans`, its version of LFToolbox's.
"""

import json
import pathlib
import shutil
import sys
import tempfile

from plenpy.cameras.raytracer_lightfield_camera import RayTracerLF


def main():
    white, pitch_px, gap_mm, distance_mm, method = sys.argv[1:]
    with tempfile.TemporaryDirectory() as folder:
        images = pathlib.Path(folder, "Calibration", "WhiteImages")
        images.mkdir(parents=True)
        pathlib.Path(folder, "Images").mkdir()
        shutil.copy(white, images / "white.png")
        camera = {"imageDistance": float(distance_mm) / 1e3, "focusDistance": 1.0}
        (images / "white.json").write_text(json.dumps({"camera": camera}))
        found = RayTracerLF(folder, grid_type="hex", ml_size=float(pitch_px), ml_focal_length=float(gap_mm) / 1e3, format="PNG-PIL")
        found.calibrate(method=method, force=True)
        grid = found._calibrationDb[0]["ideal_grid_params"]
        first = found.get_ml_centers(0)[0]
    # Rows of the image come first, and every second one is shifted. The first pixel has the number 1 in MATLAB.
    model = {
        "HSpacing": float(grid.spacing[1]), "VSpacing": float(grid.spacing[0] / 2),
        "HOffset": float(first[1]) + 1, "VOffset": float(first[0]) + 1, "Rot": -float(grid.rotation),
        "UMax": int((grid.size[1] - grid.offset[1]) // grid.spacing[1]),
        "VMax": int((grid.size[0] - grid.offset[0]) // (grid.spacing[0] / 2)),
        "Orientation": "horz", "FirstPosShiftRow": 2,
    }
    print(json.dumps({"LensletGridModel": model}))


# Plenpy starts processes that import this file.
if __name__ == "__main__":
    main()

"""Prints the numbers of main.rs: the benchmark's measures from their formulas. Needs numpy, scipy and scikit-image 0.26."""
import numpy as np
from scipy.signal import convolve2d
from skimage.filters import scharr_h, scharr_v

ROWS = COLUMNS = 24
BORDER = 3
FOCAL_M, SENSOR_M, BASELINE_M, FOCUS_M = 0.05, 0.036, 0.02, 3.0

row, column = np.meshgrid(np.arange(ROWS), np.arange(COLUMNS), indexing="ij")
truth = (2 * row + 3 * column + (row * column) % 5) / 512
estimate = truth + ((row * row + 3 * row * column + column) % 7) / 4096
estimate[10:13, 5:9] += 0.25
estimate[15:20, 4:10] -= 0.0625
estimate[5:8, 12:20] += 0.015625
inside = np.zeros((ROWS, COLUMNS), bool)
inside[BORDER:-BORDER, BORDER:-BORDER] = True
error = estimate - truth

down, along = scharr_h(error), scharr_v(error)
hessian = [scharr_v(along), scharr_h(along), scharr_v(down), scharr_h(down)]
norm = np.clip(np.sqrt(sum(np.square(part) for part in hessian)), 0, 0.05)


def normals(disparity, toolkit):
    depth = 1 / (disparity * SENSOR_M / (BASELINE_M * FOCAL_M * COLUMNS) + 1 / FOCUS_M)
    scale = SENSOR_M / FOCAL_M * depth
    if toolkit:
        x, y = column / (COLUMNS - 1) * 0.5 * scale, row / (ROWS - 1) * 0.5 * scale
    else:
        x, y = ((column + 0.5) / COLUMNS - 0.5) * scale, ((row + 0.5) / ROWS - 0.5) * scale
    kernel = np.array([[3.0, 10, 3], [0, 0, 0], [-3, -10, -3]]) / 64
    derivative = lambda kernel: np.dstack([convolve2d(part, kernel, "same", "wrap") for part in (x, y, depth)])
    normal = np.cross(derivative(kernel), derivative(kernel.T))
    return normal / np.linalg.norm(normal, axis=2, keepdims=True)


def angle(toolkit):
    cosine = np.sum(normals(estimate, toolkit) * normals(truth, toolkit), axis=2)
    return np.median(np.degrees(np.arccos(np.clip(cosine, -1, 1)))[inside])


absolute = np.sort(100 * np.abs(error[inside]))
for name, value in [
    ("BAD_PIXELS", [100 * np.mean(np.abs(error[inside]) > limit) for limit in (0.01, 0.03, 0.07)]),
    ("MEAN_SQUARE", 100 * np.mean(np.square(error[inside]))),
    ("Q25", absolute[int(absolute.size * 25 / 100)]),
    ("BUMPINESS", 100 * np.mean(norm[inside])),
    ("ANGLE_PINHOLE", angle(False)),
    ("ANGLE_TOOLKIT", angle(True)),
]:
    print(f"const {name}:", np.array(value).tolist())

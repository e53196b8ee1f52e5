"""Makes scipy_*.mat and h5py_*.h5: `python make_mat.py`. SciPy 1.17.1, NumPy 1.26.4, h5py 3.16.0 were used.

The light field is H(v,u,t,s,c) = v*97 + u*31 + t*11 + s*5 + c*3 of 4 x 3 lenses, 2 x 5 views, 3 channels, modulo 251
where it must fit 8 bits.
"""

import numpy as np
import scipy.io
import h5py

v, u, t, s, c = np.ogrid[:4, :3, :2, :5, :3]
values = v * 97 + u * 31 + t * 11 + s * 5 + c * 3
everything = {
    "H": (values % 251).astype(np.uint8),
    "views": np.array([[2.0, 5.0]]),
    "lenses": np.array([[4.0, 3.0]]),
    "axes": "vutsc",
    "baseline_m": np.array([[2e-4, 1e-4]]),
    "focal_length_mm": 35.1,
    "sensor_size_mm": 36.0,
    "focus_distance_m": np.inf,
    "int32s": np.array([[-(2**31), -1, 0, 2**31 - 1]], np.int32),
    "int8s": np.array([[-128, -1, 0, 127]], np.int8),
    "int64s": np.array([[-(2**63), 2**63 - 1]], np.int64),
    "uint64s": np.array([[2**64 - 1, 2**53 + 1]], np.uint64),
    "floats": np.array([[0.1, -0.0, np.inf]], np.float32),
    "flags": np.array([[True, False]]),
    "word": "µm",
    "nothing": np.zeros((0, 3)),
}
for compressed in (False, True):
    name = "scipy_compressed.mat" if compressed else "scipy_plain.mat"
    scipy.io.savemat(name, everything, do_compression=compressed, oned_as="row")
scipy.io.savemat(
    "scipy_classes.mat",
    {
        "LF": np.moveaxis(values, (2, 3, 0, 1, 4), (0, 1, 2, 3, 4)).astype(np.uint16),
        "cell": np.array([1, "a"], object),
        "structure": {"a": 1.0},
        "complex": np.array([[1 + 2j]]),
        "rows": np.array(["ab", "cd"]),
        "sparse": scipy.sparse.eye(3, format="csc"),
    },
)
with h5py.File("h5py_lf.h5", "w") as file:
    samples = file.create_dataset("H", data=values.astype(np.float32) / 7, chunks=(2, 2, 2, 5, 3), compression=6, shuffle=True)
    for axis, label in enumerate("vutsc"):
        samples.dims[axis].label = label
    file.attrs["views"] = [2, 5]
    file.attrs["lenses"] = [4, 3]
    file.attrs["axes"] = "vutsc"
    file.attrs["baseline_m"] = [2e-4, 1e-4]
    file.attrs["focal_length_mm"] = 35.1
    file.attrs["sensor_size_mm"] = 36.0
    file.attrs["focus_distance_m"] = np.inf
    file.attrs["projection"] = np.bytes_("orthographic")
    file["depth_m"] = values[..., 0].astype(np.float32) / 3
with h5py.File("h5py_u16.h5", "w") as file:
    file["H"] = values.astype(">u2")

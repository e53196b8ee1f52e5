"""Times Mitsuba 3 on a grid of views in one `batch` sensor, and keeps the central view.

    mitsuba_grid.py SCENE.glb --out FOLDER [--side 11] [--samples 1,4,16] [--depth 9]
                    [--sampler multijitter] [--rounds 3]

Run by `cargo xtask report --peers`. The output is described in `peer.py`; seconds are those of all views. Scene,
materials and cameras are those of `tests/radiance/mitsuba_reference.py`. Kernels are compiled before timing, as in a
second render.
"""
import os
import time

import numpy as np

import peer

import mitsuba_reference as reference  # (peer extends the import path)
from files import write_pfm

WIDTH, HEIGHT = 99, 66


def main():
    parser = peer.parser(__doc__, 11, "all rendered in one call")
    parser.add_argument("--depth", type=int, default=9)
    parser.add_argument("--sampler", choices=["multijitter", "independent"], default="multijitter")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--longest-s", type=float, default=10.0, help="no further round begins after this time")
    a = parser.parse_args()
    mi = reference.mi
    surround = {"type": "constant", "radiance": reference.color([0.2, 0.24, 0.32])}
    scene, pose = reference.describe(a.scene, surround, a.depth)
    loaded, _ = reference.grid(scene, pose, a.side**2, WIDTH, HEIGHT, a.sampler)
    for samples in a.samples:
        seconds, images = [], []
        for k in range(a.rounds + 1):
            start = time.time()
            image = np.array(mi.render(loaded, spp=samples, seed=1 + k))
            if k > 0:
                seconds.append(time.time() - start)
                center = WIDTH * (a.side**2 // 2)
                images.append(os.path.join(a.out, f"mitsuba_{a.sampler}_{a.depth}_{samples}_{k}.pfm"))
                write_pfm(images[-1], image[:, center : center + WIDTH, :3])
            if sum(seconds) > a.longest_s:
                break
        peer.print_measurement(samples, seconds, images)


if __name__ == "__main__":
    main()

"""Trains a small disparity network on light fields of `holo generate`, and scores it on what it never saw.

    holo generate --count 300 --seed 1 --recipe hci-like --spp 4 --integrator direct --out set
    holo dataset --preset hci --scenes chess,mountains --lenses 192x192 --out gallery
    python train.py set --test gallery --out model

The network is in the manner of EPINet (Shin et al., CVPR 2018): it sees nine views in each of four directions, and is
convolutional, so that it is trained on small images and estimates large ones. The same command goes on after a stop.
Runs on a GPU if there is one.

OUT has `curve.csv` (step, seconds, loss, and the mean BadPix 0.07 of the tests), `checkpoint.pt` with all that a stop
would lose, and `scores.csv` of every tested light field at the end.
"""

import argparse
import csv
import itertools
import math
import os
import pathlib
import time

import holo
import numpy as np
import torch
from torch import nn

VIEWS = 9
# What the valid convolutions of the network need at every side, px.
MARGIN = 11
# The side of the estimates that it is trained on, px.
PATCH = 32
BATCH = 16
# Steps from one line of the learning curve to the next.
NOTE = 250


class Network(nn.Module):
    """Four streams of convolutions, one a direction, then one for all of them."""

    def __init__(self, stream=20, trunk=72):
        super().__init__()
        self.streams = nn.ModuleList(self.block([VIEWS] + 4 * [stream]) for _ in range(4))
        self.trunk = nn.Sequential(self.block([4 * stream] + 6 * [trunk]), nn.Conv2d(trunk, 1, 3))

    @staticmethod
    def block(channels):
        layers = []
        for before, after in zip(channels, channels[1:]):
            layers += [nn.Conv2d(before, after, 3, bias=False), nn.BatchNorm2d(after), nn.ReLU()]
        return nn.Sequential(*layers)

    def forward(self, directions):
        """directions: (batch, 4, 9, rows, columns), gray values. Returns (batch, rows - 22, columns - 22), px."""
        middle = directions.mean((1, 2, 3, 4), keepdim=True)
        even = (directions - middle) / (directions.std((1, 2, 3, 4), keepdim=True) + 1e-3)
        parts = [stream(even[:, k]) for k, stream in enumerate(self.streams)]
        return self.trunk(torch.cat(parts, 1))[:, 0]


def directions(field):
    """The views of the central row, the central column and both diagonals, as gray values: (4, 9, V, U), float16."""
    array = np.asarray(field.array)
    top = 255 if array.dtype == np.uint8 else 65535 if array.dtype == np.uint16 else 1
    middle = np.arange(VIEWS)
    places = [(0 * middle + 4, middle), (middle, 0 * middle + 4), (middle, middle), (VIEWS - 1 - middle, middle)]
    # Axes of `array`: (lens row, lens column, view row, view column, channel).
    views = [array[:, :, t, s].astype(np.float32).mean(-1).transpose(2, 0, 1) / top for t, s in places]
    return np.stack(views).astype(np.float16)


def turned(views, disparity, number):
    """One of eight rotations and reflections of a light field, which order the views of the four directions anew."""
    row, column, falling, rising = views
    if number & 1:  # left is right
        row, column, falling, rising = row[::-1], column, rising[::-1], falling[::-1]
        row, column, falling, rising = (part[..., ::-1] for part in (row, column, falling, rising))
        disparity = disparity[..., ::-1]
    if number & 2:  # above is below
        row, column, falling, rising = row, column[::-1], rising, falling
        row, column, falling, rising = (part[..., ::-1, :] for part in (row, column, falling, rising))
        disparity = disparity[..., ::-1, :]
    if number & 4:  # rows are columns
        row, column, falling, rising = column, row, falling, rising[::-1]
        row, column, falling, rising = (part.swapaxes(-1, -2) for part in (row, column, falling, rising))
        disparity = disparity.swapaxes(-1, -2)
    return np.stack([row, column, falling, rising]), disparity


def light_fields(folder):
    """The light fields of 9 x 9 views of a dataset, or of folders as those of the HCI benchmark: names, light fields, disparities,
    and where these are known."""
    folder = pathlib.Path(folder)
    if (folder / "dataset.json").is_file():
        for job in holo.Dataset(folder):
            if job.views == (VIEWS, VIEWS):
                yield job.scene, job.light_field, job.disparity, np.isfinite(job.depth)
    for truth in sorted(folder.glob("*/gt_disp_lowres.pfm")):
        disparity = holo.read_image(truth)
        yield truth.parent.name, holo.open(truth.parent, views=(VIEWS, VIEWS)), disparity, np.isfinite(disparity)


class Examples:
    """The first light fields of some folders, in memory."""

    def __init__(self, folders, count=None):
        self.views, self.disparity, self.known, self.names = [], [], [], []
        for folder in folders:
            for name, field, disparity, known in itertools.islice(light_fields(folder), count):
                self.views.append(directions(field))
                self.disparity.append(disparity.astype(np.float32))
                self.known.append(known)
                self.names.append(f"{pathlib.Path(folder).name}/{name}")
        if not self.views:
            raise SystemExit(f"no light fields of {VIEWS} x {VIEWS} views in {', '.join(map(str, folders))}")

    def batch(self, random):
        """Patches, their disparities, and where these are known."""
        side = PATCH + 2 * MARGIN
        views, disparity, known = [], [], []
        for _ in range(BATCH):
            k = random.integers(len(self.views))
            rows, columns = self.disparity[k].shape
            v, u = random.integers(rows - side + 1), random.integers(columns - side + 1)
            inner = np.s_[v + MARGIN : v + MARGIN + PATCH, u + MARGIN : u + MARGIN + PATCH]
            number = random.integers(8)
            both = np.stack([self.disparity[k][inner], self.known[k][inner]])
            part, both = turned(self.views[k][..., v : v + side, u : u + side].astype(np.float32), both, number)
            # Exposure, contrast and polarity are no cue of depth.
            part = part ** random.uniform(0.6, 1.6) * random.uniform(0.5, 1.2)
            views.append(part if random.random() < 0.5 else 1 - part)
            disparity.append(both[0])
            known.append(both[1] > 0)
        return (torch.from_numpy(np.stack(list)) for list in (views, disparity, known))


def estimate(network, views, device):
    """The disparity map of a light field; its border repeats the nearest estimate."""
    edge = ((0, 0), (0, 0), (MARGIN, MARGIN), (MARGIN, MARGIN))
    padded = torch.from_numpy(np.pad(views.astype(np.float32), edge, mode="edge"))
    with torch.no_grad():
        return network(padded[None].to(device))[0].cpu().numpy()


def scores(network, tests, device):
    network.eval()
    out = []
    for name, views, disparity, known in zip(tests.names, tests.views, tests.disparity, tests.known):
        start = time.time()
        found = holo.evaluate(estimate(network, views, device), disparity, mask=known)
        out.append({"light_field": name, "seconds": time.time() - start, **found})
    network.train()
    return out


def main(arguments=None):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("sets", nargs="+", metavar="SET", help="datasets, or folders of scenes as those of the HCI benchmark, to train on")
    parser.add_argument("--test", nargs="+", required=True, metavar="SET", help="others to score, which are not trained on")
    parser.add_argument("--scenes", type=int, help="train on this many of each set, from the first; all without it")
    parser.add_argument("--out", type=pathlib.Path, required=True)
    parser.add_argument("--steps", type=int, default=4000, help="of training, all runs together")
    parser.add_argument("--bf16", action="store_true", help="train in bfloat16: twice as fast on processors that multiply it")
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args(arguments)
    device = "cuda" if torch.cuda.is_available() else "cpu"
    torch.manual_seed(options.seed)
    options.out.mkdir(parents=True, exist_ok=True)
    examples, tests = Examples(options.sets, options.scenes), Examples(options.test)
    network = Network().to(device)
    optimizer = torch.optim.Adam(network.parameters())
    print(f"{sum(p.numel() for p in network.parameters())} parameters, {len(examples.views)} light fields, on {device}")
    step, spent, loss_sum, count = 0, 0.0, 0.0, 0
    kept = options.out / "checkpoint.pt"
    if kept.is_file():
        state = torch.load(kept, map_location=device, weights_only=True)
        network.load_state_dict(state["network"])
        optimizer.load_state_dict(state["optimizer"])
        step, spent = state["step"], state["seconds"]
        print(f"goes on at step {step}, after {spent / 60:.1f} minutes")
    while step < options.steps:
        start = time.time()
        # From 1e-3 to 0 along half a cosine.
        for group in optimizer.param_groups:
            group["lr"] = 1e-3 * 0.5 * (1 + math.cos(math.pi * step / options.steps))
        # What a step draws follows from its number.
        views, disparity, known = examples.batch(np.random.default_rng([options.seed, step]))
        with torch.autocast(device, torch.bfloat16, enabled=options.bf16):
            found = network(views.to(device)).float()
        away = (found - disparity.to(device)).abs()[known.to(device)]
        loss = away.mean()
        optimizer.zero_grad()
        loss.backward()
        optimizer.step()
        step, loss_sum, count = step + 1, loss_sum + loss.item(), count + 1
        spent += time.time() - start
        if step % NOTE == 0 or step == options.steps:
            bad = np.mean([score["bad_pixels_0.07_percent"] for score in scores(network, tests, device)])
            with open(options.out / "curve.csv", "a") as file:
                file.write(f"{step},{spent:.1f},{loss_sum / count:.5f},{bad:.3f}\n")
            print(f"step {step}: loss {loss_sum / count:.4f}, BadPix 0.07 of the tests {bad:.1f} %", flush=True)
            state = {"network": network.state_dict(), "optimizer": optimizer.state_dict(), "step": step, "seconds": spent}
            torch.save(state, kept.with_suffix(".new"))
            os.replace(kept.with_suffix(".new"), kept)
            loss_sum, count = 0.0, 0
    final = scores(network, tests, device)
    with open(options.out / "scores.csv", "w", newline="") as file:
        table = csv.DictWriter(file, final[0].keys())
        table.writeheader()
        table.writerows(final)
    for score in final:
        print(f"{score['light_field']}: BadPix 0.07 {score['bad_pixels_0.07_percent']:.1f} %, MSE {score['mean_squared_error_x100']:.2f}")


if __name__ == "__main__":
    main()

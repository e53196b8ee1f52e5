"""A dataset of `holo dataset` for PyTorch: pairs of views and disparity, read when they are needed.

    holo dataset --out data --views 9 --sensor 1080x720 --write h5,disparity
    python torch_dataset.py data

With HDF5 only the chunks of the views that an item needs are read. Workers of a `DataLoader` get the paths alone.
"""

import sys

import holo
import numpy as np
import torch
from torch.utils.data import DataLoader, Dataset


class CrossViews(Dataset):
    """The views of the central row and column, and the disparity of the central view.

    Items: float32 tensors `views` (count, 3, V, U) in linear light and `disparity` (V, U) in pixels between adjacent views.
    """

    def __init__(self, folder, **which):
        self.jobs = holo.Dataset(folder, **which)

    def __len__(self):
        return len(self.jobs)

    def __getitem__(self, index):
        job = self.jobs[index]
        rows, columns = job.views
        row, column = rows // 2, columns // 2
        places = [(row, s) for s in range(columns)] + [(t, column) for t in range(rows) if t != row]
        views = np.stack([job.view(t, s).transpose(2, 0, 1) for t, s in places])
        return {"views": torch.from_numpy(views), "disparity": torch.from_numpy(job.disparity)}


if __name__ == "__main__":
    dataset = CrossViews(sys.argv[1])
    for batch in DataLoader(dataset, batch_size=1, num_workers=2):
        print(tuple(batch["views"].shape), tuple(batch["disparity"].shape), float(batch["disparity"].mean()))

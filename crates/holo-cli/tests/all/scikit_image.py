"""Prints PSNR and SSIM of two PNGs as scikit-image sees them: a Gaussian of deviation 1.5, the covariance of the population."""
import json
import sys

import numpy as np
from PIL import Image
from skimage.metrics import peak_signal_noise_ratio, structural_similarity

one, other = (np.asarray(Image.open(path)) for path in sys.argv[1:3])
span = 255.0 if one.dtype == np.uint8 else 65535.0
# As f64: scikit-image computes in the type that it is given.
one, other = one.astype(np.float64), other.astype(np.float64)
channels = 2 if one.ndim == 3 else None
ssim = structural_similarity(
    one, other, data_range=span, gaussian_weights=True, sigma=1.5, use_sample_covariance=False, channel_axis=channels
)
print(json.dumps({"psnr_db": peak_signal_noise_ratio(one, other, data_range=span), "ssim": ssim}))

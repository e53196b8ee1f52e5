"""Prints the numbers of the test `numbers_are_those_of_scikit_image` in ssim.rs. Needs numpy and scikit-image 0.26."""
import numpy as np
from skimage.metrics import peak_signal_noise_ratio, structural_similarity

r, c, k = np.meshgrid(np.arange(20), np.arange(24), np.arange(3), indexing="ij")
first = (r * 7 + c * 13 + k * 29 + r * c) % 251
second = first * 7 // 8 + (r * 31 + c * 17 + k * 5 + r * r * c) % 37

for name, a, b, data_range in [
    ("U8", first.astype(np.uint8), second.astype(np.uint8), 255),
    ("U16", (first * 257).astype(np.uint16), (second * 200).astype(np.uint16), 65535),
    # As f64: scikit-image computes in the type it is given, and f32 is good for six digits only.
    ("F32", first / 256, second / 256, 2.0),
]:
    similarity = structural_similarity(
        a, b, data_range=data_range, channel_axis=2, gaussian_weights=True, sigma=1.5, use_sample_covariance=False
    )
    print(f"const SSIM_{name}: f64 = {similarity!r};".replace("np.float64(", "").replace(")", ""))
    decibels = peak_signal_noise_ratio(a, b, data_range=data_range)
    print(f"const PSNR_{name}: f64 = {decibels!r};".replace("np.float64(", "").replace(")", ""))

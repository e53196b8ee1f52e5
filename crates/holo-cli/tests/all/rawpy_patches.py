"""Prints the mean linear sRGB of the left and the right half of a DNG, as LibRaw develops it: white is 1."""
import json
import sys

import rawpy

with rawpy.imread(sys.argv[1]) as raw:
    image = raw.postprocess(
        use_camera_wb=True,
        no_auto_bright=True,
        output_bps=16,
        gamma=(1, 1),
        output_color=rawpy.ColorSpace.sRGB,
        highlight_mode=rawpy.HighlightMode.Clip,
        user_flip=0,
    )
height, width, _ = image.shape
halves = [image[8:-8, 8 : width // 2 - 8], image[8:-8, width // 2 + 8 : -8]]
print(json.dumps([[float(value) / 65535.0 for value in half.reshape(-1, 3).mean(0)] for half in halves]))

# SPDX-License-Identifier: GPL-3.0-or-later
"""What `holo` wrote, as images of Blender."""

import bpy

# Files and the names of their images.
FILES = {
    "scene_el.png": "Holoscopic Raw",
    "scene_vpi.png": "Holoscopic Views",
    "scene_disparity.png": "Holoscopic Disparity",
    "raw_linear.png": "Plenoptic Raw",
    "raw.exr": "Plenoptic Raw (linear)",
    "white.png": "Plenoptic White",
}


def images(folder):
    """Loads the images of a folder, in the place of those of an earlier render, and returns them."""
    found = []
    for file, name in FILES.items():
        path = folder / file
        if not path.is_file():
            continue
        image = bpy.data.images.get(name)
        if image is None:
            image = bpy.data.images.load(str(path))
            image.name = name
        else:
            image.filepath = str(path)
            image.reload()
        image.colorspace_settings.name = "sRGB" if file.startswith("scene_") and "disparity" not in file else "Non-Color"
        found.append(image)
    return found

# SPDX-License-Identifier: GPL-3.0-or-later
"""Holoscopic images of Blender scenes, rendered by the program `holo`.

A panel in the camera's properties describes the camera; *Render Holoscopic* exports the scene as Blender evaluates it,
runs `holo`, and loads its images.
"""

from . import measure, operators, overlay, panel, preferences, properties

MODULES = (properties, preferences, measure, operators, panel, overlay)


def register():
    for module in MODULES:
        module.register()


def unregister():
    for module in reversed(MODULES):
        module.unregister()

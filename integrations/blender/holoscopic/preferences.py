# SPDX-License-Identifier: GPL-3.0-or-later
"""Where the program `holo` is: the variable HOLO, the preference, the copy in this extension, the PATH."""

import os
import pathlib
import shutil

import bpy
from bpy.props import StringProperty

PROGRAM = "holo.exe" if os.name == "nt" else "holo"


class HoloscopicPreferences(bpy.types.AddonPreferences):
    bl_idname = __package__

    program: StringProperty(name="Program", subtype="FILE_PATH", description="The program holo; empty: it is searched for")

    def draw(self, _context):
        self.layout.prop(self, "program")
        try:
            self.layout.label(text=f"Found: {find()}", icon="CHECKMARK")
        except FileNotFoundError as why:
            self.layout.label(text=str(why), icon="ERROR")


def _preferred():
    addon = bpy.context.preferences.addons.get(__package__)
    return addon.preferences.program if addon and addon.preferences else ""


def find():
    """The path of the program; FileNotFoundError with what to do if there is none."""
    bundled = pathlib.Path(__file__).parent / "bin" / PROGRAM
    for source, path in (
        ("the variable HOLO", os.environ.get("HOLO", "")),
        ("the preference of the extension Holoscopic", bpy.path.abspath(_preferred())),
        ("the extension", str(bundled) if bundled.is_file() else ""),
        ("PATH", shutil.which(PROGRAM) or ""),
    ):
        if not path:
            continue
        if not os.path.isfile(path):
            raise FileNotFoundError(f"{source} names {path}, which is no file")
        if path == str(bundled) and not os.access(path, os.X_OK):
            # Archives of extensions do not keep the permission.
            os.chmod(path, 0o755)
        return path
    raise FileNotFoundError("The program holo was not found: set its path in the preferences of the extension Holoscopic")


def register():
    bpy.utils.register_class(HoloscopicPreferences)


def unregister():
    bpy.utils.unregister_class(HoloscopicPreferences)

"""Finds Embree in the wheel of `embreex`, which the extra `embree` installs."""

import importlib.util
import os
import pathlib


def find():
    """Names the library in HOLO_EMBREE_LIB for this process, unless the variable is set or there is none."""
    if "HOLO_EMBREE_LIB" in os.environ:
        return
    spec = importlib.util.find_spec("embreex")
    if spec is None or not spec.submodule_search_locations:
        return
    package = pathlib.Path(next(iter(spec.submodule_search_locations)))
    # auditwheel, delocate and delvewheel put libraries into different folders.
    for folder in (package.parent / "embreex.libs", package / ".dylibs", package.parent / "embreex.dylibs", package):
        for library in sorted(folder.glob("*embree4*")):
            os.environ["HOLO_EMBREE_LIB"] = str(library)
            return

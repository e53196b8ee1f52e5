"""Light fields as the files that other programs read."""

from __future__ import annotations

import os
import pathlib
from collections.abc import Iterable, Mapping

from . import _holo
from ._options import tell


def export_targets() -> dict[str, str]:
    """The programs that `export` writes for: the name of the target, and what reads its files."""
    return dict(_holo.export_targets())


def export(
    input: str | os.PathLike,
    target: str,
    out: str | os.PathLike,
    *,
    views: int | tuple[int, int] | None = None,
    group: str | None = None,
    names: Mapping[str, str] | None = None,
    objects: Iterable[str] = (),
    overwrite: bool = False,
) -> list[pathlib.Path]:
    """Writes a light field, or those of a dataset, as the files that another program reads, as `holo export` does.

    input: a dataset of `holo dataset`, a folder or file with one light field, or a folder of raw images or boards. target:
    one of `export_targets()`. out: an empty or missing folder; with overwrite, files in it are replaced. views: those of a
    dataset that has several numbers of them, one number or (rows, columns).
    group: the folder of the scenes, where readers expect one. names: other names of scenes, such as {"chess": "boxes"}.
    objects: what masks show, by the names of `Scene.objects`; "ball*" is all that begin so.

    Returns the files. A target that needs what the light fields do not have is a UsageError.
    """
    views = (views, views) if isinstance(views, int) else views
    request = {
        "input": pathlib.Path(input),
        "target": target,
        "out": pathlib.Path(out),
        "views": views,
        "group": group,
        "names": list((names or {}).items()),
        "objects": list(objects),
        "overwrite": overwrite,
    }
    files, lines = _holo.export(request)
    tell(lines)
    return [pathlib.Path(out) / name for name in files]

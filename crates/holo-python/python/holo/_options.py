"""Arguments of Python as the text that the command line takes."""

import inspect
import logging
import numbers
import os
import warnings

from collections.abc import Callable
from typing import Any, TypeVar

from .errors import HoloWarning, UsageError

_Function = TypeVar("_Function", bound=Callable[..., Any])

_SIZES = ("views", "lenses", "sensor")
_LOG = logging.getLogger("holo")


def text_of(name, value):
    """The value of an option as text. Pairs are (rows, columns); on the command line columns come first."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if name in _SIZES and isinstance(value, (tuple, list)):
        if len(value) != 2:
            raise UsageError(f"{name}={value!r}: give (rows, columns), or text such as '60x40', columns first")
        return f"{int(value[1])}x{int(value[0])}"
    if name in ("views", "lenses") and isinstance(value, numbers.Integral):
        return f"{int(value)}x{int(value)}"
    if isinstance(value, numbers.Integral):
        return str(int(value))
    if isinstance(value, numbers.Real):
        # The shortest text with the same value; 'inf' as on the command line.
        return repr(float(value)).removesuffix(".0")
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    if isinstance(value, (tuple, list)) or hasattr(value, "__array__"):
        return ",".join(text_of("", part) for part in value)
    return str(value)


def texts_of(settings):
    """All settings that are given, by their names on the command line."""
    # `for` is a word of Python.
    names = {"tools": "for"}
    given = {names.get(name, name).replace("_", "-"): value for name, value in settings.items() if value is not None}
    return {name: text_of(name, value) for name, value in given.items() if not _is_empty(value)}


def _is_empty(value):
    return isinstance(value, (tuple, list)) and len(value) == 0


def with_signature(function: _Function) -> _Function:
    """Gives a function with the keywords of `Settings` a signature that names them, for help and completion."""
    from ._settings import Settings

    signature = inspect.signature(function)
    own = [parameter for parameter in signature.parameters.values() if parameter.kind is not parameter.VAR_KEYWORD]
    kind = inspect.Parameter.KEYWORD_ONLY
    settings = [
        inspect.Parameter(name, kind, default=None, annotation=annotation)
        for name, annotation in Settings.__annotations__.items()
        if name not in signature.parameters
    ]
    function.__signature__ = signature.replace(parameters=own + settings)
    return function


def tell(lines):
    """Hands diagnostics on: warnings as warnings, notes to the logger `holo`."""
    for line in lines:
        kind, _, text = line.partition(": ")
        if "built-in BVH" in text:
            _warn_of_slow_backend()
        elif kind == "warning":
            warnings.warn(text, HoloWarning, stacklevel=3)
        else:
            _LOG.info(text)


_has_warned = False


def _warn_of_slow_backend():
    global _has_warned
    if not _has_warned:
        _has_warned = True
        warnings.warn(
            "Embree was not found, so rays are traced by the built-in BVH, which is several times slower; "
            "install this package with its extra `embree`",
            HoloWarning,
            stacklevel=4,
        )

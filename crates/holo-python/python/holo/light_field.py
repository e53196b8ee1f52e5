"""Light fields: samples with the axes (v, u, t, s, c), their rig, and what is done with them."""

from __future__ import annotations

import math
import os
import warnings
from typing import Any, Literal, NamedTuple, overload

import numpy as np

from . import _holo
from ._holo import Rig
from .errors import HoloWarning, UsageError
from .images import with_channel

_AXES = "vutsc"
_DTYPES = (np.uint8, np.uint16, np.float32, np.float64)


class SynthesizedView(NamedTuple):
    """A view between the views of a light field."""

    image: np.ndarray
    """float32 in linear light, axes (row, column, channel)."""
    disparity: np.ndarray
    """Its disparities, px between adjacent views, axes (row, column)."""
    holes: np.ndarray
    """True where no view shows the point, and the farthest surface around it fills the image; axes (row, column)."""


class Estimate(NamedTuple):
    """A disparity map and how sure it is, axes (row, column)."""

    disparity: np.ndarray
    confidence: np.ndarray


class LightField:
    """A light field: `array[v, u, t, s, c]` is channel c of the pixel (v, u) of the view (t, s).

    array: axes (V, U, T, S, C), uint8, uint16, float32 or float64; not copied.
    axes: the order of the axes of `array`, if it is another one, such as "tsvuc" or "tsvu".
    rig: the cameras, if they are known.
    is_srgb: whether the samples are on the sRGB curve; by default integers are and floats are not.
    disparity_range_px: smallest and largest disparity of the scene, if they are known.
    """

    __slots__ = ("array", "disparity_range_px", "is_srgb", "rig")
    array: np.ndarray
    disparity_range_px: tuple[float, float] | None
    is_srgb: bool
    rig: Rig | None

    def __init__(
        self,
        array: np.ndarray,
        rig: Rig | None = None,
        *,
        axes: str | None = None,
        is_srgb: bool | None = None,
        disparity_range_px: tuple[float, float] | None = None,
    ):
        array = np.asarray(array)
        if axes is not None:
            array = _in_order(array, axes)
        if array.ndim == 4:
            array = array[..., None]
        if array.ndim != 5 or array.dtype not in _DTYPES or 0 in array.shape:
            raise UsageError(
                f"an array of shape {array.shape} and type {array.dtype}; a light field has the axes (v, u, t, s, c) and "
                "the type uint8, uint16, float32 or float64"
            )
        if rig is not None and (rig.lenses, rig.views) != (array.shape[:2], array.shape[2:4]):
            raise UsageError(f"an array of shape {array.shape} is none of {rig!r}")
        (v, u, t, s, _) = array.shape
        if axes is None and rig is None and t * s > v * u:
            warnings.warn(
                f"an array of shape {array.shape} has {t} x {s} views of {v} x {u} pixels; if the views come first give "
                'axes="tsvuc", else axes="vutsc"',
                HoloWarning,
                stacklevel=2,
            )
        self.array, self.rig = array, rig
        self.is_srgb = array.dtype.kind == "u" if is_srgb is None else is_srgb
        self.disparity_range_px = disparity_range_px

    @classmethod
    def from_elemental_grid(cls, image: np.ndarray, views: tuple[int, int], rig: Rig | None = None, **more) -> LightField:
        """The light field of a raw image: elemental images of `views` = (T, S) pixels side by side, axes (row, column[,
        channel]). Shares the memory of the image where numpy can."""
        image, (t, s) = with_channel(image), views
        v, u = _whole(image, views)
        return cls(image.reshape(v, t, u, s, -1).transpose(0, 2, 1, 3, 4), rig, axes=_AXES, **more)

    @classmethod
    def from_viewpoint_grid(cls, image: np.ndarray, views: tuple[int, int], rig: Rig | None = None, **more) -> LightField:
        """The light field of (T, S) views side by side, axes (row, column[, channel])."""
        image, (t, s) = with_channel(image), views
        v, u = _whole(image, views)
        return cls(image.reshape(t, v, s, u, -1).transpose(1, 3, 0, 2, 4), rig, axes=_AXES, **more)

    @property
    def shape(self) -> tuple[int, int, int, int, int]:
        """(V, U, T, S, C)."""
        return self.array.shape

    @overload
    def __getitem__(self, place: tuple[int, int]) -> np.ndarray: ...

    @overload
    def __getitem__(self, place: tuple[slice, slice]) -> LightField: ...

    def __getitem__(self, place: tuple[int | slice, int | slice]) -> np.ndarray | LightField:
        """`field[t, s]`: a view, axes (row, column, channel); with slices a light field of some views. Shares memory."""
        if not (isinstance(place, tuple) and len(place) == 2):
            raise UsageError("give the row and the column of a view, as in field[4, 4], or slices of them")
        t, s = place
        if isinstance(t, slice) != isinstance(s, slice):
            raise UsageError("give two numbers for a view, or two slices for a light field of some views")
        return self.clip(views=(t, s)) if isinstance(t, slice) else self.view(t, s)

    @property
    def views(self) -> tuple[int, int]:
        """Rows and columns of views, (T, S)."""
        return self.array.shape[2:4]

    @property
    def lenses(self) -> tuple[int, int]:
        """Rows and columns of microlenses, (V, U): the pixels of a view."""
        return self.array.shape[:2]

    @property
    def central(self) -> np.ndarray:
        """The central view (T // 2, S // 2), axes (row, column, channel); shares memory."""
        t, s = self.views
        return self.view(t // 2, s // 2)

    def view(self, t: int, s: int) -> np.ndarray:
        """The view of row t and column s, axes (row, column, channel); shares memory."""
        return self.array[:, :, t, s]

    def elemental(self, v: int, u: int) -> np.ndarray:
        """The elemental image behind the microlens of row v and column u, axes (t, s, channel); shares memory."""
        return self.array[v, u]

    def epi_row(self, v: int, t: int) -> np.ndarray:
        """The horizontal epipolar-plane image of pixel row v in view row t, axes (s, u, channel); shares memory."""
        return self.array[v, :, t].transpose(1, 0, 2)

    def epi_column(self, u: int, s: int) -> np.ndarray:
        """The vertical epipolar-plane image of pixel column u in view column s, axes (t, v, channel); shares memory."""
        return self.array[:, u, :, s].transpose(1, 0, 2)

    def elemental_grid(self) -> np.ndarray:
        """The raw image: all elemental images side by side, axes (row, column, channel). Shares memory where the samples lie
        in this order, as those of `render` do."""
        return self._grid("el", (0, 2, 1, 3, 4))

    def viewpoint_grid(self) -> np.ndarray:
        """All views side by side, axes (row, column, channel). Shares memory where the samples lie in this order."""
        return self._grid("vpi", (2, 0, 3, 1, 4))

    def _grid(self, layout, order):
        blocks = self.array.transpose(order)
        if blocks.flags.c_contiguous:
            a, b, c, d, channels = blocks.shape
            return blocks.reshape(a * b, c * d, channels)
        return _holo.to_grid(self.array, layout)

    def clip(self, *, views: tuple[slice, slice] | None = None, lenses: tuple[slice, slice] | None = None) -> LightField:
        """Some of the views or pixels, by slices of rows and of columns; shares memory. The rig is kept if it stays one:
        all pixels, and a step of 1 between views around the same center."""
        rows, columns = views or (slice(None), slice(None))
        lens_rows, lens_columns = lenses or (slice(None), slice(None))
        array = self.array[lens_rows, lens_columns, rows, columns]
        return LightField(
            array,
            self._clipped_rig(array, (rows, columns)),
            axes=_AXES,
            is_srgb=self.is_srgb,
            disparity_range_px=self.disparity_range_px,
        )

    def _clipped_rig(self, array, views):
        if self.rig is None or array.shape[:2] != self.lenses:
            return None
        for part, count in zip(views, self.views):
            first, end, step = part.indices(count)
            if step != 1 or first + end != count:
                return None
        return Rig(
            array.shape[2:4],
            self.lenses,
            focal_length_m=self.rig.focal_length_m,
            sensor_size_m=self.rig.sensor_size_m,
            baseline_m=self.rig.baseline_m,
            baseline_y_m=self.rig.baseline_y_m,
            focus_distance_m=self.rig.focus_distance_m,
            projection=self.rig.projection,
        )

    def linear(self) -> LightField:
        """The light field in linear light, float32; itself if it is."""
        if self.array.dtype == np.float32 and not self.is_srgb:
            return self
        array = _holo.to_linear(self.array, self.is_srgb)
        return _restored(array, self.rig, False, self.disparity_range_px)

    def encode(self, bits: int = 8, exposure: float | str = "auto") -> LightField:
        """The light field as uint8 or uint16 on the sRGB curve: what `holo render` writes as PNG and MAT.

        exposure: EV, or "auto": 99 % of the pixels that are not black lie below 80 % of the range.
        """
        linear = self.linear().array
        ev = _holo.automatic_exposure(linear) if exposure == "auto" else float(exposure)
        array = _holo.encode(linear, bits, ev)
        return _restored(array, self.rig, True, self.disparity_range_px)

    def refocus(
        self,
        disparity: float | np.ndarray | None = None,
        *,
        distance_m: float | None = None,
        slope: float | None = None,
        tilt_deg: tuple[float, float] = (0.0, 0.0),
        aperture: str = "all",
        kernel: str = "cubic",
    ) -> np.ndarray:
        """An image that is sharp at one disparity, depth or slope, or everywhere: shift and sum in linear light.

        disparity: pixels between adjacent views; a map with the axes (row, column) gives an image sharp everywhere.
        distance_m: depth in meters, which needs a rig. tilt_deg: its plane is tilted; the right side moves away by the first angle,
        the upper side by the second. slope: that of LFToolbox.
        aperture: "all", or "disc:D", "square:D", "gaussian:D" with D in views. kernel: "cubic" or "bilinear".

        Returns float32, axes (row, column, channel).
        """
        given = [name for name, value in (("disparity", disparity), ("distance_m", distance_m), ("slope", slope)) if value is not None]
        if len(given) != 1:
            raise UsageError("give one of disparity=, distance_m= and slope=")
        if distance_m is not None:
            if self.rig is None:
                raise UsageError("the rig is unknown, so a distance in meters has no meaning; give disparity=")
        elif any(tilt_deg):
            raise UsageError("tilt_deg= tilts the plane of distance_m=; give that too")
        is_map = disparity is not None and np.ndim(disparity) > 0
        request = {
            "disparity_px": float(disparity) if disparity is not None and not is_map else None,
            "slope": slope,
            "map": np.asarray(disparity, dtype=np.float32) if is_map else None,
            "plane": None if distance_m is None else (float(distance_m), *map(math.radians, tilt_deg), self.rig),
            "aperture": aperture,
            "kernel": kernel,
            "baseline_ratio": self._baseline_ratio(),
        }
        return _holo.refocus(self.linear().array, request)

    @overload
    def disparity(
        self,
        range: tuple[float, float] | None = None,  # noqa: A002
        *,
        effort: str = "balanced",
        subset: str | None = None,
        confidence: Literal[False] = False,
    ) -> np.ndarray: ...

    @overload
    def disparity(
        self,
        range: tuple[float, float] | None = None,  # noqa: A002
        *,
        effort: str = "balanced",
        subset: str | None = None,
        confidence: Literal[True],
    ) -> Estimate: ...

    def disparity(
        self,
        range: tuple[float, float] | None = None,  # noqa: A002
        *,
        effort: str = "balanced",
        subset: str | None = None,
        confidence: bool = False,
    ) -> np.ndarray | Estimate:
        """Estimates the disparity of the central view from the others by a plane sweep, as `holo depth` does.

        range: smallest and largest disparity in pixels; by default that of the scene, or -4 to 4 if it is unknown.
        effort: "draft", "fast", "balanced" or "thorough". subset: "cross", "star" or positions "S,T;S,T ..": only these views.

        Returns float32, axes (row, column); with confidence=True an `Estimate` of disparity and confidence.
        """
        if range is None:
            range = self.disparity_range_px  # noqa: A001
            if range is None:
                warnings.warn(
                    "the disparity range is unknown; searching -4 to 4 px; set it with range=(min, max)",
                    HoloWarning,
                    stacklevel=2,
                )
        estimate = Estimate(*_holo.plane_sweep(self.array, range, effort, self._baseline_ratio(), subset))
        return estimate if confidence else estimate.disparity

    def synthesize(
        self, at: tuple[float, float], disparity: float | np.ndarray | None = None, *, kernel: str = "cubic"
    ) -> SynthesizedView:
        """The view of a place between the views: neighboring views, blended along their disparities.

        at: row and column among the views, from 0, which may be fractions.
        disparity: a map of the central view, axes (row, column); those of all views, axes (row, column, view row, view column);
        or one number: all lies in that plane, and 0 blends the views as they are. By default it is estimated.
        kernel: "cubic", which takes what four views show of one surface as samples of one image, or "bilinear".
        """
        if disparity is None:
            disparity = self.disparity()
        if np.ndim(disparity) not in (0, 2, 4):
            raise UsageError("disparity= has to be a number, or an array of 2 or 4 axes")
        given = float(disparity) if np.ndim(disparity) == 0 else np.asarray(disparity, dtype=np.float32)
        row, column = at
        result = _holo.synthesize(self.linear().array, (float(row), float(column)), given, kernel, self._baseline_ratio())
        return SynthesizedView(*result)

    def _baseline_ratio(self):
        if self.rig is None or self.rig.baseline_m == 0.0:
            return 1.0
        return self.rig.baseline_y_m / self.rig.baseline_m

    def save(self, path: str | os.PathLike, *, mat_order: str = "lenses") -> None:
        """Writes the light field in the format of the path's ending.

        .h5: HDF5 with the rig. .mat: MATLAB, `H` of size [V U T S C], or with mat_order="lftoolbox" `LF` of size [T S V U
        C]. _el.png, _vpi.png: the raw image or all views, integers. _el.exr, _vpi.exr: the same, float32 in linear light.
        """
        if mat_order not in ("lenses", "lftoolbox"):
            raise UsageError(f"mat_order={mat_order!r}: give lenses or lftoolbox")
        _holo.write_light_field(path, self.array, self.rig, self.is_srgb, mat_order == "lftoolbox")

    def save_hci(
        self, folder: str | os.PathLike, disparity: np.ndarray | None = None, depth: np.ndarray | None = None
    ) -> None:
        """Writes a folder of the HCI 4D light field benchmark: a PNG a view, `parameters.cfg`, and ground truth if it is given.

        disparity: of the central view in pixels, axes (row, column). depth: in meters; by default what the rig makes of the
        disparity. Light fields of floats are encoded to 8 bits first.
        """
        if self.rig is None:
            raise UsageError("an HCI folder contains a rig, and that of this light field is unknown")
        if disparity is not None:
            disparity = np.asarray(disparity, dtype=np.float32)
            depth = self.rig.depth_from_disparity(disparity) if depth is None else depth
        depth = None if depth is None else np.asarray(depth, dtype=np.float32)
        field = self if self.array.dtype.kind == "u" else self.encode()
        _holo.write_hci(folder, field.array, self.rig, disparity, depth)

    def plot(self, disparity: np.ndarray | None = None) -> Any:
        """Draws the central view and the epipolar-plane image of its middle row, and with `disparity`, axes (row, column), that
        map with its scale in pixels. Needs matplotlib; returns the figure."""
        try:
            from matplotlib import pyplot
        except ImportError:
            raise UsageError("plot() needs matplotlib: pip install matplotlib") from None
        coded = self if self.array.dtype == np.uint8 else self.encode()
        (v, _), (t, _) = self.lenses, self.views
        images = [("central view", coded.central), (f"row {v // 2} in the views of row {t // 2}", coded.epi_row(v // 2, t // 2))]
        figure, places = pyplot.subplots(1, 2 + (disparity is not None), figsize=(5 * (2 + (disparity is not None)), 4))
        for place, (title, image) in zip(places, images):
            place.imshow(image[..., :3] if image.shape[2] >= 3 else image[..., 0], cmap="gray", aspect="auto")
            place.set_title(title)
        if disparity is not None:
            shown = places[2].imshow(np.where(np.isfinite(disparity), disparity, np.nan), cmap="viridis", aspect="auto")
            figure.colorbar(shown, ax=places[2], label="disparity, px")
            places[2].set_title("disparity")
        return figure

    def to_xarray(self) -> Any:
        """An `xarray.DataArray` that shares memory, with the dimensions v, u, t, s, c and the rig's numbers as attributes."""
        import xarray

        names = ("focal_length_m", "sensor_size_m", "baseline_m", "baseline_y_m", "focus_distance_m", "projection")
        attributes = {} if self.rig is None else {name: getattr(self.rig, name) for name in names}
        attributes["is_srgb"] = int(self.is_srgb)
        return xarray.DataArray(self.array, dims=("v", "u", "t", "s", "c"), name="light_field", attrs=attributes)

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> np.ndarray:
        array = self.array if dtype is None else self.array.astype(dtype, copy=False)
        return np.array(array) if copy else array

    def __repr__(self) -> str:
        (t, s), (v, u) = self.views, self.lenses
        channels, kind = self.array.shape[4], "sRGB" if self.is_srgb else "linear"
        return f"<LightField: {t} x {s} views of {v} x {u} px (rows x columns), {channels} channels, {self.array.dtype}, {kind}>"

    def _repr_png_(self) -> bytes:
        """The central view, for notebooks."""
        view = self.central[:, :, None, None]
        field = _restored(np.ascontiguousarray(view), None, self.is_srgb, None)
        coded = field.array if field.array.dtype == np.uint8 else field.encode().array
        image = coded[:, :, 0, 0]
        return bytes(_holo.png(np.ascontiguousarray(image[..., :3] if image.shape[2] >= 3 else image[..., :1])))

    def __reduce__(self):
        return (_restored, (self.array, self.rig, self.is_srgb, self.disparity_range_px))


def _restored(array, rig, is_srgb, disparity_range_px):
    return LightField(array, rig, axes=_AXES, is_srgb=is_srgb, disparity_range_px=disparity_range_px)


def _in_order(array, axes):
    """The array with its axes in the order (v, u, t, s, c)."""
    if sorted(axes) not in (sorted(_AXES), sorted(_AXES[:4])) or len(axes) != array.ndim:
        raise UsageError(
            f"axes={axes!r} of an array of shape {array.shape}: name each axis once, v and u for row and column of the pixels, "
            "t and s for those of the views, c for channels"
        )
    return array.transpose([axes.index(axis) for axis in _AXES if axis in axes])


def _whole(image, views):
    (rows, columns), (t, s) = image.shape[:2], views
    if t < 1 or s < 1 or rows % t or columns % s or not rows or not columns:
        raise UsageError(f"an image of {rows} x {columns} pixels is no whole number of {t} x {s} views")
    return rows // t, columns // s


def open(  # noqa: A001
    path: str | os.PathLike,
    *,
    views: tuple[int, int] | None = None,
    layout: str | None = None,
    order: str | None = None,
) -> LightField:
    """Reads a light field from any file or folder that holds one: a folder of `holo render`, HDF5, MAT, a raw PNG, a folder
    of views, the HCI benchmark, the Stanford archive, ESLF of Lytro, the MIT archive.

    views: (T, S), if the files do not say it. layout: "el" or "vpi", if the name of a raw image does not say it. order:
    "row-major", "serpentine", "column-major", "column-serpentine" or one of these with "-up" (from below), of a folder of
    images; a warning tells if the images show another order.
    """
    reader = _holo.Reader(path, views, layout, order)
    array, is_srgb, lines = reader.read()
    for line in lines:
        warnings.warn(line, HoloWarning, stacklevel=2)
    return _restored(array, reader.rig, is_srgb, reader.disparity_range_px)



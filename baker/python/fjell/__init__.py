"""Fjell for Python: terrains whose error is known.

Axes are those of Fjell: x east, y up, z south, metres, from sample (0, 0); a row of an array runs along +x, rows follow
each other along +z. Heights are metres. Arrays are read in place, whatever their strides; a thread that changes one
during a call gets a result of old and new numbers, and nothing worse. Calls that take long release the GIL and answer
to Ctrl-C. What is wrong with an argument or an input is a ValueError or a TypeError that names it; what is wrong with
the machine (disk, memory, GPU) is an OSError or a MemoryError.
"""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple, Optional, Union

import numpy as np
from numpy.typing import NDArray

from . import _native
from ._arrays import heights_of, is_heights, pair_of, place_of
from ._terrain import Frame, Hit, Patch, Raster, Terrain, View

__version__ = _native.version
__all__ = [
    "Comparison",
    "Frame",
    "Hit",
    "Mesh",
    "Patch",
    "Raster",
    "Terrain",
    "View",
    "bake",
    "compare",
    "info",
    "mesh",
    "options",
    "verify",
    "write_geotiff",
]

_Path = Union[str, "os.PathLike[str]"]


class Mesh(NamedTuple):
    """A triangle mesh, and how far it is from the heights it was made of.

    vertices: float32 [n, 3], metres. triangles: uint32 [m, 3], counter-clockwise seen from above. true_error: the
    largest vertical distance from a sample to the triangle over it, in metres, measured at every sample.
    """

    vertices: NDArray[np.float32]
    triangles: NDArray[np.uint32]
    true_error: float


def mesh(
    heights: Any,
    spacing: Any = 1.0,
    max_error: float = 1.0,
    holes: str = "keep",
    *,
    up: str = "y",
    threads: int = 0,
) -> Mesh:
    """A crack-free mesh of right triangles that no sample of `heights` is farther from than `max_error`, vertically.

    heights: two dimensions of any size from 2 x 2 on, rows from north to south; whole numbers or floats, masked or
        not. NaN and masked samples are holes. float16, longdouble and the other byte order are copied first.
    spacing: metres from sample to sample; or two numbers, along columns and along rows.
    max_error: metres, 0 or more; 0 leaves out only what lies exactly on its neighbours' triangles. Vertices are
        float32: of heights that float32 does not hold, true_error counts the rounding too, and may be that much.
    holes: "keep" leaves them open, to the sample; "fill" makes them smooth ground; "refuse" raises ValueError.
    up: "y" for x east, y up, z south; "z" for x east, y north, z up (so y is 0 in the first row and negative in the
        others).
    threads: 0 for all cores. The mesh is the same, bit for bit, for any number.

    >>> import numpy as np
    >>> y, x = np.mgrid[0:200, 0:300]
    >>> heights = 20 * np.sin(x / 30) * np.cos(y / 40)
    >>> made = fjell.mesh(heights, spacing=10, max_error=0.5)
    >>> made.true_error <= 0.5, len(made.triangles) < 0.1 * 2 * 199 * 299
    (True, True)
    >>> made.vertices[:, 0].max(), made.vertices[:, 2].max()
    (2990.0, 1990.0)
    """
    array, mask = heights_of(heights)
    return Mesh(*_native.mesh(array, mask, pair_of(spacing, "spacing"), float(max_error), holes, up, threads))


def options() -> dict[str, str]:
    """What `bake` takes by keyword, as `fjell-bake --help` says it; its dashes are underscores here."""
    return {name.replace("-", "_"): about for name, about, _ in _native.option_names()}


def _recipe(given: dict[str, Any]) -> dict[str, Any]:
    known = options()
    recipe: dict[str, Any] = {}
    for name, value in given.items():
        if name not in known:
            raise TypeError(f"{name}: is no option; fjell.options() lists them")
        if value is None:
            continue
        if name == "void" and not isinstance(value, (list, tuple)):
            value = [value]
        if name == "texture" and isinstance(value, (str, os.PathLike)):
            value = [value]
        if isinstance(value, (list, tuple)):
            value = [os.fspath(v) if isinstance(v, os.PathLike) else v for v in value]
        elif isinstance(value, os.PathLike):
            value = os.fspath(value)
        elif isinstance(value, np.generic):
            value = value.item()
        recipe[name.replace("_", "-")] = value
    return recipe


def _array_and_place(
    heights: Any, spacing: Any, origin: Any
) -> tuple[NDArray[Any], Optional[NDArray[np.bool_]], tuple[float, float], tuple[float, float]]:
    array, mask = heights_of(heights)
    spacing_of, origin_of, from_south = place_of(heights)
    if from_south:
        array, mask = array[::-1], None if mask is None else mask[::-1]
    step = pair_of(spacing, "spacing") if spacing is not None else spacing_of or (1.0, 1.0)
    place = pair_of(origin, "origin") if origin is not None else origin_of or (0.0, 0.0)
    return array, mask, step, place


def _names(given: Any) -> list[str]:
    return [os.fspath(p) for p in (given if isinstance(given, (list, tuple)) else [given])]


def bake(
    heights: Any,
    out: _Path,
    *,
    spacing: Any = None,
    origin: Any = None,
    progress: Optional[Callable[[str, int, int], object]] = None,
    threads: int = 0,
    memory_mb: int = 512,
    **option: Any,
) -> dict[str, Any]:
    """Bakes heights to a pack, and returns what the bake says of it, as `fjell-bake --json` does.

    heights: an array as `mesh` takes it; an xarray.DataArray, whose coordinates give spacing and origin; or the path
        of a height field that GDAL reads, or several.
    out: the pack to write. It is written beside its place and renamed: whatever happens, there is the old pack, a new
        one, or none.
    spacing: metres between samples, 1 by default; of an array also two numbers, along columns and along rows.
    origin: of an array, where sample (0, 0) lies, east and north in the units of `crs`.
    progress: called as progress(stage, done, total), from this thread; an exception of it ends the bake.
    threads: 0 for all cores. memory_mb: of the bake itself, the array not counted.
    option: as on the command line (`fjell.options()`), with underscores: nodata="fill", void=[-9999], tile=256,
        horizons="half". Of an array `crs` says which CRS it is in: an array is not reprojected.

    Raises ValueError for heights that look like voids and are not declared as such, and the like; the messages name the
    options of the command line. Ctrl-C and an exception of `progress` leave no half-written pack; the folder OUT.work
    may stay, from which the same call goes on.

    >>> import numpy as np
    >>> report = fjell.bake(np.add.outer(np.arange(65.0), np.arange(97.0)), "slope.fjell", spacing=2)
    >>> report["columns"], report["rows"], report["spacing_m"]
    (97, 65, [2.0, 2.0])
    """
    recipe = _recipe(option)
    recipe["output"] = os.fspath(out)
    for name in ("inputs", "output"):
        if name in option:
            raise TypeError(f"{name}: is an argument of its own")
    if is_heights(heights):
        array, mask, step, place = _array_and_place(heights, spacing, origin)
        text = _native.bake(array, mask, step, place, json.dumps(recipe), threads, memory_mb, progress)
    else:
        if origin is not None:
            raise TypeError("origin: is for arrays; a file says itself where it lies")
        if spacing is not None:
            recipe["spacing"] = float(spacing)
        recipe["inputs"] = _names(heights)
        text = _native.bake(None, None, (1, 1), (0, 0), json.dumps(recipe), threads, memory_mb, progress)
    report: dict[str, Any] = json.loads(text)
    return report


def _existing(pack: _Path) -> str:
    path = os.fspath(pack)
    if not os.path.exists(path):
        raise FileNotFoundError(2, "no such pack", path)
    return path


def verify(pack: _Path, against: Any = None, *, spacing: Any = None, **option: Any) -> dict[str, Any]:
    """Whether a pack keeps its promises: nesting, borders, true errors, maps, checksums.

    against: what it was baked from, an array or paths, to compare every sample with; None for the pack alone. option:
        how that is read, if not as the pack says.
    Returns the report of `fjell-bake verify --json`: "ok", counts of violations, and in "first" the first one.

    >>> import numpy as np
    >>> heights = np.add.outer(np.arange(65.0), np.arange(97.0))
    >>> _ = fjell.bake(heights, "slope.fjell", spacing=2)
    >>> fjell.verify("slope.fjell", heights, spacing=2)["ok"]
    True
    """
    recipe = _recipe(option)
    if against is not None and is_heights(against):
        array, mask, step, _ = _array_and_place(against, spacing, None)
        text = _native.verify(_existing(pack), array, mask, step, json.dumps(recipe))
    else:
        if spacing is not None:
            recipe["spacing"] = float(spacing)
        if against is not None:
            recipe["inputs"] = _names(against)
        text = _native.verify(_existing(pack), None, None, (1, 1), json.dumps(recipe))
    report: dict[str, Any] = json.loads(text)
    return report


def info(pack: _Path) -> dict[str, Any]:
    """What a pack is: size, spacing, CRS, heights, errors and maps, as `fjell-bake info --json` says it.

    >>> import numpy as np
    >>> _ = fjell.bake(np.zeros((33, 65)), "flat.fjell")
    >>> fjell.info("flat.fjell")["columns"]
    65
    """
    report: dict[str, Any] = json.loads(_native.info(_existing(pack)))
    return report


def write_geotiff(pack: _Path, out: _Path) -> None:
    """Writes a pack's heights as a GeoTIFF of 32-bit floats in its CRS, holes as no-data. out ends in .tif."""
    path = os.fspath(out)
    if not path.endswith((".tif", ".tiff")):
        raise ValueError(f"out: is {path!r}; give a name that ends in .tif")
    _native.heights(_existing(pack), path)


class Comparison(NamedTuple):
    """How two terrains differ, at samples where both have a height, in metres.

    difference: b - a, float64 [rows, columns], NaN elsewhere. compared: how many samples are. only_a, only_b: samples where
    only one has a height. worst: row and column of the largest difference.
    """

    difference: NDArray[np.float64]
    compared: int
    mean: float
    rms: float
    largest: float
    percentile_95: float
    worst: tuple[int, int]
    only_a: int
    only_b: int


def compare(a: Any, b: Any) -> Comparison:
    """How far two terrains are apart: packs, open terrains or arrays, with as many rows and columns.

    >>> import numpy as np
    >>> ground = np.add.outer(np.arange(65.0), np.arange(97.0))
    >>> _ = fjell.bake(ground + 0.25, "raised.fjell")
    >>> fjell.compare(ground, "raised.fjell").mean
    0.25
    """

    def samples(given: Any) -> NDArray[np.float64]:
        if isinstance(given, Terrain):
            return given.samples().astype(np.float64)
        if isinstance(given, (str, os.PathLike)):
            with Terrain(given, streaming=True) as terrain:
                return terrain.samples().astype(np.float64)
        array, mask = heights_of(given)
        ground = array.astype(np.float64)
        if mask is not None:
            ground[mask] = np.nan
        return ground

    first, second = samples(a), samples(b)
    if first.shape != second.shape:
        raise ValueError(f"a, b: have {first.shape} and {second.shape} samples; only terrains of one size are compared")
    difference = second - first
    there = ~np.isnan(difference)
    if not there.any():
        raise ValueError("a, b: have no sample where both have a height")
    off = np.abs(difference[there])
    row, column = np.unravel_index(np.nanargmax(np.abs(difference)), difference.shape)
    return Comparison(
        difference=difference,
        compared=int(there.sum()),
        mean=float(difference[there].mean()),
        rms=float(np.sqrt((off**2).mean())),
        largest=float(off.max()),
        percentile_95=float(np.percentile(off, 95)),
        worst=(int(row), int(column)),
        only_a=int((~np.isnan(first) & np.isnan(second)).sum()),
        only_b=int((np.isnan(first) & ~np.isnan(second)).sum()),
    )

"""What callers give as heights, as the native half takes it."""

from __future__ import annotations

from typing import Any, Optional

import numpy as np
from numpy.typing import NDArray

_NATIVE = {"i1", "i2", "i4", "i8", "u1", "u2", "u4", "u8", "b1", "f4", "f8"}


def heights_of(heights: Any, name: str = "heights") -> tuple[NDArray[Any], Optional[NDArray[np.bool_]]]:
    """An array of a type that is read in place, and which of its numbers are masked.

    Copied are only lists, numbers of the other byte order, and types without one of the same in C++ (float16,
    longdouble).
    """
    values = getattr(heights, "values", heights)  # xarray's and pandas' arrays
    mask: Optional[NDArray[np.bool_]] = None
    if isinstance(values, np.ma.MaskedArray):
        if values.mask is not np.ma.nomask:
            mask = np.asarray(values.mask, dtype=np.bool_)
        values = values.data
    array = np.asarray(values)
    if array.dtype.kind not in "biuf":
        raise TypeError(f"{name}: has dtype {array.dtype}; give whole numbers or floats")
    if array.ndim != 2:
        raise ValueError(f"{name}: has {array.ndim} dimensions; give two, rows and columns")
    if array.dtype.str[1:] not in _NATIVE or not array.dtype.isnative:
        array = array.astype(np.float64)
    return array, mask


def is_heights(given: Any) -> bool:
    """Whether it is an array, or lists that make one; and not a path, or several."""
    if hasattr(given, "__array__") or hasattr(given, "__array_interface__"):
        return True
    return isinstance(given, (list, tuple)) and bool(given) and isinstance(given[0], (list, tuple))


def pair_of(value: Any, name: str) -> tuple[float, float]:
    """One number for both, or two: along columns (x) and along rows."""
    try:
        if np.ndim(value) == 0:
            return float(value), float(value)
        first, second = value
        return float(first), float(second)
    except (TypeError, ValueError):
        raise TypeError(f"{name}: is {value!r}; give a number, or two") from None


def place_of(heights: Any) -> tuple[Optional[tuple[float, float]], Optional[tuple[float, float]], bool]:
    """Of xarray's arrays with even coordinates: the spacing, the origin, and whether rows run from the south."""
    coords, dims = getattr(heights, "coords", None), getattr(heights, "dims", None)
    if coords is None or dims is None or len(dims) != 2 or any(d not in coords for d in dims):
        return None, None, False
    ys, xs = (np.asarray(coords[d], dtype=np.float64) for d in dims)
    if len(xs) < 2 or len(ys) < 2:
        return None, None, False
    dx, dy = (xs[-1] - xs[0]) / (len(xs) - 1), (ys[-1] - ys[0]) / (len(ys) - 1)
    even = np.allclose(np.diff(xs), dx, rtol=1e-6) and np.allclose(np.diff(ys), dy, rtol=1e-6)
    if not even or dx <= 0 or dy == 0:
        raise ValueError("heights: its coordinates are not even, or run from east to west; give a plain array")
    return (float(dx), float(abs(dy))), (float(xs[0]), float(max(ys[0], ys[-1]))), bool(dy > 0)

"""Terrain: a pack that is open."""

from __future__ import annotations

import json
import os
import struct
import zlib
from types import TracebackType
from typing import Any, NamedTuple, Optional, Union

import numpy as np
from numpy.typing import NDArray

from . import _native
from ._arrays import heights_of

_Point = tuple[float, float, float]


def _point(value: Any, name: str) -> _Point:
    try:
        x, y, z = (float(v) for v in value)
    except (TypeError, ValueError):
        raise TypeError(f"{name}: is {value!r}; give three numbers, x, y and z") from None
    return x, y, z


class View(_native.View):
    """A camera: from where, towards where, and how large the picture is.

    eye: metres, x east, y up, z south. look: a point that is in the middle of the picture. up: what is up in it, not
    along the way from eye to look. fov_deg: vertical. size: pixels, width and height. near, far: metres.
    max_error_px: how far, in pixels, the drawn surface may be from the ground; 0 for the profile's.

    >>> camera = fjell.View(eye=(0, 500, 0), look=(1000, 0, 1000), size=(640, 360))
    """

    def __init__(
        self,
        eye: Any,
        look: Any,
        *,
        up: Any = (0, 1, 0),
        fov_deg: float = 45.0,
        size: tuple[int, int] = (1280, 720),
        near: float = 0.5,
        far: float = 1e6,
        max_error_px: float = 0.0,
    ) -> None:
        self.eye, self.look, self.size = _point(eye, "eye"), _point(look, "look"), size
        forward = tuple(b - a for a, b in zip(self.eye, self.look))
        if not any(forward):
            raise ValueError("look: is where eye is; give another point")
        super().__init__(self.eye, forward, _point(up, "up"), fov_deg, size, near, far, max_error_px)  # type: ignore[arg-type]


class Hit(NamedTuple):
    """Where a ray meets the ground: metres along it, the place, the triangle's normal, and the error of the height."""

    distance: float
    position: _Point
    normal: _Point
    error: float


class Patch(NamedTuple):
    """Heights float32 [side, side], NaN for holes, and how far the original ground may be from one."""

    heights: NDArray[np.float32]
    error: float


class Raster(NamedTuple):
    """An array over the terrain: values [rows, columns, ...], and metres from one to the next along x and along z."""

    values: NDArray[np.float32]
    spacing_m: tuple[float, float]


class Frame:
    """The mesh of an update, in the terrain's own memory: its arrays show the next update's mesh after that.

    vertices: a record for each slot, used or not: int32 column and row, float32 height_m. indices: uint32, three a
    triangle. ranges: what is drawn of indices, a record each: tile, first_index, index_count, triangles. All are
    read-only. converged: all that the view asked for is there. error_bound_px: no sample that the view shows is farther
    from the mesh, in pixels. short_of: the budgets that did not suffice.
    """

    def __init__(self, native: _native.Frame, spacing: tuple[float, float]) -> None:
        self._native, self._spacing = native, spacing
        self.converged, self.settled = native.converged, native.settled
        self.error_bound_px, self.threshold_px = native.error_bound_px, native.threshold_px
        self.active_vertices, self.triangles = native.active_vertices, native.triangles
        self.triangles_drawn, self.pages_missing = native.triangles_drawn, native.pages_missing
        self.short_of = native.short_of

    @property
    def vertices(self) -> NDArray[Any]:
        return self._native.vertices

    @property
    def indices(self) -> NDArray[np.uint32]:
        return self._native.indices

    @property
    def ranges(self) -> NDArray[Any]:
        return self._native.ranges

    def mesh(self) -> tuple[NDArray[np.float32], NDArray[np.uint32]]:
        """A copy of what is drawn, without unused slots: vertices float32 [n, 3] in metres, triangles uint32 [m, 3]."""
        indices = self.indices
        drawn = [indices[r["first_index"] : r["first_index"] + r["index_count"]] for r in self.ranges]
        corners = (np.concatenate(drawn) if drawn else np.empty(0, np.uint32)).reshape(-1, 3)
        a, b, c = corners.T
        corners = corners[(a != b) & (b != c) & (c != a)]
        slots, triangles = np.unique(corners, return_inverse=True)
        used = self.vertices[slots]
        columns = (used["column"] * self._spacing[0], used["height_m"], used["row"] * self._spacing[1])
        return np.stack(columns, axis=1).astype(np.float32), triangles.reshape(-1, 3).astype(np.uint32)


def _png(rgb: NDArray[np.uint8]) -> bytes:
    height, width, _ = rgb.shape

    def chunk(name: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))

    rows = np.concatenate([np.zeros((height, 1), np.uint8), rgb.reshape(height, width * 3)], axis=1)
    header = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    return (
        b"\x89PNG\r\n\x1a\n"
        + chunk(b"IHDR", header)
        + chunk(b"IDAT", zlib.compress(rows.tobytes(), 6))
        + chunk(b"IEND", b"")
    )


class Terrain:
    """A pack that is open: heights, rays and patches, frames, snapshots and pictures.

    path: of a pack, or of a pack set's folder. profile: a profile's path (profiles/*.toml), or a dict of its keys, such
    as {"refine.max_error_px": 2}. streaming: False reads all of the geometry at once, 4 bytes a sample; True keeps it
    in the file, and heights are as fine as the last updates have asked for. edit_blocks: how much of the ground `edit`
    may change: blocks of 32 x 32 samples, 4.2 KB each. 0: none. The pack's file never changes.

    Heights, rays and patches may be asked from any thread, at any time. Updates, snapshots and pictures take turns.
    Closing waits for nobody: a call that has begun ends as if the terrain were open, and arrays of frames stay valid.

    >>> import numpy as np
    >>> _ = fjell.bake(np.add.outer(np.arange(65.0), np.arange(97.0)), "slope.fjell", spacing=2)
    >>> with fjell.Terrain("slope.fjell") as terrain:
    ...     round(terrain.height(20, 30), 6)
    25.0
    """

    def __init__(
        self,
        path: Union[str, "os.PathLike[str]"],
        profile: Union[None, str, "os.PathLike[str]", dict[str, Any]] = None,
        *,
        streaming: bool = False,
        edit_blocks: int = 0,
    ) -> None:
        name = os.fspath(path)
        if not os.path.exists(name):
            raise FileNotFoundError(2, "no such pack", name)
        overrides = []
        if isinstance(profile, dict):
            for key, value in profile.items():
                text = str(value).lower() if isinstance(value, bool) else f'"{value}"' if isinstance(value, str) else repr(value)
                overrides.append((key, text))
        file = "" if profile is None or isinstance(profile, dict) else os.fspath(profile)
        if not 0 <= edit_blocks <= 1 << 20:
            raise ValueError(f"edit_blocks: is {edit_blocks}; give 0 to {1 << 20}")
        self._streaming = streaming
        self._native = _native.Terrain(name, file, overrides, streaming, edit_blocks)
        self.path = name

    def close(self) -> None:
        """Frees the terrain once nothing uses it any more. Closing it again does nothing."""
        self._native.close()

    def __enter__(self) -> "Terrain":
        return self

    def __exit__(
        self, kind: Optional[type[BaseException]], raised: Optional[BaseException], trace: Optional[TracebackType]
    ) -> None:
        self.close()

    def __repr__(self) -> str:
        if self._native.closed:
            return f"<fjell.Terrain {self.path!r}, closed>"
        return f"<fjell.Terrain {self.path!r}, {self.columns} x {self.rows} samples, {self.spacing_m[0]:g} m apart>"

    @property
    def columns(self) -> int:
        """Samples along x."""
        return self._native.columns

    @property
    def rows(self) -> int:
        """Samples along z."""
        return self._native.rows

    @property
    def spacing_m(self) -> tuple[float, float]:
        """Metres from column to column, and from row to row."""
        return self._native.spacing_m

    @property
    def extent_m(self) -> tuple[float, float]:
        """Where the last column and the last row lie."""
        return (self.columns - 1) * self.spacing_m[0], (self.rows - 1) * self.spacing_m[1]

    @property
    def height_range_m(self) -> tuple[float, float]:
        """The lowest and the highest height."""
        return self._native.height_range_m

    @property
    def quantum_m(self) -> float:
        """The step of heights in the pack: each is within half of it of the one that was baked."""
        return self._native.quantum_m

    @property
    def has_holes(self) -> bool:
        """Whether some samples have no height."""
        return self._native.has_holes

    def height(self, x: float, z: float) -> float:
        """The ground's height at a place, in metres; NaN beyond the terrain and in a hole."""
        return self._native.height(float(x), float(z))[0]

    def heights(self, xs: Any, zs: Any, *, errors: bool = False) -> Any:
        """The same for arrays of places, which are broadcast: float64 of their shape. Some 0.2 us a place.

        errors: returns also how far the original ground may be from each height, float64 of the same shape.
        """
        (x, z), shape = self._places(xs, zs)
        found, error, _ = self._native.heights(x, z)
        return (found.reshape(shape), error.reshape(shape)) if errors else found.reshape(shape)

    def normals(self, xs: Any, zs: Any) -> NDArray[np.float64]:
        """The unit normals of the triangles there: float64 [..., 3], NaN where there is no ground."""
        (x, z), shape = self._places(xs, zs)
        return self._native.heights(x, z)[2].reshape(shape + (3,))

    @staticmethod
    def _places(xs: Any, zs: Any) -> tuple[tuple[NDArray[np.float64], NDArray[np.float64]], tuple[int, ...]]:
        try:
            x, z = np.broadcast_arrays(np.asarray(xs, np.float64), np.asarray(zs, np.float64))
        except (TypeError, ValueError):
            raise ValueError("xs, zs: are no numbers, or their shapes do not go together") from None
        return (x.ravel(), z.ravel()), x.shape

    def ray(self, origin: Any, direction: Any, max_distance: float = np.inf) -> Optional[Hit]:
        """The first place where a ray meets the ground, from above or below; None where it does not.

        direction: of any length but 0. max_distance: metres along the ray.
        """
        o, d = _point(origin, "origin"), _point(direction, "direction")
        far, at, normal, error = self._native.rays(np.array([o]), np.array([d]), float(max_distance))
        if np.isnan(far[0]):
            return None
        px, py, pz = at[0].tolist()
        nx, ny, nz = normal[0].tolist()
        return Hit(float(far[0]), (px, py, pz), (nx, ny, nz), float(error[0]))

    def rays(self, origins: Any, directions: Any, max_distance: float = np.inf) -> NDArray[np.float64]:
        """The distances of many rays at once: origins and directions [n, 3], broadcast; NaN where there is no hit."""
        o, d = np.broadcast_arrays(np.asarray(origins, np.float64), np.asarray(directions, np.float64))
        if o.ndim == 0 or o.shape[-1] != 3:
            raise ValueError("origins, directions: their last dimension must be 3, x, y and z")
        return self._native.rays(o.reshape(-1, 3), d.reshape(-1, 3), float(max_distance))[0].reshape(o.shape[:-1])

    def patch(self, column: int, row: int, side: int, step: int = 1) -> Patch:
        """Heights of side x side samples, `step` apart (a power of two, up to 4096), from (column, row) on.

        What physics engines take: 33 or 65 a side. Samples beyond the rim are the rim's. At step 1 the ground between
        samples is two triangles a cell, cut from north-west to south-east where column + row of the cell's
        north-western sample is even, and the other way elsewhere.
        """
        if step < 1 or step & (step - 1) or step > 4096:
            raise ValueError(f"step: is {step}; give a power of two up to 4096")
        return Patch(*self._native.patch(column, row, side, step.bit_length() - 1))

    def samples(self, step: int = 1) -> NDArray[np.float32]:
        """All heights, float32 [rows, columns], NaN for holes; or every step-th of a row and a column (a power of two).

        A last one that would lie beyond the rim is the rim's. Read from the file, whatever is loaded; but of a terrain
        with edit_blocks they are those of the edited ground.
        """
        if step < 1 or step & (step - 1):
            raise ValueError(f"step: is {step}; give a power of two")
        if self._streaming or not self._native.editable:
            return self._native.samples(step.bit_length() - 1)
        side = 1025
        columns, rows = ((count - 2) // step + 2 for count in (self.columns, self.rows))
        made = np.empty((rows, columns), np.float32)
        for y in range(0, rows, side):
            for x in range(0, columns, side):
                part = made[y : y + side, x : x + side]
                part[:] = self.patch(x * step, y * step, max(*part.shape, 2), step).heights[: part.shape[0], : part.shape[1]]
        return made

    def edit(
        self,
        shape: str,
        at: Optional[tuple[float, float]] = None,
        *,
        radius: Optional[float] = None,
        falloff: float = 0.0,
        amount: Optional[float] = None,
        height: Optional[float] = None,
        slope: tuple[float, float] = (0.0, 0.0),
        wavelength: Optional[float] = None,
        seed: int = 0,
        points: Any = None,
        first: Optional[tuple[int, int]] = None,
        heights: Any = None,
        mask: Any = None,
        rgb: Optional[tuple[int, int, int]] = None,
        material: Optional[int] = None,
        strength: float = 1.0,
    ) -> int:
        """Changes the ground, and returns how many samples have another height. Metres, x and z as everywhere.

        shape: "raise" adds `amount` (negative: takes away); "level" makes a plane with `height` at the centre and
            `slope`, metres up a metre east and a metre south; "crater" makes a bowl `amount` deep, with a rim; "path"
            makes a road along `points`, [n, 3] of x, z and height; "noise" adds hills of `amount` and `wavelength`;
            "smooth" takes the mean of a sample and its neighbours; "heights" takes those of an array [rows, columns],
            NaN leaving a sample as it is; "restore" gives back the pack's. "paint" shows the colour `rgb` instead of the
            pack's, and of its splat map the `material` of that number, within a radius, along `points` [n, 2] or by a
            mask, "unpaint" gives back the pack's. Neither changes a height.
            "hole" cuts one, and "fill" makes it ground again; a few packs need `room_for_holes="yes"` for it.
            "lock" keeps what any view draws within `amount` metres of the ground, within a radius, along `points` [n, 2]
            or by a mask; a few packs need `room_for_locks="yes"` for it. "unlock" takes locks away. Neither changes a
            height.
        at: the centre, x and z. radius: within it the shape applies wholly, and fades out over `falloff`; of a path,
            half its width.
        strength: the share of all this that happens, 0 to 1.
        first: column and row of the array's first sample. mask: uint8 [rows, columns], of any shape; 255 applies it
            wholly, 0 not at all.

        Heights move in steps of `quantum_m`. Heights, rays, patches and samples are those of the new ground at once;
        frames, snapshots and pictures from the next one on, with their bound. Slopes and horizons stay the pack's. A
        streamed terrain loads the ground under the stamp first. What is wrong, needs more than edit_blocks, or is
        steeper than the pack can bound, is a ValueError and changes nothing. Each edit is kept until the terrain is
        closed.

        >>> import numpy as np
        >>> _ = fjell.bake(np.add.outer(np.arange(65.0), np.arange(97.0)), "slope.fjell", spacing=2)
        >>> with fjell.Terrain("slope.fjell", edit_blocks=64) as terrain:
        ...     changed = terrain.edit("level", (100, 60), radius=10, falloff=6, height=80)
        ...     round(terrain.height(100, 60), 6), changed > 100
        (80.0, True)
        """
        stamp: dict[str, Any] = {"shape": shape}
        plain = {"radius_m": radius, "amount_m": amount, "height_m": height, "wavelength_m": wavelength}
        stamp.update((name, float(value)) for name, value in plain.items() if value is not None)
        optional = {"falloff_m": float(falloff), "slope_x": float(slope[0]), "slope_z": float(slope[1]), "seed": int(seed)}
        stamp.update((name, value) for name, value in optional.items() if value != 0)
        if strength != 1:
            stamp["strength"] = float(strength)
        if at is not None:
            stamp["at"] = [float(v) for v in at]
        if points is not None:
            stamp["points"] = np.asarray(points, np.float64).tolist()
        if rgb is not None:
            stamp["rgb"] = [int(v) for v in rgb]
        if material is not None:
            stamp["material"] = int(material)
        shapes = set()
        if heights is not None:
            values, hidden = heights_of(heights)
            numbers = values.astype(np.float64)
            left = np.isnan(numbers) if hidden is None else np.isnan(numbers) | hidden
            stamp["heights_m"] = np.where(left, None, numbers).ravel().tolist()  # type: ignore[call-overload]
            shapes.add(values.shape)
        if mask is not None:
            shares, _ = heights_of(mask, "mask")
            stamp["mask"] = shares.astype(np.int64).ravel().tolist()
            shapes.add(shares.shape)
        if len(shapes) > 1:
            raise ValueError("mask: give one of the heights' shape")
        if bool(shapes) != (first is not None):
            raise ValueError("first: heights and a mask need it, and nothing else does: the column and row where they begin")
        if first is not None:
            stamp["first"] = [int(v) for v in first]
            stamp["rows"], stamp["columns"] = shapes.pop()
        try:
            text = json.dumps(stamp, allow_nan=False)
        except ValueError:
            raise ValueError("edit: a number is infinite or none") from None
        return self._native.edit(text)

    def ground_changes(self) -> list[tuple[int, int, int, int]]:
        """What edits have changed since the last call: rectangles of samples, (column, row, columns, rows), in order.

        For physics and other copies of the ground: `patch` of a rectangle gives its heights. Of more than the last
        1,024 changes it is all of the terrain.
        """
        return self._native.ground_changes()

    def _codes(self, kind: str) -> tuple[NDArray[np.uint8], tuple[float, float]]:
        codes, step = self._native.map_codes(kind)
        return codes, (step * self.spacing_m[0], step * self.spacing_m[1])

    def slope(self) -> Raster:
        """How steep the ground is, in degrees, from the normal map that the bake has made of the full resolution.

        The map has 8 bits a component: to half a degree or so where the ground is steep, a few degrees where it is
        nearly level.
        """
        codes, spacing = self._codes("normal")
        east, south = ((codes[..., k].clip(1).astype(np.float32) - 128) / 127 for k in (0, 1))
        return Raster(np.degrees(np.arcsin(np.hypot(east, south).clip(max=1))), spacing)

    def horizons(self) -> Raster:
        """How high the ground around each place stands, in degrees: 15 directions, 24 degrees apart from north on.

        Clockwise, float32 [rows, columns, 15]. Of a pack that was baked with horizons="half" or "quarter".
        """
        codes, spacing = self._codes("horizon")
        return Raster(np.degrees(np.arcsin(codes[..., :15].astype(np.float32) / 255)), spacing)

    def sky(self) -> Raster:
        """The share of the sky's light that arrives, 0 to 1, of what would if nothing stood around. As `horizons`."""
        codes, spacing = self._codes("horizon")
        return Raster(codes[..., 15].astype(np.float32) / 255, spacing)

    def update(self, view: View, now_s: Optional[float] = None, *, wait: bool = False) -> Frame:
        """Refines the mesh for a view, as an engine does once a frame, and returns it without copying.

        now_s: the caller's clock, for what morphs by time; None counts 60 updates a second. wait: updates until all
        that the view wants is there.
        """
        return Frame(self._native.update(view, now_s, wait), self.spacing_m)

    def snapshot(
        self,
        path: Union[str, "os.PathLike[str]"],
        view: Optional[View] = None,
        *,
        texel: float = 0,
        quantised: bool = False,
        meshopt: bool = False,
        texture: str = "png",
    ) -> dict[str, Any]:
        """Writes what a view settles on to a .glb, with its textures, and returns what is in it.

        texel: the largest width of a texel, in metres; 0: as fine as the maps are. quantised: 16 bits a number; the
        file says what this rounds. meshopt: compressed, which not all viewers read. texture: "png", or "jpeg" for
        smaller colours.
        """
        return self._native.snapshot(os.fspath(path), view or self.overview(), texel, quantised, meshopt, texture)

    def overview(self, size: tuple[int, int] = (960, 540)) -> View:
        """A view of all of the terrain, from the south."""
        width, depth = self.extent_m
        low, high = self.height_range_m
        middle = (width / 2, (low + high) / 2, depth / 2)
        away = max(width, depth)
        eye = (middle[0], high + 0.4 * away, depth / 2 + 0.8 * away)
        return View(eye, middle, size=size, near=away / 1000, far=away * 4)

    def render(self, view: Optional[View] = None, size: tuple[int, int] = (960, 540), mode: str = "shaded") -> NDArray[np.uint8]:
        """A picture, uint8 [height, width, 3], sRGB, drawn without a window.

        view: None for all of the terrain, without haze, in a picture of `size`. mode: "shaded", "wire", "levels", "tiles", "mips" or
        "distance". Needs OpenGL 4.5 through EGL, of a GPU or Mesa's software; OSError where there is none.
        """
        return self._native.render(view or self.overview(size), mode, view is not None)

    def map(self, longest_px: int = 512) -> Optional[NDArray[np.uint8]]:
        """A map from above: relief, and the errors of its vertices in colours; uint8 [height, width, 3].

        Needs no OpenGL. None of a terrain that is streamed.
        """
        return self._native.map(longest_px)

    def _repr_png_(self) -> Optional[bytes]:
        if self._native.closed:
            return None
        try:
            return _png(self.render())
        except OSError:  # no OpenGL here
            picture = self.map()
            return None if picture is None else _png(picture)

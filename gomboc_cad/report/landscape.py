"""The height of the COM over all poses as a map, with its equilibria and the basins of its rests."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Self, get_args

import numpy as np
from scipy.interpolate import RectSphereBivariateSpline
from scipy.spatial import cKDTree

from gomboc_cad.body.sphere import Array, IntArray, unit
from gomboc_cad.equilibria.persistence import merge_tree
from gomboc_cad.equilibria.records import Census, Kind, Vector, as_vector
from gomboc_cad.errors import CensusError, InspectionError
from gomboc_cad.report.packing import packed, packed_integers, unpacked, unpacked_integers
from gomboc_cad.report.surface_fields import pose_of

_LATITUDES = 90
_STEP, _STEPS = np.radians(2.0), 60


@dataclass(frozen=True)
class Pose:
    """An equilibrium on the map.

    Attributes:
        kind: `stable`, `unstable` or `saddle`.
        direction: Body direction that points down.
        height_mm: Height of the COM over the table.
    """

    kind: Kind
    direction: Vector
    height_mm: float


@dataclass(frozen=True, eq=False)
class HeightLandscape:
    """Heights on a grid of cells between parallels and meridians, all of the same width in degrees.

    The map is laid by the rest and not by the body's frame, so that it looks the same however the body is
    turned: the lowest rest is on the equator, a quarter of a turn left of the middle, and north is its soft
    direction.

    Attributes:
        axes: The direction in the middle of the map, that on the equator a quarter of a turn to the right,
            and north, as the rows of a rotation.
        heights_mm: From the south to the north, in each row from the left to the right, shape (n, 2n).
        basins: To which rest each cell drains, counted from 0 in the order of the poses, shape (n, 2n).
        poses: The equilibria, the lowest first.
    """

    axes: tuple[Vector, Vector, Vector]
    heights_mm: Array
    basins: IntArray
    poses: tuple[Pose, ...]

    @property
    def latitudes(self) -> Array:
        """Middles of the rows in radians, shape (n,)."""
        return _middles(-0.5 * np.pi, 0.5 * np.pi, self.heights_mm.shape[0])

    @property
    def longitudes(self) -> Array:
        """Middles of the columns in radians, shape (2n,)."""
        return _middles(-np.pi, np.pi, self.heights_mm.shape[1])

    @property
    def shares(self) -> Array:
        """Share of the sphere that each cell takes, shape (n, 2n)."""
        level = np.cos(self.latitudes)[:, None]
        result: Array = np.broadcast_to(level / (level.sum() * len(self.longitudes)), self.heights_mm.shape)
        return result

    def place(self, directions: Array) -> tuple[Array, Array]:
        """Longitudes and latitudes of unit vectors (k, 3) on the map, in radians."""
        middle, right, north = np.clip(np.array(self.axes) @ np.transpose(directions), -1.0, 1.0)
        return np.arctan2(right, middle), np.arcsin(north)

    def document(self) -> dict[str, Any]:
        """As it is stored."""
        return {
            "axes": [list(axis) for axis in self.axes],
            "heights_mm": packed(self.heights_mm),
            "basins": packed_integers(self.basins, "uint8"),
            "poses": [
                {"kind": pose.kind, "direction": list(pose.direction), "height_mm": pose.height_mm}
                for pose in self.poses
            ],
        }

    @classmethod
    def of_document(cls, document: Mapping[str, Any]) -> Self:
        """Read what is stored.

        Raises:
            InspectionError: If an array is damaged.
        """
        middle, right, north = (as_vector(np.array(axis)) for axis in document["axes"])
        poses = tuple(
            Pose(pose["kind"], as_vector(np.array(pose["direction"])), float(pose["height_mm"]))
            for pose in document["poses"]
        )
        heights, basins = unpacked(document["heights_mm"]), unpacked_integers(document["basins"])
        if heights.ndim != 2 or heights.shape != basins.shape or {p.kind for p in poses} - {*get_args(Kind)}:
            raise InspectionError("The landscape in the report's data is damaged; build again.")
        return cls((middle, right, north), heights, basins, poses)


def height_landscape(census: Census, latitudes: int = _LATITUDES) -> HeightLandscape:
    """Evaluate the heights of a census and divide them into basins.

    Args:
        census: The census.
        latitudes: Rows of the map.

    Raises:
        CensusError: If the census does not know the shape it was taken of.
    """
    if census.height_at is None:
        raise CensusError("This census does not know its shape; take it again to draw it.")
    soft, stiff, up = pose_of(census.rest)
    # Down at rest is a quarter of a turn left of the middle.
    axes = (as_vector(-np.array(stiff)), up, soft)
    turn, rise = np.meshgrid(
        _middles(-np.pi, np.pi, 2 * latitudes), _middles(-0.5 * np.pi, 0.5 * np.pi, latitudes)
    )
    level = np.cos(rise)
    local = np.stack([level * np.cos(turn), level * np.sin(turn), np.sin(rise)], axis=-1)
    directions = local.reshape(-1, 3) @ np.array(axes)
    heights = census.height_at(directions)
    poses = tuple(Pose(e.kind, e.direction, e.height_mm) for e in census.equilibria)
    rests = np.array([pose.direction for pose in poses if pose.kind == "stable"]) @ np.array(axes).T
    basins = _basins(heights.reshape(turn.shape), local.reshape(-1, 3), rests)
    return HeightLandscape(axes, heights.reshape(turn.shape), basins, poses)


def _middles(start: float, end: float, count: int) -> Array:
    edges = np.linspace(start, end, count + 1)
    result: Array = 0.5 * (edges[1:] + edges[:-1])
    return result


def _basins(heights: Array, directions: Array, rests: Array) -> IntArray:
    """Number of the rest that is reached by steepest descent from each cell, all in the frame of the map."""
    if len(rests) == 1:
        return np.zeros(heights.shape, dtype=np.int64)
    # Between cells descent has eight directions only, which carries it astray on the long way down a flank;
    # at the bottom of a valley, where a smooth step leaps from wall to wall, it is better.
    ends = _descended(heights, directions)
    cells = cKDTree(directions).query(ends)[1]
    result: IntArray = _drained(heights, directions, rests)[cells].reshape(heights.shape)
    return result


def _descended(heights: Array, directions: Array) -> Array:
    """Where steepest descent on a smooth interpolation leads from each cell, for a stretch, shape (k, 3)."""
    rows, columns = heights.shape
    polar, turn = _middles(0.0, np.pi, rows), _middles(-np.pi, np.pi, columns)
    smooth = RectSphereBivariateSpline(polar, turn, heights[::-1])

    def height(at: Array) -> Array:
        x, y, z = at.T
        result: Array = smooth.ev(np.arctan2(np.hypot(x, y), z), np.arctan2(y, x))
        return result

    def downhill(at: Array) -> Array:
        x, y, z = at.T
        level = np.maximum(np.hypot(x, y), 1e-9)
        theta, phi = np.arctan2(level, z), np.arctan2(y, x)
        south = np.stack([x * z / level, y * z / level, -level], axis=-1)
        east = np.stack([-y / level, x / level, np.zeros(len(at))], axis=-1)
        slope = smooth.ev(theta, phi, dtheta=1)[:, None] * south
        slope += (smooth.ev(theta, phi, dphi=1) / level)[:, None] * east
        result: Array = -slope / np.maximum(np.linalg.norm(slope, axis=1, keepdims=True), 1e-300)
        return result

    at, level = directions, height(directions)
    step = np.full((len(at), 1), _STEP)
    for _ in range(_STEPS):
        middle = unit(at + 0.5 * step * downhill(at))
        ahead = unit(at + step * downhill(middle))
        found = height(ahead)
        lower = found < level
        at, level = np.where(lower[:, None], ahead, at), np.where(lower, found, level)
        # Where a step leads up again, it has leapt over the bottom of a valley.
        step = np.where(lower[:, None], step, 0.5 * step)
    return at


def _drained(heights: Array, directions: Array, rests: Array) -> IntArray:
    """Number of the rest that each cell drains to, from neighbour to neighbour, shape (k,).

    The grid makes basins of its own; water that rises in one of them flows over its lowest pass onwards.
    """
    neighbours = _neighbours(*heights.shape)
    level = heights.ravel()
    cells = np.arange(len(level))
    run = np.linalg.norm(directions[:, None] - directions[neighbours], axis=-1)
    slope = (level[:, None] - level[neighbours]) / run
    steepest = slope.argmax(axis=1)
    downhill = np.where(slope[cells, steepest] > 0.0, neighbours[cells, steepest], cells)
    # Every rest has a basin, if the grid shows its minimum or not.
    own = np.asarray(cKDTree(directions).query(rests)[1])
    downhill[own] = own
    edges = np.stack([np.repeat(cells, neighbours.shape[1]), neighbours.ravel()], axis=-1)
    tree = merge_tree(level, edges, level[edges].max(axis=1), downhill)
    owner = np.full(len(tree.bottom), -1)
    owner[tree.basin[own[::-1]]] = np.arange(len(rests))[::-1]
    lake = np.arange(len(owner))
    for a, b in tree.ends.tolist():
        one, other = lake[a], lake[b]
        if min(owner[one], owner[other]) < 0:
            owner[one] = max(owner[one], owner[other])
            lake[lake == other] = one
    result: IntArray = owner[lake][tree.basin]
    return result


def _neighbours(rows: int, columns: int) -> IntArray:
    """The eight cells around each; over a pole they are half a turn away, shape (rows · columns, 8)."""
    row, column = np.divmod(np.arange(rows * columns), columns)
    steps = np.array([(i, j) for i in (-1, 0, 1) for j in (-1, 0, 1) if (i, j) != (0, 0)])
    up = row[:, None] + steps[:, 0]
    beyond = (up < 0) | (up >= rows)
    across = column[:, None] + steps[:, 1] + np.where(beyond, columns // 2, 0)
    result: IntArray = np.clip(up, 0, rows - 1) * columns + across % columns
    return result

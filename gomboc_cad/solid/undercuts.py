"""What a mould of two halves, opened along one direction, cannot release.

A point of the surface is reached by one half of the mould if nothing of the part is in its way along the
direction, and by the other if nothing is against it. Where both ways are barred the surface is an
undercut: it needs a slide, a core that is pulled, or another parting direction. Draft is not judged: a wall
along the direction counts as released.

The ways are followed exactly through the facets; only the area is a sum over points spread on the surface.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import distance_transform_edt
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from gomboc_cad.body.sphere import Array, BoolArray, IntArray, tangent_frame
from gomboc_cad.equilibria.records import Vector, as_vector
from gomboc_cad.solid.facets import facet_normals, spread_points
from gomboc_cad.solid.mesh import Mesh

_SAMPLES = 40_000
_LIFT = 1e-5
"""How far points are lifted off the surface before they look around, over the size of the part."""

_COLUMNS = 200
_LEVELS = 24
_MOST_PLACES = 10
_APART = 4.0
"""Undercuts farther apart than this, in units of the spacing of the points, are two places."""

_MOST_PAIRS = 2_000_000


@dataclass(frozen=True)
class UndercutPlace:
    """A connected undercut.

    Attributes:
        position_mm: Middle of its surface.
        area_mm2: Its area.
        depth_mm: How far a slide has to be drawn sideways at least, square to the direction.
    """

    position_mm: Vector
    area_mm2: float
    depth_mm: float


@dataclass(frozen=True)
class Undercuts:
    """The surface of a part that a mould of two halves cannot release.

    Attributes:
        direction: Unit vector along which the mould opens.
        area_mm2: Area of all undercuts.
        share: The same as a share of the whole surface.
        deepest_mm: Largest depth of all places.
        places: The places, the largest first, at most ten.
        resolution_mm2: Area that one of the points stands for; smaller undercuts may be missed.
    """

    direction: Vector
    area_mm2: float
    share: float
    deepest_mm: float
    places: tuple[UndercutPlace, ...]
    resolution_mm2: float


def undercuts(mesh: Mesh, direction: Vector, *, samples: int = _SAMPLES) -> Undercuts:
    """Find the undercuts of a part.

    Args:
        mesh: A closed mesh.
        direction: Direction along which the mould opens, of any length but zero.
        samples: Number of points that are spread over the surface.
    """
    up = np.array(direction) / np.linalg.norm(direction)
    normals, areas = facet_normals(mesh)
    points, facets = spread_points(mesh, samples)
    size = float(np.ptp(mesh.vertices_mm, axis=0).max())
    ways = _Ways(mesh, up)
    below, above = ways.barred(points + _LIFT * size * normals[facets])
    held = points[below & above]
    each = float(areas.sum()) / samples
    depths = _depths(ways, held)
    places = _places(held, depths, each)
    return Undercuts(
        direction=as_vector(up),
        area_mm2=each * len(held),
        share=len(held) / samples,
        deepest_mm=float(depths.max(initial=0.0)),
        places=places[:_MOST_PLACES],
        resolution_mm2=each,
    )


class _Ways:
    """The facets of a mesh seen along a direction, sorted into the columns of a grid across it."""

    def __init__(self, mesh: Mesh, up: Array):
        """Sort the facets."""
        self.frame = np.stack([*(axis[0] for axis in tangent_frame(up[None])), up])
        corners = (mesh.vertices_mm @ self.frame.T)[mesh.faces]
        sides = np.roll(corners, -1, axis=1) - corners
        twice = sides[:, 0, 0] * sides[:, 1, 1] - sides[:, 0, 1] * sides[:, 1, 0]
        # A facet along the direction bars no way.
        self.corners, self.twice = corners[twice != 0.0], twice[twice != 0.0]
        plane = self.corners[:, :, :2]
        self.low = plane.min(axis=(0, 1))
        self.width = float((plane.max(axis=(0, 1)) - self.low).max()) / _COLUMNS * (1.0 + 1e-9)
        first = self._cells(plane.min(axis=1))
        spans = self._cells(plane.max(axis=1)) - first + 1
        counts = spans.prod(axis=1)
        facet = np.repeat(np.arange(len(counts)), counts)
        within = np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
        column = (
            (first[facet, 0] + within % spans[facet, 0]) * _COLUMNS
            + first[facet, 1]
            + within // spans[facet, 0]
        )
        order = np.argsort(column, kind="stable")
        self._facet = facet[order]
        self._start = np.searchsorted(column[order], np.arange(_COLUMNS**2 + 1))

    def _cells(self, plane: Array) -> IntArray:
        cells: IntArray = np.clip((plane - self.low) // self.width, 0, _COLUMNS - 1).astype(np.int64)
        return cells

    def barred(self, points: Array) -> tuple[BoolArray, BoolArray]:
        """Whether facets lie below and above points (n, 3), shapes (n,)."""
        low, high = self.extremes((points @ self.frame.T)[:, :2])
        height = points @ self.frame[2]
        return low < height, high > height

    def extremes(self, plane: Array) -> tuple[Array, Array]:
        """Lowest and highest facet at places (n, 2) of the plane, infinite where there is none."""
        low, high = np.full(len(plane), np.inf), np.full(len(plane), -np.inf)
        x, y = self._cells(plane).T
        start = self._start[x * _COLUMNS + y]
        counts = self._start[x * _COLUMNS + y + 1] - start
        blocks = np.cumsum(counts) // _MOST_PAIRS
        for block in range(int(blocks.max(initial=-1)) + 1):
            rows = np.flatnonzero(blocks == block)
            row = np.repeat(rows, counts[rows])
            begun = np.repeat(np.cumsum(counts[rows]) - counts[rows], counts[rows])
            facet = self._facet[start[row] + np.arange(len(row)) - begun]
            height, over = self._heights(plane[row], facet)
            np.minimum.at(low, row[over], height[over])
            np.maximum.at(high, row[over], height[over])
        return low, high

    def _heights(self, plane: Array, facet: IntArray) -> tuple[Array, BoolArray]:
        """Heights of facets over places of the plane, and whether they are over them at all."""
        corners = self.corners[facet]
        arms = corners[:, :, :2] - plane[:, None]
        ahead = np.roll(arms, -1, axis=1)
        # Areas opposite to the corners 3, 1 and 2.
        areas = (arms[:, :, 0] * ahead[:, :, 1] - arms[:, :, 1] * ahead[:, :, 0]) / self.twice[facet][:, None]
        heights = np.vecdot(np.roll(areas, -1, axis=1), corners[:, :, 2])
        return heights, np.all(areas >= 0.0, axis=1)


def _depths(ways: _Ways, held: Array) -> Array:
    """Distance of held points (n, 3), across the direction, from where their height is free, shape (n,)."""
    if len(held) == 0:
        return np.zeros(0)
    middles = ways.low + ways.width * (np.indices((_COLUMNS, _COLUMNS)).reshape(2, -1).T + 0.5)
    low, high = ways.extremes(middles)
    place = held @ ways.frame.T
    cells = ways._cells(place[:, :2])
    levels = np.linspace(place[:, 2].min(), place[:, 2].max(), _LEVELS)
    level = np.abs(place[:, 2, None] - levels).argmin(axis=1)
    result = np.zeros(len(held))
    for number in np.unique(level):
        height = place[level == number, 2].mean()
        full = np.pad(((low < height) & (high > height)).reshape(_COLUMNS, _COLUMNS), 1)
        distance = ways.width * distance_transform_edt(full)
        x, y = cells[level == number].T + 1
        result[level == number] = distance[x, y]
    return result


def _places(held: Array, depths: Array, each: float) -> tuple[UndercutPlace, ...]:
    """Held points gathered into connected places, the largest first."""
    if len(held) == 0:
        return ()
    pairs = cKDTree(held).query_pairs(_APART * float(np.sqrt(each)), output_type="ndarray")
    graph = coo_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(len(held), len(held)))
    count, label = connected_components(graph, directed=False)
    found = [
        UndercutPlace(
            as_vector(held[label == k].mean(axis=0)),
            each * int(np.sum(label == k)),
            float(depths[label == k].max()),
        )
        for k in range(count)
    ]
    return tuple(sorted(found, key=lambda place: -place.area_mm2))

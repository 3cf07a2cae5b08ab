"""The thinnest wall of a made part, measured on its mesh.

The thickness at a point of the surface is the diameter of the largest sphere inside the material that
touches the surface there, as CAD programs measure it. It counts as a wall where the sphere touches two
places that face away from each other to within 30°. Near an edge of the part the sphere touches the two
faces of the edge, and shrinks to nothing although no wall is thin; so an edge counts only where its faces
meet at less than 30°, and then as what it is: a feather edge of no thickness.

Spheres are first shrunk among points spread over the surface (Ma, Bae, Choi, The Visual Computer 28 (2012)
7), which can leave them too large only; the thinnest are then shrunk among the facets themselves, on finer
and finer nets of points around them.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.spatial import cKDTree

from gomboc_cad.body.sphere import Array, IntArray, tangent_frame
from gomboc_cad.equilibria.records import Vector, as_vector
from gomboc_cad.solid.facets import Facets, facet_normals, nearest_on_facets, spread_points
from gomboc_cad.solid.mesh import Mesh

_SAMPLES = 60_000
_PLACES = 8
"""How many of the thinnest places are looked at closely."""

_FACING_DEG = 30.0
_FACING = math.tan(math.radians(0.5 * _FACING_DEG))
_SLOPE = 2.0 * _FACING
"""Most that a wall's thickness changes along it, between faces that are parallel to within 30°."""

_MOST_STEPS = 50
_CONVERGED = 1e-5
_ROUNDING = 1e-6
_BATCH = 4000
_FEW = 10
_REACH = 12.0
"""Diameter of the first spheres over the spacing of the points."""

_THINNING = 9

_NET = 7
"""Points along each side of the net that is laid around a thin place."""

_ROUNDS = 6
_SHRINK = 0.4
_APART = 4.0
"""Least distance of two places that are looked at, in units of the spacing of the points."""


@dataclass(frozen=True)
class WallThickness:
    """The thinnest wall of a part.

    Attributes:
        min_mm: Its thickness on the mesh; infinite for a part without walls.
        place_mm: Where, on one face of the wall.
        opposite_mm: Where on its other face.
        spacing_mm: Mean distance of the points that were looked at; a thin place smaller than that may be
            missed.
        error_mm: How much thinner a wall may be between those points, if its faces are smooth.
    """

    min_mm: float
    place_mm: Vector
    opposite_mm: Vector
    spacing_mm: float
    error_mm: float


class _Wall(NamedTuple):
    """A wall at a point of the surface; at many points, with arrays of shape (n,) and (n, 3)."""

    thickness: Array
    place: Array
    opposite: Array


def thinnest_wall(mesh: Mesh, *, samples: int = _SAMPLES) -> WallThickness:
    """Measure the thinnest wall of a part.

    Args:
        mesh: A closed mesh; each face of the wall may be off by the mesh's sag.
        samples: Number of points that are spread over its surface.
    """
    size = float(np.ptp(mesh.vertices_mm, axis=0).max())
    surface = _Surface(mesh, samples)
    thinnest = surface.thinnest()
    # Thick walls do not need, and a search tree does not like, spheres much larger than the spacing.
    while surface.reach < 2.0 * size and not np.isfinite(thinnest.thickness):
        samples //= _THINNING
        surface = _Surface(mesh, samples)
        thinnest = surface.thinnest()
    return WallThickness(
        min_mm=float(thinnest.thickness),
        place_mm=as_vector(thinnest.place),
        opposite_mm=as_vector(thinnest.opposite),
        spacing_mm=surface.spacing,
        error_mm=_SLOPE * surface.spacing / math.sqrt(2.0),
    )


class _Surface:
    """The facets of a mesh and points spread over them."""

    def __init__(self, mesh: Mesh, samples: int):
        """Spread the points."""
        self.corners = mesh.vertices_mm[mesh.faces]
        self.normals, areas = facet_normals(mesh)
        self.points, self.facets = spread_points(mesh, samples)
        self.spacing = float(np.sqrt(areas.sum() / samples))
        self._low, self._high = (self.corners.min(axis=1).T.copy(), self.corners.max(axis=1).T.copy())
        # Small facets that no point happens to be on have at least their middles in the tree.
        self._marks = np.concatenate([self.points, self.corners.mean(axis=1)])
        self._mark_facets = np.concatenate([self.facets, np.arange(len(self.corners))])
        self._tree = cKDTree(self._marks)

    @property
    def reach(self) -> float:
        """The thickest wall that is looked for."""
        return _REACH * self.spacing

    def thinnest(self) -> _Wall:
        """The thinnest wall; infinite if there is none within reach."""
        walls = self._walls()
        best = _Wall(np.array(np.inf), walls.place[0], walls.place[0])
        found = 0
        for row in _thinnest(walls, _APART * self.spacing):
            if walls.thickness[row] - 2.0 * _SLOPE * self.spacing > best.thickness or found == _PLACES:
                break
            closer = self._refined(row, walls.thickness[row])
            found += bool(np.isfinite(closer.thickness))
            best = min(best, closer, key=lambda wall: float(wall.thickness))
        return best

    def _walls(self) -> _Wall:
        """Walls at all points within reach; exact for the thinnest of them."""
        normals = self.normals[self.facets]
        reach = np.full(len(self.points), self.reach)
        rough = _walls(self.points, normals, reach, self._nearest_mark, self.spacing)
        thickness, opposite = rough.thickness.copy(), rough.opposite
        order = np.argsort(thickness, kind="stable")[: int(np.isfinite(thickness).sum())]
        best = np.inf
        for rows in np.split(order, range(_BATCH, len(order), _BATCH)):
            # Among points only, a wall may seem too thick by the square of their distance over it.
            seeming = thickness[rows].min(initial=np.inf)
            if seeming - self.spacing**2 / seeming > best:
                break
            exact = _walls(self.points[rows], normals[rows], thickness[rows], self._nearest_of_few)
            thickness[rows], opposite[rows] = exact.thickness, exact.opposite
            best = min(best, float(exact.thickness.min(initial=np.inf)))
        return _Wall(thickness, self.points, opposite)

    def _around(self, middle: Array, reach: float) -> IntArray:
        """Facets with a bounding box that meets a cube."""
        meets = (self._low < middle[:, None] + reach) & (self._high > middle[:, None] - reach)
        return np.flatnonzero(meets.all(axis=0))

    def _nearest_mark(self, centers: Array) -> Array:
        found: Array = self._marks[self._tree.query(centers, workers=-1)[1]]
        return found

    def _nearest_of_few(self, centers: Array) -> Array:
        """Nearest points of the facets that the nearest few marks are on."""
        few = self._mark_facets[self._tree.query(centers, k=_FEW, workers=-1)[1]]
        return nearest_on_facets(centers, self.corners[few])[0]

    def _refined(self, row: int, thickness: float) -> _Wall:
        """Follow a wall to its thinnest point nearby, exactly on the facets."""
        place, normal = self.points[row], self.normals[self.facets[row]]
        step = np.linspace(-1.0, 1.0, _NET)
        net = np.stack(np.meshgrid(step, step), axis=-1).reshape(-1, 2)
        best = _Wall(np.array(np.inf), place, place)
        width = 2.0 * self.spacing
        for _ in range(_ROUNDS):
            # What a sphere at any point of the net can touch.
            near = self._around(place - 0.5 * thickness * normal, 0.55 * thickness + 2.0 * width)
            local, outward = Facets(self.corners[near]), self.normals[near]
            spread = place + width * net @ np.concatenate(tangent_frame(normal[None]))
            points, facets = local.nearest(spread)
            found = _walls(
                points,
                outward[facets],
                np.full(len(points), 1.1 * thickness),
                local.nearest_points,
            )
            row = int(found.thickness.argmin())
            if found.thickness[row] < best.thickness:
                best = _Wall(found.thickness[row], found.place[row], found.opposite[row])
                place, normal, thickness = best.place, outward[facets[row]], float(best.thickness)
            width *= _SHRINK
        return best


def _walls(
    points: Array,
    normals: Array,
    largest: Array,
    nearest: Callable[[Array], Array],
    astray_mm: float = 0.0,
) -> _Wall:
    """Shrink spheres that touch a surface from inside until nothing of it is within them.

    Args:
        points: Where they touch it, shape (n, 3).
        normals: Outward unit normals there, shape (n, 3).
        largest: Diameters to begin with, shape (n,).
        nearest: Gives the nearest points of the surface to points (k, 3).
        astray_mm: How far along the surface those may be from the true ones.
    """
    radius = 0.5 * largest
    touched = points.copy()
    rows = np.arange(len(points))
    for _ in range(_MOST_STEPS):
        centers = points[rows] - radius[rows, None] * normals[rows]
        found = nearest(centers)
        arm = points[rows] - found
        depth = np.vecdot(arm, normals[rows])
        within = (np.linalg.norm(found - centers, axis=1) < radius[rows] * (1.0 - _CONVERGED)) & (depth > 0.0)
        rows, arm = rows[within], arm[within]
        if len(rows) == 0:
            break
        touched[rows] = points[rows] - arm
        radius[rows] = np.vecdot(arm, arm) / (2.0 * depth[within])
    arm = points - touched
    depth = np.vecdot(arm, normals)
    beside = np.linalg.norm(arm - depth[:, None] * normals, axis=1)
    # A sphere that nothing shrinks tells of no wall, nor does one at an edge, where the other facet is.
    wall = (beside <= _FACING * depth + astray_mm) & (depth > _ROUNDING * largest)
    return _Wall(np.where(wall, 2.0 * radius, np.inf), points, touched)


def _thinnest(walls: _Wall, apart_mm: float) -> Iterator[int]:
    """Rows of the thinnest walls, the thinnest first, not too near to each other."""
    left = np.argsort(walls.thickness, kind="stable")[: int(np.isfinite(walls.thickness).sum())]
    while len(left):
        yield int(left[0])
        left = left[np.linalg.norm(walls.place[left] - walls.place[left[0]], axis=1) > apart_mm]

"""The landscape that a search looks at: valley, ridge, focal distances along them, and curvature.

The height of a body of this kind falls along valleys to its one rest, and rises along ridges to its one
unstable pose. Its focal surface comes near the centre of mass only there: the sheet of the larger curvature
along the valleys (S), the sheet of the smaller one along the ridges (U). Both are narrow, and a search soon
finds the bodies that a coarser look takes for better than they are. So the distances are taken where
they are least: every place of a grid that is the nearest among its neighbours, on its ring or on its
meridian, starts a descent, first across the valley and then along it. (With one start per ring, at its lowest
place, a search ended with a body whose margin it took for 0.0080 R₀ and which has 0.0013.)

Flat spots are broader, but as many; the places where the smaller curvature is least are refined likewise.

All bodies here are symmetric under a half-turn about x, so the northern half is enough.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from gomboc_cad.body.sphere import Array, BoolArray, lengths, tangent_frame, unit
from gomboc_cad.body.surface import Body
from gomboc_cad.equilibria.critical import critical_directions
from gomboc_cad.equilibria.margin import focal_points_mm
from gomboc_cad.errors import DegenerateEquilibriaError

RINGS = 90
MERIDIANS = 120
_ACROSS_STEPS, _ALONG_STEPS = 4, 8
_REACH = 3.0
_FARTHEST_START = 0.1
_DECIMALS = 3
_DIFFERENCE = 1e-5
_LONGEST_STEP = 0.05
_FLATTEST, _REFINED = 250, 40
_NEWTON_STEPS = 6
_STENCIL_STEP = 1e-3
_STENCIL = _STENCIL_STEP * np.array(
    [(1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1)], dtype=np.float64
)
_REST, _TOP = np.array([[-1.0, 0.0, 0.0]]), np.array([[1.0, 0.0, 0.0]])


@dataclass(frozen=True, eq=False)
class Landscape:
    """What a search needs to know of a body that is symmetric under a half-turn about x.

    Lengths are in mm.

    Attributes:
        flat: Places where the smaller principal curvature is small, all local minima among them, (n, 3).
        curvature_per_mm: The smaller principal curvature at `flat`, shape (n,).
        valley: Places where the sheet S is near to the COM, all local minima among them, shape (n, 3).
        ridge: The same for the sheet U.
        s_distance_mm: Distance of the sheet S at `valley`, shape (n,).
        u_distance_mm: Distance of the sheet U at `ridge`.
        height_range_mm: Height of the COM in the unstable pose less that at rest.
        stiffness_mm: Soft stiffness of the rest.
    """

    flat: Array
    curvature_per_mm: Array
    valley: Array
    ridge: Array
    s_distance_mm: Array
    u_distance_mm: Array
    height_range_mm: float
    stiffness_mm: float

    @property
    def min_curvature_per_mm(self) -> float:
        """Smallest principal curvature."""
        return float(self.curvature_per_mm.min())

    @property
    def margin_mm(self) -> float:
        """The smaller of the two margins."""
        return float(min(self.s_distance_mm.min(), self.u_distance_mm.min()))


@lru_cache(maxsize=1)
def ring_directions() -> Array:
    """Unit vectors of the rings from near the north pole to the equator, shape (rings, meridians, 3)."""
    theta = 0.5 * np.pi * np.arange(1, RINGS + 1)[:, None] / RINGS
    phi = 2.0 * np.pi * np.arange(MERIDIANS)[None, :] / MERIDIANS
    theta, phi = np.broadcast_arrays(theta, phi)
    return np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], axis=-1)


def survey(body: Body, com_mm: Array) -> Landscape | None:
    """Look at a body about its COM; None if it is not strictly convex with two poses, a rest and a top."""
    rings = ring_directions()
    points = body.surface(rings.reshape(-1, 3))
    curvatures = points.principal_curvatures_per_mm()
    if curvatures.min() <= 0.0 or not _has_two_poses(body, com_mm):
        return None
    from_com = points.position_mm - com_mm
    places, distances = [], []
    for sheet in (0, 1):
        focal = from_com - points.normal / curvatures[:, sheet, None]
        near = _nearest_among_neighbours(
            np.linalg.norm(focal, axis=1).reshape(rings.shape[:2]), body.radius_mm
        )
        found, distance = _nearest_places(body, com_mm, rings[near], sheet)
        places.append(found)
        distances.append(distance)
    flat, curvature = _flat_spots(body, rings, curvatures[:, 1].reshape(rings.shape[:2]))
    return Landscape(
        flat=flat,
        curvature_per_mm=curvature,
        valley=places[0],
        ridge=places[1],
        s_distance_mm=distances[0],
        u_distance_mm=distances[1],
        height_range_mm=height_range_mm(body, com_mm),
        stiffness_mm=stiffness_mm(body, com_mm),
    )


def height_range_mm(body: Body, com_mm: Array) -> float:
    """Height of the COM over the table at +x less that at −x, the two poses that the symmetry fixes."""
    top, rest = np.linalg.norm(body.position_mm(np.concatenate([_TOP, _REST])) - com_mm, axis=1)
    return float(top - rest)


def stiffness_mm(body: Body, com_mm: Array) -> float:
    """Soft stiffness at −x: how far the nearer centre of curvature lies over the COM."""
    return float(focal_points_mm(body, _REST, 0)[0, 0] - com_mm[0])


def _nearest_places(body: Body, com_mm: Array, directions: Array, sheet: int) -> tuple[Array, Array]:
    """Places where a sheet is near to the COM, with the distances, by descent from given directions."""
    across = _distinct(descended(body, com_mm, directions, sheet, _ACROSS_STEPS))
    distance = _focal_distance_mm(body, com_mm, across, sheet)
    near = distance < _REACH * distance.min()
    along = descended(body, com_mm, across[near], sheet, _ALONG_STEPS)
    found = _distinct(np.concatenate([along, across[near]]))
    distance = _focal_distance_mm(body, com_mm, found, sheet)
    near = distance < _REACH * distance.min()
    return found[near], distance[near]


def _focal_distance_mm(body: Body, com_mm: Array, directions: Array, sheet: int) -> Array:
    return lengths(focal_points_mm(body, directions, sheet) - com_mm)


def descended(body: Body, com_mm: Array, directions: Array, sheet: int, steps: int) -> Array:
    """Unit vectors (n, 3) after steps of Levenberg and Marquardt towards the least focal distance of a sheet.

    Few steps lead into the valley, since the distance grows fast across it, and more of them along it.
    """
    u = directions
    offset = focal_points_mm(body, u, sheet) - com_mm
    damping = np.full(len(u), 1e-3)
    for _ in range(steps):
        frame = body.radial_jet(u).frame
        probes = unit(u[:, None, None] + _DIFFERENCE * np.stack([frame, -frame], axis=2))
        focal = focal_points_mm(body, probes.reshape(-1, 3), sheet).reshape(len(u), 2, 2, 3)
        jacobian = (focal[:, :, 0] - focal[:, :, 1]) / (2.0 * _DIFFERENCE)
        normal_matrix = jacobian @ jacobian.transpose(0, 2, 1)
        normal_matrix[:, [0, 1], [0, 1]] *= 1.0 + damping[:, None]
        normal_matrix[:, [0, 1], [0, 1]] += 1e-12 * body.radius_mm**2
        step = -np.linalg.solve(normal_matrix, jacobian @ offset[:, :, None])[:, :, 0]
        step *= np.minimum(1.0, _LONGEST_STEP / np.maximum(np.linalg.norm(step, axis=1), 1e-300))[:, None]
        trial = unit(u + np.einsum("na,nax->nx", step, frame))
        trial_offset = focal_points_mm(body, trial, sheet) - com_mm
        better = np.linalg.norm(trial_offset, axis=1) < np.linalg.norm(offset, axis=1)
        u = np.where(better[:, None], trial, u)
        offset = np.where(better[:, None], trial_offset, offset)
        damping = np.where(better, 0.3 * damping, 10.0 * damping)
    return u


def _nearest_among_neighbours(distances: Array, radius_mm: float) -> BoolArray:
    """Whether a place is nearer than both neighbours on its ring or on its meridian, and near at all."""
    on_ring, on_meridian = _least_among_neighbours(distances)
    return (on_ring | on_meridian) & (distances < _FARTHEST_START * radius_mm)


def _least_among_neighbours(values: Array) -> tuple[BoolArray, BoolArray]:
    """Whether a value of the rings is at most that of both neighbours on its ring, and on its meridian."""
    before, after = np.roll(values, 1, axis=1), np.roll(values, -1, axis=1)
    # Beyond the equator lies the image of the ring before it, and the pole is left to the ring around it.
    beyond = np.roll(values[-2, ::-1], 1)
    north, south = np.vstack([values[:1], values[:-1]]), np.vstack([values[1:], beyond])
    return (values <= before) & (values <= after), (values <= north) & (values <= south)


def _flat_spots(body: Body, rings: Array, curvatures: Array) -> tuple[Array, Array]:
    """The flattest places of the rings and, refined, the least among neighbours, with their curvatures."""
    on_ring, on_meridian = _least_among_neighbours(curvatures)
    flattest = np.argsort(curvatures, axis=None, kind="stable")[:_FLATTEST]
    places, values = rings.reshape(-1, 3)[flattest], curvatures.ravel()[flattest]
    least = np.flatnonzero((on_ring | on_meridian).ravel()[flattest])[:_REFINED]
    refined, lower = _flattened(body, places[least], values[least])
    return np.concatenate([places, refined]), np.concatenate([values, lower])


def _flattened(body: Body, directions: Array, curvatures: Array) -> tuple[Array, Array]:
    """Unit vectors (n, 3) and their curvatures (n,) after Newton steps towards less curvature."""

    def smaller_curvature(places: Array) -> Array:
        flat = body.surface(places.reshape(-1, 3)).principal_curvatures_per_mm()[:, 1]
        return flat.reshape(places.shape[:-1])

    u, lowest = directions, curvatures
    reach = np.full(len(u), _LONGEST_STEP)
    for _ in range(_NEWTON_STEPS):
        frame = np.stack(tangent_frame(u), axis=1)
        around = smaller_curvature(unit(u[:, None] + _STENCIL @ frame))
        gradient, hessian = _stencil_derivatives(around, lowest)
        values, vectors = np.linalg.eigh(hessian)
        # Downhill along a direction in which the curvature bends down, too.
        along = np.einsum("nai,na->ni", vectors, gradient) / np.maximum(np.abs(values), 1e-6)
        step = -np.einsum("nai,ni->na", vectors, along)
        step *= np.minimum(1.0, reach / np.maximum(np.linalg.norm(step, axis=1), 1e-300))[:, None]
        trial = unit(u + np.einsum("na,nax->nx", step, frame))
        there = smaller_curvature(trial)
        better = there < lowest
        u, lowest = np.where(better[:, None], trial, u), np.where(better, there, lowest)
        reach = np.where(better, reach, 0.3 * reach)
    return u, lowest


def _stencil_derivatives(around: Array, middle: Array) -> tuple[Array, Array]:
    """Gradients (n, 2) and Hessians (n, 2, 2) from values on `_STENCIL` (n, 8) and in its middle (n,)."""
    east, north_east, north, north_west, west, south_west, south, south_east = around.T
    gradient = np.stack([east - west, north - south], axis=1) / (2.0 * _STENCIL_STEP)
    mixed = 0.25 * (north_east - north_west + south_west - south_east)
    hessian = np.stack([east - 2.0 * middle + west, mixed, mixed, north - 2.0 * middle + south], axis=1)
    return gradient, hessian.reshape(-1, 2, 2) / _STENCIL_STEP**2


def _distinct(directions: Array) -> Array:
    """One of each group of unit vectors (n, 3) that are nearly the same."""
    _, first = np.unique(np.round(directions, _DECIMALS), axis=0, return_index=True)
    result: Array = directions[np.sort(first)]
    return result


def _has_two_poses(body: Body, com_mm: Array) -> bool:
    """Whether the height has two critical points only, which are its minimum and its maximum."""
    try:
        return len(critical_directions(body, com_mm)) == 2
    except DegenerateEquilibriaError:
        return False

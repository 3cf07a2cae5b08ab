"""Mass integrals: of a homogeneous body by Gauss–Legendre quadrature, of a polyhedron exactly."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from gomboc_cad.body.sphere import Array, IntArray, cross
from gomboc_cad.body.surface import Body
from gomboc_cad.errors import BodyError

RELATIVE_TOLERANCE = 1e-12
"""Two successive quadratures must agree this well before a result is given."""

_MAX_ORDER = 1024


@dataclass(frozen=True)
class MassProperties:
    """Mass properties of a homogeneous solid of unit density.

    Attributes:
        volume_mm3: Volume.
        com_mm: Centre of mass (x, y, z), which is the centroid.
        inertia_mm5: Inertia tensor about the centre of mass, as nested rows.
    """

    volume_mm3: float
    com_mm: tuple[float, float, float]
    inertia_mm5: tuple[tuple[float, float, float], ...]

    @classmethod
    def from_arrays(cls, volume_mm3: float, com_mm: Array, inertia_mm5: Array) -> MassProperties:
        """Make the record from arrays of shape (3,) and (3, 3)."""
        x, y, z = (float(c) for c in com_mm)
        rows = tuple((float(a), float(b), float(c)) for a, b, c in inertia_mm5)
        return cls(float(volume_mm3), (x, y, z), rows)


def sphere_quadrature(order: int) -> tuple[Array, Array]:
    """Product rule with `order` Gauss nodes in θ and 2·`order` equal steps in φ.

    The nodes are taken in θ and not in cosθ, so that integrands which are analytic in θ alone
    (Sloan 1 is not smooth in cosθ at the poles) converge exponentially.

    Returns:
        Directions, shape (2·order², 3), and weights that sum to 4π.
    """
    nodes, gauss = np.polynomial.legendre.leggauss(order)
    theta = 0.5 * np.pi * (nodes + 1.0)
    phi = np.pi * (np.arange(2 * order) + 0.5) / order
    sine, cosine = np.sin(theta), np.cos(theta)
    grid = np.stack(
        [np.outer(sine, np.cos(phi)), np.outer(sine, np.sin(phi)), np.outer(cosine, np.ones_like(phi))],
        axis=-1,
    )
    weights = np.outer(0.5 * np.pi * gauss * sine, np.full(2 * order, np.pi / order))
    return grid.reshape(-1, 3), weights.ravel()


@lru_cache(maxsize=64)
def mass_properties(body: Body) -> MassProperties:
    """Integrate volume `∫r³/3`, first moment `∫r⁴u/4` and second moment `∫r⁵uuᵀ/5` over the sphere.

    The order is doubled until two successive results agree to 1e-12.

    Raises:
        BodyError: If the quadrature does not settle, which means coefficients of absurd order.
    """
    order = 32
    previous = _moments(body, order)
    while order < _MAX_ORDER:
        order *= 2
        current = _moments(body, order)
        if np.all(np.abs(current - previous) <= RELATIVE_TOLERANCE * current[0]):
            return _from_moments(current, body.radius_mm)
        previous = current
    raise BodyError(
        f"The mass integrals of {body.name!r} do not converge; use lower orders or smaller coefficients."
    )


def _moments(body: Body, order: int) -> Array:
    """Zeroth, first and second moments with R₀ = 1, as 10 numbers."""
    directions, weights = sphere_quadrature(order)
    r = body.radius_at(directions) / body.radius_mm
    first = (weights * r**4 / 4.0) @ directions
    second = np.einsum("n,ni,nj->ij", weights * r**5 / 5.0, directions, directions, optimize=True)
    return np.concatenate([[weights @ r**3 / 3.0], first, second[np.triu_indices(3)]])


def _from_moments(moments: Array, radius_mm: float) -> MassProperties:
    volume = moments[0]
    centroid = moments[1:4] / volume
    second = np.empty((3, 3))
    second[np.triu_indices(3)] = moments[4:]
    second.T[np.triu_indices(3)] = moments[4:]
    central = second - volume * np.outer(centroid, centroid)
    inertia = (np.trace(central) * np.eye(3) - central) * radius_mm**5
    return MassProperties.from_arrays(float(volume) * radius_mm**3, centroid * radius_mm, inertia)


def is_closed_mesh(faces: IntArray, count: int) -> bool:
    """Whether each directed edge of a triangle mesh has one partner that runs back.

    Args:
        faces: Indices of corners, shape (m, 3).
        count: Number of vertices.
    """
    start, end = faces.ravel(), np.roll(faces, -1, axis=1).ravel()
    if len(start) % 2:
        return False
    # An edge and its partner differ in the last bit only, so they are neighbours in order.
    keys = 2 * (np.minimum(start, end) * count + np.maximum(start, end)) + (start > end)
    keys.sort()
    forth, back = keys[0::2], keys[1::2]
    return bool(np.all((forth % 2 == 0) & (back == forth + 1)) and np.all(np.diff(forth) > 0))


def mesh_mass(vertices_mm: Array, faces: IntArray) -> MassProperties:
    """Integrate exactly over the polyhedron that a closed, outward oriented mesh bounds.

    Args:
        vertices_mm: Shape (n, 3).
        faces: Shape (m, 3).
    """
    # Tetrahedra from a point amid the mesh lose fewer digits than from a distant origin.
    pivot = vertices_mm.mean(axis=0)
    corners = (vertices_mm - pivot)[faces]
    six_volumes = np.einsum("nx,nx->n", corners[:, 0], cross(corners[:, 1], corners[:, 2]))
    volume = six_volumes.sum() / 6.0
    total = corners.sum(axis=1)
    centroid = six_volumes @ total / (24.0 * volume)
    second = np.einsum("n,ni,nj->ij", six_volumes, total, total, optimize=True)
    second += np.einsum("n,nai,naj->ij", six_volumes, corners, corners, optimize=True)
    second = second / 120.0 - volume * np.outer(centroid, centroid)
    inertia = np.trace(second) * np.eye(3) - second
    return MassProperties.from_arrays(float(volume), centroid + pivot, inertia)

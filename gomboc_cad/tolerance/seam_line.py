"""The seam of the nominal body, and the rims of the two halves as made."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from gomboc_cad.body import Body
from gomboc_cad.body.sphere import Array, BoolArray, IntArray, tangent_frame, unit
from gomboc_cad.equilibria.rim import mouths_mm
from gomboc_cad.tolerance.made_bodies import MadeBodies
from gomboc_cad.tolerance.support_grid import linear_jets
from gomboc_cad.tolerance.surface_frames import SurfaceFrames
from gomboc_cad.tolerance.variants import SeamPlane

_STATIONS = 360
_RIM_STEPS = 8
_FEW_RIM_STEPS = 4
"""Steps to a point of the rim from its station, and from where it was a moment ago."""


@dataclass(frozen=True, eq=False)
class SeamLine:
    """Stations along the seam of the nominal body, in order around the upward normal of its plane.

    Attributes:
        plane: The parting plane.
        directions: Surface parameters w, shape (m, 3).
        frames: Surface there; first tangent vector along the seam, second one across it and upwards.
        linear: Slope and Hessian for each coordinate of a variant, float32, shape (D, 5, m).
    """

    plane: SeamPlane
    directions: Array
    frames: SurfaceFrames
    linear: NDArray[np.float32]


@lru_cache(maxsize=4)
def seam_line(body: Body, com_mm: tuple[float, float, float], plane: SeamPlane, degree: int) -> SeamLine:
    """Stations along the seam, at equal angles about the place of its plane nearest to the origin.

    That point has to be inside the body.
    """
    normal = np.array(plane.normal)
    middle = float(normal @ np.array(plane.origin_mm)) * normal
    angles = 2.0 * np.pi * np.arange(_STATIONS) / _STATIONS
    first = tangent_frame(normal[None])[0]
    second = np.cross(normal, first)
    rays = np.cos(angles)[:, None] * first + np.sin(angles)[:, None] * second
    directions = unit(mouths_mm(body, middle, rays))
    frames = SurfaceFrames.at(body, directions, np.array(com_mm)).along(normal)
    linear = linear_jets(frames, np.zeros(_STATIONS), degree)
    return SeamLine(plane, directions, frames, linear.astype(np.float32))


@dataclass(frozen=True, eq=False)
class RimPoints:
    """Points of rims that are farthest along given directions.

    Attributes:
        direction: Their surface parameters w, shape (k, 3).
        arm: From the COM to them, as made, shape (3, k).
        normal: The given directions as made, shape (3, k).
    """

    direction: Array
    arm: Array
    normal: Array

    @classmethod
    def farthest(
        cls,
        line: SeamLine,
        bodies: MadeBodies,
        row: IntArray,
        normals: Array,
        upper: BoolArray,
        start: Array | None = None,
    ) -> RimPoints:
        """Points of the rims of halves that are farthest along normals v (k, 3) before the stretch.

        There the surface normal lies in the plane of the given one and of the parting. The steps are Newton's
        but for the form error, whose curvature is left out.
        """
        m, origin = np.array(line.plane.normal), np.array(line.plane.origin_mm)
        steps = _RIM_STEPS if start is None else _FEW_RIM_STEPS
        direction = start
        if direction is None:
            direction = line.directions[scalar_products(normals, line.frames.position).argmax(axis=1)]
        side = np.cross(m, normals)
        for _ in range(steps):
            surface = bodies.body.surface(direction)
            one, two = surface.tangents.transpose(1, 0, 2)
            form = bodies.form.jets(row, surface.normal, surface.tangents)[:3, :, None]
            point = surface.position_mm + form[0] * surface.normal + form[1] * one + form[2] * two
            above = ((point - origin) * m).sum(axis=1)
            askew = (surface.normal * side).sum(axis=1)
            z1, z2 = (one * m).sum(axis=1), (two * m).sum(axis=1)
            s1, s2 = (one * side).sum(axis=1), (two * side).sum(axis=1)
            k = surface.shape_operator_per_mm
            t1, t2 = k[:, 0, 0] * s1 + k[:, 1, 0] * s2, k[:, 0, 1] * s1 + k[:, 1, 1] * s2
            determinant = z1 * t2 - z2 * t1
            x1, x2 = (z2 * askew - t2 * above) / determinant, (t1 * above - z1 * askew) / determinant
            direction = unit(surface.position_mm + x1[:, None] * one + x2[:, None] * two)
        return cls(direction, *bodies.arms(row, point, normals, upper))


def scalar_products(vectors: Array, others: Array) -> Array:
    """Scalar products of vectors (n, 3) and others (m, 3), added up in one order for all, shape (n, m)."""
    x, y, z = vectors.T
    a, b, c = others.T
    result: Array = x[:, None] * a + y[:, None] * b + z[:, None] * c
    return result

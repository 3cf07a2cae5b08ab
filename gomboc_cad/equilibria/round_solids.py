"""Exact equilibria of sphere, capsule and cylinder about any centre of mass, and the shape of an ellipsoid.

The height of the COM over the table when u points down is the support function about it, `max (x − c)·u`. It
has a kink wherever the solid touches the table along a line or a face, so the smooth census does not apply to
capsule and cylinder; their poses follow from the nearest and the farthest line, rim and cap. The ellipsoid is
smooth: with its shape function it is a body like any other.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from gomboc_cad.body.families import AmbientJet
from gomboc_cad.body.sphere import Array
from gomboc_cad.equilibria.convexity import as_point
from gomboc_cad.equilibria.records import Equilibrium, Extent, Kind, Vector, as_vector
from gomboc_cad.errors import CensusError, DegenerateEquilibriaError

_UP = np.array([0.0, 0.0, 1.0])


@dataclass(frozen=True)
class EllipsoidShape:
    """The shape function `f = ((uᵀ D u)⁻² − 1)/4`, D = diag(1/a²), of an ellipsoid.

    Attributes:
        semi_axes: Semi-axes in units of the nominal radius.
    """

    semi_axes: Vector

    @property
    def family(self) -> str:
        """Name of the family."""
        return "ellipsoid"

    def ambient_jet(self, directions: Array) -> AmbientJet:
        """Evaluate at unit vectors (n, 3)."""
        d = 1.0 / np.array(self.semi_axes) ** 2
        along = directions * d
        s = np.einsum("nx,nx->n", directions, along)[:, None]
        outer = along[:, :, None] * along[:, None, :]
        hessian = 6.0 * outer / s[:, :, None] ** 4 - np.diag(d) / s[:, :, None] ** 3
        return AmbientJet(0.25 * (s[:, 0] ** -2.0 - 1.0), -along / s**3, hessian)


def sphere_equilibria(radius_mm: float, com: Sequence[float] | Array) -> tuple[Equilibrium, ...]:
    """Equilibria of a sphere about the origin: one stable, however little the COM is off the centre.

    Raises:
        CensusError: If the COM is not inside.
    """
    c = as_point(com)
    off = float(np.linalg.norm(c))
    _require(off < radius_mm)
    if off == 0.0:
        return (_at("stable", _UP, radius_mm, "sphere"),)
    return _at("stable", c, radius_mm - off), _at("unstable", -c, radius_mm + off)


def capsule_equilibria(
    radius_mm: float, length_mm: float, com: Sequence[float] | Array
) -> tuple[Equilibrium, ...]:
    """Equilibria of a capsule about the origin along z, the lowest first.

    With the straight part L it has `h = r + (L/2) |u_z| − c·u`. It lies on its side while the COM is between
    the centres of the caps, on the line that is nearest to the COM; with the COM on the axis on any line.

    Args:
        radius_mm: Radius r of the caps.
        length_mm: Length L of the straight part.
        com: Centre of mass, shape (3,).

    Raises:
        CensusError: If the COM is not inside.
        DegenerateEquilibriaError: If it is level with the centre of a cap.
    """
    c, half = as_point(com), 0.5 * length_mm
    _require(float(np.linalg.norm(c - np.clip(c[2], -half, half) * _UP)) < radius_mm)
    if abs(c[2]) == half:
        raise DegenerateEquilibriaError(
            "The centre of mass is level with the centre of a cap, where the capsule is neutral; move it."
        )
    found: list[Equilibrium] = []
    if abs(c[2]) < half:
        found += _line_contacts(radius_mm, c)
    for end in (half, -half):
        arm = c - end * _UP
        off = float(np.linalg.norm(arm))
        if arm[2] * end > 0.0:
            found.append(_at("stable", arm, radius_mm - off))
        else:
            found.append(_at("unstable", -arm, radius_mm + off))
    return _sorted(found)


def cylinder_equilibria(
    radius_mm: float, length_mm: float, com: Sequence[float] | Array
) -> tuple[Equilibrium, ...]:
    """Equilibria of a right circular cylinder about the origin along z, the lowest first.

    Args:
        radius_mm: Radius.
        length_mm: Length.
        com: Centre of mass, shape (3,).

    Raises:
        CensusError: If the COM is not inside.
    """
    c, half = as_point(com), 0.5 * length_mm
    across = c * (1.0, 1.0, 0.0)
    off = float(np.linalg.norm(across))
    _require(off < radius_mm and abs(c[2]) < half)
    found = _line_contacts(radius_mm, c)
    for end in (half, -half):
        found.append(_at("stable", end * _UP, half - np.sign(end) * c[2]))
        outwards = across / off if off > 0.0 else np.array([1.0, 0.0, 0.0])
        near, far = (side * radius_mm * outwards + end * _UP - c for side in (1.0, -1.0))
        if off == 0.0:
            found.append(_at("unstable", near, float(np.linalg.norm(near)), "ring"))
        else:
            found.append(_at("saddle", near, float(np.linalg.norm(near))))
            found.append(_at("unstable", far, float(np.linalg.norm(far))))
    return _sorted(found)


def _line_contacts(radius_mm: float, com: Array) -> list[Equilibrium]:
    """Poses on the straight side of a body of revolution: nearest and farthest line, or all of them."""
    across = com * (1.0, 1.0, 0.0)
    off = float(np.linalg.norm(across))
    if off == 0.0:
        return [_at("stable", np.array([1.0, 0.0, 0.0]), radius_mm, "ring")]
    return [_at("stable", across, radius_mm - off), _at("saddle", -across, radius_mm + off)]


def _at(kind: Kind, toward: Array, height_mm: float, extent: Extent = "point") -> Equilibrium:
    return Equilibrium(kind, as_vector(toward / np.linalg.norm(toward)), float(height_mm), extent=extent)


def _sorted(found: list[Equilibrium]) -> tuple[Equilibrium, ...]:
    return tuple(sorted(found, key=lambda pose: pose.height_mm))


def _require(inside: bool) -> None:
    if not inside:
        raise CensusError("The centre of mass lies outside the solid; give one inside it.")

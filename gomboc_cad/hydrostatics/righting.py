"""The curve of righting arms: what a floating part does when it is heeled and let go."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Self

import numpy as np

from gomboc_cad.body.sphere import Array, IntArray, unit
from gomboc_cad.equilibria.records import Vector, as_vector
from gomboc_cad.hydrostatics.state import floating_landscape, state_at
from gomboc_cad.hydrostatics.water import SEA_WATER, Water

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_STEP_DEG = 5.0


@dataclass(frozen=True, eq=False)
class RightingCurve:
    """Righting arms of a part that is heeled about a fixed axis, at heave equilibrium at every angle.

    The arm is the derivative by the angle (in rad) of the height of the COM over the centre of buoyancy: it
    is positive where weight and buoyancy turn the part back. They may turn it out of its plane as well.

    Attributes:
        up: Body direction that points up at no heel.
        axes: Body directions of the axes, the easier one first; they are right-handed.
        heel_deg: Angles from 0 to 180, shape (n,).
        righting_arm_mm: Arms about each of the axes, shape (2, n).
    """

    up: Vector
    axes: tuple[Vector, Vector]
    heel_deg: Array
    righting_arm_mm: Array

    def document(self) -> dict[str, Any]:
        """As it is stored."""
        return {
            "up": list(self.up),
            "axes": [list(axis) for axis in self.axes],
            "heel_deg": self.heel_deg.tolist(),
            "righting_arm_mm": self.righting_arm_mm.tolist(),
        }

    @classmethod
    def of_document(cls, document: Mapping[str, Any]) -> Self:
        """Read what is stored."""
        easier, harder = (as_vector(np.array(axis)) for axis in document["axes"])
        heel, arms = (np.array(document[key], dtype=float) for key in ("heel_deg", "righting_arm_mm"))
        return cls(as_vector(np.array(document["up"])), (easier, harder), heel, arms)

    def plot(self, ax: Axes | None = None) -> Axes:
        """Draw the righting arms against the angle of heel.

        Args:
            ax: Axes to draw on; new ones if not given.

        Returns:
            The axes.
        """
        from gomboc_cad.report.floating_figures import plot_righting

        return plot_righting(self, ax)


def righting_curve(
    vertices: Array,
    faces: IntArray,
    mass_g: float,
    com_mm: Sequence[float] | Array,
    up: Sequence[float] | Array,
    water: Water = SEA_WATER,
    *,
    step_deg: float = _STEP_DEG,
) -> RightingCurve:
    """Heel a part about both principal axes of its waterplane, all the way round to upside down.

    Args:
        vertices: Corners of the outer surface in mm, shape (n, 3).
        faces: Indices of the corners of each triangle, counter-clockwise from outside, shape (m, 3).
        mass_g: Mass of the part with all that it carries.
        com_mm: Its centre of mass, shape (3,).
        up: Body direction that points up at no heel, of any length, shape (3,).
        water: What it floats in.
        step_deg: Between the angles.

    Raises:
        GeometryError: As `floating_state`.
    """
    landscape = floating_landscape(vertices, faces, mass_g, com_mm, water)
    upright = unit(np.asarray(up, dtype=float))
    axes = state_at(landscape, upright, mass_g, water).heel_axes
    heel = np.linspace(0.0, 180.0, 1 + round(180.0 / step_deg))
    turn = np.radians(heel)[:, None]
    arms = []
    for axis in axes:
        # Heeling by an angle φ about the axis turns what points up by −φ in the body.
        aside = np.cross(upright, axis)
        jet = landscape.jet(np.cos(turn) * upright + np.sin(turn) * aside)
        onwards = np.cos(turn) * aside - np.sin(turn) * upright
        arms.append(np.einsum("ka,kax,kx->k", jet.gradient_mm, jet.immersion.frame, onwards))
    return RightingCurve(as_vector(upright), axes, heel, np.array(arms))

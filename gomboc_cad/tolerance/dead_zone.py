"""Where rolling resistance holds a body: around each equilibrium, as far as the slope of its height is small.

With a rolling-resistance length b a body stays wherever `|∇f| ≤ b`. Around an equilibrium `∇f = K δu` to
first order, K being its stiffness, so that the dead zone reaches b/|k| along each principal direction. Around
the stable rest it is the spread of the final rest; around an unstable pose it is how far askew the body has
to be put for it to leave.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from gomboc_cad.body.sphere import Array
from gomboc_cad.equilibria.records import Equilibrium, Kind, Vector


def half_width_deg(rolling_mm: float, stiffness_mm: Array) -> Array:
    """First order b/|k| of the half-width of a dead zone, at most 180, of any shape; NaN where k is.

    A sphere whose COM is lowered by s has the stiffness s and in truth the half-width arcsin(b/s).
    """
    stiffness = np.abs(stiffness_mm)
    # Beyond half a turn the first order means nothing, and a stiffness of zero would overflow.
    moves = math.pi * stiffness > rolling_mm
    angle: Array = np.divide(rolling_mm, stiffness, out=np.full(stiffness.shape, math.pi), where=moves)
    angle[np.isnan(stiffness)] = np.nan
    return np.degrees(angle)


@dataclass(frozen=True)
class DeadZone:
    """The surroundings of an equilibrium in which rolling resistance holds the body.

    Attributes:
        kind: Kind of the equilibrium.
        direction: Body direction that points down there.
        half_width_deg: Half-widths along the two principal directions, the wider first.
    """

    kind: Kind
    direction: Vector
    half_width_deg: tuple[float, float]


def dead_zones(equilibria: Sequence[Equilibrium], rolling_mm: float) -> tuple[DeadZone, ...]:
    """The dead zones of the equilibria of a smooth census, to first order, in their order.

    Args:
        equilibria: With their stiffness.
        rolling_mm: Rolling-resistance length b.
    """
    found = []
    for equilibrium in equilibria:
        if equilibrium.stiffness_mm is None:
            raise ValueError("an equilibrium of a polyhedron has no stiffness")
        narrow, wide = sorted(half_width_deg(rolling_mm, np.array(equilibrium.stiffness_mm)).tolist())
        found.append(DeadZone(equilibrium.kind, equilibrium.direction, (wide, narrow)))
    return tuple(found)

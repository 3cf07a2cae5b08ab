"""Frozen records of a body that moves on a table."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Self

import numpy as np

from gomboc_cad.body import Body, mass_properties
from gomboc_cad.body.sphere import Array
from gomboc_cad.equilibria.records import Equilibrium, Vector, as_vector
from gomboc_cad.errors import CensusError

GRAVITY_MM_S2 = 9806.65
"""Standard gravity, by definition of the 3rd General Conference on Weights and Measures (1901)."""


@dataclass(frozen=True)
class RollingBody:
    """A rigid body with a smooth, strictly convex surface and any distribution of mass.

    Its mass cancels from all motion on a table and is not needed.

    Attributes:
        body: The surface.
        com_mm: Centre of mass.
        gyration_mm2: Inertia tensor about the COM over the mass, as rows.
    """

    body: Body
    com_mm: Vector
    gyration_mm2: tuple[Vector, Vector, Vector]

    @classmethod
    def homogeneous(cls, body: Body) -> Self:
        """The body filled with one material."""
        return cls.ballasted(body, 0.0, (0.0, 0.0, 0.0))

    @classmethod
    def ballasted(cls, body: Body, fraction: float, place_mm: Vector) -> Self:
        """The homogeneous body with the part `fraction` of the total mass in a point.

        This is the law by which the source paper moves the COM: `c = (1 − w) c₀ + w v`.

        Raises:
            CensusError: If the fraction is not in 0 ≤ w < 1.
        """
        if not 0.0 <= fraction < 1.0:
            raise CensusError(
                f"The fraction of the ballast must be at least 0 and below 1, not {fraction!r}."
            )
        mass = mass_properties(body)
        centroid, place = np.array(mass.com_mm), np.array(place_mm, dtype=float)
        gyration = (1.0 - fraction) * np.array(mass.inertia_mm5) / mass.volume_mm3
        # Two masses about their common COM are the reduced mass on their distance.
        gyration += fraction * (1.0 - fraction) * _point_inertia(place - centroid)
        com = (1.0 - fraction) * centroid + fraction * place
        first, second, third = (as_vector(row) for row in gyration)
        return cls(body, as_vector(com), (first, second, third))


def _point_inertia(arm: Array) -> Array:
    """Inertia tensor of a unit mass at the end of an arm (3,)."""
    result: Array = (arm @ arm) * np.eye(3) - np.outer(arm, arm)
    return result


@dataclass(frozen=True)
class Resistance:
    """What takes energy out of rolling.

    Attributes:
        rolling_mm: Rolling-resistance length b: the patch of contact holds against turning with the moment
            `N b`, N being its load, in whatever direction the body turns. A body at rest stays there wherever
            `|∇h| ≤ b`. Steel on steel has about 0.005 to 0.01 mm, a hard plastic on a table ten times that.
        damping_per_s: Rate γ at which a viscous moment takes the angular momentum about the contact away; a
            small oscillation decays as exp(−γ t/2).
    """

    rolling_mm: float = 0.0
    damping_per_s: float = 0.0

    def __post_init__(self) -> None:
        """Raise CensusError if a figure is negative or no number."""
        for name, value in (("rolling-resistance length", self.rolling_mm), ("damping", self.damping_per_s)):
            if not 0.0 <= value < math.inf:
                raise CensusError(f"The {name} must be zero or more, not {value!r}.")


@dataclass(frozen=True, eq=False)
class Trajectory:
    """A body that rolls on a table without slipping, at k instants.

    Attributes:
        times_s: Shape (k,).
        down: Body direction that points down, shape (k, 3).
        turn: Quaternion (x, y, z, w) that takes body coordinates to those of the table, z up, shape (k, 4).
        angular_velocity_rad_s: In body coordinates, shape (k, 3).
        com_mm: Place of the COM over the table, z = 0 being its surface, shape (k, 3).
        energy_mm: Kinetic and potential energy over the weight, shape (k,).
        load: Force of the table on the body across it, over the weight, shape (k,).
        friction: Force along the table over that across it, shape (k,): no slip needs a coefficient of
            friction at least as large.
        slope_mm: `|∇h|`, the moment of the weight about the contact over the weight, shape (k,).
        stopped: Whether the body has come to rest at the last instant.
        drift_rad: Largest angle by which the errors of integration turn the normal at the contact away from
            straight down.
        drift_mm: Largest distance by which they lift the contact off the table.
    """

    times_s: Array
    down: Array
    turn: Array
    angular_velocity_rad_s: Array
    com_mm: Array
    energy_mm: Array
    load: Array
    friction: Array
    slope_mm: Array
    stopped: bool
    drift_rad: float
    drift_mm: float

    @property
    def stays_on_table(self) -> bool:
        """Whether the table only ever pushes, so that the assumption of contact holds."""
        return bool(self.load.min() > 0.0)


@dataclass(frozen=True, eq=False)
class Righting:
    """Releases at rest from n orientations.

    Attributes:
        start: Body direction that points down at first, shape (n, 3).
        end: The same where the body stops, shape (n, 3).
        stopped: Whether it stops within the time that was simulated, shape (n,).
        rest_time_s: When it stops; infinite if it does not, shape (n,).
        righting_time_s: From when on its tilt stays below `upright_deg`; infinite if it ends with more,
            shape (n,).
        tilt_deg: Angle between the end and the lowest rest, shape (n,).
        upright_deg: That tilt.
        friction: Coefficient of friction that no slip needs on the way, shape (n,).
        load: Smallest force of the table over the weight on the way, shape (n,); below 0 the body would lift
            off.
    """

    start: Array
    end: Array
    stopped: Array
    rest_time_s: Array
    righting_time_s: Array
    tilt_deg: Array
    upright_deg: float
    friction: Array
    load: Array


@dataclass(frozen=True, eq=False)
class DescentPath:
    """A quasi-static way down: so slow that the body always turns down the steepest slope of its height.

    Attributes:
        down: Body directions that point down on the way, shape (k, 3).
        height_mm: Heights of the COM, falling, shape (k,).
        length_rad: Length of the way on the sphere of directions.
        rest: The stable rest at its end.
    """

    down: Array
    height_mm: Array
    length_rad: float
    rest: Equilibrium


@dataclass(frozen=True)
class Basin:
    """The orientations that end in one rest.

    Attributes:
        rest: The rest.
        share: Part of the sphere of orientations.
        barrier_mm: How far the COM has to rise to leave it for another rest; to the highest pose if there is
            no other.
    """

    rest: Equilibrium
    share: float
    barrier_mm: float

"""Frozen records of floating."""

from __future__ import annotations

from dataclasses import dataclass

from gomboc_cad.body.sphere import Array
from gomboc_cad.equilibria.records import CensusVerdict, Extent, Kind, Vector
from gomboc_cad.hydrostatics.water import Water

STANDARD_GRAVITY_M_S2 = 9.80665
"""By definition of the 3rd General Conference on Weights and Measures (1901)."""


def energy_mj(mass_g: float, height_mm: float) -> float:
    """Energy in mJ that raises a mass by a height under standard gravity."""
    return 1e-3 * mass_g * STANDARD_GRAVITY_M_S2 * height_mm


@dataclass(frozen=True, eq=False)
class FloatingState:
    """A part that floats at heave equilibrium in one orientation, held there if need be.

    Attributes:
        up: Body direction that points up.
        water: What it floats in.
        displaced_volume_mm3: Volume below the water.
        reserve_buoyancy: Share of the volume that is above the water.
        draft_mm: Depth of the lowest point.
        freeboard_mm: Height of the highest point above the water.
        waterline_mm: Closed loops of the waterline in body coordinates, each of shape (k, 3); those around
            water inside others run clockwise from above.
        center_of_buoyancy_mm: Centroid of the displaced volume.
        center_of_flotation_mm: Centroid of the waterplane.
        waterplane_area_mm2: Area of the waterplane.
        second_moments_mm4: Principal second moments of the waterplane (smaller, larger).
        heel_axes: Body directions of the heel axes through the centre of flotation that belong to
            them: heeling about the first is the easier one.
        bm_mm: Metacentric radii (smaller, larger): second moment over displaced volume.
        gm_mm: Metacentric heights (smaller, larger): BM less the height of the COM over the centre of
            buoyancy.
        com_over_buoyancy_mm: Height of the COM over the centre of buoyancy: potential energy per weight.
        energy_mj: The same as an energy.
        righting_arm_mm: Horizontal distance between the COM and the centre of buoyancy; 0 at equilibrium.
        restoring_torque_n_mm: Torque of weight and buoyancy on the part, in body coordinates.
    """

    up: Vector
    water: Water
    displaced_volume_mm3: float
    reserve_buoyancy: float
    draft_mm: float
    freeboard_mm: float
    waterline_mm: tuple[Array, ...]
    center_of_buoyancy_mm: Vector
    center_of_flotation_mm: Vector
    waterplane_area_mm2: float
    second_moments_mm4: tuple[float, float]
    heel_axes: tuple[Vector, Vector]
    bm_mm: tuple[float, float]
    gm_mm: tuple[float, float]
    com_over_buoyancy_mm: float
    energy_mj: float
    righting_arm_mm: float
    restoring_torque_n_mm: Vector


@dataclass(frozen=True, eq=False)
class FloatingPose:
    """An orientation in which the part floats in equilibrium.

    Attributes:
        kind: `stable`, `unstable` or `saddle`.
        state: How it floats there.
        barrier_mm: How far the COM has to rise against the centre of buoyancy (for an unstable pose: sink)
            before the part passes to another equilibrium of the same kind; if there is no other, all the way
            to the opposite one. None for saddles.
        barrier_mj: The same as an energy.
        extent: `point`, or `ring` or `sphere` where the part floats neutrally all along one, up to the
            barrier of the census.
    """

    kind: Kind
    state: FloatingState
    barrier_mm: float | None = None
    barrier_mj: float | None = None
    extent: Extent = "point"

    @property
    def up(self) -> Vector:
        """Body direction that points up."""
        return self.state.up


@dataclass(frozen=True)
class FloatingEvidence:
    """What a floating census rests on.

    Attributes:
        orientations: Orientations at which the energy was computed.
        spacing_deg: Largest angle between neighbouring ones.
        resolution_mm: By how much the energy may differ, between them, from what they tell of it: estimated
            from the largest metacentric height.
        sag_mm: Bound on the distance between the mesh and the surface that it stands for.
        barrier_mm: Equilibria with a lower barrier were not counted.
        highest_uncounted_mm: Highest barrier among the stable poses that were not counted; None if all count.
        exact_stable: Stable poses found by Newton from every orientation near one, however low their
            barriers; None where the part floats neutrally.
        exact_saddles: The same for saddles.
        exact_unstable: The same for unstable poses.
    """

    orientations: int
    spacing_deg: float
    resolution_mm: float
    sag_mm: float
    barrier_mm: float
    highest_uncounted_mm: float | None
    exact_stable: int | None
    exact_saddles: int | None
    exact_unstable: int | None

    @property
    def complete(self) -> bool | None:
        """Whether these satisfy S − H + U = 2 (Poincaré–Hopf); None where they were not counted."""
        if self.exact_stable is None or self.exact_saddles is None or self.exact_unstable is None:
            return None
        return self.exact_stable - self.exact_saddles + self.exact_unstable == 2


@dataclass(frozen=True, eq=False)
class FloatingCensus:
    """All floating equilibria of a part, the lowest first.

    It is apart from the census on a flat floor: neither verdict says anything about the other.

    Attributes:
        water: What it floats in.
        mass_g: Mass of the part.
        com_mm: Its centre of mass.
        poses: The equilibria with a barrier above that of the evidence.
        energy_range_mm: Largest less smallest height of the COM over the centre of buoyancy.
        verdict: Whether there is one stable floating pose; `undecided` where that is not told.
        reason: One sentence for the verdict.
        evidence: Resolution and raw counts.
    """

    water: Water
    mass_g: float
    com_mm: Vector
    poses: tuple[FloatingPose, ...]
    energy_range_mm: float
    verdict: CensusVerdict
    reason: str
    evidence: FloatingEvidence

    def _count(self, kind: Kind) -> int:
        return sum(pose.kind == kind for pose in self.poses)

    @property
    def stable(self) -> int:
        """Number S of stable floating poses."""
        return self._count("stable")

    @property
    def unstable(self) -> int:
        """Number U of unstable floating poses."""
        return self._count("unstable")

    @property
    def saddles(self) -> int:
        """Number H of saddles."""
        return self._count("saddle")

    @property
    def depth_mm(self) -> float:
        """Barrier around the lowest pose: how far the COM must rise against the centre of buoyancy."""
        return next(pose.barrier_mm or 0.0 for pose in self.poses if pose.kind == "stable")

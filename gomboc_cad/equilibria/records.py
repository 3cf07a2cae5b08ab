"""Frozen records that the oracle hands on."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Literal

import numpy as np

from gomboc_cad.body.mass import MassProperties
from gomboc_cad.body.sphere import Array

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Kind = Literal["stable", "unstable", "saddle"]
Extent = Literal["point", "ring", "sphere"]
CensusVerdict = Literal["monostable", "multistable", "undecided"]
Vector = tuple[float, float, float]


def as_vector(array: Array) -> Vector:
    """Turn an array of shape (3,) into a plain tuple."""
    x, y, z = (float(value) for value in array)
    return x, y, z


@dataclass(frozen=True)
class Convexity:
    """Extremes of the curvature over the whole surface.

    Attributes:
        strictly_convex: Whether the smallest principal curvature is positive everywhere.
        min_curvature_per_mm: Smallest principal curvature.
        min_curvature_direction: Where it is, as a unit vector from the origin.
        min_gaussian_curvature_per_mm2: Smallest Gaussian curvature.
        min_radius_of_curvature_mm: One over the largest principal curvature: the thickest wall that a
            smooth inner offset surface allows.
    """

    strictly_convex: bool
    min_curvature_per_mm: float
    min_curvature_direction: Vector
    min_gaussian_curvature_per_mm2: float
    min_radius_of_curvature_mm: float


@dataclass(frozen=True)
class Equilibrium:
    """A pose in which the body balances on a flat table.

    Attributes:
        kind: `stable`, `unstable` or `saddle`.
        direction: Body direction that points down.
        height_mm: Height of the COM over the table.
        stiffness_mm: Eigenvalues (smaller, larger) of the Hessian of the height; None on a polyhedron,
            whose height has kinks.
        barrier_mm: How far the COM has to rise (for an unstable pose: to sink) before the body passes to
            another equilibrium of the same kind; if there is no other, all the way to the opposite one. None
            for saddles and in a smooth census.
        probability: Share of the orientations from which a quasi-static release ends in this stable pose;
            None for other kinds, or where it was not computed.
        probability_error: Share of the orientations for which the roughness of the mesh decides between two
            poses; where it is large, there is no probability.
        extent: `point`, or `ring` or `sphere` where the body balances neutrally all along one, up to the
            barrier of the census.
    """

    kind: Kind
    direction: Vector
    height_mm: float
    stiffness_mm: tuple[float, float] | None = None
    barrier_mm: float | None = None
    probability: float | None = None
    probability_error: float | None = None
    extent: Extent = "point"


@dataclass(frozen=True)
class Rest:
    """The lowest stable pose and how it answers to an error of the COM.

    Attributes:
        direction: Body direction that points down.
        height_mm: Height of the COM over the table.
        stiffness_mm: (soft, stiff) eigenvalues of the Hessian of the height; infinite on a polyhedron, which
            does not turn on its facet for a small COM error.
        soft_direction: Body direction along which a COM error tilts the rest most.
        stiff_direction: Body direction along which it tilts the rest least.
    """

    direction: Vector
    height_mm: float
    stiffness_mm: tuple[float, float]
    soft_direction: Vector
    stiff_direction: Vector

    @property
    def tilt_deg_per_um(self) -> tuple[float, float]:
        """Tilt (soft, stiff) for a COM error of 1 µm along those directions."""
        soft, stiff = self.stiffness_mm
        return math.degrees(1e-3 / soft), math.degrees(1e-3 / stiff)

    @property
    def tilt_matrix_deg_per_um(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """Tilt vector (soft, stiff) per COM error vector (soft, stiff); diagonal in these axes."""
        soft, stiff = self.tilt_deg_per_um
        return (soft, 0.0), (0.0, stiff)

    @property
    def stiffness_matrix_mm(self) -> tuple[Vector, Vector, Vector]:
        """Hessian of the height in the body's frame, as rows: takes a small tilt to its COM error."""
        axes = zip(self.stiffness_mm, (self.soft_direction, self.stiff_direction), strict=True)
        matrix = sum((k * np.outer(axis, axis) for k, axis in axes), np.zeros((3, 3)))
        first, second, third = matrix
        return as_vector(first), as_vector(second), as_vector(third)


@dataclass(frozen=True)
class Margin:
    """How far the COM may move before the census changes.

    Attributes:
        margin_mm: Radius of the largest ball of COM positions with an unchanged census.
        s_margin_mm: The same for the number of stable rests.
        u_margin_mm: The same for the number of unstable rests.
        s_witness_mm: The nearest COM position at which a stable rest meets a saddle.
        u_witness_mm: The nearest COM position at which an unstable rest meets a saddle.
    """

    margin_mm: float
    s_margin_mm: float
    u_margin_mm: float
    s_witness_mm: Vector
    u_witness_mm: Vector


@dataclass(frozen=True)
class MeshEvidence:
    """What the census of a mesh rests on.

    Attributes:
        facets: Number of facets of the convex hull, coplanar triangles merged.
        raw_stable: Stable facets of the hull, however low the barrier around them.
        raw_unstable: Unstable vertices of the hull.
        raw_saddles: Saddle edges of the hull.
        neutral: Places where the height is exactly stationary without a strict kind (a foot exactly on an
            edge, for example); they were counted as if the COM were moved by an infinitesimal.
        sag_mm: Bound on the distance between the facets and the smooth surface that they stand for; 0 where
            all folds are edges of the part itself.
        barrier_mm: Equilibria with a lower barrier were not counted.
        lowest_counted_mm: Lowest barrier among the counted stable equilibria except the deepest; None if
            only one counts.
        highest_uncounted_mm: Highest barrier among the stable equilibria that were not counted; None if all
            count.
        uncounted_directions: Where the uncounted stable equilibria with the highest barriers are, the
            highest first, at most ten.
    """

    facets: int
    raw_stable: int
    raw_unstable: int
    raw_saddles: int
    neutral: int
    sag_mm: float
    barrier_mm: float
    lowest_counted_mm: float | None
    highest_uncounted_mm: float | None
    uncounted_directions: tuple[Vector, ...]


@dataclass(frozen=True)
class Census:
    """All resting positions of a body about a centre of mass.

    Attributes:
        com_mm: The centre of mass.
        equilibria: Every equilibrium that counts, the lowest first: all of a smooth body, of a mesh those
            with a barrier above that of `mesh`.
        height_range_mm: Highest less lowest height of the COM.
        rest: The lowest stable rest.
        verdict: Whether there is one stable rest; `undecided` where the resolution of a mesh does not tell.
        reason: One sentence for the verdict, which says what would decide it if it is `undecided`.
        mass_properties: Of the homogeneous body; None for a mesh that does not bound a solid.
        convexity: Extremes of curvature; None for a mesh.
        margin: How far the COM may move; None for a mesh, and where it was not asked for.
        mesh: Raw counts and resolution of a mesh; None for a smooth body.
        height_at: Gives the heights of the COM in mm, shape (n,), with each of the unit vectors (n, 3)
            pointing down; None if the census was put together without a shape.
    """

    com_mm: Vector
    equilibria: tuple[Equilibrium, ...]
    height_range_mm: float
    rest: Rest
    verdict: CensusVerdict
    reason: str
    mass_properties: MassProperties | None = None
    convexity: Convexity | None = None
    margin: Margin | None = None
    mesh: MeshEvidence | None = None
    height_at: Callable[[Array], Array] | None = field(default=None, repr=False, compare=False)

    def _count(self, kind: Kind) -> int:
        return sum(e.kind == kind for e in self.equilibria)

    @property
    def stable(self) -> int:
        """Number S of stable rests."""
        return self._count("stable")

    @property
    def unstable(self) -> int:
        """Number U of unstable rests."""
        return self._count("unstable")

    @property
    def saddles(self) -> int:
        """Number H of saddles."""
        return self._count("saddle")

    def plot(self, ax: Axes | None = None) -> Axes:
        """Draw the height over all poses with the equilibria and their basins, in Mollweide's projection.

        Args:
            ax: Axes of that projection to draw on; new ones if not given.

        Returns:
            The axes.
        """
        from gomboc_cad.report.landscape import height_landscape
        from gomboc_cad.report.landscape_figures import plot_landscape

        return plot_landscape(height_landscape(self), ax)

"""What ballast does to the number of rests, exactly, beside what the source paper's oracle reads.

The paper (arXiv 2604.17095 v1, section "Density Perturbation") moves the centre of mass by the part w of the
way from the centroid to the lowest vertex, `c = (1 − w) c₀ + w v`, and counts with its drainage oracle. Here
the rests about each such COM are those of the solid itself: in closed form for sphere, capsule and cylinder,
by the smooth census for ellipsoid and Gömböc, and of the polyhedron with its real facets for the cube.

A right cylinder rests on both ends and at least once on its side wherever inside the COM is, and a box on all
six faces, since the foot of the perpendicular from an inner point lies inside each of them. So ballast makes
neither of them monostable. But what stands in the way is not the ring of neutral rests on the side of the
cylinder, the reason that the paper gives: the first bit of ballast beside the axis makes one rest of it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache, partial
from typing import Literal

import numpy as np

from gomboc_cad.body import Body, mass_properties
from gomboc_cad.body.catalogue import catalogue_entries, named_body
from gomboc_cad.body.sphere import Array
from gomboc_cad.equilibria.convexity import as_point, convexity
from gomboc_cad.equilibria.drainage import drainage_count, random_rotations
from gomboc_cad.equilibria.drainage_shapes import TriangleMesh, paper_shape, ring_mesh
from gomboc_cad.equilibria.margin import com_margin
from gomboc_cad.equilibria.mesh import mesh_census
from gomboc_cad.equilibria.records import Equilibrium, Extent, Vector, as_vector
from gomboc_cad.equilibria.round_solids import (
    EllipsoidShape,
    capsule_equilibria,
    cylinder_equilibria,
    sphere_equilibria,
)
from gomboc_cad.equilibria.smooth import find_equilibria
from gomboc_cad.errors import DegenerateEquilibriaError

BallastShape = Literal["gomboc", "sphere", "ellipsoid", "capsule", "cylinder", "cube"]
_ELLIPSOID = (1.5, 1.0, 0.7)
_CAPSULE_LENGTH = 5.0
_BALL = 4.0 * np.pi / 3.0


@dataclass(frozen=True, eq=False)
class BallastSubject:
    """A body of the paper's table of ballast.

    Attributes:
        name: Its name.
        mesh: What the paper's oracle sees of it.
        centroid_mm: Homogeneous centroid.
        lowest_mm: The lowest vertex along z, of several the first: where the paper puts the ballast.
        equilibria: Takes a COM (3,) to the equilibria of the true solid, the lowest first.
    """

    name: str
    mesh: TriangleMesh
    centroid_mm: Vector
    lowest_mm: Vector
    equilibria: Callable[[Array], tuple[Equilibrium, ...]]

    def com_mm(self, fraction: float, place_mm: Sequence[float] | Array | None = None) -> Array:
        """Centre of mass with the part `fraction` of the mass at a place, by default the lowest vertex."""
        place = np.array(self.lowest_mm) if place_mm is None else as_point(place_mm)
        result: Array = (1.0 - fraction) * np.array(self.centroid_mm) + fraction * place
        return result

    def rests(self, com: Array) -> tuple[Equilibrium, ...]:
        """The stable rests about a COM; of a ring or sphere of neutral ones there is one, which says so."""
        return tuple(e for e in self.equilibria(com) if e.kind == "stable")


@lru_cache(maxsize=8)
def ballast_subject(name: BallastShape) -> BallastSubject:
    """One of the paper's bodies at its size: the volume of the unit ball, of the Gömböc R₀ = 1."""
    if name == "gomboc":
        return body_subject(named_body("primary", diameter_mm=2.0))
    mesh = paper_shape(name)
    if name == "sphere":
        exact = partial(sphere_equilibria, 1.0)
    elif name == "ellipsoid":
        axes = np.array(_ELLIPSOID) / np.prod(_ELLIPSOID) ** (1.0 / 3.0)
        exact = partial(find_equilibria, Body(name, EllipsoidShape(as_vector(axes)), 1.0))
    elif name == "capsule":
        radius = float((_BALL / (_CAPSULE_LENGTH * np.pi + _BALL)) ** (1.0 / 3.0))
        exact = partial(capsule_equilibria, radius, _CAPSULE_LENGTH * radius)
    elif name == "cylinder":
        radius = (1.0 / 3.0) ** (1.0 / 3.0)
        exact = partial(cylinder_equilibria, radius, 4.0 * radius)
    else:
        exact = partial(_facet_equilibria, mesh)
    return _subject(name, mesh, exact, (0.0, 0.0, 0.0))


def body_subject(body: Body) -> BallastSubject:
    """A strictly convex body as a subject, meshed as the paper meshes bodies."""
    mesh = ring_mesh(body.position_mm)
    return _subject(body.name, mesh, partial(find_equilibria, body), mass_properties(body).com_mm)


def _subject(
    name: str, mesh: TriangleMesh, exact: Callable[[Array], tuple[Equilibrium, ...]], centroid: Vector
) -> BallastSubject:
    lowest = mesh.vertices[np.argmin(mesh.vertices[:, 2])]
    return BallastSubject(name, mesh, centroid, as_vector(lowest), exact)


def _facet_equilibria(mesh: TriangleMesh, com: Array) -> tuple[Equilibrium, ...]:
    return mesh_census(*mesh, com, sag_mm=0.0, probabilities=False).equilibria


@dataclass(frozen=True)
class BallastRow:
    """A body with one amount of ballast.

    Attributes:
        name: The body.
        fraction: Part w of the mass that is ballast.
        com_mm: Centre of mass.
        stable: True number of stable rests, a ring or sphere of neutral ones being one.
        extent: `ring` or `sphere` if there are neutral rests, else `point`.
        oracle: What the paper's oracle counts under each rotation of its directions, the first being none.
    """

    name: str
    fraction: float
    com_mm: Vector
    stable: int
    extent: Extent
    oracle: tuple[int, ...]


def ballast_rows(
    subject: BallastSubject,
    fractions: Sequence[float],
    *,
    place_mm: Sequence[float] | Array | None = None,
    rotations: int = 0,
    seed: int = 0,
) -> tuple[BallastRow, ...]:
    """Count the rests of a body against ballast, truly and by the paper's oracle.

    Args:
        subject: The body.
        fractions: Parts w of the mass that are ballast.
        place_mm: Where the ballast is, shape (3,); by default where the paper puts it.
        rotations: How many random rotations of the oracle's directions are tried besides its own.
        seed: Seed of the rotations.

    Raises:
        CensusError: If a COM is not inside the body.
        DegenerateEquilibriaError: If its equilibria cannot be counted.
    """
    turns = [None, *random_rotations(rotations, seed)]
    rows = []
    for fraction in fractions:
        com = subject.com_mm(fraction, place_mm)
        rests = subject.rests(com)
        extents: list[Extent] = [rest.extent for rest in rests if rest.extent != "point"]
        counts = tuple(drainage_count(*subject.mesh, com, turn=turn).ecs for turn in turns)
        rows.append(
            BallastRow(
                subject.name,
                float(fraction),
                as_vector(com),
                len(rests),
                extents[0] if extents else "point",
                counts,
            )
        )
    return tuple(rows)


@dataclass(frozen=True)
class RestChange:
    """An amount of ballast at which the number of stable rests changes.

    Attributes:
        fraction: The part w of the mass.
        before: Number of stable rests with a little less.
        after: Number with a little more.
    """

    fraction: float
    before: int
    after: int


def rest_changes(
    subject: BallastSubject,
    lightest: float,
    heaviest: float,
    *,
    step: float = 1e-3,
    place_mm: Sequence[float] | Array | None = None,
    accuracy: float = 1e-9,
) -> tuple[RestChange, ...]:
    """Find the amounts of ballast at which the number of stable rests changes.

    Args:
        subject: The body.
        lightest: Least part w of the mass that is looked at.
        heaviest: Largest.
        step: Two changes that are closer together than this may be missed.
        place_mm: Where the ballast is, shape (3,); by default where the paper puts it.
        accuracy: To what each change is located.

    Raises:
        CensusError: If a COM is not inside the body.
        DegenerateEquilibriaError: If its equilibria cannot be counted.
    """

    def stable(fraction: float) -> int:
        return len(subject.rests(subject.com_mm(fraction, place_mm)))

    fractions = np.linspace(lightest, heaviest, 1 + max(1, round((heaviest - lightest) / step))).tolist()
    counts = [stable(fraction) for fraction in fractions]
    changes = []
    for k in range(len(counts) - 1):
        if counts[k] == counts[k + 1]:
            continue
        low, high = fractions[k : k + 2]
        while high - low > accuracy:
            middle = 0.5 * (low + high)
            try:
                low, high = (middle, high) if stable(middle) == counts[k] else (low, middle)
            except DegenerateEquilibriaError:
                # Just where the number changes a rest is neutral.
                low = high = middle
        changes.append(RestChange(0.5 * (low + high), counts[k], counts[k + 1]))
    return tuple(changes)


@dataclass(frozen=True)
class TurnedCounts:
    """Counts of one body, turned at random against what counts it.

    Attributes:
        name: The body.
        oracle: What the paper's oracle counts, for each rotation.
        census: Stable rests of the mesh census, for each rotation.
    """

    name: str
    oracle: tuple[int, ...]
    census: tuple[int, ...]


def turned_counts(
    subject: BallastSubject, fraction: float = 0.0, *, rotations: int = 30, seed: int = 0
) -> TurnedCounts:
    """Count a body under random rotations; a number of rests cannot depend on them.

    Both see the same mesh, the oracle with turned directions, the census turned itself.

    Args:
        subject: The body.
        fraction: Part w of the mass that is ballast.
        rotations: Number of rotations, uniform over the rotation group.
        seed: Their seed.
    """
    mesh, com = subject.mesh, subject.com_mm(fraction)
    turns = random_rotations(rotations, seed)
    return TurnedCounts(
        subject.name,
        tuple(drainage_count(*mesh, com, turn=turn).ecs for turn in turns),
        tuple(
            mesh_census(mesh.vertices @ turn, mesh.faces, com @ turn, probabilities=False).stable
            for turn in turns
        ),
    )


@dataclass(frozen=True)
class EquivalentBallast:
    """What the shape of a homogeneous body is worth in ballast.

    A sphere whose COM is lowered by s keeps its one rest while the COM moves by less than s, its S-margin.
    So a body with the S-margin s is as robust as a sphere with the part `s/R` of its mass moved from its
    centre to its surface.

    Attributes:
        name: The body.
        s_margin_mm: S-margin about the homogeneous centroid; None for a body that is not strictly convex.
        sphere_radius_mm: Radius R of the sphere of the same volume.
        fraction: That part, the w of the paper's law; None where there is no margin.
    """

    name: str
    s_margin_mm: float | None
    sphere_radius_mm: float
    fraction: float | None


def equivalent_ballast(body: Body) -> EquivalentBallast:
    """Compare a homogeneous body with a loaded sphere."""
    mass = mass_properties(body)
    radius = float((mass.volume_mm3 / _BALL) ** (1.0 / 3.0))
    rests = find_equilibria(body, mass.com_mm) if convexity(body).strictly_convex else ()
    if sum(e.kind == "stable" for e in rests) != 1:
        return EquivalentBallast(body.name, None, radius, None)
    margin = com_margin(body, mass.com_mm).s_margin_mm
    return EquivalentBallast(body.name, margin, radius, margin / radius)


def catalogue_ballast() -> tuple[EquivalentBallast, ...]:
    """The equivalent ballast of every body of the catalogue, in its order and with R₀ = 1."""
    return tuple(equivalent_ballast(named_body(name, diameter_mm=2.0)) for name in catalogue_entries())

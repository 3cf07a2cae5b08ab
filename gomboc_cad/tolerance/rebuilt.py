"""The second judge: each variant is built as geometry and its hull comes to rest by the census of a mesh.

It shares with the fast judge the definition of what a variant is, and nothing else: no Hessian, no tracking
of critical points, no special case for the seam. Only the facets over the mouths of holes are looked at on
their own: a foot just inside of a rim makes a rest so shallow that no sampling tells it.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.optimize import least_squares

from gomboc_cad.body.sphere import Array, IntArray, lengths, tangent_frame, unit
from gomboc_cad.equilibria.mesh import mesh_census
from gomboc_cad.equilibria.records import Census, CensusVerdict, Vector, as_vector
from gomboc_cad.equilibria.rim import RimRest, rim_rest
from gomboc_cad.errors import CensusError
from gomboc_cad.tolerance.geometry import MadePart
from gomboc_cad.tolerance.refinement import MAX_POINTS, SampledPart, hull_mesh, sample_part
from gomboc_cad.tolerance.variants import Nominal, Variants

DEFAULT_SAG = 2e-6
"""Sag of the points over R₀: 0.1 µm on a body of 100 mm."""

_BARRIER_PER_SAG = 1.5
"""Facets make basins of up to half of the sag, which are not to be taken for doubtful rests."""

_BALANCED = 1e-10
"""Distance of the foot of the perpendicular from the contact, over R₀, at which a part rests there."""

_FLUSH = 1e-9
"""How far a hull may stand out over a facet that closes a mouth, over R₀."""

_SUPPORTS = 1e-12
"""How far the hull may reach through the table, over R₀."""


@dataclass(frozen=True)
class Rebuilt:
    """How a variant rests that was built as geometry.

    Attributes:
        verdict: Whether it has one rest; `undecided` where the points do not tell.
        stable: Number of rests that are known.
        reason: One sentence for the verdict.
        barrier_mm: Rests with a lower barrier cannot be told.
        highest_uncounted_mm: Highest barrier of a basin that does not count; None if there is none.
        rest_direction: The deepest rest, as the outward normal that points down; None if none is known.
        tilt_deg: Angle between it and the rest of the nominal, built in the same way; NaN if none is known.
        settled: Whether that rest is a point of the smooth surface, so that its direction is exact; on a rim,
            across the seam or on layers it is that of a facet.
        dented: Whether the form error was too rough for a convex part, so that displaced points were taken.
    """

    verdict: CensusVerdict
    stable: int
    reason: str
    barrier_mm: float
    highest_uncounted_mm: float | None
    rest_direction: Vector | None
    tilt_deg: float
    settled: bool
    dented: bool


def as_made_mesh(
    nominal: Nominal, variants: Variants, row: int, sag_mm: float | None = None
) -> tuple[Array, IntArray]:
    """The convex hull of a variant as a closed mesh, fine where the part could balance.

    Args:
        nominal: What is varied.
        variants: The variants.
        row: Which of them.
        sag_mm: Sag at the places where it could balance; by default `DEFAULT_SAG` times R₀.

    Returns:
        Vertices in mm, shape (n, 3), and outward triangles, shape (m, 3).

    Raises:
        GeometryError: If the parting plane or a hole does not cut the part as it should.
    """
    part = MadePart.of(nominal, variants, row)
    return hull_mesh(sample_part(part, sag_or_default_mm(nominal, sag_mm)).points_mm)


def rebuild(
    nominal: Nominal,
    variants: Variants,
    row: int,
    sag_mm: float | None = None,
    nominal_direction: Vector | None = None,
    max_points: int = MAX_POINTS,
) -> Rebuilt:
    """Build a variant as geometry and let it come to rest.

    Args:
        nominal: What is varied.
        variants: The variants.
        row: Which of them.
        sag_mm: Sag of its points where it could balance; half more is the lowest barrier that is told. By
            default `DEFAULT_SAG` times R₀.
        nominal_direction: Where the tilt is measured from; by default what `nominal_rest` finds.
        max_points: Where more would be needed, the sag is larger, and the barrier of the record higher.

    Raises:
        GeometryError: If the parting plane or a hole does not cut the part as it should.
    """
    sag = sag_or_default_mm(nominal, sag_mm)
    sampled = sample_part(MadePart.of(nominal, variants, row), sag, max_points)
    return come_to_rest(sampled, nominal_direction or nominal_rest(nominal, sag))


def come_to_rest(sampled: SampledPart, nominal_direction: Vector, barrier_mm: float | None = None) -> Rebuilt:
    """Let the hull of a part's points come to rest.

    Args:
        sampled: The points.
        nominal_direction: Where the tilt is measured from.
        barrier_mm: Rests with a lower barrier do not count; by default one and a half times the sag.
    """
    try:
        census = sampled_census(sampled, barrier_mm)
    except CensusError as error:
        return Rebuilt(
            "undecided", 0, str(error), sampled.sag_mm, None, None, np.nan, False, sampled.part.dented
        )
    assert census.mesh is not None  # it is a census of points
    direction, settled = _rest(sampled, census)
    verdict, stable, reason = census.verdict, census.stable, census.reason
    on_rims = [] if verdict == "multistable" or barrier_mm is not None else _rests_on_rims(sampled, direction)
    if on_rims:
        verdict, stable = "multistable", stable + len(on_rims)
        shallow = min(rest.barrier_mm for rest in on_rims)
        reason = f"It also rests on the rim of a hole, with a barrier of {1e3 * shallow:.3g} µm."
    return Rebuilt(
        verdict=verdict,
        stable=stable,
        reason=reason,
        barrier_mm=census.mesh.barrier_mm,
        highest_uncounted_mm=census.mesh.highest_uncounted_mm,
        rest_direction=as_vector(direction),
        tilt_deg=_angle_deg(direction, np.array(nominal_direction)),
        settled=settled,
        dented=sampled.part.dented,
    )


@lru_cache(maxsize=8)
def nominal_rest(nominal: Nominal, sag_mm: float) -> Vector:
    """Direction in which the nominal rests, with its halves where they belong, built as the variants are.

    Raises:
        CensusError: If its COM lies outside, or its points are degenerate.
        GeometryError: If a hole does not cut it as it should.
    """
    exact = Variants(np.array([nominal.com_mm]), np.eye(3)[None], np.empty((1, 0)), np.zeros((1, 3)))
    sampled = sample_part(MadePart.of(nominal, exact, 0), sag_mm)
    return as_vector(_rest(sampled, sampled_census(sampled))[0])


def sampled_census(sampled: SampledPart, barrier_mm: float | None = None) -> Census:
    """Census of the hull of a part's points.

    Args:
        sampled: The points.
        barrier_mm: Rests with a lower barrier do not count; by default one and a half times the sag.

    Raises:
        CensusError: If the COM lies outside, or the points are degenerate.
    """
    points = sampled.points_mm
    # The census makes the hull itself; the faces only have to name all points.
    faces = np.resize(np.arange(len(points)), (-(-len(points) // 3), 3))
    com, sag = sampled.part.com_mm, sampled.sag_mm
    barrier = _BARRIER_PER_SAG * sag if barrier_mm is None else barrier_mm
    return mesh_census(points, faces, com, barrier_mm=barrier, sag_mm=sag, probabilities=False)


def sag_or_default_mm(nominal: Nominal, sag_mm: float | None) -> float:
    """The sag that is asked for, or `DEFAULT_SAG` times R₀."""
    return DEFAULT_SAG * nominal.body.radius_mm if sag_mm is None else sag_mm


def _rest(sampled: SampledPart, census: Census) -> tuple[Array, bool]:
    """The deepest rest, moved from a facet of the points to the point of the surface that it stands for.

    It stays where it is if the surface does not balance near there, or would, but the hull reaches lower: on
    a rim, or across the seam.
    """
    part, size = sampled.part, sampled.part.body.radius_mm
    down = np.array(census.rest.direction)
    start = sampled.surface.directions[int((sampled.surface.position_mm @ down).argmax())]
    frame = np.stack(tangent_frame(start[None]), axis=1)[0]

    def foot(turn: Array) -> Array:
        foot_mm: Array = part.at(unit(start[None] + turn @ frame)).foot_mm[0]
        return foot_mm

    found = least_squares(foot, np.zeros(2), method="lm", xtol=1e-15, ftol=1e-15, gtol=1e-15)
    contact = part.at(unit(start[None] + found.x @ frame))
    normal, place = contact.normal[0], contact.position_mm[0]
    balanced = lengths(contact.foot_mm)[0] < _BALANCED * size
    supported = float((sampled.points_mm @ normal).max() - place @ normal) < _SUPPORTS * size
    near = abs((place - part.com_mm) @ normal - census.rest.height_mm) <= 2.0 * sampled.sag_mm
    return (normal, True) if balanced and supported and near else (down, False)


def _rests_on_rims(sampled: SampledPart, down: Array) -> list[RimRest]:
    """Rests on the rims of holes, however shallow, but for that of the hole on whose rim the part rests."""
    part = sampled.part
    contact = sampled.points_mm[int((sampled.points_mm @ down).argmax())]
    others = [rim for rim in sampled.mouths_mm if not np.any(np.all(rim == contact, axis=1))]
    found = [rest for rim in others if (rest := rim_rest(rim, part.com_mm)) is not None]
    size = part.body.radius_mm
    return [
        rest
        for rest in found
        if ((sampled.points_mm - part.com_mm) @ np.array(rest.direction)).max() - rest.height_mm
        < _FLUSH * size
    ]


def _angle_deg(one: Array, other: Array) -> float:
    """Angle between unit vectors, exact for small ones."""
    return float(np.degrees(2.0 * np.arctan2(np.linalg.norm(one - other), np.linalg.norm(one + other))))

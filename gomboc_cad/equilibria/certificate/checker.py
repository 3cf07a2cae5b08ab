"""The independent check of a certificate.

Nothing of the file is believed: the centroid and the volume are enclosed anew from the decimals, each
cell's claim is proven again by ball arithmetic, and the cells are shown to cover what they have to. How the
cells were found plays no part; the code that found them is not used. To be convinced one has to read
this module and those with the mathematics: `enclosures.py` for all bodies, `sloan.py`, or `harmonic.py` with
`meridian.py` and `affine.py`, for a family. Why the parts make a proof:

* A closed surface whose principal curvatures are positive everywhere bounds a strictly convex body
  (Hadamard). Its stable (unstable) poses on a table are then the minima (maxima) of the distance from the
  centre of mass, of the same number and type, if the centre of mass lies inside.
* That distance has a minimum and a maximum on the sphere, both critical points. There is none outside the two
  discs. In a disc, a rectangle of the chart away from the poles, the matrix of its second derivatives is
  definite, so a disc holds one critical point at most, and no maximum where the matrix is positive, no
  minimum where it is negative. So there is exactly one of each and nothing else.
* As the centre of mass moves, equilibria come and go only where one is degenerate, which is where the centre
  of mass is a centre of curvature. If none of these is nearer to the certified one than the margin, the
  counts are the same for every centre of mass within it.
* A point of negative Gaussian curvature is no point of a convex surface.
* Where half a turn about the x-axis maps the body to itself, both directions of that axis are critical points
  about a centre of mass on it: a tangent vector that the half-turn leaves alone is zero. Where one of them is
  a saddle there are three critical points or more, as the minimum and the maximum lie elsewhere.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, TypeVar

import numpy as np
from flint import arb, ctx

from gomboc_cad.equilibria.certificate.decimals import decimal_ball
from gomboc_cad.equilibria.certificate.enclosures import PRECISION_BITS, BallGeometry, Form
from gomboc_cad.equilibria.certificate.geometry import ball_geometry
from gomboc_cad.equilibria.certificate.records import (
    SPHERE,
    TURN_UNITS,
    Cell,
    Certificate,
    ConvexityProof,
    Disc,
    EquilibriaProof,
    MarginProof,
    Witness,
)
from gomboc_cad.errors import BodyError
from gomboc_cad.progress import Progress, silent

_Claim = TypeVar("_Claim", Cell, tuple[Cell, str])

STAGES = 4
"""How many stages `verify` reports."""

_WIDEST_ENCLOSURE = 1e-6


@dataclass(frozen=True)
class Verification:
    """The outcome of a check.

    Attributes:
        accepted: Whether every claim was proven again.
        reason: One sentence: what was proven, or which claim was not.
    """

    accepted: bool
    reason: str


class _Unproven(Exception):
    """A claim that does not hold, or cannot be shown to."""


def verify(certificate: Certificate, progress: Progress = silent) -> Verification:
    """Prove every claim of a certificate again."""
    try:
        with ctx.workprec(PRECISION_BITS):
            progress("enclosing the centroid")
            geometry = ball_geometry(certificate.parameters, certificate.com, certificate.chart)
            _check_enclosures(geometry, certificate)
            progress("proving strict convexity")
            if certificate.convexity:
                _check_convexity(geometry, certificate.convexity)
            progress("separating the equilibria")
            if certificate.equilibria:
                _check_equilibria(geometry, certificate.equilibria)
            progress("keeping the margin")
            if certificate.margin:
                _check_margin(geometry, certificate.margin)
            if certificate.witness:
                _check_witness(geometry, certificate.witness)
    except (_Unproven, BodyError) as error:
        return Verification(False, f"Rejected: {str(error).rstrip('.')}.")
    return Verification(True, certificate.reason)


def _check_enclosures(geometry: BallGeometry[Any], certificate: Certificate) -> None:
    claimed = (*certificate.com_enclosure, certificate.volume_enclosure)
    for interval, value in zip(claimed, (*geometry.centroid, geometry.volume), strict=True):
        low, high = (decimal_ball(end) for end in interval)
        _require(bool(low <= value <= high), "the centroid or the volume is not where it is said to be")
        # A body can be refuted without knowing well where its centroid is.
        narrow = high - low < _WIDEST_ENCLOSURE
        _require(bool(narrow) or not certificate.equilibria, "an enclosure is too wide to say anything")


def _check_convexity(geometry: BallGeometry[Any], proof: ConvexityProof) -> None:
    bound = _not_negative(proof.curvature_above)
    _require_cover(proof.cells, SPHERE)
    _require_all(proof.cells, lambda cell: geometry.curvature_excess(cell, bound).is_positive(), "curvature")


def _check_equilibria(geometry: BallGeometry[Any], proof: EquilibriaProof) -> None:
    _require_inside(geometry, arb(0))
    _check_disc(geometry, proof.stable, Form.is_positive)
    _check_disc(geometry, proof.unstable, Form.is_negative)
    discs = {"s": proof.stable.rectangle, "u": proof.unstable.rectangle}

    def holds(claim: tuple[Cell, str]) -> bool:
        cell, letter = claim
        if letter in discs:
            return discs[letter].holds(cell)
        pull = geometry.pulls(cell)["EM".index(letter.upper())]
        return bool(pull > 0 if letter.isupper() else pull < 0)

    _require_cover([cell for cell, _ in proof.cells], SPHERE)
    _require_all(proof.cells, holds, "equilibria")


def _check_disc(geometry: BallGeometry[Any], disc: Disc, definite: Callable[[Form[Any]], bool]) -> None:
    away = disc.rectangle.theta_low > 0 and disc.rectangle.theta_high < TURN_UNITS
    _require(away and SPHERE.holds(disc.rectangle), "a disc reaches a pole or leaves the chart")
    _require_cover(disc.cells, disc.rectangle)
    _require_all(disc.cells, lambda cell: definite(geometry.distance_hessian(cell)), "a disc")


def _check_margin(geometry: BallGeometry[Any], proof: MarginProof) -> None:
    distance = _not_negative(proof.com_margin)
    _require_inside(geometry, distance)
    _require_cover(proof.cells, SPHERE)
    _require_all(proof.cells, lambda cell: geometry.keeps_focal_distance(cell, distance), "the margin")


def _require_inside(geometry: BallGeometry[Any], shift: arb) -> None:
    _require(geometry.holds_ball(shift), "the centre of mass is not certainly inside the body")


def _check_witness(geometry: BallGeometry[Any], witness: Witness) -> None:
    point = Cell.at(witness.theta, witness.psi)
    _require(SPHERE.holds(point), "the witness is no direction")
    if witness.kind == "saddle":
        on_axis = witness.theta == TURN_UNITS // 2 and witness.psi in (0, TURN_UNITS)
        is_saddle = geometry.distance_hessian(point).determinant < 0
        _require_inside(geometry, arb(0))
        bound_to_be_one = geometry.axis_is_symmetry and geometry.com_on_axis and on_axis
        _require(bound_to_be_one, "the witness is not bound to be an equilibrium")
        _require(bool(is_saddle), "the witness is no saddle")
    else:
        bound = decimal_ball(witness.gaussian_curvature_below)
        curvature = geometry.gaussian_curvature(point).upper()
        _require(bool(bound < 0 and curvature <= bound), "the witness has no such negative curvature")


def _not_negative(decimal: str) -> arb:
    ball = decimal_ball(decimal)
    _require(bool(ball >= 0), "a bound is negative")
    return ball


def _require(holds: bool, complaint: str) -> None:
    if not holds:
        raise _Unproven(complaint)


def _require_all(claims: Iterable[_Claim], holds: Callable[[_Claim], bool], what: str) -> None:
    for claim in claims:
        _require(holds(claim), f"the claim of the cell {claim} of {what} does not hold")


def _require_cover(cells: Iterable[Cell], whole: Cell) -> None:
    """Require that rectangles leave no gap in a rectangle.

    Between two neighbouring edges in θ the cells that span that strip have to follow each other in ψ.
    """
    table = np.array(list(cells), dtype=np.int64).reshape(-1, 4)
    _require(len(table) > 0, "a list of cells is empty")
    theta_low, theta_high, psi_low, psi_high = table[np.argsort(table[:, 2], kind="stable")].T
    edges = np.unique(np.concatenate([theta_low, theta_high]))
    gap = "the cells do not cover the sphere or a disc"
    _require(bool(edges[0] <= whole.theta_low and edges[-1] >= whole.theta_high), gap)
    for low, high in pairwise(edges):
        spans = (theta_low <= low) & (theta_high >= high)
        reached = np.maximum.accumulate(np.append(whole.psi_low, psi_high[spans]))
        begins = np.append(psi_low[spans], whole.psi_high)
        _require(bool(np.all(begins <= reached)), gap)

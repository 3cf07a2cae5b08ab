"""The search for a proof: which cells to claim, and which bounds.

The sphere is covered by cells that are halved until a claim about each is proven by ball arithmetic
(`enclosures.py`). A body is proven to be strictly convex with exactly one stable and one unstable
equilibrium in three parts.

Strictly convex
    Both principal curvatures exceed a positive bound in every cell.
No equilibrium outside two discs
    In every other cell a component of the gradient of the distance from the centre of mass has one sign.
One in each disc
    The Hessian of the distance is positive (negative) definite in the chart's coordinates all over a disc,
    which is a rectangle of the chart and so convex: it holds one critical point at most. The distance takes
    its least and its greatest value on the sphere, both at critical points, and neither a minimum can lie
    where the Hessian is negative nor a maximum where it is positive. So each disc holds exactly one, and for
    a strictly convex body these are its stable and its unstable pose.

A fourth list of cells proves how far the centre of mass may move: in each cell no centre of
curvature is within that distance, so the counts stay the same. Nothing here has to be trusted: `checker.py`
proves the result again.
"""

from __future__ import annotations

from collections.abc import Callable
from decimal import Decimal
from typing import Any, TypeVar

from flint import arb, ctx

from gomboc_cad.body.catalogue import ExactParameters
from gomboc_cad.equilibria.certificate.decimals import decimal_ball, decimal_interval
from gomboc_cad.equilibria.certificate.enclosures import PRECISION_BITS, BallGeometry
from gomboc_cad.equilibria.certificate.geometry import ball_geometry
from gomboc_cad.equilibria.certificate.records import (
    MAX_CELLS,
    SPHERE,
    TURN_UNITS,
    Cell,
    Certificate,
    ConvexityProof,
    Decimals,
    Disc,
    EquilibriaProof,
    MarginProof,
    Witness,
)
from gomboc_cad.equilibria.certificate.straightening import straightening_chart
from gomboc_cad.progress import Progress, silent

STAGES = 4
"""How many stages `certify` reports."""

_CELLS_FOR_A_BETTER_BOUND = 3_000
_CELLS_FOR_A_HARMONIC = 9_000
"""The same where a search has made the margin nearly equal all along valley and ridge."""

_FINEST_LEFT = TURN_UNITS // 2**8
_BOUNDS = tuple(format(Decimal(m).scaleb(k), "f") for k in (-6, -5, -4, -3, -2) for m in range(10, 100))
_GRID = 64

Proof = TypeVar("Proof", ConvexityProof, MarginProof)


def certify(
    parameters: ExactParameters, progress: Progress = silent, *, com: Decimals | None = None
) -> Certificate:
    """Prove or refute that a body is strictly convex with one stable and one unstable equilibrium.

    The same parameters give the same certificate.

    Args:
        parameters: Family and exact decimals.
        progress: Told of each stage as it begins.
        com: Decimals of the centre of mass in units of R₀; the homogeneous centroid if not given.

    Raises:
        BodyError: If the parameters are not those of a `sloan2` or `extended` body with 0 < β < 0.25, or of a
            `harmonic` body with 4 |f| < 1, or the centre of mass is not three decimals.
    """
    with ctx.workprec(PRECISION_BITS):
        chart = straightening_chart(parameters)
        geometry = ball_geometry(parameters, com, chart)
        few = _CELLS_FOR_A_HARMONIC if parameters.family == "harmonic" else _CELLS_FOR_A_BETTER_BOUND
        progress("proving strict convexity")
        convexity = _best(lambda bound, limit: _prove_convexity(geometry, bound, limit), few)
        progress("separating the equilibria")
        equilibria = _prove_equilibria(geometry) if convexity else None
        progress("proving the margin")
        margin = None
        if equilibria:
            margin = _best(lambda bound, limit: _prove_margin(geometry, bound, limit), few)
        if margin and margin.com_margin == "0":
            margin = None
        progress("looking for a reason against it")
        witness = None if equilibria else _saddle(geometry) if convexity else _dent(geometry)
        x, y, z = geometry.centroid
        return Certificate(
            parameters=parameters,
            com_enclosure=(_interval(x), _interval(y), _interval(z)),
            volume_enclosure=decimal_interval(geometry.volume),
            com=com,
            chart=chart,
            convexity=convexity,
            equilibria=equilibria,
            margin=margin,
            witness=witness,
        )


def _interval(ball: arb) -> tuple[str, str]:
    return ("0", "0") if ball == 0 else decimal_interval(ball)


def _best(prove: Callable[[str, int], Proof | None], few: int) -> Proof | None:
    """The proof with the largest bound of two digits that few cells can prove, else that with the bound 0."""
    best = prove("0", MAX_CELLS)
    low, high = 0, len(_BOUNDS) if best else 0
    while low < high:
        middle = (low + high) // 2
        better = prove(_BOUNDS[middle], few)
        if better:
            best, low = better, middle + 1
        else:
            high = middle
    return best


def _prove_convexity(geometry: BallGeometry[Any], bound: str, limit: int) -> ConvexityProof | None:
    ball = decimal_ball(bound)
    cells = _cover(SPHERE, lambda cell: geometry.curvature_excess(cell, ball).is_positive(), limit)
    return ConvexityProof(bound, cells) if cells else None


def _prove_margin(geometry: BallGeometry[Any], com_margin: str, limit: int) -> MarginProof | None:
    distance = decimal_ball(com_margin)
    if not geometry.holds_ball(distance):
        return None
    cells = _cover(SPHERE, lambda cell: geometry.keeps_focal_distance(cell, distance), limit)
    return MarginProof(com_margin, cells) if cells else None


def _prove_equilibria(geometry: BallGeometry[Any]) -> EquilibriaProof | None:
    if not geometry.holds_ball(arb(0)):
        return None
    cells, left = _subdivide(
        SPHERE, lambda cell: _sign_of_pull(geometry, cell), MAX_CELLS, leave=MAX_CELLS, finest=_FINEST_LEFT
    )
    # The charts have the least f about ψ = π and the greatest about ψ = 0, so the stable pose lies about the
    # one, the unstable about the other.
    half = TURN_UNITS // 2
    groups = {"s": [c for c in left if c.psi_low >= half], "u": [c for c in left if c.psi_high <= half]}
    if not all(groups.values()):
        return None
    stable, unstable = (_bounding(group) for group in groups.values())
    stable_cells = _cover(stable, lambda cell: geometry.distance_hessian(cell).is_positive(), MAX_CELLS)
    unstable_cells = _cover(unstable, lambda cell: geometry.distance_hessian(cell).is_negative(), MAX_CELLS)
    if not (stable_cells and unstable_cells):
        return None
    cells += [(cell, letter) for letter, group in groups.items() for cell in group]
    return EquilibriaProof(tuple(sorted(cells)), Disc(stable, stable_cells), Disc(unstable, unstable_cells))


def _sign_of_pull(geometry: BallGeometry[Any], cell: Cell) -> str:
    """A component of the gradient that keeps its sign in the cell, as the letter of its claim."""
    for pull, positive, negative in zip(geometry.pulls(cell), "EM", "em", strict=True):
        if pull > 0:
            return positive
        if pull < 0:
            return negative
    return ""


def _bounding(cells: list[Cell]) -> Cell:
    theta_low, theta_high, psi_low, psi_high = zip(*cells, strict=True)
    return Cell(min(theta_low), max(theta_high), min(psi_low), max(psi_high))


def _cover(root: Cell, holds: Callable[[Cell], bool], limit: int) -> tuple[Cell, ...]:
    """Cells that cover a rectangle, in each of which the claim holds; none if they would be too many."""
    claimed, left = _subdivide(root, lambda cell: "+" if holds(cell) else "", limit, leave=0)
    return () if left else tuple(sorted(cell for cell, _ in claimed))


def _subdivide(
    root: Cell, claim: Callable[[Cell], str], limit: int, *, leave: int, finest: int = 1
) -> tuple[list[tuple[Cell, str]], list[Cell]]:
    """Halve a rectangle, always across its longer side, until each cell has a claim.

    It ends early if the limit of cells is met or more than `leave` cells of the finest size have no claim.

    Returns:
        Cells with their claims, and the others.
    """
    claimed: list[tuple[Cell, str]] = []
    left: list[Cell] = []
    waiting = [root]
    while waiting and len(claimed) + len(left) + len(waiting) <= limit and len(left) <= leave:
        cell = waiting.pop()
        if letter := claim(cell):
            claimed.append((cell, letter))
        elif (halves := _halves(cell, finest)) is None:
            left.append(cell)
        else:
            waiting.extend(halves)
    return claimed, left + waiting


def _halves(cell: Cell, finest: int) -> tuple[Cell, Cell] | None:
    theta, psi = cell.theta_high - cell.theta_low, cell.psi_high - cell.psi_low
    if max(theta, psi) <= finest:
        return None
    if theta >= psi:
        middle = cell.theta_low + theta // 2
        return cell._replace(theta_high=middle), cell._replace(theta_low=middle)
    middle = cell.psi_low + psi // 2
    return cell._replace(psi_high=middle), cell._replace(psi_low=middle)


def _dent(geometry: BallGeometry[Any]) -> Witness | None:
    """The most negative Gaussian curvature on a grid, if it is certainly negative."""
    step = TURN_UNITS // _GRID
    points = [(i * step, j * step) for i in range(_GRID + 1) for j in range(-_GRID // 2, 3 * _GRID // 2)]
    curvature, (theta, psi) = min(
        ((geometry.gaussian_curvature(Cell.at(*point)).upper(), point) for point in points),
        key=lambda item: float(item[0]),
    )
    if not curvature < 0:
        return None
    return Witness("negative curvature", theta, psi, decimal_interval(curvature)[1])


def _saddle(geometry: BallGeometry[Any]) -> Witness | None:
    """A saddle on the x-axis, where the half-turn symmetry makes both directions equilibria."""
    if not (geometry.axis_is_symmetry and geometry.com_on_axis and geometry.holds_ball(arb(0))):
        return None
    for psi in (0, TURN_UNITS):
        if geometry.distance_hessian(Cell.at(TURN_UNITS // 2, psi)).determinant < 0:
            return Witness("saddle", TURN_UNITS // 2, psi)
    return None

"""The sweep of β over Sloan's second body, and the "parameterization gap" that the paper reads from it."""

from __future__ import annotations

import numpy as np

from gomboc_cad.body import make_body
from gomboc_cad.body.sphere import fibonacci_directions
from gomboc_cad.body.support import support_height_mm
from gomboc_cad.equilibria import convexity
from gomboc_cad.equilibria.drainage import DirectionGraph, DrainageOptions, drain, drainage_count
from gomboc_cad.paper.bodies import (
    body_mesh,
    census_evidence,
    convex_by_volume,
    exact_census,
    sloan2,
    unit_body,
    yes,
)
from gomboc_cad.paper.published import published
from gomboc_cad.paper.records import Row, Table, judged
from gomboc_cad.paper.truths import catalogue_rests
from gomboc_cad.progress import Progress

_PROVEN_NAME, _PROVEN_BETA = "sloan2-0.030", 0.030
_SLOAN_1_BETAS = (0.01, 0.03)


def beta_sweep(progress: Progress) -> Table:
    """Count, convexity and height range at each β of the paper, and what it concludes from them."""
    figures = published()["beta_sweep"]
    rows: list[Row] = []
    columns = (figures[key] for key in ("beta", "ecs", "convex", "h_range"))
    for beta, ecs, convex, height_range in zip(*columns, strict=True):
        progress(f"beta-sweep: β = {beta:g}")
        rows += _rows(beta, ecs, convex, height_range)
    progress("beta-sweep: the gap")
    rows += [_never_one(), _analytic(figures["beta"]), *(_sloan_1(beta) for beta in _SLOAN_1_BETAS)]
    return Table(
        "beta-sweep",
        "Sloan's second body against β",
        (
            "Meshes of 100 × 200 with 101 parallels, 5,000 directions, 1 %.",
            "The body is strictly convex for β < 0.035505 and has exactly one stable and one unstable "
            "equilibrium there: every count above one is an artefact of facets and of sampling. Beyond that "
            "it rests on its convex hull.",
        ),
        tuple(rows),
    )


def _rows(beta: float, ecs: int, convex: bool, height_range: float) -> list[Row]:
    body = sloan2(beta)
    found = drainage_count(*body_mesh(body))
    census, curvature = exact_census(body), convexity(body)
    evidence = census_evidence(census)
    if census.stable == ecs:
        why = (
            "Right by chance: the two rests of the hull are images of each other under the half-turn and "
            "are merged; what is counted beside them is no rest."
        )
    elif census.stable == 1:
        why = f"The body has one rest; the other {found.ecs - 1} basins read here are not there."
    else:
        why = f"The body rests on its hull, in {census.stable} ways above the barrier that its mesh resolves."
    label = f"β = {beta:.3f}"
    true_range = census.height_range_mm
    truly, claimed = yes(curvature.strictly_convex), yes(convex)
    return [
        judged(f"{label}: ECS", ecs, found.ecs, census.stable, evidence, why, refuted=census.stable != ecs),
        judged(
            f"{label}: convex",
            claimed,
            convex_by_volume(body),
            truly,
            "smooth census",
            f"The smallest Gaussian curvature is {curvature.min_gaussian_curvature_per_mm2:.3f}"
            + (
                "."
                if truly == claimed
                else ": the body is dented, and a ratio of volumes above 0.999 does not see it."
            ),
            refuted=truly != claimed,
        ),
        judged(
            f"{label}: h-range",
            height_range,
            found.height_range_mm,
            true_range,
            evidence,
            f"Highest less lowest height; read {100.0 * abs(found.height_range_mm / true_range - 1.0):.1f} % "
            "from the true range.",
        ),
    ]


def _never_one() -> Row:
    """The claim that no value of β gives one, at a β that has been proven."""
    truth = catalogue_rests(_PROVEN_NAME, 1)
    return judged(
        f"β = {_PROVEN_BETA:.3f} (not in the table): ECS",
        "> 1 at every β",
        drainage_count(*body_mesh(unit_body(_PROVEN_NAME))).ecs,
        truth.shown,
        truth.evidence,
        "Proven in ball arithmetic: strictly convex, one stable and one unstable equilibrium "
        f"({_PROVEN_NAME} of the catalogue).",
        refuted=not truth.refutes,
    )


def _analytic(betas: list[float]) -> Row:
    """Basins of the exact height at 2,000 directions, which the paper takes for a confirmation."""
    graph = DirectionGraph.of(fibonacci_directions(2000), DrainageOptions.paper().neighbours)
    counts = []
    for body in (sloan2(beta) for beta in betas):
        com = np.array(exact_census(body).com_mm)
        heights = support_height_mm(body, -graph.directions) + graph.directions @ com
        counts.append(drain(graph, heights, DrainageOptions.paper()).sinks)
    return judged(
        "Basins of the exact height at 2,000 directions, all β",
        "9–21",
        f"{min(counts)}–{max(counts)}",
        1,
        "smooth census",
        "Without facets the greedy descent still ends in false sinks: in a valley that is narrower than the "
        "spacing of the directions the lowest neighbour is not the next one down the valley.",
        refuted=True,
    )


def _sloan_1(beta: float) -> Row:
    body = make_body("sloan1", beta, diameter_mm=2.0)
    census = exact_census(body)
    return judged(
        f"Sloan 1, β = {beta:.3f}: ECS",
        "> 1 at every β",
        drainage_count(*body_mesh(body)).ecs,
        census.stable,
        census_evidence(census),
        "Strictly convex up to about β = 0.0323, with one stable and one unstable equilibrium.",
        refuted=census.stable == 1,
    )

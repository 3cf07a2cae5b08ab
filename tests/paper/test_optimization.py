"""The paper's objective, and the search that minimises it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.special import j1

from gomboc_cad.equilibria import convexity
from gomboc_cad.paper.bodies import sloan2
from gomboc_cad.paper.optimization import (
    CONVEXITY_WEIGHT,
    FREE_STAGES,
    STAGE_1,
    STAGE_2,
    Stage,
    basin_gap,
    objective,
    search,
)
from gomboc_cad.progress import silent

PRIMARY = np.array([0.023149, 0.234433])


def test_the_primary_is_a_zero_of_the_objective_only_without_the_com_penalty() -> None:
    assert objective(PRIMARY, FREE_STAGES[0]) == 0.0
    assert objective(PRIMARY, STAGE_2) == pytest.approx((4.0 / 3.0 * j1(PRIMARY[1])) ** 2)


def test_a_dent_costs_what_the_ratio_of_volumes_lacks() -> None:
    from gomboc_cad.equilibria.drainage import drainage_count
    from gomboc_cad.paper.bodies import body_mesh, volume_ratio

    mesh = body_mesh(sloan2(0.15))
    lacking = 0.999 - volume_ratio(mesh)
    assert lacking > 0.0
    gap = basin_gap(drainage_count(*mesh))
    assert objective(np.array([0.15]), STAGE_1) == pytest.approx(gap + CONVEXITY_WEIGHT * lacking)


def test_the_ratio_of_volumes_passes_a_body_that_is_dented() -> None:
    """At the start of the paper's search, β = 0.05, the objective sees no dent."""
    from gomboc_cad.equilibria.drainage import drainage_count
    from gomboc_cad.paper.bodies import body_mesh

    body = sloan2(0.05)
    assert convexity(body).min_gaussian_curvature_per_mm2 < -0.5
    assert objective(np.array([0.05]), STAGE_1) == basin_gap(drainage_count(*body_mesh(body)))


@pytest.fixture(scope="module")
def short() -> Stage:
    return replace(STAGE_1, population=5, generations=2)


def test_a_search_tells_its_generations_and_is_the_same_for_the_same_seed(short: Stage) -> None:
    told: list[str] = []
    one, again = search(short, told.append), search(short, silent)
    assert (one.parameters, one.objective) == (again.parameters, again.objective)
    assert len(told) == 2
    assert "generation 2 of at most 2" in told[1]
    assert one.evaluations == 15
    assert one.objective <= objective(np.array([0.05]), short)


def test_a_search_ends_where_the_objective_is_zero() -> None:
    stage = replace(FREE_STAGES[1], population=4, generations=50)
    told: list[str] = []
    found = search(stage, told.append)
    assert found.objective == 0.0
    assert found.result.ecs == 1
    assert len(told) < 50

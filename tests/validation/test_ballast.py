"""What is true of the paper's section "Density Perturbation: Geometry vs. Ballast".

Source of the claims: arXiv 2604.17095 v1, Table "Minimum ballast fraction for ECS = 1" and the text below it.
"""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gomboc_cad.body import catalog
from gomboc_cad.body.sphere import fibonacci_directions
from gomboc_cad.equilibria import com_margin
from gomboc_cad.equilibria.ballast import BallastShape, ballast_rows, ballast_subject, rest_changes

INSIDE = st.floats(-0.95, 0.95)
LEVELS = (0.001, 0.05, 0.3)


@given(place=st.tuples(INSIDE, INSIDE, INSIDE))
@settings(max_examples=30, deadline=None)
def test_cube_and_cylinder_never_have_one_rest(place: tuple[float, float, float]) -> None:
    """True, and not only up to 30 %: for a COM anywhere inside."""
    cube, cylinder = ballast_subject("cube"), ballast_subject("cylinder")
    half = -cube.lowest_mm[2]
    assert len(cube.rests(half * np.array(place))) == 6
    x, y, z = place
    com = np.array([0.7 * x, 0.7 * y, 2.0 * z]) * -0.5 * cylinder.lowest_mm[2]
    assert len(cylinder.rests(com)) == 3


def test_the_reason_given_for_the_cylinder_is_wrong() -> None:
    """Not the ring persists but both ends: ballast at the rim, where the paper puts it, breaks the ring."""
    cylinder = ballast_subject("cylinder")
    rim = ballast_rows(cylinder, LEVELS)
    assert [(row.stable, row.extent) for row in rim] == [(3, "point")] * 3
    axial = ballast_rows(cylinder, LEVELS, place_mm=(0.0, 0.0, cylinder.lowest_mm[2]))
    assert [(row.stable, row.extent) for row in axial] == [(3, "ring")] * 3
    assert [row.oracle[0] for row in rim][-1] > 3


@pytest.mark.parametrize(
    ("name", "truth"),
    [("sphere", [(1, "point")] * 3), ("ellipsoid", [(2, "point")] * 3), ("capsule", [(1, "ring")] * 3)],
)
def test_rests_of_the_other_bodies(name: BallastShape, truth: list[tuple[int, str]]) -> None:
    """The sphere needs not 5 % but any; the ellipsoid has two rests throughout, the capsule a ring."""
    assert [(row.stable, row.extent) for row in ballast_rows(ballast_subject(name), LEVELS)] == truth


def test_a_capsule_has_one_rest_with_any_ballast_beside_its_axis() -> None:
    """And on its axis from 5/7 on, where the COM is in the cap."""
    capsule = ballast_subject("capsule")
    beside = ballast_rows(capsule, LEVELS, place_mm=(0.3, 0.0, -1.0))
    assert [(row.stable, row.extent) for row in beside] == [(1, "point")] * 3
    extents = [row.extent for row in ballast_rows(capsule, (5.0 / 7.0 - 1e-6, 5.0 / 7.0 + 1e-6))]
    assert extents == ["ring", "point"]


def test_the_gomboc_does_not_keep_one_rest_at_every_level() -> None:
    """Between w = 0.01938 and 0.02195 it has two; at both ends the COM crosses the focal surface."""
    gomboc = ballast_subject("gomboc")
    changes = rest_changes(gomboc, 0.0, 0.05, step=2.5e-3)
    assert [(change.before, change.after) for change in changes] == [(1, 2), (2, 1)]
    assert [change.fraction for change in changes] == pytest.approx([0.0193769, 0.0219505], abs=1e-6)
    assert rest_changes(gomboc, 0.05, 0.3, step=0.01) == ()
    (row,) = ballast_rows(gomboc, (0.0205,))
    assert (row.stable, row.oracle) == (2, (1,))
    body = catalog()["primary"].with_diameter(2.0)
    for change in changes:
        assert com_margin(body, gomboc.com_mm(change.fraction)).s_margin_mm < 1e-7


def test_random_shifts_of_the_com_of_the_gomboc() -> None:
    """By 0.003 R none breaks S = 1, as the S-margin of 0.0034 R promises; by 0.02 R most do."""
    gomboc = ballast_subject("gomboc")
    shifts = fibonacci_directions(24)
    rests = {
        size: [len(gomboc.rests(np.array(gomboc.centroid_mm) + size * shift)) for shift in shifts]
        for size in (0.003, 0.02)
    }
    assert set(rests[0.003]) == {1}
    assert np.mean(np.array(rests[0.02]) > 1) > 0.5


def test_ballast_where_the_gomboc_rests_keeps_its_one_rest() -> None:
    """Towards the rest itself, and not towards the lowest vertex of a mesh."""
    gomboc = ballast_subject("gomboc")
    (rest,) = gomboc.rests(np.array(gomboc.centroid_mm))
    place = np.array(gomboc.centroid_mm) + rest.height_mm * np.array(rest.direction)
    assert rest_changes(gomboc, 0.0, 0.3, step=0.01, place_mm=place) == ()

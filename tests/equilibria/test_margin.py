"""The COM margin: closed forms, a second method, and what it promises about the census."""

from __future__ import annotations

import numpy as np
import pytest

from gomboc_cad.body import Body, Harmonic, make_body, mass_properties
from gomboc_cad.body.sphere import fibonacci_directions
from gomboc_cad.equilibria import Census, com_margin, find_equilibria, smooth_census
from gomboc_cad.equilibria.margin import focal_points_mm
from gomboc_cad.errors import CensusError, NotConvexError
from tests.body.shapes import Array, Counting, ellipsoid, random_directions
from tests.equilibria.brute_force import margins


def kinds(body: Body, com: Array) -> tuple[int, int, int]:
    found = [e.kind for e in find_equilibria(body, com)]
    return found.count("stable"), found.count("saddle"), found.count("unstable")


HARMONIC = Harmonic((((2, 0), 0.012), ((2, 2), 0.006), ((3, 1), 0.004), ((4, -3), 0.002)))


@pytest.mark.parametrize(
    "body",
    [
        make_body("extended", 0.023149, {"1": 0.234433}, diameter_mm=2.0),
        make_body("sloan2", 0.03, diameter_mm=2.0),
        Body("harmonic", HARMONIC, 1.0),
    ],
    ids=["primary", "sloan2", "harmonic"],
)
def test_a_grid_with_a_simplex_search_finds_the_same_margins(body: Body) -> None:
    """`min sqrt(|∇h|² + λ²)` by another formula and another search; these valleys are narrow."""
    com = np.array(mass_properties(body).com_mm)
    found = com_margin(body, com)
    s_margin, u_margin = margins(body, com)
    assert found.s_margin_mm == pytest.approx(s_margin, rel=1e-5)
    assert found.u_margin_mm == pytest.approx(u_margin, rel=1e-5)
    assert found.margin_mm == min(found.s_margin_mm, found.u_margin_mm)


def test_a_com_away_from_the_centroid_has_its_own_margins(primary: Body) -> None:
    com = np.array([-0.03, 0.012, 0.02])
    found = com_margin(primary, com)
    s_margin, u_margin = margins(primary, com)
    assert found.s_margin_mm == pytest.approx(s_margin, rel=1e-5)
    assert found.u_margin_mm == pytest.approx(u_margin, rel=1e-5)


def test_the_margin_of_an_ellipsoid_is_not_above_its_evolutes() -> None:
    """In a plane of symmetry the evolute `(a x)^⅔ + (b y)^⅔ = (a² − b²)^⅔` belongs to the focal surface."""
    body, axes = ellipsoid((1.1, 1.0, 0.92), 12)
    found = com_margin(body, np.zeros(3))
    nearest = np.inf
    t = np.linspace(0.0, np.pi / 2, 2001)
    for i, j in ((0, 1), (1, 2), (0, 2)):
        a, b = axes[i], axes[j]
        evolute = np.hypot((a * a - b * b) / a * np.cos(t) ** 3, (a * a - b * b) / b * np.sin(t) ** 3)
        nearest = min(nearest, float(evolute.min()))
    assert found.margin_mm <= nearest + 1e-6
    s_margin, u_margin = margins(body, np.zeros(3), grid=10_000, starts=8)
    assert found.s_margin_mm == pytest.approx(s_margin, rel=1e-5)
    assert found.u_margin_mm == pytest.approx(u_margin, rel=1e-5)


def test_the_witnesses_lie_at_the_margin_and_on_the_focal_surface(
    primary: Body, primary_census: Census
) -> None:
    """Towards a witness the margin falls as the distance."""
    com, margin = np.array(primary_census.com_mm), primary_census.margin
    for witness, distance in (
        (margin.s_witness_mm, margin.s_margin_mm),
        (margin.u_witness_mm, margin.u_margin_mm),
    ):
        assert np.linalg.norm(np.array(witness) - com) == pytest.approx(distance, rel=1e-12)
    beside = com + 0.95 * (np.array(margin.s_witness_mm) - com)
    assert com_margin(primary, beside).s_margin_mm == pytest.approx(0.05 * margin.s_margin_mm, rel=0.01)


def test_the_census_changes_at_the_margin_and_not_before(primary: Body, primary_census: Census) -> None:
    """Just inside a witness nothing has changed, just beyond it its own count has."""
    com, margin = np.array(primary_census.com_mm), primary_census.margin
    s_direction = np.array(margin.s_witness_mm) - com
    u_direction = np.array(margin.u_witness_mm) - com
    assert kinds(primary, com + 0.999 * s_direction)[0] == 1
    assert kinds(primary, com + 1.001 * s_direction)[0] == 2
    assert kinds(primary, com + 0.999 * u_direction) == (1, 0, 1)
    assert kinds(primary, com + 1.001 * u_direction)[2] == 2


@pytest.mark.parametrize(
    "body", [make_body("sloan2", 0.03, diameter_mm=2.0), Body("harmonic", HARMONIC, 1.0)]
)
def test_the_margin_is_the_largest_ball_of_unchanged_census(body: Body) -> None:
    """No COM inside the ball changes a count, and one within 1.15 margins does.

    The nearest focal point may lie on a cuspidal edge of the focal surface, which a straight path can pass
    by; so both sides of the surface are compared at places close to the edge of the ball.
    """
    census = smooth_census(body)
    com, margin = np.array(census.com_mm), census.margin
    counted = (census.stable, census.saddles, census.unstable)
    for direction in random_directions(12, seed=6):
        assert kinds(body, com + 0.99 * margin.margin_mm * direction) == counted
        assert kinds(body, com + 0.99 * margin.s_margin_mm * direction)[0] == census.stable
        assert kinds(body, com + 0.99 * margin.u_margin_mm * direction)[2] == census.unstable
    u = fibonacci_directions(50_000)
    for sheet, reach in ((0, margin.s_margin_mm), (2, margin.u_margin_mm)):
        focal = focal_points_mm(body, u, sheet // 2)
        distance = np.linalg.norm(focal - com, axis=1)
        assert distance.min() >= reach * (1.0 - 1e-12)
        near = np.flatnonzero(distance < 1.15 * reach)
        picked = near[np.linspace(0, len(near) - 1, 4).astype(int)]
        across = 1e-9 * body.surface(u[picked]).principal_directions()[:, sheet // 2]
        sides = [
            {kinds(body, center + sign * step)[sheet] for sign in (1.0, -1.0)}
            for center, step in zip(focal[picked], across, strict=True)
        ]
        assert all(len(side) == 2 for side in sides)


def test_a_shift_of_0_003_r_never_breaks_one_rest_on_the_primary(
    primary: Body, primary_census: Census
) -> None:
    """arXiv 2604.17120 v2: random shifts of 0.02 R mostly break S = 1 and shifts of 0.003 R never do."""
    com = np.array(primary_census.com_mm)
    rests = [kinds(primary, com + 0.003 * d)[0] for d in random_directions(30, seed=9)]
    assert rests == [1] * 30
    far = [kinds(primary, com + 0.02 * d)[0] for d in random_directions(30, seed=9)]
    assert sum(rest > 1 for rest in far) > 15


def test_a_margin_that_vanishes_is_found_in_bounded_time(primary: Body, primary_census: Census) -> None:
    com = np.array(primary_census.com_mm)
    toward = np.array(primary_census.margin.s_witness_mm) - com
    counting = Counting(primary.shape)
    found = com_margin(Body("counted", counting, 1.0), com + (1.0 - 1e-6) * toward)
    assert found.s_margin_mm == pytest.approx(1e-6 * primary_census.margin.s_margin_mm, rel=1e-3)
    assert counting.asked < 4_000_000


def test_margins_of_a_dented_body_or_about_nothing_are_refused(primary: Body) -> None:
    with pytest.raises(NotConvexError):
        com_margin(make_body("sloan2", 0.05), (0.0, 0.0, 0.0))
    with pytest.raises(CensusError, match="three finite numbers"):
        com_margin(primary, (np.nan, 0.0, 0.0))

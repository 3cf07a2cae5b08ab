"""Closed forms of sphere, capsule and cylinder against the definition; the ellipsoid as a smooth body."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gomboc_cad.body import Body, mass_properties
from gomboc_cad.body.sphere import Array, unit
from gomboc_cad.equilibria import Equilibrium, com_margin, find_equilibria
from gomboc_cad.equilibria.round_solids import (
    EllipsoidShape,
    capsule_equilibria,
    cylinder_equilibria,
    sphere_equilibria,
)
from gomboc_cad.errors import CensusError, DegenerateEquilibriaError
from tests.body.shapes import random_directions

RADIUS, LENGTH = 1.0, 3.0

Census = Callable[[Array], tuple[Equilibrium, ...]]
Support = Callable[[Array], Array]
SOLIDS: dict[str, tuple[Census, Support]] = {
    "sphere": (lambda c: sphere_equilibria(RADIUS, c), lambda u: np.full(len(u), RADIUS)),
    "capsule": (
        lambda c: capsule_equilibria(RADIUS, LENGTH, c),
        lambda u: RADIUS + 0.5 * LENGTH * np.abs(u[:, 2]),
    ),
    "cylinder": (
        lambda c: cylinder_equilibria(RADIUS, LENGTH, c),
        lambda u: RADIUS * np.hypot(u[:, 0], u[:, 1]) + 0.5 * LENGTH * np.abs(u[:, 2]),
    ),
}
INNER = st.tuples(st.floats(0.02, 0.6), st.floats(0.0, 6.28), st.floats(-0.7, 0.7)).map(
    lambda p: np.array([p[0] * np.cos(p[1]), p[0] * np.sin(p[1]), p[2]])
)


def kind_by_definition(support: Support, com: Array, direction: Array) -> str:
    """What the height does on a small circle around a direction."""
    angle = 2.0 * np.pi * np.arange(720) / 720
    level = np.cross((0.0, 0.0, 1.0), direction)
    # Along a line of contact the height falls in one direction only, so the circle has to meet it.
    one = unit(level) if np.linalg.norm(level) > 1e-9 else np.array([1.0, 0.0, 0.0])
    other = np.cross(direction, one)
    circle = unit(direction + 1e-4 * (np.outer(np.cos(angle), one) + np.outer(np.sin(angle), other)))
    rise = support(circle) - circle @ com - (support(direction[None]) - direction @ com)
    changes = int(np.count_nonzero(np.sign(rise) != np.sign(np.roll(rise, 1))))
    return {0: "stable" if rise[0] > 0.0 else "unstable", 4: "saddle"}.get(changes, "none")


@pytest.mark.parametrize("name", SOLIDS)
@given(com=INNER)
@settings(max_examples=20, deadline=None)
def test_equilibria_are_what_the_support_function_says(name: str, com: Array) -> None:
    """Heights and kinds by definition, and none is missing by Poincaré–Hopf."""
    census, support = SOLIDS[name]
    found = census(com)
    for pose in found:
        direction = np.array(pose.direction)
        assert pose.height_mm == pytest.approx(
            float(support(direction[None])[0] - direction @ com), abs=1e-12
        )
        assert kind_by_definition(support, com, direction) == pose.kind
    assert sum(-1 if pose.kind == "saddle" else 1 for pose in found) == 2
    assert [pose.height_mm for pose in found] == sorted(pose.height_mm for pose in found)


def test_solids_about_points_of_their_axis_have_rings() -> None:
    ring = [(pose.kind, pose.extent) for pose in cylinder_equilibria(1.0, 3.0, (0.0, 0.0, 0.4))]
    assert sorted(ring) == [
        ("stable", "point"),
        ("stable", "point"),
        ("stable", "ring"),
        ("unstable", "ring"),
        ("unstable", "ring"),
    ]
    capsule = [(pose.kind, pose.extent) for pose in capsule_equilibria(1.0, 3.0, (0.0, 0.0, 0.4))]
    assert sorted(capsule) == [("stable", "ring"), ("unstable", "point"), ("unstable", "point")]
    (sphere,) = sphere_equilibria(1.0, (0.0, 0.0, 0.0))
    assert sphere.extent == "sphere"


def test_a_capsule_stands_only_with_its_com_in_a_cap() -> None:
    (rest,) = (p for p in capsule_equilibria(1.0, 3.0, (0.0, 0.1, 1.6)) if p.kind == "stable")
    assert rest.direction == pytest.approx((0.0, np.sqrt(0.5), np.sqrt(0.5)))
    with pytest.raises(DegenerateEquilibriaError, match="level with the centre of a cap"):
        capsule_equilibria(1.0, 3.0, (0.1, 0.0, 1.5))


@pytest.mark.parametrize("name", SOLIDS)
def test_a_com_outside_is_refused(name: str) -> None:
    with pytest.raises(CensusError, match="outside"):
        SOLIDS[name][0](np.array([1.1, 0.0, 0.0]))
    with pytest.raises(CensusError, match="outside"):
        SOLIDS[name][0](np.array([0.0, 0.0, 2.6]))


def test_the_ellipsoid_is_an_ellipsoid() -> None:
    axes = np.array([1.5, 1.0, 0.7])
    body = Body("ellipsoid", EllipsoidShape((1.5, 1.0, 0.7)), 1.0)
    u = random_directions(50)
    points = body.surface(u)
    np.testing.assert_allclose(np.sum((points.position_mm / axes) ** 2, axis=1), 1.0, rtol=1e-12)
    gradient = points.position_mm / axes**2
    np.testing.assert_allclose(points.normal, unit(gradient), atol=1e-12)
    # Gauss curvature of an ellipsoid: do Carmo, Differential Geometry of Curves and Surfaces, §3-3.
    gauss = 1.0 / (np.prod(axes) ** 2 * np.linalg.norm(gradient, axis=1) ** 4)
    np.testing.assert_allclose(np.prod(points.principal_curvatures_per_mm(), axis=1), gauss, rtol=1e-11)
    mass = mass_properties(body)
    assert mass.volume_mm3 == pytest.approx(4.0 / 3.0 * np.pi * np.prod(axes), rel=1e-10)


@given(com=INNER)
@settings(max_examples=8, deadline=None)
def test_equilibria_of_an_ellipsoid_are_its_normals_through_the_com(com: Array) -> None:
    """At `x = a² c/(a² + t)` for the real roots of `Σ a² c²/(a² + t)² = 1`: two, four or six of them."""
    squares = np.array([1.5, 1.2, 0.9]) ** 2
    com = 0.6 * com + 0.02
    factors = [np.poly1d([1.0, a]) ** 2 for a in squares]
    total = -1.0 * factors[0] * factors[1] * factors[2]
    for k in range(3):
        total += factors[k - 1] * factors[k - 2] * float(squares[k] * com[k] ** 2)
    roots = total.roots
    real = roots[np.abs(roots.imag) < 1e-7 * (1.0 + np.abs(roots))].real
    heights = np.sort([np.linalg.norm(squares * com / (squares + t) - com) for t in real])
    found = find_equilibria(Body("ellipsoid", EllipsoidShape((1.5, 1.2, 0.9)), 1.0), com)
    assert [pose.height_mm for pose in found] == pytest.approx(list(heights), abs=1e-6)


def test_the_margin_of_a_loaded_sphere_is_how_far_its_com_is_lowered() -> None:
    sphere = Body("sphere", EllipsoidShape((1.0, 1.0, 1.0)), 1.0)
    margin = com_margin(sphere, (0.0, 0.006, -0.008))
    assert margin.s_margin_mm == pytest.approx(0.01, abs=1e-9)
    assert find_equilibria(sphere, (0.0, 0.006, -0.008))[0].stiffness_mm == pytest.approx((0.01, 0.01))

"""Affine numbers enclose what they stand for at each place of a cell, and err by the square of its width."""

from __future__ import annotations

import math
from collections.abc import Callable

import pytest
from flint import arb, ctx
from hypothesis import given, settings
from hypothesis import strategies as st

from gomboc_cad.equilibria.certificate.affine import Affine

Function = Callable[..., object]

FUNCTIONS: dict[str, tuple[Function, Callable[[float, float], float]]] = {
    "sum": (lambda x, y: x + y - 2, lambda x, y: x + y - 2),
    "difference": (lambda x, y: 3 - x - y, lambda x, y: 3 - x - y),
    "product": (lambda x, y: x * y * 3, lambda x, y: 3 * x * y),
    "square": (lambda x, y: x * x - y * y, lambda x, y: x * x - y * y),
    "quotient": (lambda x, y: x / y, lambda x, y: x / y),
    "reciprocal": (lambda x, y: 2 / x + y / 4, lambda x, y: 2 / x + y / 4),
    "root": (lambda x, y: (x * y).sqrt(), lambda x, y: math.sqrt(x * y)),
    "mixture": (
        lambda x, y: (1 - x * y.sqrt()) / (-x * x - y),
        lambda x, y: (1 - x * math.sqrt(y)) / (-x * x - y),
    ),
}

places = st.floats(-1.0, 1.0)


def numbers(width: float) -> tuple[Affine, Affine]:
    """x = 2 + w(ε/2 − η/3) and y = 3 + w(η/2 + ε/5), y with a ball of 1/1000 of its slope."""
    return (
        Affine(arb(2), arb(width) / 2, -arb(width) / 3),
        Affine(arb(3, width / 1000), arb(width) / 5, arb(width) / 2),
    )


@pytest.mark.parametrize("name", FUNCTIONS)
@settings(max_examples=60, deadline=None)
@given(width=st.floats(0.0, 1.2), epsilon=places, eta=places, inside=places)
def test_the_value_at_a_place_is_enclosed(
    name: str, width: float, epsilon: float, eta: float, inside: float
) -> None:
    function, exact = FUNCTIONS[name]
    x = 2 + width * (epsilon / 2 - eta / 3)
    y = 3 + width * (eta / 2 + epsilon / 5 + inside / 1000)
    with ctx.workprec(64):
        found = function(*numbers(width))
        assert isinstance(found, Affine)
        here = found.center + found.theta * epsilon + found.psi * eta
    assert here.overlaps(arb(exact(x, y), 1e-12))
    assert here.rad() < 10.0
    assert found.range.overlaps(arb(exact(x, y), 1e-12))
    # A radius has 30 bits.
    assert found > found.range.lower() - 1e-6
    assert found < found.upper() + 1e-6
    assert not found < arb(exact(x, y)) - 1e-9
    assert not found > arb(exact(x, y)) + 1e-9


@pytest.mark.parametrize("name", FUNCTIONS)
def test_the_error_falls_with_the_square_of_the_width(name: str) -> None:
    function, _ = FUNCTIONS[name]
    errors = []
    for width in (1e-2, 1e-4):
        x, y = numbers(width)
        found = function(x, Affine(arb(3), y.theta, y.psi))
        assert isinstance(found, Affine)
        errors.append(float(found.center.rad()))
    assert errors[1] <= 1.1e-4 * errors[0] + 1e-13


@pytest.mark.parametrize(("center", "slope"), [(1.0, 1.5), (-1.0, 0.1), (0.0, 0.0)])
def test_a_root_or_reciprocal_that_need_not_exist_says_nothing(center: float, slope: float) -> None:
    number = Affine(arb(center), arb(slope), arb(0))
    root = number.sqrt()
    assert not root > arb(-1e9)
    if center >= 0:
        reciprocal = 1 / number
        assert not reciprocal > arb(-1e9)
        assert not reciprocal < arb(1e9)

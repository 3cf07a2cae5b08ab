"""Ball arithmetic against the floating-point geometry of the body, which was derived another way."""

from __future__ import annotations

import math

import numpy as np
import pytest
from flint import arb, ctx
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.special import j1

from gomboc_cad.body import Body, make_body, mass_properties
from gomboc_cad.body.catalogue import ExactParameters
from gomboc_cad.body.sphere import Array
from gomboc_cad.equilibria.certificate.enclosures import (
    PRECISION_BITS,
    BallGeometry,
    decimal_ball,
    decimal_interval,
)
from gomboc_cad.equilibria.certificate.records import SPHERE, TURN_UNITS, Cell
from gomboc_cad.equilibria.margin import focal_points_mm
from gomboc_cad.errors import BodyError

BETA, TERMS = "0.0231", {"1": "0.31", "3": "-0.07"}
ROUNDING = 1e-9


@pytest.fixture(scope="module")
def geometry() -> BallGeometry:
    return BallGeometry.of(ExactParameters("extended", BETA, TERMS))


@pytest.fixture(scope="module")
def body() -> Body:
    return make_body("extended", float(BETA), {k: float(a) for k, a in TERMS.items()}, diameter_mm=2.0)


@st.composite
def cell_and_point(draw: st.DrawFn) -> tuple[Cell, float, float]:
    """A cell of any size, and a point (θ, ψ) of it in radians; often a corner, never a pole."""
    edges, angles = [], []
    for low, high, levels in ((0, TURN_UNITS, 11), (SPHERE.psi_low, SPHERE.psi_high, 12)):
        level = draw(st.integers(0, levels))
        index = draw(st.integers(0, 2**level - 1))
        width = (high - low) >> level
        start = low + index * width
        place = draw(st.one_of(st.sampled_from([0.0, 1.0]), st.floats(0.0, 1.0)))
        edges += [start, start + width]
        angles.append(math.pi * (start + place * width) / TURN_UNITS)
    return Cell(*edges), min(max(angles[0], 1e-3), math.pi - 1e-3), angles[1]


def direction(theta: float, psi: float, terms: dict[str, str] = TERMS) -> Array:
    """u(θ, ψ): φ = ψ + P(cosθ)."""
    eta = 1.5 * math.pi * (math.cos(theta) - math.cos(theta) ** 3 / 3.0)
    phi = psi + eta + sum(float(a) * math.sin(int(k) * eta) for k, a in terms.items())
    return np.array([math.sin(theta) * math.cos(phi), math.sin(theta) * math.sin(phi), math.cos(theta)])


def distance_hessian(
    body: Body, theta: float, psi: float, terms: dict[str, str] = TERMS
) -> tuple[float, float, float]:
    """Second derivatives of |x − c|²/2 in (θ, ψ) by differences of the fourth order."""
    com = np.array(mass_properties(body).com_mm)
    h = 2e-3
    steps = np.arange(-2, 3)
    grid = np.array([[direction(theta + i * h, psi + j * h, terms) for j in steps] for i in steps])
    values = 0.5 * np.sum((body.position_mm(grid.reshape(-1, 3)) - com) ** 2, axis=1).reshape(5, 5)
    first, second = np.array([1, -8, 0, 8, -1]) / (12 * h), np.array([-1, 16, -30, 16, -1]) / (12 * h * h)
    return float(second @ values[:, 2]), float(first @ values @ first), float(second @ values[2])


def holds(ball: arb, value: float) -> bool:
    return bool(arb(value, ROUNDING).overlaps(ball))


@settings(max_examples=300, deadline=None)
@given(where=cell_and_point())
def test_curvatures_are_enclosed(
    geometry: BallGeometry, body: Body, where: tuple[Cell, float, float]
) -> None:
    cell, theta, psi = where
    curvatures = body.surface(direction(theta, psi)[None]).principal_curvatures_per_mm()[0]
    with ctx.workprec(PRECISION_BITS):
        assert holds(geometry.gaussian_curvature(cell), float(curvatures.prod()))
        bound = float(np.mean(curvatures))
        assert not geometry.curvature_excess(cell, arb(bound + ROUNDING)).is_positive()
        point = Cell.at(round(theta / math.pi * TURN_UNITS), round(psi / math.pi * TURN_UNITS))
        assert geometry.curvature_excess(point, arb(float(curvatures[1]) - 1e-3)).is_positive()


@settings(max_examples=300, deadline=None)
@given(where=cell_and_point())
def test_the_gradient_of_the_distance_is_enclosed(
    geometry: BallGeometry, body: Body, where: tuple[Cell, float, float]
) -> None:
    cell, theta, psi = where
    com = np.array(mass_properties(body).com_mm)
    u = direction(theta, psi)
    r = body.radius_at(u[None])[0]
    phi = math.atan2(u[1], u[0])
    e_theta = np.array([u[2] * math.cos(phi), u[2] * math.sin(phi), -math.sin(theta)])
    e_phi = np.array([-math.sin(phi), math.cos(phi), 0.0])
    h = 1e-6

    def slope(t: Array) -> float:
        """s/r times the derivative of |x − c|²/2 along t, by differences."""
        ahead, behind = (body.position_mm((math.cos(h) * u + k * math.sin(h) * t)[None])[0] for k in (1, -1))
        return float(r**3 * (r * u - com) @ (ahead - behind)) / (2 * h)

    eta = 1.5 * math.pi * (u[2] - u[2] ** 3 / 3.0)
    winding = 1.0 + sum(float(a) * int(k) * math.cos(int(k) * eta) for k, a in TERMS.items())
    q = 1.5 * math.pi * (1.0 - u[2] ** 2) ** 2 * winding
    expected = slope(e_phi), slope(e_theta) - q * slope(e_phi)
    with ctx.workprec(PRECISION_BITS):
        for pull, value in zip(geometry.pulls(cell), expected, strict=True):
            assert arb(value, 1e-7).overlaps(pull)


@settings(max_examples=200, deadline=None)
@given(where=cell_and_point())
def test_the_hessian_of_the_distance_is_enclosed(
    geometry: BallGeometry, body: Body, where: tuple[Cell, float, float]
) -> None:
    cell, theta, psi = where
    with ctx.workprec(PRECISION_BITS):
        expected = distance_hessian(body, theta, psi)
        for ball, value in zip(geometry.distance_hessian(cell), expected, strict=True):
            assert arb(value, 1e-5).overlaps(ball)


@settings(max_examples=300, deadline=None)
@given(where=cell_and_point())
def test_a_cell_never_keeps_farther_from_the_centroid_than_its_centres_of_curvature(
    geometry: BallGeometry, body: Body, where: tuple[Cell, float, float]
) -> None:
    cell, theta, psi = where
    com = np.array(mass_properties(body).com_mm)
    u = direction(theta, psi)[None]
    nearest = min(float(np.linalg.norm(focal_points_mm(body, u, sheet) - com)) for sheet in (0, 1))
    with ctx.workprec(PRECISION_BITS):
        assert not geometry.keeps_focal_distance(cell, arb(nearest * (1 + 1e-9)))


@pytest.mark.parametrize(("theta", "psi"), [(0.5, 1.0), (0.5, 0.0), (0.3, 0.7), (0.9, -0.4), (0.61, 1.01)])
def test_a_point_keeps_nearly_the_distance_of_its_centres_of_curvature(
    geometry: BallGeometry, body: Body, theta: float, psi: float
) -> None:
    point = Cell.at(round(theta * TURN_UNITS), round(psi * TURN_UNITS))
    u = direction(*(math.pi * angle / TURN_UNITS for angle in (point.theta_low, point.psi_low)))[None]
    com = np.array(mass_properties(body).com_mm)
    nearest = min(float(np.linalg.norm(focal_points_mm(body, u, sheet) - com)) for sheet in (0, 1))
    with ctx.workprec(PRECISION_BITS):
        assert geometry.keeps_focal_distance(point, arb(nearest * (1 - 1e-6)))


def test_points_of_a_wilder_body() -> None:
    """With a large β and a centroid at 0.055 R₀ every term of the formulas counts."""
    beta, terms = "0.12", {"1": "-0.9", "2": "0.3"}
    geometry = BallGeometry.of(ExactParameters("extended", beta, terms))
    body = make_body("extended", float(beta), {k: float(a) for k, a in terms.items()}, diameter_mm=2.0)
    assert abs(mass_properties(body).com_mm[0]) > 0.04
    for theta, psi in np.random.default_rng(5).integers((10_000, -500_000), (1_038_000, 1_500_000), (50, 2)):
        point = Cell.at(int(theta), int(psi))
        angles = math.pi * theta / TURN_UNITS, math.pi * psi / TURN_UNITS
        gaussian = body.surface(direction(*angles, terms)[None]).principal_curvatures_per_mm().prod()
        with ctx.workprec(PRECISION_BITS):
            assert float(geometry.gaussian_curvature(point)) == pytest.approx(gaussian, rel=1e-9, abs=1e-9)
            found = [float(ball) for ball in geometry.distance_hessian(point)]
        np.testing.assert_allclose(found, distance_hessian(body, *angles, terms), atol=1e-5)


def test_the_balls_of_a_point_are_narrow(geometry: BallGeometry) -> None:
    """Enclosures that always hold but say nothing would pass the tests above."""
    with ctx.workprec(PRECISION_BITS):
        point = Cell.at(TURN_UNITS // 3, TURN_UNITS // 5)
        assert geometry.gaussian_curvature(point).rad() < 1e-14
        assert all(pull.rad() < 1e-14 for pull in geometry.pulls(point))
        assert all(ball.rad() < 1e-14 for ball in geometry.distance_hessian(point))


def test_volume_and_centroid(geometry: BallGeometry, body: Body) -> None:
    mass = mass_properties(body)
    assert abs(geometry.volume - mass.volume_mm3) < 1e-12
    assert abs(geometry.centroid_x - mass.com_mm[0]) < 1e-14
    assert geometry.volume.rad() < 1e-30


@pytest.mark.parametrize("a", ["0.234433", "-0.8", "3.1"])
def test_centroid_of_one_term_is_a_bessel_function(a: str) -> None:
    """∫ cos(η + a sin η) dη = −2π J₁(a) over a turn (Bessel's integral)."""
    geometry = BallGeometry("0.02", {1: a})
    expected = -4.0 * math.pi * 0.02 * j1(float(a)) / (3.0 * float(geometry.volume))
    assert float(geometry.centroid_x) == pytest.approx(expected, rel=1e-13)


@pytest.mark.parametrize("terms", [{}, {2: "0.1376"}, {3: "-0.0552"}, {2: "0.5", 4: "0.3"}])
def test_centroid_is_at_the_origin_where_the_integral_vanishes(terms: dict[int, str]) -> None:
    centroid = BallGeometry("0.02", terms).centroid_x
    assert centroid.contains(0)
    assert centroid.rad() < 1e-18


def test_decimals_are_enclosed_outwards() -> None:
    third = arb(1) / 3
    low, high = decimal_interval(third)
    assert (low, high) == ("0.33333333333333325931", "0.33333333333333337035")
    assert decimal_interval(-third) == ("-0.33333333333333337035", "-0.33333333333333325931")
    assert decimal_interval(arb(0)) == ("0.00000000000000000000", "0.00000000000000000000")
    assert decimal_interval(arb(2) ** 80)[0] == f"{2**80}.00000000000000000000"


@pytest.mark.parametrize(
    "text", ["", "nan", "inf", "0x1", "1e999999999", "1_0", " 0.02", "٠.٢", "9" * 200, 0.02, None]
)
def test_what_is_no_plain_decimal_is_refused(text: object) -> None:
    with pytest.raises(BodyError, match="not a decimal number"):
        decimal_ball(text)


@pytest.mark.parametrize(
    ("family", "beta", "coefficients", "sentence"),
    [
        ("harmonic", None, {"2,0": "0.01"}, "families sloan2 and extended, not for 'harmonic'"),
        ("sloan1", "0.02", {}, "not for 'sloan1'"),
        ("sloan2", "0", {}, "beta = 0 is outside 0 < beta < 0.25"),
        ("sloan2", "-0.02", {}, "outside 0 < beta"),
        ("sloan2", "0.25", {}, "outside 0 < beta < 0.25"),
        ("sloan2", "0.02", {"1": "0.1"}, "to the family extended and not to sloan2"),
        ("extended", "0.02", {}, "to the family extended and not to sloan2"),
        ("extended", "0.02", {"0": "0.1"}, "is not an order k"),
        ("extended", "0.02", {"1.5": "0.1"}, "is not an order k"),
        ("extended", "0.02", {"1001": "0.1"}, "1 ≤ k ≤ 1000"),
        ("extended", "0.02", {"10": "101"}, "k |a| ≤ 1000"),
        ("extended", "0.02", {str(k): "0.01" for k in range(1, 50)}, "at most 32 Fourier terms"),
    ],
)
def test_bodies_without_certificates_are_refused(
    family: str, beta: str | None, coefficients: dict[str, str], sentence: str
) -> None:
    with pytest.raises(BodyError) as caught:
        BallGeometry.of(ExactParameters(family, beta, coefficients))
    assert sentence in str(caught.value)

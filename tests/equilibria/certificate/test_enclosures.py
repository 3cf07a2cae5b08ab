"""Ball arithmetic against the floating-point geometry of the body, which was derived another way."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest
from flint import acb, arb, ctx
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.polynomial import Polynomial
from scipy.special import j1

from gomboc_cad.body import Body, make_body, mass_properties
from gomboc_cad.body.catalogue import ExactParameters
from gomboc_cad.body.sphere import Array
from gomboc_cad.equilibria.certificate.affine import Affine
from gomboc_cad.equilibria.certificate.decimals import decimal_ball, decimal_interval
from gomboc_cad.equilibria.certificate.enclosures import PRECISION_BITS, BallGeometry
from gomboc_cad.equilibria.certificate.geometry import ball_geometry
from gomboc_cad.equilibria.certificate.harmonic import HarmonicGeometry
from gomboc_cad.equilibria.certificate.records import SPHERE, TURN_UNITS, Cell
from gomboc_cad.equilibria.certificate.sloan import SloanGeometry
from gomboc_cad.equilibria.margin import focal_points_mm
from gomboc_cad.errors import BodyError

BETA, TERMS = "0.0231", {"1": "0.31", "3": "-0.07"}
HARMONICS = {
    "2,0": "0.004",
    "2,-1": "0.02",
    "3,1": "-0.03",
    "3,2": "-0.003",
    "4,-3": "0.002",
    "5,0": "0.001",
    "6,5": "-0.0007",
    "9,-1": "0.0009",
    "12,4": "0.0001",
}
CHART = ("0.3", "2.1", "-0.7", "0.4")
OFF_AXES = ("0.011", "-0.023", "0.017")
ROUNDING = 1e-9


@dataclass(frozen=True)
class Charted:
    """A body in ball arithmetic and in floats, and the P(z) and P'(z) of its chart."""

    geometry: BallGeometry[Any]
    body: Body
    phase: Any
    slope: Any

    @property
    def com(self) -> Array:
        return np.array([float(c) for c in self.geometry.com])

    def direction(self, theta: float, psi: float) -> Array:
        """u(θ, ψ): φ = ψ + P(cosθ)."""
        phi = psi + self.phase(math.cos(theta))
        return np.array([math.sin(theta) * math.cos(phi), math.sin(theta) * math.sin(phi), math.cos(theta)])

    def distance_hessian(self, theta: float, psi: float) -> tuple[float, float, float]:
        """Second derivatives of |x − c|²/2 in (θ, ψ) by differences of the fourth order."""
        h = 2e-3
        steps = np.arange(-2, 3)
        grid = np.array([[self.direction(theta + i * h, psi + j * h) for j in steps] for i in steps])
        points = self.body.position_mm(grid.reshape(-1, 3)) - self.com
        values = 0.5 * np.sum(points**2, axis=1).reshape(5, 5)
        first, second = np.array([1, -8, 0, 8, -1]) / (12 * h), np.array([-1, 16, -30, 16, -1]) / (12 * h * h)
        return float(second @ values[:, 2]), float(first @ values @ first), float(second @ values[2])


def fourier(beta: str, terms: dict[str, str]) -> Charted:
    a = {int(k): float(value) for k, value in terms.items()}

    def eta(z: float) -> float:
        return 1.5 * math.pi * (z - z**3 / 3.0)

    return Charted(
        ball_geometry(ExactParameters("extended", beta, terms)),
        make_body("extended", float(beta), {k: float(value) for k, value in terms.items()}, diameter_mm=2.0),
        lambda z: eta(z) + sum(value * math.sin(k * eta(z)) for k, value in a.items()),
        lambda z: (
            1.5 * math.pi * (1.0 - z * z) * (1.0 + sum(v * k * math.cos(k * eta(z)) for k, v in a.items()))
        ),
    )


def harmonic() -> Charted:
    phase = Polynomial([float(p) for p in CHART])
    return Charted(
        ball_geometry(ExactParameters("harmonic", None, HARMONICS), OFF_AXES, CHART),
        make_body("harmonic", None, {k: float(c) for k, c in HARMONICS.items()}, diameter_mm=2.0),
        phase,
        phase.deriv(),
    )


@pytest.fixture(scope="module", params=["extended", "harmonic"])
def charted(request: pytest.FixtureRequest) -> Charted:
    return fourier(BETA, TERMS) if request.param == "extended" else harmonic()


@pytest.fixture(scope="module")
def geometry() -> HarmonicGeometry:
    return HarmonicGeometry.of(ExactParameters("harmonic", None, HARMONICS), None, CHART)


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


def holds(number: arb | Affine, value: float, where: tuple[Cell, float, float], rounding: float) -> bool:
    """Whether a number encloses a value: an affine one does so at the very place in the cell."""
    cell, theta, psi = where
    if isinstance(number, Affine):
        epsilon = _place(theta, cell.theta_low, cell.theta_high)
        number = number.center + number.theta * epsilon + number.psi * _place(psi, *cell[2:])
    return not number.is_finite() or bool(arb(value, rounding).overlaps(number))


def _place(angle: float, low: int, high: int) -> float:
    """Where an angle lies in an interval, from −1 to 1."""
    return (2 * angle / math.pi * TURN_UNITS - low - high) / (high - low)


@settings(max_examples=300, deadline=None)
@given(where=cell_and_point())
def test_curvatures_are_enclosed(charted: Charted, where: tuple[Cell, float, float]) -> None:
    cell, theta, psi = where
    u = charted.direction(theta, psi)[None]
    curvatures = charted.body.surface(u).principal_curvatures_per_mm()[0]
    with ctx.workprec(PRECISION_BITS):
        assert holds(charted.geometry.gaussian_curvature(cell), float(curvatures.prod()), where, ROUNDING)
        bound = float(np.mean(curvatures))
        assert not charted.geometry.curvature_excess(cell, arb(bound + ROUNDING)).is_positive()
        point = Cell.at(round(theta / math.pi * TURN_UNITS), round(psi / math.pi * TURN_UNITS))
        assert charted.geometry.curvature_excess(point, arb(float(curvatures[1]) - 1e-3)).is_positive()


@settings(max_examples=300, deadline=None)
@given(where=cell_and_point())
def test_the_gradient_of_the_distance_is_enclosed(charted: Charted, where: tuple[Cell, float, float]) -> None:
    cell, theta, psi = where
    u = charted.direction(theta, psi)
    r = charted.body.radius_at(u[None])[0]
    phi = math.atan2(u[1], u[0])
    e_theta = np.array([u[2] * math.cos(phi), u[2] * math.sin(phi), -math.sin(theta)])
    e_phi = np.array([-math.sin(phi), math.cos(phi), 0.0])
    h = 1e-6

    def slope(t: Array) -> float:
        """s/r times the derivative of |x − c|²/2 along t, by differences."""
        turned = np.stack([math.cos(h) * u + k * math.sin(h) * t for k in (1, -1)])
        ahead, behind = charted.body.position_mm(turned)
        return float(r**3 * (r * u - charted.com) @ (ahead - behind)) / (2 * h)

    q = (1.0 - u[2] ** 2) * charted.slope(u[2])
    expected = slope(e_phi), slope(e_theta) - q * slope(e_phi)
    with ctx.workprec(PRECISION_BITS):
        for pull, value in zip(charted.geometry.pulls(cell), expected, strict=True):
            assert holds(pull, value, where, 1e-7)


@settings(max_examples=200, deadline=None)
@given(where=cell_and_point())
def test_the_hessian_of_the_distance_is_enclosed(charted: Charted, where: tuple[Cell, float, float]) -> None:
    cell, theta, psi = where
    with ctx.workprec(PRECISION_BITS):
        expected = charted.distance_hessian(theta, psi)
        for number, value in zip(charted.geometry.distance_hessian(cell), expected, strict=True):
            assert holds(number, value, where, 1e-5)


@settings(max_examples=300, deadline=None)
@given(where=cell_and_point())
def test_a_cell_never_keeps_farther_from_the_com_than_its_centres_of_curvature(
    charted: Charted, where: tuple[Cell, float, float]
) -> None:
    cell, theta, psi = where
    u = charted.direction(theta, psi)[None]
    focal = [focal_points_mm(charted.body, u, sheet) for sheet in (0, 1)]
    nearest = min(float(np.linalg.norm(points - charted.com)) for points in focal)
    with ctx.workprec(PRECISION_BITS):
        assert not charted.geometry.keeps_focal_distance(cell, arb(nearest * (1 + 1e-9)))


@pytest.mark.parametrize(("theta", "psi"), [(0.5, 1.0), (0.5, 0.0), (0.3, 0.7), (0.9, -0.4), (0.61, 1.01)])
def test_a_point_keeps_nearly_the_distance_of_its_centres_of_curvature(
    charted: Charted, theta: float, psi: float
) -> None:
    point = Cell.at(round(theta * TURN_UNITS), round(psi * TURN_UNITS))
    u = charted.direction(*(math.pi * angle / TURN_UNITS for angle in (point.theta_low, point.psi_low)))[None]
    focal = [focal_points_mm(charted.body, u, sheet) for sheet in (0, 1)]
    nearest = min(float(np.linalg.norm(points - charted.com)) for points in focal)
    with ctx.workprec(PRECISION_BITS):
        assert charted.geometry.keeps_focal_distance(point, arb(nearest * (1 - 1e-6)))


def test_points_of_a_wilder_body() -> None:
    """With a large β and a centroid at 0.055 R₀ every term of the formulas counts."""
    wild = fourier("0.12", {"1": "-0.9", "2": "0.3"})
    assert abs(mass_properties(wild.body).com_mm[0]) > 0.04
    for theta, psi in np.random.default_rng(5).integers((10_000, -500_000), (1_038_000, 1_500_000), (50, 2)):
        point = Cell.at(int(theta), int(psi))
        angles = math.pi * theta / TURN_UNITS, math.pi * psi / TURN_UNITS
        gaussian = wild.body.surface(wild.direction(*angles)[None]).principal_curvatures_per_mm().prod()
        with ctx.workprec(PRECISION_BITS):
            found_curvature = float(wild.geometry.gaussian_curvature(point))
            assert found_curvature == pytest.approx(gaussian, rel=1e-9, abs=1e-9)
            found = [float(ball) for ball in wild.geometry.distance_hessian(point)]
        np.testing.assert_allclose(found, wild.distance_hessian(*angles), atol=1e-5)


def test_the_balls_of_a_point_are_narrow(charted: Charted) -> None:
    """Enclosures that always hold but say nothing would pass the tests above."""
    with ctx.workprec(PRECISION_BITS):
        point = Cell.at(TURN_UNITS // 3, TURN_UNITS // 5)
        numbers = [
            charted.geometry.gaussian_curvature(point),
            *charted.geometry.pulls(point),
            *charted.geometry.distance_hessian(point),
        ]
        assert all(n.range.rad() < 1e-14 if isinstance(n, Affine) else n.rad() < 1e-14 for n in numbers)


def test_volume(charted: Charted) -> None:
    assert abs(charted.geometry.volume - mass_properties(charted.body).volume_mm3) < 1e-11
    assert charted.geometry.volume.rad() < 1e-12


@pytest.mark.parametrize("c", ["0.02", "-0.09", "1e-9"])
def test_volume_of_a_body_of_revolution(c: str) -> None:
    """V = 2π/3 ∫ (1 + 4 c N P₂(z))^(3/4) dz with N² = 5/4π, by rigorous quadrature in one variable."""
    geometry = ball_geometry(ExactParameters("harmonic", None, {"2,0": c}))
    with ctx.workprec(128):
        factor = 4 * decimal_ball(c) * (5 / (4 * arb.pi())).sqrt()
        profile = acb.integral(lambda z, _: (1 + factor * (3 * z * z - 1) / 2).pow(arb(3) / 4), -1, 1).real
        expected = 2 * arb.pi() / 3 * profile
    assert geometry.volume.overlaps(expected)
    assert geometry.volume.rad() < 1e-11


def test_the_quadrature_of_the_volume_is_exact_for_the_powers_it_is_made_for(
    geometry: HarmonicGeometry,
) -> None:
    """The mean of f over the sphere is zero, that of f² is Σ c²/4π (Parseval)."""
    with ctx.workprec(128):
        nodes = list(geometry._nodes_of_4f(2))
        moments = [sum((weight * value**k for weight, value in nodes), arb(0)) for k in (0, 1, 2)]
        squares = sum((decimal_ball(c) ** 2 for c in HARMONICS.values()), arb(0))
        expected = [arb(1), arb(0), 4 * squares / arb.pi()]
    for found, value in zip(moments, expected, strict=True):
        assert found.overlaps(value)
        assert found.rad() < 1e-25


@settings(max_examples=25, deadline=None)
@given(level=st.integers(1, 12), data=st.data())
def test_the_functions_of_an_interval_hold_those_of_its_points(
    geometry: HarmonicGeometry, level: int, data: st.DataObject
) -> None:
    """Against a point's own series, in many more digits than the last term of the interval's."""
    width = TURN_UNITS >> level
    low = data.draw(st.integers(0, 2**level - 1)) * width
    step = data.draw(st.integers(0, 16))
    # The radius of a ball has 30 bits, so an interval reaches a little beyond its ends.
    epsilon = arb((step - 8) / 8, 1e-8)
    interval = geometry._band(low, low + width)
    point = geometry._band(low + width * step // 16, low + width * step // 16)
    with ctx.workprec(160):
        for wide, exact in ((interval.relief, point.relief), (interval.jet, point.jet)):
            for row in range(0, wide.nrows(), 2):
                for column in range(wide.ncols()):
                    model = wide[row, column] + epsilon * wide[row + 1, column]
                    assert not model.is_finite() or model.overlaps(exact[row, column])


def test_centroid() -> None:
    charted = fourier(BETA, TERMS)
    x, y, z = charted.geometry.centroid
    assert abs(x - mass_properties(charted.body).com_mm[0]) < 1e-14
    assert (y, z) == (0, 0)


@pytest.mark.parametrize("a", ["0.234433", "-0.8", "3.1"])
def test_centroid_of_one_term_is_a_bessel_function(a: str) -> None:
    """∫ cos(η + a sin η) dη = −2π J₁(a) over a turn (Bessel's integral)."""
    geometry = SloanGeometry("0.02", {1: a})
    expected = -4.0 * math.pi * 0.02 * j1(float(a)) / (3.0 * float(geometry.volume))
    assert float(geometry.centroid[0]) == pytest.approx(expected, rel=1e-13)


@pytest.mark.parametrize("terms", [{}, {2: "0.1376"}, {3: "-0.0552"}, {2: "0.5", 4: "0.3"}])
def test_centroid_is_at_the_origin_where_the_integral_vanishes(terms: dict[int, str]) -> None:
    centroid = SloanGeometry("0.02", terms).centroid[0]
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
        ("sloan1", "0.02", {}, "families harmonic, sloan2 and extended, not for 'sloan1'"),
        ("sloan2", None, {}, "not a decimal number"),
        ("sloan2", "0", {}, "beta = 0 is outside 0 < beta < 0.25"),
        ("sloan2", "-0.02", {}, "outside 0 < beta"),
        ("sloan2", "0.25", {}, "outside 0 < beta < 0.25"),
        ("sloan2", "0.02", {"1": "0.1"}, "to the family extended and not to sloan2"),
        ("extended", "0.02", {}, "to the family extended and not to sloan2"),
        ("extended", "0.02", {"0": "0.1"}, "is not an order k"),
        ("extended", "0.02", {"1.5": "0.1"}, "is not an order k"),
        ("extended", "0.02", {"1001": "0.1"}, "1 ≤ k ≤ 1000"),
        ("extended", "0.02", {"10": "101"}, "k |a| ≤ 1000"),
        ("harmonic", None, {}, "at least one coefficient"),
        ("harmonic", "0.02", {"2,0": "0.01"}, "takes no beta"),
        ("harmonic", None, {"2,0": "0.01", "02,0": "0.01"}, "each coefficient once"),
        ("harmonic", None, {"1,0": "0.01"}, "is not a pair l,m"),
        ("harmonic", None, {"41,0": "0.01"}, "2 ≤ l ≤ 40"),
        ("harmonic", None, {"3,4": "0.01"}, "|m| ≤ l"),
        ("harmonic", None, {"3": "0.01"}, "is not a pair l,m"),
        ("harmonic", None, {"3,1": "nan"}, "not a decimal number"),
        ("harmonic", None, {"2,0": "0.5"}, "4 |f| must stay below 1"),
        ("extended", "0.02", {str(k): "0.01" for k in range(1, 50)}, "at most 32 Fourier terms"),
    ],
)
def test_bodies_without_certificates_are_refused(
    family: str, beta: str | None, coefficients: dict[str, str], sentence: str
) -> None:
    with pytest.raises(BodyError) as caught:
        ball_geometry(ExactParameters(family, beta, coefficients))
    assert sentence in str(caught.value)


@pytest.mark.parametrize(
    ("family", "chart", "sentence"),
    [
        ("sloan2", ("0.1",), "'sloan2' has a chart of its own"),
        ("harmonic", ("0.1", "x"), "not a decimal number"),
        ("harmonic", ("0.1",) * 42, "at most 41 coefficients"),
    ],
)
def test_charts_that_cannot_be_are_refused(family: str, chart: tuple[str, ...], sentence: str) -> None:
    coefficients = {"2,0": "0.01"} if family == "harmonic" else {}
    beta = None if family == "harmonic" else "0.02"
    with pytest.raises(BodyError, match=sentence):
        ball_geometry(ExactParameters(family, beta, coefficients), None, chart)

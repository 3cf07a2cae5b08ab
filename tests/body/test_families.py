"""Shape functions: their values against the published formulas, their derivatives against differences."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gomboc_cad.body import Body, FourierSloan, Harmonic, Sloan1, make_body
from gomboc_cad.body.families import MAX_HARMONIC_DEGREE
from gomboc_cad.body.sphere import tangent_frame
from tests.body.shapes import EVERY_FAMILY, Array, random_directions, real_harmonic

POLES = np.array([[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]])
NEAR_POLES = np.array([[1e-9, 2e-9, 1.0], [-3e-5, 1e-5, -1.0], [0.0, 1e-300, 1.0]])


def angles(directions: Array) -> tuple[Array, Array]:
    x, y, z = directions.T
    return np.arctan2(np.hypot(x, y), z), np.arctan2(y, x)


def along(body: Body, u: Array, e: Array, t: float) -> Array:
    """Radius at the angle t along the great circles that leave u in the directions e."""
    return body.radius_at(np.cos(t) * u + np.sin(t) * e)


def differences(body: Body, u: Array, e: Array, h: float) -> tuple[Array, Array]:
    """First and second derivative along great circles by five-point differences."""
    r = {k: along(body, u, e, k * h) for k in (-2, -1, 0, 1, 2)}
    first = (r[-2] - 8 * r[-1] + 8 * r[1] - r[2]) / (12 * h)
    second = (-r[-2] + 16 * r[-1] - 30 * r[0] + 16 * r[1] - r[2]) / (12 * h * h)
    return first, second


def assert_radial_jet_is_right(body: Body, u: Array, h: float, tolerance: float) -> None:
    jet = body.radial_jet(u)
    assert jet.radius_mm == pytest.approx(body.radius_at(u), rel=1e-15)
    for weights in ((1.0, 0.0), (0.0, 1.0), (np.sqrt(0.5), np.sqrt(0.5)), (0.6, -0.8)):
        w = np.array(weights)
        first, second = differences(body, u, np.einsum("a,nax->nx", w, jet.frame), h)
        np.testing.assert_allclose(jet.gradient_mm @ w, first, atol=tolerance)
        np.testing.assert_allclose(np.einsum("a,nab,b->n", w, jet.hessian_mm, w), second, atol=tolerance)


@pytest.mark.parametrize("family", EVERY_FAMILY)
def test_derivatives_of_the_radius_agree_with_differences(family: str) -> None:
    name, beta, coefficients = EVERY_FAMILY[family]
    body = make_body(name, beta, coefficients, diameter_mm=2.0)
    u = random_directions(200, seed=1)
    assert_radial_jet_is_right(body, u[np.hypot(u[:, 0], u[:, 1]) > 0.1], 1e-3, 3e-8)


@pytest.mark.parametrize("family", ["sloan2", "extended", "harmonic"])
def test_the_poles_are_ordinary_points_of_the_smooth_families(family: str) -> None:
    name, beta, coefficients = EVERY_FAMILY[family]
    body = make_body(name, beta, coefficients, diameter_mm=2.0)
    near = NEAR_POLES / np.linalg.norm(NEAR_POLES, axis=1, keepdims=True)
    assert_radial_jet_is_right(body, np.concatenate([POLES, near]), 1e-3, 3e-8)


@settings(max_examples=40, deadline=None, derandomize=True)
@given(
    degree=st.integers(2, MAX_HARMONIC_DEGREE),
    share=st.floats(-1.0, 1.0),
    seed=st.integers(0, 1000),
)
def test_every_harmonic_term_is_the_orthonormal_one_with_its_derivatives(
    degree: int, share: float, seed: int
) -> None:
    order = round(share * degree)
    u = np.concatenate([random_directions(20, seed), POLES])
    shape = Harmonic((((degree, order), 1.0),))
    # 1e-12 at degree 40: a normalisation by factorials loses six digits more.
    np.testing.assert_allclose(shape.ambient_jet(u).value, real_harmonic(degree, order, u), atol=1e-12)
    small = Body("term", Harmonic((((degree, order), 1.0 / degree**2 / 40.0),)), 1.0)
    assert_radial_jet_is_right(small, u, 0.1 / degree, 2e-5)
    # The Laplace–Beltrami operator multiplies a harmonic by −l (l + 1).
    jet = shape.ambient_jet(u)
    frame = np.stack(tangent_frame(u), axis=1)
    laplacian = np.einsum("nax,nxy,nay->n", frame, jet.hessian, frame) - 2.0 * np.einsum(
        "nx,nx->n", u, jet.gradient
    )
    np.testing.assert_allclose(laplacian, -degree * (degree + 1) * jet.value, atol=1e-9)


def test_harmonics_are_orthonormal_together() -> None:
    """Many terms in one body sum up as the single ones do."""
    rng = np.random.default_rng(3)
    terms = tuple(((n, m), float(rng.normal())) for n in range(2, 12) for m in range(-n, n + 1))
    u = random_directions(50)
    expected = sum(c * real_harmonic(n, m, u) for (n, m), c in terms)
    np.testing.assert_allclose(Harmonic(terms).ambient_jet(u).value, expected, atol=1e-12)


def test_values_follow_the_published_formulas_in_angles() -> None:
    """arXiv 2604.17095: r⁴ = R⁴ (1 + 4 β sinθ cos(φ − P)), P = 5θ, η, or η + Σ a_k sin kη."""
    u = random_directions(300, seed=5)
    theta, phi = angles(u)
    eta = 1.5 * np.pi * (np.cos(theta) - np.cos(theta) ** 3 / 3.0)
    beta = 0.04
    phases = {
        Sloan1(beta): 5.0 * theta,
        FourierSloan(beta): eta,
        FourierSloan(beta, ((1, 0.3), (4, -0.2))): eta + 0.3 * np.sin(eta) - 0.2 * np.sin(4 * eta),
    }
    for shape, phase in phases.items():
        expected = (1.0 + 4.0 * beta * np.sin(theta) * np.cos(phi - phase)) ** 0.25
        np.testing.assert_allclose(Body("b", shape, 1.0).radius_at(u), expected, rtol=1e-14)


@pytest.mark.parametrize("pole", [1.0, -1.0])
def test_sloan1_is_continuous_in_slope_at_the_poles_and_not_in_curvature(pole: float) -> None:
    """`y ρ` has a Hessian that depends on the direction of approach; the limit along x is given."""
    body = make_body("sloan1", 0.03, diameter_mm=2.0)

    def hessian_in_space(azimuth: float, theta: float) -> tuple[Array, Array]:
        u = np.array(
            [[np.sin(theta) * np.cos(azimuth), np.sin(theta) * np.sin(azimuth), pole * np.cos(theta)]]
        )
        jet = body.radial_jet(u)
        slope = np.einsum("na,nax->nx", jet.gradient_mm, jet.frame)[0]
        return slope, (jet.frame.transpose(0, 2, 1) @ jet.hessian_mm @ jet.frame)[0]

    slope, at_pole = hessian_in_space(0.0, 0.0)
    assert np.isfinite(at_pole).all()
    for azimuth in np.linspace(0.0, 2.0 * np.pi, 9):
        np.testing.assert_allclose(hessian_in_space(azimuth, 1e-8)[0], slope, atol=1e-8)
    np.testing.assert_allclose(hessian_in_space(0.0, 1e-8)[1], at_pole, atol=1e-6)
    jump = np.abs(hessian_in_space(np.pi / 2, 1e-8)[1] - at_pole).max()
    # ∂²(yρ)/∂y² is 0 along x and 2 along y; U₄(±1) = 5.
    assert jump == pytest.approx(0.03 * 10.0, rel=1e-3)


def test_sloan1_derivatives_hold_next_to_the_pole() -> None:
    body = make_body("sloan1", 0.03, diameter_mm=2.0)
    azimuth = np.linspace(0.1, 6.0, 12)
    theta = 0.02
    u = np.stack(
        [np.sin(theta) * np.cos(azimuth), np.sin(theta) * np.sin(azimuth), np.full(12, np.cos(theta))], 1
    )
    assert_radial_jet_is_right(body, u, 5e-4, 2e-6)

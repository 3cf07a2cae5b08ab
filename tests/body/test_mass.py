"""Mass properties against closed forms, against other quadratures, and under rotation and scaling."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import lebedev_rule, quad, quad_vec
from scipy.special import j1
from scipy.stats import special_ortho_group

from gomboc_cad.body import Body, FourierSloan, Harmonic, MassProperties, catalog, make_body, mass_properties
from gomboc_cad.body.mass import sphere_quadrature
from gomboc_cad.errors import BodyError
from tests.body.shapes import EVERY_FAMILY, Array, rotated


def moments(r: Array, u: Array, weight: Array) -> tuple[float, Array, Array]:
    """Volume, centroid and inertia about the centroid, from radii at quadrature nodes."""
    volume = float(weight @ r**3 / 3.0)
    centroid = (weight * r**4 / 4.0) @ u / volume
    second = np.einsum("n,ni,nj->ij", weight * r**5 / 5.0, u, u) - volume * np.outer(centroid, centroid)
    return volume, centroid, np.trace(second) * np.eye(3) - second


def assert_same(mass: MassProperties, other: tuple[float, Array, Array], tolerance: float = 1e-10) -> None:
    volume, centroid, inertia = other
    assert mass.volume_mm3 == pytest.approx(volume, rel=tolerance)
    np.testing.assert_allclose(mass.com_mm, centroid, atol=tolerance)
    np.testing.assert_allclose(mass.inertia_mm5, inertia, rtol=tolerance, atol=tolerance)


@pytest.mark.parametrize("family", ["sloan2", "extended", "harmonic"])
def test_a_lebedev_rule_gives_the_same_mass_properties(family: str) -> None:
    """An independent second quadrature: octahedral, exact to degree 131."""
    name, beta, coefficients = EVERY_FAMILY[family]
    body = make_body(name, beta, coefficients, diameter_mm=2.0)
    nodes, weight = lebedev_rule(131)
    assert_same(mass_properties(body), moments(body.radius_at(nodes.T), nodes.T, weight), 1e-10)


def test_adaptive_integration_gives_the_same_mass_properties_for_sloan1() -> None:
    """Sloan 1 is not smooth at the poles, so no rule on the sphere converges quickly; θ and φ apart do."""
    beta = 0.03
    phi = 2.0 * np.pi * np.arange(64) / 64

    def ring(theta: float) -> Array:
        u = np.stack(
            [np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.full(64, np.cos(theta))], axis=1
        )
        r = (1.0 + 4.0 * beta * np.sin(theta) * np.cos(phi - 5.0 * theta)) ** 0.25
        columns = np.column_stack(
            [r**3 / 3, (r**4 / 4)[:, None] * u, *((r**5 / 5)[:, None] * u * u[:, [k]] for k in range(3))]
        )
        return columns.sum(axis=0) * np.sin(theta) * 2.0 * np.pi / 64

    total = quad_vec(ring, 0.0, np.pi, epsabs=1e-13, epsrel=1e-13)[0]
    volume, centroid = total[0], total[1:4] / total[0]
    second = total[4:].reshape(3, 3) - volume * np.outer(centroid, centroid)
    expected = volume, centroid, np.trace(second) * np.eye(3) - second
    assert_same(mass_properties(make_body("sloan1", beta, diameter_mm=2.0)), expected, 1e-11)


def test_a_sphere() -> None:
    mass = mass_properties(Body("sphere", FourierSloan(0.0), 3.0))
    volume = 4.0 / 3.0 * np.pi * 27.0
    assert mass.volume_mm3 == pytest.approx(volume, rel=1e-14)
    np.testing.assert_allclose(mass.com_mm, 0.0, atol=1e-14)
    np.testing.assert_allclose(mass.inertia_mm5, 0.4 * volume * 9.0 * np.eye(3), rtol=1e-13, atol=1e-10)


def test_reference_figures_of_the_primary() -> None:
    """Volume and centroid of the primary at R₀ = 50 mm, computed apart by adaptive quadrature."""
    mass = mass_properties(catalog()["primary"])
    assert mass.volume_mm3 == pytest.approx(523458.313905, rel=1e-9)
    np.testing.assert_allclose(mass.com_mm, (-0.134778477, 0.0, 0.0), atol=1e-9)


def test_the_two_halves_of_a_half_turn_about_x_balance() -> None:
    """All Sloan bodies are symmetric under a half-turn about x: the centroid is on x, Ixy = Ixz = 0."""
    for name in ("primary", "second", "third", "sloan2-0.030"):
        mass = mass_properties(catalog()[name])
        np.testing.assert_allclose(mass.com_mm[1:], 0.0, atol=1e-12)
        np.testing.assert_allclose(mass.inertia_mm5[0][1:], 0.0, atol=1e-4)


@pytest.mark.parametrize("a", [0.05, 0.234433, 0.8, -0.5])
@pytest.mark.parametrize("k", [1, 2, 3])
def test_the_centroid_follows_bessels_function(k: int, a: float) -> None:
    """`|∫ sin³θ e^{iP} dθ|` is (4/3) J₁(a) for k = 1 and 0 for k ≥ 2, P = η + a sin kη.

    With r⁴ = 1 + 4 f the first moment is `∫ f u dω = β π ∫ sin³θ e^{iP} dθ`, so the centroid is at
    `β π (4/3) J₁(a) / V` from the origin. J₁ comes from the substitution dη = −(3π/2) sin³θ dθ.
    """

    def integrand(theta: float) -> complex:
        eta = 1.5 * np.pi * (np.cos(theta) - np.cos(theta) ** 3 / 3.0)
        return complex(np.sin(theta) ** 3 * np.exp(1j * (eta + a * np.sin(k * eta))))

    expected = 4.0 / 3.0 * abs(j1(a)) if k == 1 else 0.0
    real = quad(lambda t: integrand(t).real, 0.0, np.pi, limit=200, epsabs=1e-13)[0]
    imaginary = quad(lambda t: integrand(t).imag, 0.0, np.pi, limit=200, epsabs=1e-13)[0]
    assert abs(complex(real, imaginary)) == pytest.approx(expected, abs=1e-12)
    beta = 0.02
    mass = mass_properties(make_body("extended", beta, {str(k): a}, diameter_mm=2.0))
    offset = np.linalg.norm(mass.com_mm)
    assert offset == pytest.approx(beta * np.pi * expected / mass.volume_mm3, abs=1e-13)


def test_the_papers_com_violation_of_the_primary_is_refuted() -> None:
    """arXiv 2604.17095 v1 states 6·10⁻⁸ for the primary; the true modulus is (4/3) J₁(0.234433) = 0.155."""
    assert 4.0 / 3.0 * j1(0.234433) == pytest.approx(0.1552, abs=5e-5)


@settings(max_examples=15, deadline=None, derandomize=True)
@given(c=st.lists(st.floats(-5e-3, 5e-3), min_size=6, max_size=6), radius=st.floats(1e-3, 1e3))
def test_harmonic_bodies_are_centred_and_scale_exactly(c: list[float], radius: float) -> None:
    places = [(2, 0), (2, 2), (3, -1), (4, 3), (5, -5), (8, 1)]
    shape = Harmonic(tuple(zip(places, c, strict=True)))
    one, many = mass_properties(Body("b", shape, 1.0)), mass_properties(Body("b", shape, radius))
    np.testing.assert_allclose(one.com_mm, 0.0, atol=1e-14)
    assert many.volume_mm3 == pytest.approx(one.volume_mm3 * radius**3, rel=1e-13)
    np.testing.assert_allclose(
        many.inertia_mm5, np.array(one.inertia_mm5) * radius**5, rtol=1e-12, atol=1e-13 * radius**5
    )


def test_mass_properties_turn_with_the_body() -> None:
    """Volume is the same and the inertia tensor turns as a tensor, for cyclic and random rotations."""
    name, _, coefficients = EVERY_FAMILY["harmonic"]
    body = make_body(name, None, coefficients, diameter_mm=2.0)
    mass = mass_properties(body)
    rotations = [np.roll(np.eye(3), 1, axis=0), *special_ortho_group(3, seed=4).rvs(2)]
    for rotation in rotations:
        turned = mass_properties(rotated(body, rotation))
        assert turned.volume_mm3 == pytest.approx(mass.volume_mm3, rel=1e-12)
        expected = rotation @ np.array(mass.inertia_mm5) @ rotation.T
        np.testing.assert_allclose(turned.inertia_mm5, expected, atol=1e-12)


def test_the_quadrature_is_exact_where_it_should_be_and_its_weights_sum_to_the_sphere() -> None:
    u, weight = sphere_quadrature(32)
    assert weight.sum() == pytest.approx(4.0 * np.pi, rel=1e-14)
    x, y, z = u.T
    # ∫ x⁴ y² z² = 4π · 3!! 1!! 1!! / 9!! = 4π · 3 / 945.
    assert weight @ (x**4 * y**2 * z**2) == pytest.approx(4.0 * np.pi * 3.0 / 945.0, rel=1e-13)
    assert weight @ (x * y**3) == pytest.approx(0.0, abs=1e-14)


def test_coefficients_too_fine_to_integrate_are_refused_with_a_sentence() -> None:
    with pytest.raises(BodyError, match=r"mass integrals of .* do not converge"):
        mass_properties(make_body("extended", 0.02, {"60": 0.5}, diameter_mm=2.0))

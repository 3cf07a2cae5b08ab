"""Support function and depth against their definitions."""

from __future__ import annotations

import numpy as np
import pytest

from gomboc_cad.body import Body, FourierSloan, catalog, depth_mm, make_body, support_height_mm, support_jet
from gomboc_cad.body.sphere import geodesic_triangulation
from gomboc_cad.body.support import touching_directions
from tests.body.shapes import EVERY_FAMILY, Array, random_directions


def highest_of_cloud(body: Body, normals: Array, level: int = 7) -> Array:
    """The definition of h: the greatest x·n over 160,000 surface points."""
    cloud = body.position_mm(geodesic_triangulation(level)[0])
    return np.array([(cloud @ n).max() for n in normals])


@pytest.mark.parametrize("family", EVERY_FAMILY)
def test_height_gradient_and_hessian_of_the_support_function(family: str) -> None:
    name, beta, coefficients = EVERY_FAMILY[family]
    body = make_body(name, beta, coefficients, diameter_mm=2.0)
    n = random_directions(40, seed=3)
    center = np.array([0.05, -0.02, 0.1])
    jet = support_jet(body, n, center)
    np.testing.assert_allclose(jet.height_mm, support_height_mm(body, n) - n @ center, atol=1e-13)
    excess = jet.height_mm + n @ center - highest_of_cloud(body, n, level=6)
    assert excess.min() > -1e-12
    assert excess.max() < 1e-3
    # The touching point: on the surface, with this normal, at x = h n + ∇h from the centre.
    np.testing.assert_allclose(body.normal(jet.directions), n, atol=1e-10)
    np.testing.assert_allclose(
        center + jet.height_mm[:, None] * n + jet.gradient_mm, body.position_mm(jet.directions), atol=1e-10
    )
    h = 2e-4
    for weights in ((1.0, 0.0), (0.0, 1.0), (0.6, 0.8)):
        w = np.array(weights)
        e = np.einsum("a,nax->nx", w, jet.tangents)
        ahead, behind = (
            support_height_mm(body, np.cos(h) * n + s * np.sin(h) * e)
            - (np.cos(h) * n + s * np.sin(h) * e) @ center
            for s in (1.0, -1.0)
        )
        first, second = (ahead - behind) / (2 * h), (ahead - 2 * jet.height_mm + behind) / h**2
        np.testing.assert_allclose(np.einsum("nx,nx->n", jet.gradient_mm, e), first, atol=3e-5)
        np.testing.assert_allclose(
            np.einsum("a,nab,b->n", w, jet.hessian_mm, w), second, atol=2e-3, rtol=2e-3
        )


@pytest.mark.parametrize("name", ["second", "third"])
def test_the_support_function_of_a_dented_body_is_that_of_its_hull(name: str) -> None:
    """Over a dent two far places compete for the highest point; the first climb alone may take the lower."""
    body = catalog()[name].with_diameter(2.0)
    n = np.concatenate([random_directions(1500, seed=8), -body.surface(dented(body)).normal])
    n = np.concatenate([n, body.surface(dented(body)).normal])
    excess = support_height_mm(body, n) - highest_of_cloud(body, n)
    assert excess.min() > -1e-12
    assert excess.max() < 5e-5


def dented(body: Body) -> Array:
    """The 300 most dented of 10,242 directions."""
    u = geodesic_triangulation(5)[0]
    return u[np.argsort(body.surface(u).principal_curvatures_per_mm()[:, 1])[:300]]


def test_a_dented_body_touches_at_both_ends_of_a_bridge_with_equal_heights() -> None:
    """Turning a plane across a dent, the touching point jumps: both sides meet at the same height."""
    body = catalog()["third"].with_diameter(2.0)
    center = body.surface(dented(body)[:1])
    e = center.principal_directions()[0, 1]
    angles = np.linspace(-0.4, 0.4, 401)
    n = np.cos(angles)[:, None] * center.normal + np.sin(angles)[:, None] * e
    x = body.position_mm(touching_directions(body, n))
    jumps = np.flatnonzero(np.linalg.norm(np.diff(x, axis=0), axis=1) > 0.1)
    assert len(jumps) >= 1
    for i in jumps:
        # The support function is continuous; the two touching points are as high but for the step of 2 mrad.
        assert abs((x[i] - x[i + 1]) @ n[i]) < 2e-3 * np.linalg.norm(x[i] - x[i + 1])


def test_depth_against_brute_force() -> None:
    """Distance from inner and outer points to a dense cloud, and its exactness on a sphere."""
    body = make_body("extended", 0.023149, {"1": 0.234433}, diameter_mm=2.0)
    rng = np.random.default_rng(0)
    inside = random_directions(25, 1) * rng.uniform(0.0, 0.9, (25, 1))
    cloud = body.position_mm(geodesic_triangulation(7)[0])
    nearest = np.array([np.linalg.norm(cloud - p, axis=1).min() for p in inside])
    depth = depth_mm(body, inside)
    assert np.all(depth <= nearest + 1e-12)
    np.testing.assert_allclose(depth, nearest, atol=2e-4)
    u = random_directions(10, 2)
    for distance in (0.3, 1e-3, 1e-9, -0.2):
        np.testing.assert_allclose(depth_mm(body, body.offset_mm(u, distance)), distance, atol=1e-12)


def test_depth_of_a_sphere_and_of_its_own_centre() -> None:
    sphere = Body("sphere", FourierSloan(0.0), 5.0)
    p = np.array([[0.0, 0.0, 0.0], [1.0, 2.0, -2.0], [0.0, 0.0, 7.0], [4.999999, 0.0, 0.0]])
    np.testing.assert_allclose(depth_mm(sphere, p), 5.0 - np.linalg.norm(p, axis=1), atol=1e-9)


@pytest.mark.parametrize("radius", [1e-6, 1e6])
def test_the_support_function_scales(radius: float) -> None:
    n = random_directions(20)
    one = support_jet(make_body("sloan2", 0.03, diameter_mm=2.0), n)
    many = support_jet(make_body("sloan2", 0.03, diameter_mm=2.0 * radius), n)
    np.testing.assert_allclose(many.height_mm, radius * one.height_mm, rtol=1e-12)
    np.testing.assert_allclose(many.gradient_mm, radius * one.gradient_mm, atol=1e-9 * radius)
    inner = np.array([[0.1, 0.2, -0.3]])
    deep = depth_mm(make_body("sloan2", 0.03, diameter_mm=2.0 * radius), radius * inner)
    np.testing.assert_allclose(
        deep, radius * depth_mm(make_body("sloan2", 0.03, diameter_mm=2.0), inner), rtol=1e-9
    )

"""Normals, tangents and the shape operator against their definitions."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gomboc_cad.body import Body, FourierSloan, Harmonic, make_body
from gomboc_cad.body.sphere import fibonacci_directions, geodesic_triangulation, subdivide, tangent_frame
from gomboc_cad.errors import BodyError
from tests.body.shapes import EVERY_FAMILY, random_directions


@pytest.mark.parametrize("family", EVERY_FAMILY)
def test_normal_and_shape_operator_agree_with_differences_of_points_and_normals(family: str) -> None:
    """Weingarten: moving along the surface by dx turns the normal by S dx."""
    name, beta, coefficients = EVERY_FAMILY[family]
    body = make_body(name, beta, coefficients, diameter_mm=2.0)
    u = random_directions(200, seed=2)
    u = u[np.hypot(u[:, 0], u[:, 1]) > 0.1]
    points = body.surface(u)
    np.testing.assert_allclose(np.linalg.norm(points.normal, axis=1), 1.0, atol=1e-14)
    np.testing.assert_allclose(points.normal, body.normal(u), atol=1e-14)
    assert np.all(np.einsum("nx,nx->n", points.normal, u) > 0.0)
    gram = points.tangents @ points.tangents.transpose(0, 2, 1)
    np.testing.assert_allclose(gram, np.broadcast_to(np.eye(2), gram.shape), atol=1e-14)
    np.testing.assert_allclose(np.einsum("nax,nx->na", points.tangents, points.normal), 0.0, atol=1e-14)
    h = 1e-5
    for e in tangent_frame(u):
        ahead, behind = np.cos(h) * u + np.sin(h) * e, np.cos(h) * u - np.sin(h) * e
        dx = (body.position_mm(ahead) - body.position_mm(behind)) / (2 * h)
        dn = (body.normal(ahead) - body.normal(behind)) / (2 * h)
        np.testing.assert_allclose(np.einsum("nx,nx->n", dx, points.normal), 0.0, atol=1e-9)
        moved = np.einsum("nax,nx->na", points.tangents, dx)
        turned = np.einsum("nax,nx->na", points.tangents, dn)
        np.testing.assert_allclose(
            np.einsum("nab,nb->na", points.shape_operator_per_mm, moved), turned, atol=1e-7
        )


def test_principal_directions_diagonalise_the_shape_operator() -> None:
    body = make_body("sloan2", 0.03, diameter_mm=2.0)
    u = random_directions(50)
    points = body.surface(u)
    curvature = points.principal_curvatures_per_mm()
    assert np.all(curvature[:, 0] >= curvature[:, 1])
    local = np.einsum("nix,nax->nia", points.principal_directions(), points.tangents)
    rebuilt = np.einsum("ni,nia,nib->nab", curvature, local, local)
    np.testing.assert_allclose(rebuilt, points.shape_operator_per_mm, atol=1e-13)


def test_a_sphere_has_curvature_one_over_its_radius_everywhere() -> None:
    points = Body("sphere", FourierSloan(0.0), 7.0).surface(random_directions(20))
    np.testing.assert_allclose(points.principal_curvatures_per_mm(), 1.0 / 7.0, rtol=1e-14)
    np.testing.assert_allclose(points.normal, points.directions, atol=1e-15)


@settings(max_examples=20, deadline=None, derandomize=True)
@given(radius=st.sampled_from([1e-6, 1e-3, 1.0, 50.0, 1e6]), seed=st.integers(0, 99))
def test_geometry_scales_with_the_radius(radius: float, seed: int) -> None:
    u = random_directions(5, seed)
    small, large = (
        make_body("sloan2", 0.03, diameter_mm=2.0),
        make_body("sloan2", 0.03, diameter_mm=2 * radius),
    )
    one, many = small.surface(u), large.surface(u)
    np.testing.assert_allclose(many.position_mm, radius * one.position_mm, rtol=1e-13)
    np.testing.assert_allclose(many.normal, one.normal, atol=1e-14)
    np.testing.assert_allclose(
        many.principal_curvatures_per_mm() * radius, one.principal_curvatures_per_mm(), rtol=1e-12
    )
    inner = large.offset_mm(u, 0.1 * radius)
    np.testing.assert_allclose(np.linalg.norm(inner - large.position_mm(u), axis=1), 0.1 * radius, rtol=1e-12)


def test_gauss_bonnet() -> None:
    """The Gaussian curvature integrates to 4π over any closed surface of genus 0."""
    for name, beta, coefficients in EVERY_FAMILY.values():
        body = make_body(name, beta, coefficients, diameter_mm=2.0)
        nodes, weights = np.polynomial.legendre.leggauss(200)
        theta, phi = 0.5 * np.pi * (nodes + 1.0), np.pi * np.arange(128) / 64
        sine = np.sin(theta)
        u = np.stack(
            [np.outer(sine, np.cos(phi)), np.outer(sine, np.sin(phi)), np.outer(np.cos(theta), 1 + 0 * phi)],
            -1,
        ).reshape(-1, 3)
        points = body.surface(u)
        r = body.radius_at(u)
        area = r**2 / np.einsum("nx,nx->n", u, points.normal)
        gauss = np.prod(points.principal_curvatures_per_mm(), axis=1)
        weight = np.outer(0.5 * np.pi * weights * sine, np.full(128, np.pi / 64)).ravel()
        assert weight @ (gauss * area) == pytest.approx(4.0 * np.pi, rel=1e-9)


@pytest.mark.parametrize("radius", [0.0, -1.0, float("nan"), float("inf"), 1e-12, 1e300])
def test_a_senseless_radius_is_refused(radius: float) -> None:
    with pytest.raises(BodyError, match="nominal radius must be between"):
        Body("b", FourierSloan(0.02), radius)


def test_a_radius_that_is_not_real_between_the_checked_places_is_refused_where_it_is_met() -> None:
    """A degree that the first check cannot resolve must not give NaN later."""
    body = Body("fine", Harmonic((((40, 0), 0.3),)), 1.0)
    with pytest.raises(BodyError, match="radius is not real and positive"):
        body.radius_at(fibonacci_directions(20_000))


def test_directions_of_a_fibonacci_spiral_are_unit_and_balanced() -> None:
    u = fibonacci_directions(5000)
    np.testing.assert_allclose(np.linalg.norm(u, axis=1), 1.0, atol=1e-14)
    assert np.abs(u.mean(axis=0)).max() < 1e-3
    second = u.T @ u / len(u)
    np.testing.assert_allclose(second, np.eye(3) / 3.0, atol=1e-3)


@pytest.mark.parametrize("level", [0, 1, 3])
def test_the_geodesic_triangulation_is_a_closed_outward_sphere(level: int) -> None:
    vertices, triangles = geodesic_triangulation(level)
    assert len(vertices) == 10 * 4**level + 2
    assert len(triangles) == 20 * 4**level
    edges = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    assert len(np.unique(edges, axis=0)) == len(edges)
    assert {tuple(e) for e in edges} == {tuple(e[::-1]) for e in edges}
    corners = vertices[triangles]
    assert np.all(np.linalg.det(corners) > 0.0)


def test_subdividing_some_triangles_keeps_the_numbering_of_the_old_vertices() -> None:
    vertices, triangles = geodesic_triangulation(1)
    finer, children = subdivide(vertices, triangles[:7])
    np.testing.assert_array_equal(finer[: len(vertices)], vertices)
    assert len(children) == 28
    # The signed solid volumes under the children keep orientation.
    assert np.all(np.linalg.det(finer[children]) > 0.0)

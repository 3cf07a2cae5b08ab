"""The loading zone of bodies whose focal surface is known, and what it refuses."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

from gomboc_cad.body import Body, Harmonic, depth_mm, make_body
from gomboc_cad.equilibria import Census, find_equilibria
from gomboc_cad.equilibria.margin import s_margin_mm
from gomboc_cad.equilibria.zone import LoadingZone, loading_zone, margins_towards_rest
from gomboc_cad.errors import CensusError, NotConvexError
from tests.body.shapes import ellipsoid

SPHERE = Body("sphere", Harmonic((((2, 0), 0.0),)), 10.0)


def mesh_of(zone: LoadingZone) -> trimesh.Trimesh:
    return trimesh.Trimesh(zone.vertices_mm, zone.faces, process=False)


def shells(zone: LoadingZone) -> list[trimesh.Trimesh]:
    """Connected pieces of the boundary, the largest first."""
    return sorted(mesh_of(zone).split(only_watertight=False), key=lambda part: -part.area)


@pytest.fixture(scope="module")
def sphere_zone() -> LoadingZone:
    return loading_zone(SPHERE, (0.0, 0.0, -2.0))


def test_the_zone_of_a_sphere_is_all_but_its_centre(sphere_zone: LoadingZone) -> None:
    """The focal surface of a sphere is its centre: a lowered COM has one rest, its margin the depth."""
    assert sphere_zone.s_margin_mm == pytest.approx(2.0, rel=1e-9)
    assert sphere_zone.best_s_margin_mm == pytest.approx(5.0, rel=1e-3)
    assert np.linalg.norm(sphere_zone.best_com_mm) == pytest.approx(5.0, rel=1e-3)
    assert sphere_zone.nearest_best_s_margin_mm == pytest.approx(5.0, rel=1e-3)
    assert sphere_zone.volume_mm3 == pytest.approx(4.0 / 3.0 * np.pi * 1e3, rel=2e-3)
    outer, inner = shells(sphere_zone)
    np.testing.assert_allclose(np.linalg.norm(outer.vertices, axis=1), 10.0, rtol=1e-9)
    assert np.linalg.norm(inner.vertices, axis=1).max() < sphere_zone.resolution_mm(np.zeros((1, 3)))[0]


def test_the_boundary_is_closed_and_turned_outwards(sphere_zone: LoadingZone) -> None:
    mesh = mesh_of(sphere_zone)
    assert mesh.is_watertight
    assert mesh.is_winding_consistent
    assert mesh.volume == pytest.approx(sphere_zone.volume_mm3, rel=1e-9)
    assert mesh.area_faces.min() > 0.0


def test_margins_towards_the_rest_of_a_sphere(sphere_zone: LoadingZone) -> None:
    """Lowered by s: margin s up to half the radius, from there on the surface is nearer."""
    lowered = np.array([0.0, 1.0, 3.0, 5.0, 7.0])
    expected = [2.0, 3.0, 5.0, 3.0, 1.0]
    np.testing.assert_allclose(margins_towards_rest(sphere_zone, lowered), expected, rtol=1e-6)


@pytest.fixture(scope="module")
def ellipsoid_zone() -> LoadingZone:
    body, _ = ellipsoid((1.1, 1.0, 0.92), 12)
    return loading_zone(body, (0.0, 0.0, -0.5))


def test_the_zone_of_an_ellipsoid_is_outside_its_evolute(ellipsoid_zone: LoadingZone) -> None:
    """In the plane y = 0 the focal sheet is `(a x)^⅔ + (c z)^⅔ = (a² − c²)^⅔` or within it."""
    _, axes = ellipsoid((1.1, 1.0, 0.92), 12)
    inner = shells(ellipsoid_zone)[1]
    x, y, z = np.abs(inner.vertices).T
    a, b, c = axes
    reach = ellipsoid_zone.resolution_mm(inner.vertices).max()
    assert x.max() == pytest.approx((a * a - c * c) / a, abs=reach)
    assert z.max() < (a * a - c * c) / c + reach
    assert y.max() < (a * a - c * c) / b + reach
    assert mesh_of(ellipsoid_zone).is_watertight


def test_zones_about_two_places_that_hang_together_are_the_same(ellipsoid_zone: LoadingZone) -> None:
    other = loading_zone(ellipsoid_zone.body, (0.0, 0.45, 0.2))
    assert other.volume_mm3 == pytest.approx(ellipsoid_zone.volume_mm3, rel=2e-3)
    assert other.best_s_margin_mm == pytest.approx(ellipsoid_zone.best_s_margin_mm, rel=0.01)


def test_the_best_ball_touches_walls_and_cannot_be_bettered_nearby(ellipsoid_zone: LoadingZone) -> None:
    body, best = ellipsoid_zone.body, np.array(ellipsoid_zone.best_com_mm)
    rng = np.random.default_rng(3)
    for step in rng.normal(size=(8, 3)):
        place = best + 0.02 * step / np.linalg.norm(step)
        room = min(s_margin_mm(body, place), depth_mm(body, place)[0])
        assert room <= ellipsoid_zone.best_s_margin_mm * (1.0 + 2e-3)


def test_the_zone_scales_with_the_body(sphere_zone: LoadingZone) -> None:
    small = loading_zone(SPHERE.with_diameter(2.0), (0.0, 0.0, -0.2))
    assert small.volume_mm3 == pytest.approx(sphere_zone.volume_mm3 / 1e3, rel=1e-6)
    change = np.abs(10.0 * small.vertices_mm - sphere_zone.vertices_mm)
    # Rounding may pick another of two samples that are equally near.
    assert np.median(change) < 1e-9
    assert change.max() < 0.02


def test_coarser_cells_make_the_same_zone_of_fewer_faces(sphere_zone: LoadingZone) -> None:
    coarse = loading_zone(SPHERE, sphere_zone.com_mm, fineness=0.5)
    assert len(coarse.faces) < 0.5 * len(sphere_zone.faces)
    assert mesh_of(coarse).is_watertight
    assert coarse.volume_mm3 == pytest.approx(sphere_zone.volume_mm3, rel=5e-3)
    assert coarse.best_s_margin_mm == pytest.approx(sphere_zone.best_s_margin_mm, rel=1e-3)
    place = np.array([[0.0, 0.0, 4.0]])
    assert coarse.resolution_mm(place) == pytest.approx(2.0 * sphere_zone.resolution_mm(place))
    with pytest.raises(CensusError, match=r"from 0\.5 to 2, not 0\.1"):
        loading_zone(SPHERE, sphere_zone.com_mm, fineness=0.1)


def test_a_com_without_exactly_one_rest_has_no_zone(primary: Body, primary_census: Census) -> None:
    witness = np.array(primary_census.margin.s_witness_mm)
    beyond = witness + 0.2 * (witness - np.array(primary_census.com_mm))
    assert sum(e.kind == "stable" for e in find_equilibria(primary, beyond)) == 2
    with pytest.raises(CensusError, match="2 stable rests"):
        loading_zone(primary, beyond)


def test_a_com_at_the_edge_of_its_zone_is_refused(primary: Body, primary_census: Census) -> None:
    com = np.array(primary_census.com_mm)
    edge = com + (1.0 - 1e-5) * (np.array(primary_census.margin.s_witness_mm) - com)
    with pytest.raises(CensusError, match="at the edge of its loading zone"):
        loading_zone(primary, edge)


def test_bodies_and_centres_that_have_no_zone(primary: Body) -> None:
    with pytest.raises(NotConvexError):
        loading_zone(make_body("sloan2", 0.05))
    with pytest.raises(CensusError, match="outside"):
        loading_zone(primary, (0.0, 2.0, 0.0))
    with pytest.raises(CensusError, match="three finite numbers"):
        loading_zone(primary, (np.nan, 0.0, 0.0))

"""Points on facets: spread evenly, and the nearest ones those that trimesh finds."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

from gomboc_cad.solid.facets import facet_normals, nearest_on_facets, spread_points
from tests.solid.manifolds import block, mesh_of, rod


def test_normals_point_out_and_areas_add_up() -> None:
    mesh = mesh_of(block(2.0, 3.0, 4.0))
    normals, areas = facet_normals(mesh)
    assert areas.sum() == pytest.approx(52.0)
    assert np.all(np.vecdot(normals, mesh.vertices_mm[mesh.faces].mean(axis=1)) > 0.0)


def test_spread_points_lie_on_their_facets_each_with_its_share_of_points() -> None:
    mesh = mesh_of(block(2.0, 3.0, 4.0) - rod(0.5, 9.0))
    points, facets = spread_points(mesh, 20_000)
    normals, areas = facet_normals(mesh)
    on_plane = np.vecdot(normals[facets], points - mesh.vertices_mm[mesh.faces[facets, 0]])
    assert np.abs(on_plane).max() < 1e-12
    places, _ = nearest_on_facets(points[::50], mesh.vertices_mm[mesh.faces])
    assert np.abs(places - points[::50]).max() < 1e-12
    counts = np.bincount(facets, minlength=len(areas))
    assert np.abs(counts - 20_000 * areas / areas.sum()).max() <= 1.0


def test_nearest_points_of_triangles_are_those_of_trimesh() -> None:
    rng = np.random.default_rng(4)
    corners, points = rng.normal(size=(30, 3, 3)), 2.0 * rng.normal(size=(200, 3))
    places, facets = nearest_on_facets(points, corners)
    pairs = np.repeat(corners[None], len(points), axis=0).reshape(-1, 3, 3)
    each = trimesh.triangles.closest_point(pairs, np.repeat(points, len(corners), axis=0)).reshape(-1, 30, 3)
    distances = np.linalg.norm(each - points[:, None], axis=2)
    assert np.linalg.norm(places - points, axis=1) == pytest.approx(distances.min(axis=1), abs=1e-12)
    assert np.array_equal(facets, distances.argmin(axis=1))


def test_each_point_may_have_triangles_of_its_own() -> None:
    rng = np.random.default_rng(5)
    corners, points = rng.normal(size=(50, 4, 3, 3)), rng.normal(size=(50, 3))
    places, facets = nearest_on_facets(points, corners)
    for k in range(50):
        place, facet = nearest_on_facets(points[k : k + 1], corners[k])
        assert np.array_equal(place[0], places[k])
        assert facet[0] == facets[k]

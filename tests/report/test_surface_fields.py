"""The fields on the outer surface, held against integrals and against the exact drill map."""

from __future__ import annotations

import json

import numpy as np
import pytest

from gomboc_cad.body import catalog
from gomboc_cad.body.sphere import geodesic_triangulation
from gomboc_cad.equilibria import Census, mesh_census, smooth_census
from gomboc_cad.equilibria.drill_map import safe_radius_mm
from gomboc_cad.report.body_figures import plot_body
from gomboc_cad.report.style import figure_of
from gomboc_cad.report.surface_fields import SurfaceFields, surface_fields

COM_MM = (-0.411, 0.0, 0.0)


@pytest.fixture(scope="module")
def census() -> Census:
    return smooth_census(catalog()["primary"], COM_MM)


@pytest.fixture(scope="module")
def fields(census: Census) -> SurfaceFields:
    return surface_fields(catalog()["primary"], COM_MM, census.rest)


def test_the_curvature_integrates_to_that_of_a_sphere(fields: SurfaceFields) -> None:
    """Gauss and Bonnet: the integral of the Gaussian curvature over a closed surface is 4π."""
    a, b, c = np.moveaxis(fields.positions_mm[fields.faces], 1, 0)
    area = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)
    total = area @ fields.gaussian_curvature_per_mm2[fields.faces].mean(axis=1)
    assert total == pytest.approx(4.0 * np.pi, rel=2e-3)
    assert fields.gaussian_curvature_per_mm2.min() > 0.0


def test_the_deviation_is_the_distance_from_the_sphere(fields: SurfaceFields) -> None:
    distance = np.linalg.norm(fields.positions_mm, axis=1)
    np.testing.assert_allclose(fields.deviation_mm, distance - 50.0, atol=1e-9)
    # Radii from 48.80 to 51.10 mm are on record for the primary of 100 mm.
    assert fields.deviation_mm.min() == pytest.approx(-1.20, abs=0.01)
    assert fields.deviation_mm.max() == pytest.approx(1.12, abs=0.03)


def test_the_drill_radius_is_that_of_the_drill_map_to_a_few_percent(fields: SurfaceFields) -> None:
    rows = np.random.default_rng(0).choice(len(fields.positions_mm), 60, replace=False)
    directions = geodesic_triangulation(5)[0][rows]
    exact = safe_radius_mm(catalog()["primary"], directions, COM_MM)
    assert fields.drill_radius_mm is not None
    ratio = fields.drill_radius_mm[rows] / exact
    assert ratio.min() > 0.88
    assert ratio.max() < 1.05


def test_the_pose_stands_on_its_rest(fields: SurfaceFields, census: Census) -> None:
    pose = np.array(fields.pose)
    np.testing.assert_allclose(pose @ pose.T, np.eye(3), atol=1e-12)
    assert np.linalg.det(pose) == pytest.approx(1.0)
    lowest = ((fields.positions_mm - COM_MM) @ pose[2]).min()
    assert -lowest == pytest.approx(census.rest.height_mm, abs=0.05)


def test_json_gives_the_fields_back(fields: SurfaceFields) -> None:
    text = json.dumps(fields.document())
    assert len(text) < 600_000
    back = SurfaceFields.of_document(json.loads(text))
    np.testing.assert_array_equal(back.faces, fields.faces)
    np.testing.assert_allclose(back.positions_mm, fields.positions_mm, atol=1e-3)
    np.testing.assert_allclose(back.normals, fields.normals, atol=2e-5)
    for name in ("deviation_mm", "gaussian_curvature_per_mm2", "drill_radius_mm"):
        values = getattr(fields, name)
        np.testing.assert_allclose(getattr(back, name), values, atol=1e-5 * np.ptp(values))
    assert (back.radius_mm, back.com_mm, back.pose) == (fields.radius_mm, fields.com_mm, fields.pose)


def test_a_dented_body_has_no_drill_map_and_is_drawn_without() -> None:
    body = catalog()["second"]
    directions, faces = geodesic_triangulation(3)
    census = mesh_census(body.position_mm(directions), faces)
    fields = surface_fields(body, census.com_mm, census.rest, level=4)
    assert fields.gaussian_curvature_per_mm2.min() < 0.0
    back = SurfaceFields.of_document(json.loads(json.dumps(fields.document())))
    assert back.drill_radius_mm is None
    with pytest.raises(ValueError, match="not strictly convex"):
        plot_body(back, "drill")


def test_the_figure_shows_three_bodies_on_a_table(fields: SurfaceFields) -> None:
    ax = plot_body(fields)
    assert len(ax.collections) == 3
    (table,) = (line for line in ax.lines if len(line.get_xdata()) == 2)
    lowest = ((fields.positions_mm - COM_MM) @ np.array(fields.pose[2])).min()
    np.testing.assert_allclose(table.get_ydata(), lowest)
    assert len(figure_of(ax).axes) == 2  # with the scale


def test_axes_that_are_given_are_drawn_on(fields: SurfaceFields) -> None:
    first = plot_body(fields, "curvature")
    ax = figure_of(first).add_subplot()
    assert plot_body(fields, "drill", ax) is ax

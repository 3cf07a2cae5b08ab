"""The section of the loading zone, held against the census at places of it and against the margin."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

from gomboc_cad.body import catalog
from gomboc_cad.equilibria import Census, smooth_census
from gomboc_cad.equilibria.margin import s_margin_mm
from gomboc_cad.equilibria.smooth import find_equilibria
from gomboc_cad.errors import CensusError
from gomboc_cad.report.style import new_axes
from gomboc_cad.report.zone_figures import plot_zone_section
from gomboc_cad.report.zone_section import Fields, ZoneMesh, ZoneSection, zone_mesh, zone_section

COM_MM = (-0.411, 0.0, 0.0)
SPREAD_MM2 = np.diag([0.01, 0.0025, 0.04])


@pytest.fixture(scope="module")
def census() -> Census:
    return smooth_census(catalog()["primary"], COM_MM)


@pytest.fixture(scope="module")
def section(census: Census) -> ZoneSection:
    return zone_section(catalog()["primary"], census, SPREAD_MM2)


def places_of(fields: Fields) -> np.ndarray:
    count = len(fields.rests)
    return fields.reach_mm * (2.0 * (np.arange(count) + 0.5) / count - 1.0)


@pytest.mark.parametrize("name", ["whole", "close_up"])
def test_every_field_has_the_rests_that_the_census_counts(section: ZoneSection, name: str) -> None:
    fields: Fields = getattr(section, name)
    places, rng = places_of(fields), np.random.default_rng(0)
    inside = np.argwhere(fields.rests > 0)
    wrong = 0
    for row, column in rng.choice(inside, 25, replace=False):
        com = COM_MM + np.array([places[column], places[row]]) @ np.array(section.axes)
        found = sum(e.kind == "stable" for e in find_equilibria(catalog()["primary"], com))
        wrong += found != fields.rests[row, column]
    # A cell that a curve passes through may belong to either side.
    assert wrong <= 1
    assert set(np.unique(fields.rests)) >= {1, 2}


def test_the_margin_reaches_to_the_nearest_curve(section: ZoneSection, census: Census) -> None:
    assert census.margin is not None
    assert np.hypot(*section.witness_mm) == pytest.approx(census.margin.s_margin_mm, rel=1e-9)
    nearest = min(np.linalg.norm(curve, axis=1).min() for curve in section.curves_mm)
    assert nearest == pytest.approx(section.s_margin_mm, rel=0.01)


def test_the_number_of_rests_changes_at_the_witness(section: ZoneSection) -> None:
    """Just within the S-margin there is one rest, just beyond it another."""
    for factor, rests in ((0.97, 1), (1.03, 2)):
        com = COM_MM + factor * np.array(section.witness_mm) @ np.array(section.axes)
        assert sum(e.kind == "stable" for e in find_equilibria(catalog()["primary"], com)) == rests


def test_the_plane_holds_the_direction_that_points_down(section: ZoneSection, census: Census) -> None:
    right, up = np.array(section.axes)
    np.testing.assert_allclose(up, -np.array(census.rest.direction), atol=1e-12)
    assert right @ up == pytest.approx(0.0, abs=1e-12)
    np.testing.assert_allclose(
        section.com_covariance_mm2, np.array(section.axes) @ SPREAD_MM2 @ np.array(section.axes).T
    )


def test_the_outline_is_on_the_body(section: ZoneSection) -> None:
    body = catalog()["primary"]
    points = COM_MM + section.outline_mm @ np.array(section.axes)
    distance = np.linalg.norm(points, axis=1)
    np.testing.assert_allclose(distance, body.radius_at(points / distance[:, None]), rtol=1e-4)


def test_the_wall_is_nowhere_nearer_than_the_margin() -> None:
    body = catalog()["primary"]
    mesh = zone_mesh(body)
    for com in ((-0.411, 0.0, 0.0), (-2.0, 0.5, 0.0)):
        nearest = np.linalg.norm(mesh.vertices_mm - com, axis=1).min()
        assert s_margin_mm(body, com) <= nearest < s_margin_mm(body, com) + 0.3
    back = ZoneMesh.of_document(json.loads(json.dumps(mesh.document())))
    np.testing.assert_allclose(back.vertices_mm, mesh.vertices_mm, atol=1e-3)
    np.testing.assert_array_equal(back.faces, mesh.faces)


def test_json_gives_the_section_back(section: ZoneSection) -> None:
    text = json.dumps(section.document())
    assert len(text) < 300_000
    back = ZoneSection.of_document(json.loads(text))
    for name in ("com_mm", "axes", "s_margin_mm", "witness_mm"):
        assert getattr(back, name) == getattr(section, name)
    np.testing.assert_array_equal(back.close_up.rests, section.close_up.rests)
    np.testing.assert_array_equal(back.whole.rests, section.whole.rests)
    np.testing.assert_allclose(back.curves_mm[0], section.curves_mm[0], atol=2e-3)
    np.testing.assert_array_equal(back.com_covariance_mm2, section.com_covariance_mm2)


def test_without_a_spread_there_is_no_ellipse(census: Census) -> None:
    section = zone_section(catalog()["primary"], census)
    back = ZoneSection.of_document(json.loads(json.dumps(section.document())))
    assert back.com_covariance_mm2 is None
    labels = [line.get_label() for line in plot_zone_section(back).lines]
    assert "95 % of the COM errors" not in labels


def test_a_smaller_margin_of_the_product_is_drawn_beside_that_of_the_body(census: Census) -> None:
    body = catalog()["primary"]
    stored = zone_section(body, census, None, 0.05).document()
    lines = plot_zone_section(ZoneSection.of_document(json.loads(json.dumps(stored)))).lines
    radii = {str(line.get_label()): np.hypot(*line.get_data()).max() for line in lines}
    assert radii["S-margin of the product, 0.05 mm"] == pytest.approx(0.05)
    assert radii["S-margin without openings, 0.382 mm"] == pytest.approx(0.382, abs=5e-4)


def test_the_ellipse_holds_95_percent(section: ZoneSection) -> None:
    ax = new_axes(None, (4.0, 4.0))
    assert plot_zone_section(section, ax) is ax
    (ellipse,) = (line for line in ax.lines if line.get_label() == "95 % of the COM errors")
    covariance = section.com_covariance_mm2
    assert covariance is not None
    points = np.column_stack(ellipse.get_data())
    # Mahalanobis' distance is constant on it; its square has a chi-squared distribution with two degrees.
    squared = np.einsum("ni,ij,nj->n", points, np.linalg.inv(covariance), points)
    np.testing.assert_allclose(squared, 5.991465, rtol=1e-6)


def test_a_census_without_margins_has_no_section(census: Census) -> None:
    with pytest.raises(CensusError, match="no margin"):
        zone_section(catalog()["primary"], replace(census, margin=None))

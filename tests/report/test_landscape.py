"""The map of heights: exact heights, basins of the right size, turned as the body may be."""

from __future__ import annotations

import itertools
import json

import numpy as np
import pytest
from scipy.spatial import ConvexHull
from scipy.spatial.transform import Rotation

from gomboc_cad.body import catalog
from gomboc_cad.body.sphere import geodesic_triangulation
from gomboc_cad.equilibria import Census, mesh_census, smooth_census
from gomboc_cad.equilibria.heights import BodyHeights
from gomboc_cad.errors import CensusError, InspectionError
from gomboc_cad.report.landscape import HeightLandscape, height_landscape
from gomboc_cad.report.landscape_figures import plot_height_histogram, plot_landscape
from gomboc_cad.report.style import figure_of, new_axes
from tests.body.shapes import Array

CUBE = np.array(list(itertools.product((-1.0, 1.0), repeat=3)))


def census_of(corners: Array, com: Array | tuple[float, ...] = (0.0, 0.0, 0.0)) -> Census:
    return mesh_census(corners, ConvexHull(corners).simplices, com, sag_mm=0.0)


def basin_shares(landscape: HeightLandscape) -> list[float]:
    count = sum(pose.kind == "stable" for pose in landscape.poses)
    return [float(landscape.shares[landscape.basins == basin].sum()) for basin in range(count)]


@pytest.fixture(scope="module")
def primary() -> Census:
    return smooth_census(catalog()["primary"])


@pytest.fixture(scope="module")
def landscape(primary: Census) -> HeightLandscape:
    return height_landscape(primary)


def test_heights_of_a_cube_are_those_of_its_corners() -> None:
    """The support function of a cube of edge 2 is |x| + |y| + |z|."""
    census = census_of(CUBE)
    assert census.height_at is not None
    directions = np.random.default_rng(0).normal(size=(50, 3))
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    np.testing.assert_allclose(census.height_at(directions), np.abs(directions).sum(axis=1), rtol=1e-12)


def test_the_map_spans_the_heights_of_the_census(primary: Census, landscape: HeightLandscape) -> None:
    low, high = (e.height_mm for e in (primary.equilibria[0], primary.equilibria[-1]))
    assert low <= landscape.heights_mm.min() < low + 0.05
    assert high - 0.05 < landscape.heights_mm.max() <= high
    assert landscape.shares.sum() == pytest.approx(1.0)
    assert basin_shares(landscape) == [pytest.approx(1.0)]


def test_the_mean_height_is_half_the_mean_width(landscape: HeightLandscape) -> None:
    """Of a body r⁴ = R₀⁴ (1 + 4 f) that is about a sphere; for the ball it is R₀ exactly."""
    mean = float((landscape.shares * landscape.heights_mm).sum())
    assert mean == pytest.approx(50.0, rel=3e-3)


def test_the_rest_is_a_quarter_of_a_turn_left_of_the_middle(landscape: HeightLandscape) -> None:
    longitude, latitude = landscape.place(np.array([landscape.poses[0].direction]))
    assert longitude[0] == pytest.approx(-0.5 * np.pi)
    assert latitude[0] == pytest.approx(0.0, abs=1e-6)


@pytest.mark.parametrize("turn", [None, (0.3, -1.1, 2.0)])
def test_the_six_basins_of_a_cube_are_equal(turn: tuple[float, float, float] | None) -> None:
    corners = CUBE if turn is None else CUBE @ Rotation.from_rotvec(turn).as_matrix().T
    landscape = height_landscape(census_of(corners))
    np.testing.assert_allclose(basin_shares(landscape), 1.0 / 6.0, atol=0.01)


@pytest.mark.parametrize("seed", [5, 8])
def test_basins_have_the_probabilities_of_a_quasi_static_release(seed: int) -> None:
    """Which the census of a mesh finds by following every release over the facets."""
    corners = np.random.default_rng(seed).normal(size=(14, 3))
    census = census_of(corners, corners.mean(axis=0))
    expected = [e.probability for e in census.equilibria if e.kind == "stable"]
    assert len(expected) > 1
    np.testing.assert_allclose(basin_shares(height_landscape(census)), expected, atol=0.01)


def test_two_rests_of_a_smooth_body_have_a_basin_each() -> None:
    """Both of them, the maxima and the saddles between them lie in their basins or on the border."""
    census = smooth_census(catalog()["primary"], (1.0, 0.8, 0.5))
    landscape = height_landscape(census)
    assert census.stable == 2
    assert min(basin_shares(landscape)) > 0.2
    rests = np.array([pose.direction for pose in landscape.poses if pose.kind == "stable"])
    longitude, latitude = landscape.place(rests)
    row = np.abs(landscape.latitudes[:, None] - latitude).argmin(axis=0)
    column = np.abs(landscape.longitudes[:, None] - longitude).argmin(axis=0)
    assert landscape.basins[row, column].tolist() == [0, 1]


def test_a_dented_body_stands_on_its_hull() -> None:
    """Over a dent the hull is higher than any point of the surface with that normal."""
    body, com = catalog()["second"], np.array([0.1, 0.2, 0.3])
    directions = geodesic_triangulation(3)[0]
    points = body.surface(directions)
    heights = BodyHeights(body, com)(points.normal)
    own = np.einsum("nx,nx->n", points.position_mm - com, points.normal)
    assert np.all(heights >= own - 1e-9)
    assert (heights > own + 1e-3).any()


def test_json_gives_the_map_back(landscape: HeightLandscape) -> None:
    text = json.dumps(landscape.document())
    assert len(text) < 100_000
    back = HeightLandscape.of_document(json.loads(text))
    np.testing.assert_allclose(back.heights_mm, landscape.heights_mm, atol=1e-4)
    np.testing.assert_array_equal(back.basins, landscape.basins)
    assert (back.axes, back.poses) == (landscape.axes, landscape.poses)


@pytest.mark.parametrize("damage", [{"poses": [{"kind": "odd", "direction": [0, 0, 1], "height_mm": 1.0}]}])
def test_a_damaged_map_is_refused(landscape: HeightLandscape, damage: dict[str, object]) -> None:
    with pytest.raises(InspectionError, match="damaged"):
        HeightLandscape.of_document(landscape.document() | damage)
    smaller = landscape.document() | {"basins": height_landscape(census_of(CUBE), 8).document()["basins"]}
    with pytest.raises(InspectionError, match="damaged"):
        HeightLandscape.of_document(smaller)


def test_a_census_without_a_shape_cannot_be_drawn(primary: Census) -> None:
    from dataclasses import replace

    with pytest.raises(CensusError, match="shape"):
        height_landscape(replace(primary, height_at=None))


def test_the_figure_marks_every_equilibrium() -> None:
    census = smooth_census(catalog()["primary"], (1.0, 0.8, 0.5))
    ax = plot_landscape(height_landscape(census, latitudes=30))
    marked = {line.get_label(): len(line.get_xdata()) for line in ax.lines}
    assert marked == {"stable rest (2)": 2, "saddle (2)": 2, "unstable equilibrium (2)": 2}
    legend = ax.get_legend()
    assert legend is not None
    assert legend.get_title().get_text().startswith("2 basins")


def test_a_census_draws_itself_on_given_axes(primary: Census) -> None:
    ax = new_axes(None, (4.0, 3.0), "mollweide")
    assert primary.plot(ax) is ax
    assert figure_of(ax) is ax.get_figure(root=True)
    with pytest.raises(ValueError, match="mollweide"):
        primary.plot(new_axes(None, (4.0, 3.0)))


def test_the_histogram_is_a_density(landscape: HeightLandscape) -> None:
    bars = plot_height_histogram(landscape).patches
    assert sum(bar.get_width() * bar.get_height() for bar in bars) == pytest.approx(1.0)

"""The drill map as a table and as a picture."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from gomboc_cad.body import catalog
from gomboc_cad.equilibria.drill_map import DrillMap, drill_limits, drill_map
from gomboc_cad.errors import OutputError
from gomboc_cad.report.drill_figures import draw_drill_map, write_drill_table
from gomboc_cad.report.style import figure_of, new_axes, write_figure


@pytest.fixture(scope="module")
def drilling() -> DrillMap:
    return drill_map(catalog()["primary"], sites=60)


def test_the_table_can_be_read_and_says_what_the_map_says(drilling: DrillMap, tmp_path: Path) -> None:
    path = tmp_path / "drill.csv"
    write_drill_table(drilling, path)
    with path.open(newline="") as stream:
        rows = list(csv.DictReader(stream))
    assert [row["kind"] for row in rows] == ["best"] * len(drilling.best) + ["site"] * 60
    assert float(rows[0]["radius_mm"]) == pytest.approx(drilling.max_radius_mm, rel=1e-5)
    normals = np.array([[float(row[f"normal_{axis}"]) for axis in "xyz"] for row in rows])
    places = np.array([[float(row[f"{axis}_mm"]) for axis in "xyz"] for row in rows])
    again = drill_limits(drilling.body, normals / np.linalg.norm(normals, axis=1)[:, None], drilling.com_mm)
    np.testing.assert_allclose(again.positions_mm, places, atol=2e-3)
    for column in ("radius_mm", "refined_radius_mm", "flat_depth_mm"):
        values = [float(row[column]) for row in rows]
        np.testing.assert_allclose(values, getattr(again, column), rtol=0.01, atol=1e-3)


def test_the_picture_is_that_of_the_map_and_the_same_each_time(drilling: DrillMap, tmp_path: Path) -> None:
    first, second = tmp_path / "map.png", tmp_path / "again.png"
    draw_drill_map(drilling, first)
    ax = drilling.plot()
    write_figure(figure_of(ax), second)
    assert first.read_bytes() == second.read_bytes()
    with Image.open(first) as image:
        assert len(image.convert("RGB").getcolors(1 << 24)) > 100
    (cells,) = ax.collections
    # No cell is better than the best place.
    assert 0.8 * drilling.max_radius_mm < cells.get_array().max() < 1.02 * drilling.max_radius_mm


def test_a_map_needs_its_projection(drilling: DrillMap) -> None:
    with pytest.raises(ValueError, match="mollweide"):
        drilling.plot(new_axes(None, (4.0, 3.0)))


def test_other_kinds_of_files_are_refused(drilling: DrillMap, tmp_path: Path) -> None:
    with pytest.raises(OutputError, match=r"\.png or \.svg"):
        draw_drill_map(drilling, tmp_path / "map.pdf")

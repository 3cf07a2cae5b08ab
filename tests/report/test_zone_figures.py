"""Figures of the loading zone: sections that are really cut, and files that are whole and repeatable."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from gomboc_cad.body import catalog
from gomboc_cad.body.sphere import geodesic_triangulation
from gomboc_cad.equilibria.zone import LoadingZone, loading_zone
from gomboc_cad.errors import OutputError
from gomboc_cad.report.canvas import new_figure, write_figure
from gomboc_cad.report.zone_figures import draw_zone, section_loops
from tests.body.shapes import Array


def signed_area(loop: Array) -> float:
    x, y = loop.T
    return 0.5 * float(x @ np.roll(y, -1) - y @ np.roll(x, -1))


@pytest.mark.parametrize("plane", [(0, 1), (0, 2), (1, 2)])
def test_a_section_of_a_hollow_ball_is_a_ring(plane: tuple[int, int]) -> None:
    vertices, faces = geodesic_triangulation(5)
    both = np.concatenate([2.0 * vertices, vertices])
    loops = section_loops(
        both, np.concatenate([faces, faces[:, ::-1] + len(vertices)]), np.full(3, 0.3), plane
    )
    assert len(loops) == 2
    outer, inner = sorted(map(signed_area, loops), key=abs, reverse=True)
    assert abs(outer) == pytest.approx(np.pi * (4.0 - 0.09), rel=2e-3)
    assert abs(inner) == pytest.approx(np.pi * (1.0 - 0.09), rel=2e-3)
    assert outer * inner < 0.0
    radii = [np.linalg.norm(loop, axis=1) for loop in loops]
    assert max(np.ptp(radius) for radius in radii) < 5e-3


def test_a_plane_beside_the_mesh_cuts_nothing() -> None:
    vertices, faces = geodesic_triangulation(2)
    assert section_loops(vertices, faces, np.array([0.0, 0.0, 1.5]), (0, 1)) == []


@pytest.fixture(scope="module")
def zone() -> LoadingZone:
    return loading_zone(catalog()["primary"], (-15.0, 0.0, 0.0))


def test_the_figure_is_written_and_is_the_same_each_time(zone: LoadingZone, tmp_path: Path) -> None:
    first, second = tmp_path / "zone.png", tmp_path / "again.png"
    draw_zone(zone, first)
    draw_zone(zone, second)
    assert first.read_bytes() == second.read_bytes()
    with Image.open(first) as image:
        assert min(image.size) > 1000
        colors = {color for _, color in image.convert("RGB").getcolors(1 << 24)}
    assert (0xCF, 0xE3, 0xF4) in colors
    assert sorted(path.name for path in tmp_path.iterdir()) == ["again.png", "zone.png"]


def test_other_kinds_of_files_are_refused(zone: LoadingZone, tmp_path: Path) -> None:
    with pytest.raises(OutputError, match=r"\.png or \.svg"):
        draw_zone(zone, tmp_path / "zone.gif")
    assert list(tmp_path.iterdir()) == []


def test_figures_as_svg_are_the_same_each_time(tmp_path: Path) -> None:
    for name in ("one.svg", "two.svg"):
        figure = new_figure(3.0, 2.0)
        figure.add_subplot().plot([0.0, 1.0], [0.0, 1.0])
        write_figure(figure, tmp_path / name)
    assert (tmp_path / "one.svg").read_bytes() == (tmp_path / "two.svg").read_bytes()
    assert "<dc:date>" not in (tmp_path / "one.svg").read_text(encoding="utf-8")

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
from gomboc_cad.report.sections import section_loops
from gomboc_cad.report.style import BLUE, new_axes
from gomboc_cad.report.zone_figures import draw_zone
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
    return loading_zone(catalog()["primary"], (-15.0, 0.0, 0.0), fineness=0.5)


def test_the_figure_is_written(zone: LoadingZone, tmp_path: Path) -> None:
    path = tmp_path / "zone.png"
    draw_zone(zone, path)
    with Image.open(path) as image:
        assert min(image.size) > 1000
        colors = {color for _, color in image.getcolors(1 << 24)}
    # The zone is laid over whatever is below.
    blue = tuple(int(BLUE[k : k + 2], 16) for k in (1, 3, 5))
    assert any(color[:3] == blue and 0 < color[3] < 255 for color in colors)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["zone.png"]


def test_other_kinds_of_files_are_refused(zone: LoadingZone, tmp_path: Path) -> None:
    with pytest.raises(OutputError, match=r"\.png or \.svg"):
        draw_zone(zone, tmp_path / "zone.gif")
    assert list(tmp_path.iterdir()) == []


def test_a_zone_draws_the_section_at_its_nearest_wall(zone: LoadingZone) -> None:
    ax = new_axes(None, (4.0, 4.0))
    assert zone.plot(ax) is ax
    (nearest,) = (line for line in ax.lines if line.get_label() == "nearest place with other rests")
    distance = np.hypot(*nearest.get_data())
    assert distance == pytest.approx([zone.s_margin_mm], rel=1e-3)

"""Closed forms of the simple solids, against the exact census of their meshes."""

from __future__ import annotations

import numpy as np
import pytest

from gomboc_cad.body.mass import mesh_mass
from gomboc_cad.body.sphere import fibonacci_directions
from gomboc_cad.equilibria import mesh_census
from gomboc_cad.equilibria.drainage_shapes import PaperShape, paper_shape, ring_mesh
from gomboc_cad.paper.landscape import heights_and_slopes
from gomboc_cad.paper.solids import solid

SHAPES: tuple[PaperShape, ...] = ("cylinder", "hemisphere", "ellipsoid", "capsule", "cube")


@pytest.mark.parametrize("name", SHAPES)
def test_rests_height_range_and_largest_basin_are_those_of_the_census(name: PaperShape) -> None:
    known, census = solid(name), mesh_census(*paper_shape(name, 61, 120))
    poses = [pose for pose in census.equilibria if pose.kind == "stable"]
    assert census.stable == known.rests
    assert ("ring" in {pose.extent for pose in poses}) == ("ring" in known.neutral)
    assert census.height_range_mm == pytest.approx(known.height_range, rel=1e-3)
    assert max(pose.probability or 0.0 for pose in poses) == pytest.approx(known.boa, abs=1e-3)


@pytest.mark.parametrize("name", [name for name in SHAPES if solid(name).sre is not None])
def test_mean_drops_are_those_of_the_mesh(name: PaperShape) -> None:
    known, mesh = solid(name), paper_shape(name, 61, 120)
    com = np.array(mesh_mass(*mesh).com_mm)
    heights = heights_and_slopes(mesh.vertices, com, fibonacci_directions(20_000))[0]
    lowest = mesh_census(*mesh, probabilities=False).rest.height_mm
    assert heights.mean() - lowest == pytest.approx(known.sre, rel=2e-3)


def test_a_ball_with_a_lowered_com_has_the_slope_of_its_closed_form() -> None:
    """`h = 1 − s cos a` has `|∇h| = s sin a`, whose mean over the sphere is π s / 4."""
    s = 0.2
    vertices = ring_mesh(lambda u: u, 101, 200).vertices
    heights, slopes = heights_and_slopes(vertices, np.array([0.0, 0.0, -s]), fibonacci_directions(5000))
    assert heights.mean() == pytest.approx(1.0, abs=1e-3)
    assert slopes.mean() == pytest.approx(0.25 * np.pi * s, rel=2e-3)

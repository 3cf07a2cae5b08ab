"""Hydrostatics against capytaine, which integrates over the facets that it clips with one point each.

Its volumes are exact and its moments good to the square of the facets' size, so the meshes are fine ones.
"""

from __future__ import annotations

from types import ModuleType

import numpy as np
import pytest

from gomboc_cad.body.sphere import unit
from tests.equilibria.polyhedra import Mesh
from tests.hydrostatics.hulls import float_with, sloan


def fine_box() -> Mesh:
    """A box of 10 by 6 by 4 of small triangles."""
    count = 24
    steps = np.linspace(-1.0, 1.0, count + 1)
    a, b = (grid.ravel() for grid in np.meshgrid(steps, steps, indexing="ij"))
    i, j = (grid.ravel() for grid in np.meshgrid(*[np.arange(count)] * 2, indexing="ij"))
    corner = i * (count + 1) + j
    quads = np.stack([corner, corner + count + 1, corner + count + 2, corner + 1], axis=1)
    triangles = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
    side = np.column_stack([a, b, np.ones_like(a)])
    points, faces = [], []
    for axis in range(3):
        for sign in (1.0, -1.0):
            turned = np.roll(side * (1.0, sign, sign), axis, axis=1)
            faces.append(triangles + len(points) * len(side))
            points.append(turned)
    vertices, inverse = np.unique(np.round(np.concatenate(points), 9), axis=0, return_inverse=True)
    return Mesh(vertices * (5.0, 3.0, 2.0), inverse.ravel()[np.concatenate(faces)])


CASES = {
    "upright box": (fine_box, (0.0, 0.0, 1.0), 0.4),
    "box on its side": (fine_box, (0.0, 1.0, 0.0), 0.7),
    "box on a corner": (fine_box, (0.4, -0.5, 0.8), 0.55),
    "Sloan body": (lambda: sloan(4), (0.2, 0.7, -0.4), 0.35),
    "deep Sloan body": (lambda: sloan(4), (-0.9, 0.1, 0.3), 0.8),
}


@pytest.mark.parametrize("case", CASES)
def test_capytaine_finds_the_same(capytaine: ModuleType, case: str) -> None:
    make, up, share = CASES[case]
    mesh = make()
    com = np.array([0.3, -0.2, -0.5])
    state = float_with(mesh, share, com, up)
    z = unit(np.array(up))
    x = np.array(state.heel_axes[0])
    turn = np.stack([x, np.cross(z, x), z])
    points = mesh.vertices @ turn.T
    # It takes the second moments about its own axes, which therefore go through the centre of flotation.
    rise = -turn @ np.array(state.center_of_flotation_mm)
    assert points[:, 2].min() + rise[2] == pytest.approx(-state.draft_mm)
    theirs = capytaine.FloatingBody(
        mesh=capytaine.Mesh(vertices=points + rise, faces=mesh.faces.tolist()),
        center_of_mass=turn @ com + rise,
    ).immersed_part()
    size = float(np.ptp(points, axis=0).max())
    assert theirs.volume == pytest.approx(state.displaced_volume_mm3, rel=1e-9)
    ours = turn @ np.array(state.center_of_buoyancy_mm) + rise
    assert theirs.center_of_buoyancy == pytest.approx(ours, abs=5e-4 * size)
    assert theirs.waterplane_area == pytest.approx(state.waterplane_area_mm2, rel=1e-9)
    heights = (theirs.transversal_metacentric_height, theirs.longitudinal_metacentric_height)
    assert heights == pytest.approx(state.gm_mm, abs=1e-3 * size)

"""Stepped seams: both kernels give the same parts, which share the material less the clearance."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from build123d import Solid

from gomboc_cad import Body
from gomboc_cad.errors import GeometryError
from gomboc_cad.solid.boundary import Boundary
from gomboc_cad.solid.hollow import Box, Cylinder, HollowBody, Mesh, Seam, brep, mesh, split_brep, split_mesh
from gomboc_cad.solid.mass import solid_mass
from tests.solid.conftest import ORIGIN
from tests.solid.inspection import problems_on_disk

SAG_UM = 30.0
UP = (0.0, 0.0, 1.0)
TONGUE = Cylinder((0.0, 0.0, -2.0), UP, 26.0, 3.0, 24.5)
GROOVE = Cylinder((0.0, 0.0, -2.3), UP, 26.2, 3.3, 24.3)
FLANGE = Cylinder((0.0, 0.0, -5.0), UP, 32.0, 10.0, 23.0)
DOWEL_HOLE = Cylinder((0.0, 28.1, -3.0), UP, 0.5, 6.0)


STEPPED = Seam(ORIGIN, UP, (TONGUE,), (GROOVE,))


@dataclass(frozen=True)
class Shell:
    hollow: HollowBody
    solid: Solid
    mesh: Mesh


@dataclass(frozen=True)
class Parts:
    """The two sides of a seam in both kernels, with their boundaries."""

    solids: tuple[Solid, Solid]
    meshes: tuple[Mesh, Mesh]
    boundaries: tuple[Boundary, Boundary]

    def problems(self, folder: Path) -> tuple[str, ...]:
        sides = zip(self.solids, self.meshes, self.boundaries, strict=True)
        return tuple(problem for side in sides for problem in problems_on_disk(folder, *side, SAG_UM))


@pytest.fixture(scope="module")
def shell(primary: Body) -> Shell:
    """A shell of 60 mm with an annular flange inside, across the seam, and an enclosed hole in it."""
    hollow = HollowBody(
        primary.with_diameter(60.0), 2.0, (0.1, -0.05, 0.08), bosses=(FLANGE,), holes=(DOWEL_HOLE,)
    )
    return Shell(hollow, brep(hollow), mesh(hollow, SAG_UM))


def split(shell: Shell, seam: Seam) -> Parts:
    return Parts(
        split_brep(shell.solid, seam),
        split_mesh(shell.mesh, seam, SAG_UM),
        Boundary.of_hollow(shell.hollow).split(seam),
    )


@pytest.fixture(scope="module")
def stepped(shell: Shell) -> Parts:
    return split(shell, STEPPED)


def test_tongue_and_groove_pass_the_inspection_of_their_files(stepped: Parts, tmp_path: Path) -> None:
    assert stepped.problems(tmp_path) == ()


def test_what_is_lost_is_the_clearance(shell: Shell, stepped: Parts) -> None:
    """Both rings lie in the flange, so closed forms hold."""
    lost = solid_mass(shell.solid).volume_mm3 - sum(solid_mass(part).volume_mm3 for part in stepped.solids)
    ring = np.pi * (26.2**2 - 24.3**2) * 2.3 - np.pi * (26.0**2 - 24.5**2) * 2.0
    assert lost == pytest.approx(ring, rel=1e-5)


def test_without_a_groove_the_tongue_changes_sides(shell: Shell) -> None:
    """Nothing is lost, in either kernel, and what moves is the tongue's ring."""
    flat, seamless = split(shell, Seam(ORIGIN, UP)), split(shell, Seam(ORIGIN, UP, (TONGUE,)))
    ring = np.pi * (26.0**2 - 24.5**2) * 2.0
    for measure, before, after, tolerance in (
        (solid_mass, flat.solids, seamless.solids, 1e-5),
        (Mesh.mass, flat.meshes, seamless.meshes, 5e-3),
    ):
        gain = [measure(b).volume_mm3 - measure(a).volume_mm3 for a, b in zip(before, after, strict=True)]
        assert gain == pytest.approx([-ring, ring], rel=tolerance)
        assert sum(gain) == pytest.approx(0.0, abs=1e-5 * ring)


def test_keys_of_an_oblique_seam_pass_too(shell: Shell, tmp_path: Path) -> None:
    """Boxes as tongues, on a plane that is square to no axis."""
    normal = np.array([0.05, -0.04, 1.0])
    normal /= np.linalg.norm(normal)
    key = Box((0.0, -25.5, 0.2), (1.0, 0.0, 0.0), UP, (4.0, 1.6, 3.0))
    seat = Box((0.0, -25.5, 0.2), (1.0, 0.0, 0.0), UP, (4.4, 2.0, 3.4))
    seam = Seam((0.0, 0.0, 0.3), tuple(normal.tolist()), (key,), (seat,))
    assert split(shell, seam).problems(tmp_path) == ()


def test_a_tongue_of_another_size_is_found_on_disk(shell: Shell, stepped: Parts, tmp_path: Path) -> None:
    wanted = Seam(ORIGIN, UP, (Cylinder((0.0, 0.0, -2.0), UP, 26.1, 3.0, 24.5),), (GROOVE,))
    boundary = Boundary.of_hollow(shell.hollow).split(wanted)[1]
    problems = problems_on_disk(tmp_path, stepped.solids[1], stepped.meshes[1], boundary, SAG_UM)
    assert any("away from the model's surface" in problem for problem in problems)


def test_seams_that_cut_nothing_are_refused(shell: Shell) -> None:
    with pytest.raises(GeometryError, match="leaves 1 below and 0 above"):
        split_brep(shell.solid, Seam((0.0, 0.0, 40.0), UP))
    with pytest.raises(GeometryError, match="a point and a normal"):
        Seam(ORIGIN, ORIGIN)
    with pytest.raises(GeometryError, match="a point and a normal"):
        Seam((0.0, float("nan"), 0.0), UP)


def test_a_tongue_that_hangs_on_nothing_is_refused(shell: Shell) -> None:
    loose = Seam(ORIGIN, UP, (Cylinder((0.0, 0.0, -3.0), UP, 26.0, 2.0, 24.5),))
    with pytest.raises(GeometryError, match="leaves 1 below and 2 above"):
        split_brep(shell.solid, loose)
    with pytest.raises(GeometryError, match="upper part is in 2 pieces"):
        split_mesh(shell.mesh, loose, SAG_UM)

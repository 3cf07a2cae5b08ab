"""What is measured once: the same solid or mesh to the last bit, from whatever file, and nothing else."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from build123d import Box, Location, Solid

from gomboc_cad.solid.content import mesh_content, solid_content
from gomboc_cad.solid.export import write_step
from gomboc_cad.solid.mass import solid_mass
from gomboc_cad.solid.mesh import Mesh
from gomboc_cad.solid.step import NamedSolid, read_step
from tests.solid.manifolds import block, mesh_of


def box(size_mm: float) -> Solid:
    return Box(size_mm, 2.0, 3.0).solids()[0].moved(Location((5.0, 0.0, 0.0)))


def test_a_part_is_the_same_in_its_own_file_and_in_the_assembly(tmp_path: Path) -> None:
    parts = [NamedSolid("one", box(1.0)), NamedSolid("other", box(1.0 + 1e-12))]
    write_step(tmp_path / "both.step", parts, "both")
    write_step(tmp_path / "one.step", parts[:1], "one")
    (alone,) = read_step(tmp_path / "one.step")
    one, other = (solid_content(part.solid) for part in read_step(tmp_path / "both.step"))
    assert solid_content(alone.solid) == one
    assert one != other


def test_another_place_or_another_size_is_another_solid() -> None:
    here = box(1.0)
    assert solid_content(here) == solid_content(box(1.0))
    assert solid_content(here) != solid_content(here.moved(Location((0.0, 0.0, 1e-9))))
    assert solid_mass(here).com_mm[2] != solid_mass(here.moved(Location((0.0, 0.0, 1.0)))).com_mm[2]


def test_a_mesh_is_another_one_with_any_bit_of_it_changed() -> None:
    mesh = mesh_of(block(1.0, 2.0, 3.0))
    assert mesh_content(mesh) == mesh_content(Mesh(mesh.vertices_mm.copy(), mesh.faces.copy()))
    nudged = mesh.vertices_mm.copy()
    nudged[-1, -1] = np.nextafter(nudged[-1, -1], np.inf)
    assert mesh_content(mesh) != mesh_content(Mesh(nudged, mesh.faces))
    assert mesh_content(mesh) != mesh_content(Mesh(mesh.vertices_mm, np.roll(mesh.faces, 1, axis=0)))

"""One process, one kernel: build123d, CadQuery and the mesh libraries work side by side."""

from __future__ import annotations

from pathlib import Path
from types import ModuleType

import pytest


def test_cadquery_and_build123d_exchange_a_solid(cadquery: ModuleType) -> None:
    import build123d as bd

    box = bd.Solid.make_box(10, 20, 30)
    work = cadquery.Workplane(cadquery.Shape.cast(box.wrapped))
    assert work.val().Volume() == pytest.approx(6000, rel=1e-12)
    drilled = work.faces(">Z").workplane(centerOption="CenterOfMass").hole(4).val()
    (back,) = bd.Compound(drilled.wrapped).solids()
    assert back.volume == pytest.approx(6000 - 30 * 3.141592653589793 * 4, rel=1e-6)


def test_mesh_libraries_share_a_process_with_the_kernel(pymeshlab: ModuleType, tmp_path: Path) -> None:
    import build123d as bd
    import manifold3d
    import numpy as np
    import trimesh

    exporter = bd.Mesher()
    exporter.add_shape(bd.Solid.make_box(1, 2, 3))
    exporter.write(str(tmp_path / "box.3mf"))
    read = trimesh.load(tmp_path / "box.3mf", force="mesh")
    read.merge_vertices()
    assert read.is_watertight
    vertices, faces = np.asarray(read.vertices, dtype=np.float64), np.asarray(read.faces, dtype=np.uint64)
    solid = manifold3d.Manifold(manifold3d.Mesh64(vert_properties=vertices, tri_verts=faces))
    assert solid.volume() == pytest.approx(6)
    meshes = pymeshlab.MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(vertices, faces.astype(np.int32)))
    assert meshes.get_topological_measures()["boundary_edges"] == 0

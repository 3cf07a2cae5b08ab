"""Meshes read back from STL and 3MF by trimesh, which wrote neither."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import trimesh

from gomboc_cad.body.sphere import Array
from gomboc_cad.errors import InspectionError
from gomboc_cad.solid.mesh import Mesh


def read_stl(path: Path) -> Mesh:
    """Read an STL file, joining equal corners.

    Raises:
        InspectionError: If it cannot be read.
    """
    scene = _load(path)
    return _mesh(path, scene.to_geometry())


def read_3mf(path: Path) -> list[tuple[str, Mesh]]:
    """Read the named objects of a 3MF file, in place.

    Raises:
        InspectionError: If it cannot be read, or is not in millimetres.
    """
    meshes, items = read_3mf_items(path)
    return [
        (name, Mesh(meshes[name].vertices_mm @ place[:3, :3].T + place[:3, 3], meshes[name].faces))
        for name, place in items
    ]


def read_3mf_items(path: Path) -> tuple[dict[str, Mesh], list[tuple[str, Array]]]:
    """Read the objects of a 3MF file by name, and the items of its build: an object and a place (4, 4) each.

    Raises:
        InspectionError: If it cannot be read, or is not in millimetres.
    """
    scene = _load(path)
    if scene.units != "millimeter":
        raise InspectionError(f"{path.name} is in the unit {scene.units!r} and not in millimetres.")
    places = [scene.graph[node] for node in scene.graph.nodes_geometry]
    meshes = {str(name): _mesh(path, scene.geometry[name]) for _, name in places}
    return meshes, [(str(name), np.array(place, dtype=float)) for place, name in places]


def _load(path: Path) -> trimesh.Scene:
    try:
        return trimesh.load_scene(path)
    except Exception as error:  # the readers for damaged files raise whatever their parsers do
        raise InspectionError(f"{path.name} cannot be read: {error or type(error).__name__}.") from error


def _mesh(path: Path, geometry: object) -> Mesh:
    if not isinstance(geometry, trimesh.Trimesh) or len(geometry.faces) == 0:
        raise InspectionError(f"{path.name} holds no triangles.")
    vertices = np.array(geometry.vertices, dtype=float)
    if not np.all(np.isfinite(vertices)):
        raise InspectionError(f"{path.name} holds coordinates that are not numbers.")
    return Mesh(vertices, np.array(geometry.faces, dtype=np.int64))

"""Wavefront OBJ files: vertices and polygons; materials and textures are never opened."""

from __future__ import annotations

from array import array
from pathlib import Path

import numpy as np

from gomboc_cad.errors import InspectionError
from gomboc_cad.solid.formats.content import MAX_CORNERS, FileMesh, check_count, text_lines
from gomboc_cad.solid.formats.polygons import triangulate

OBJ = "an OBJ file"

_FREE_FORM = {b"cstype", b"curv", b"curv2", b"surf", b"bmat"}


def read_obj(path: Path, name: str) -> FileMesh:
    """Read an OBJ file; several objects in it become one mesh.

    Raises:
        InspectionError: If it does not follow the format, holds free-form surfaces, or is too large.
    """
    coordinates, sizes, corners = array("d"), array("q"), array("q")
    with path.open("rb") as stream:
        for number, line in enumerate(text_lines(name, stream), start=1):
            fields = line.split()
            if not fields:
                continue
            word = fields[0]
            try:
                if word == b"v":
                    x, y, z = fields[1:4]
                    coordinates.extend((float(x), float(y), float(z)))
                elif word == b"f":
                    polygon = [int(field.split(b"/", 1)[0]) for field in fields[1:]]
                    latest = len(coordinates) // 3
                    # Indices count from one; negative ones count back from the latest vertex.
                    corners.extend(i - 1 if i > 0 else latest + i if i < 0 else -1 for i in polygon)
                    sizes.append(len(polygon))
            except (ValueError, OverflowError) as error:
                raise InspectionError(
                    f"{name} is damaged: line {number} does not follow the format."
                ) from error
            if word in _FREE_FORM:
                raise InspectionError(
                    f"{name} holds free-form surfaces (line {number}); export it as STEP or as a mesh."
                )
            check_count(name, "vertices", len(coordinates) // 3, MAX_CORNERS)
            check_count(name, "corners of facets", len(corners), MAX_CORNERS)
    vertices = np.frombuffer(coordinates, dtype=float).reshape(-1, 3)
    faces, notes = triangulate(
        name, vertices, np.frombuffer(sizes, dtype=np.int64), np.frombuffer(corners, dtype=np.int64)
    )
    return FileMesh(OBJ, vertices, faces, notes=notes)

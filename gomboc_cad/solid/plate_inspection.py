"""A plate of parts read back from its 3MF file: every copy there, whole, on the bed, clear of the others."""

from __future__ import annotations

import hashlib
from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from gomboc_cad.body.sphere import Array
from gomboc_cad.errors import InspectionError
from gomboc_cad.solid.export import PlateItem
from gomboc_cad.solid.inspect import Expected, FileInspection, inspect_mesh
from gomboc_cad.solid.mesh_reading import read_3mf_items

_ROUNDING_MM = 1e-3
"""Coordinates in the file are 32-bit numbers."""


def inspect_plate(
    path: Path, expected: Mapping[str, Expected], items: Sequence[PlateItem], bed_mm: tuple[float, float]
) -> FileInspection:
    """Read a plate back and check it.

    Args:
        path: The file.
        expected: What each part has to be, as it stands in the product.
        items: The copies that were laid out.
        bed_mm: Width and depth of the bed, which begins at the origin.

    Raises:
        InspectionError: If there is no such file.
    """
    try:
        data = path.read_bytes()
    except OSError as error:
        raise InspectionError(f"{path} cannot be read: {error.strerror}.") from error
    try:
        meshes, found = read_3mf_items(path)
    except InspectionError as error:
        parts, problems = [], [str(error)]
    else:
        looked_at = [inspect_mesh(name, mesh, expected.get(name)) for name, mesh in meshes.items()]
        parts = [part for part, _ in looked_at]
        problems = [problem for _, clauses in looked_at for problem in clauses]
        wanted, there = Counter(item.part for item in items), Counter(name for name, _ in found)
        if wanted != there:
            problems.append(f"It holds {dict(there)} where {dict(wanted)} were laid out.")
        boxes = [_box(meshes[name].vertices_mm, place) for name, place in found]
        problems += _room_problems(np.array(boxes).reshape(-1, 2, 3), bed_mm)
    digest = hashlib.sha256(data).hexdigest()
    return FileInspection(path.name, "3mf", digest, len(data), tuple(parts), tuple(problems))


def _box(vertices_mm: Array, place: Array) -> Array:
    """Lower and upper corner of a copy in place, shape (2, 3)."""
    moved = vertices_mm @ place[:3, :3].T + place[:3, 3]
    return np.array([moved.min(axis=0), moved.max(axis=0)])


def _room_problems(boxes: Array, bed_mm: tuple[float, float]) -> list[str]:
    """Sentences about copies that do not stand on the bed or reach into each other's room."""
    low, high = boxes[:, 0], boxes[:, 1]
    problems = []
    if np.any(np.abs(low[:, 2]) > _ROUNDING_MM):
        problems.append("A copy does not stand on the bed.")
    if np.any(low[:, :2] < -_ROUNDING_MM) or np.any(high[:, :2] > np.array(bed_mm) + _ROUNDING_MM):
        problems.append("A copy reaches over the edge of the bed.")
    apart = np.any(low[:, None, :2] >= high[None, :, :2] - _ROUNDING_MM, axis=2)
    if not np.all(apart | apart.T | np.eye(len(boxes), dtype=bool)):
        problems.append("Two copies stand in each other's way.")
    return problems

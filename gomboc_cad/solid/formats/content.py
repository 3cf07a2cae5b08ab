"""What a mesh file says, before anything is concluded from it, and how much of it may be read."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import BinaryIO

import numpy as np

from gomboc_cad.body.sphere import Array, BoolArray, IntArray
from gomboc_cad.errors import InspectionError

MAX_FACETS = 5_000_000
"""More triangles than any maker's mesh needs; what counts is what the file declares, before it is read."""

MAX_CORNERS = 3 * MAX_FACETS
MAX_BYTES = 2**30
"""Largest file, and largest unpacked member of an archive."""

MAX_LINE_BYTES = 2**16


@dataclass(frozen=True, eq=False)
class FileMesh:
    """Triangles as a file states them, in its own unit.

    Attributes:
        kind: What the file is, for sentences: `a binary STL file`.
        vertices: Shape (n, 3), float64.
        faces: Indices of corners, shape (m, 3).
        parts: Names of the separate parts that the file declares; empty where the format knows none.
        unit: The unit that the file states; None where the format has none.
        notes: What was left out or interpreted, one sentence each.
    """

    kind: str
    vertices: Array
    faces: IntArray
    parts: tuple[str, ...] = ()
    unit: str | None = None
    notes: tuple[str, ...] = ()


def check_count(name: str, what: str, count: int, limit: int) -> None:
    """Refuse a number of things before room is made for them.

    Raises:
        InspectionError: If there are more than allowed.
    """
    if count > limit:
        raise InspectionError(
            f"{name} holds {count:,} {what}, more than the {limit:,} that are read; make it coarser."
        )


def text_lines(name: str, stream: BinaryIO) -> Iterator[bytes]:
    """Lines of a text file, none longer than `MAX_LINE_BYTES`.

    Raises:
        InspectionError: If a line is longer.
    """
    for line in iter(lambda: stream.readline(MAX_LINE_BYTES), b""):
        if len(line) == MAX_LINE_BYTES:
            raise InspectionError(f"{name} is damaged: it holds a line of more than {MAX_LINE_BYTES} bytes.")
        yield line


def check_indices(name: str, faces: IntArray, vertices: int) -> None:
    """Refuse facets whose corners are not there.

    Raises:
        InspectionError: If an index is out of range.
    """
    strangers: BoolArray = (faces < 0) | (faces >= vertices)
    if strangers.any():
        facet = int(np.flatnonzero(strangers.reshape(len(faces), -1).any(axis=1))[0])
        raise InspectionError(
            f"{name} is damaged: facet {facet + 1} has a corner that is not among the {vertices:,} vertices."
        )

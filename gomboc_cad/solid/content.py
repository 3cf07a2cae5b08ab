"""Solids and meshes told apart by what they hold, so that what stands in several files is measured once."""

from __future__ import annotations

import io
from dataclasses import dataclass, field
from hashlib import sha256
from typing import Generic, TypeVar

import numpy as np
from build123d import Shape
from OCP.BinTools import BinTools

from gomboc_cad.solid.mesh import Mesh

T = TypeVar("T")


@dataclass(frozen=True)
class Content(Generic[T]):
    """A solid or a mesh as the key of a cache.

    Attributes:
        digest: Digest of all its numbers; two contents are equal if their digests are.
        of: The solid or mesh itself.
    """

    digest: bytes
    of: T = field(compare=False)


def solid_content(shape: Shape) -> Content[Shape]:
    """Content of a B-rep: its topology and geometry to the last bit, and its place."""
    stream = io.BytesIO()
    BinTools.Write_s(shape.wrapped, stream)
    return Content(sha256(stream.getvalue()).digest(), shape)


def mesh_content(mesh: Mesh) -> Content[Mesh]:
    """Content of a mesh: its vertices to the last bit, in their order, and its facets."""
    digest = sha256(np.array([len(mesh.vertices_mm), len(mesh.faces)]).tobytes())
    digest.update(np.ascontiguousarray(mesh.vertices_mm).tobytes())
    digest.update(np.ascontiguousarray(mesh.faces).tobytes())
    return Content(digest.digest(), mesh)

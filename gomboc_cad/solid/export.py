"""STEP, STL and 3MF files of named parts, in millimetres, with the same bytes for the same input."""

from __future__ import annotations

import ctypes
import io
import os
import uuid
import zipfile
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from hashlib import sha256
from pathlib import Path
from typing import Protocol

import lib3mf
import numpy as np

from gomboc_cad.body.sphere import Array
from gomboc_cad.errors import OutputError
from gomboc_cad.solid.mesh import Mesh
from gomboc_cad.solid.output import write_bytes
from gomboc_cad.solid.step import NamedSolid, step_bytes

_EPOCH = datetime(1980, 1, 1, tzinfo=UTC)
"""Date in the files where SOURCE_DATE_EPOCH is not set: the first that a zip archive can hold."""

_NAMESPACE = uuid.uuid5(uuid.NAMESPACE_URL, "gomboc-cad/3mf")
_STL_FACET = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])


class PlateItem(Protocol):
    """A copy of a part on a plate: its vertices are turned, and then moved."""

    @property
    def part(self) -> str:
        """Name of the part."""

    @property
    def turn(self) -> Array:
        """Rotation, shape (3, 3)."""

    @property
    def shift_mm(self) -> Array:
        """Displacement after it, shape (3,)."""


@dataclass(frozen=True)
class NamedMesh:
    """An object of a 3MF file.

    Attributes:
        name: Name of the object, unique in its file.
        mesh: The mesh, in place.
    """

    name: str
    mesh: Mesh


def write_step(path: Path, parts: Sequence[NamedSolid], name: str) -> None:
    """Write a STEP file (AP214) of one part, or of an assembly of several parts in place.

    Args:
        path: The file.
        parts: The parts.
        name: Name of the assembly, and the title in the file's header.

    Raises:
        OutputError: If the file cannot be written there.
    """
    write_bytes(path, step_bytes(parts, name, file_date()))


def write_stl(path: Path, mesh: Mesh, name: str) -> None:
    """Write a binary STL file; its unit, which the format cannot say, is the millimetre.

    Raises:
        OutputError: If the file cannot be written there.
    """
    facets = np.zeros(len(mesh.faces), dtype=_STL_FACET)
    corners = mesh.vertices_mm[mesh.faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    facets["normal"] = normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300)
    facets["corners"] = corners
    # A header that begins with "solid" would be taken for a text file.
    header = f"gomboc-cad, unit mm, {name}".encode("ascii", "replace")[:80].ljust(80)
    write_bytes(path, header + np.uint32(len(facets)).astype("<u4").tobytes() + facets.tobytes())


def write_3mf(path: Path, parts: Sequence[NamedMesh]) -> None:
    """Write a 3MF file with one named object per part, in millimetres.

    Raises:
        OutputError: If the file cannot be written there.
    """
    model = _Model3mf()
    for part in parts:
        model.place(model.add(part), np.eye(3), np.zeros(3))
    model.write(path)


def write_plate(path: Path, parts: Sequence[NamedMesh], items: Sequence[PlateItem]) -> None:
    """Write a 3MF file of parts laid out on a printer's bed: each mesh once, however many copies there are.

    Args:
        path: The file.
        parts: The parts.
        items: Where each copy goes.

    Raises:
        OutputError: If the file cannot be written there.
    """
    model = _Model3mf()
    objects = {part.name: model.add(part) for part in parts}
    for item in items:
        model.place(objects[item.part], np.array(item.turn), np.array(item.shift_mm))
    model.write(path)


class _Model3mf:
    """A 3MF model in the making; its ids follow from its content."""

    def __init__(self) -> None:
        self.wrapper = lib3mf.get_wrapper()
        self.model = self.wrapper.CreateModel()
        self.model.SetUnit(lib3mf.ModelUnit.MilliMeter)
        self.seed = sha256()

    def add(self, part: NamedMesh) -> lib3mf.MeshObject:
        """Add a mesh as an object."""
        vertices = np.ascontiguousarray(part.mesh.vertices_mm, dtype=np.float32)
        faces = np.ascontiguousarray(part.mesh.faces, dtype=np.uint32)
        item = self.model.AddMeshObject()
        item.SetName(part.name)
        # From arrays straight into the library; its Python method takes a structure per vertex.
        self.wrapper.checkError(
            item,
            self.wrapper.lib.lib3mf_meshobject_setgeometry(
                item._handle,
                ctypes.c_uint64(len(vertices)),
                vertices.ctypes.data_as(ctypes.POINTER(lib3mf.Position)),
                ctypes.c_uint64(len(faces)),
                faces.ctypes.data_as(ctypes.POINTER(lib3mf.Triangle)),
            ),
        )
        item.SetUUID(self._uuid("object", part.name.encode(), vertices.tobytes(), faces.tobytes()))
        return item

    def place(self, item: lib3mf.MeshObject, turn: Array, shift_mm: Array) -> None:
        """Put an object into the build, turned by a rotation (3, 3) and then moved."""
        transform = lib3mf.Transform()
        # 3MF multiplies rows by the matrix.
        for row, values in enumerate(np.vstack([turn.T, shift_mm]).tolist()):
            for column, value in enumerate(values):
                transform.Fields[row][column] = value
        placed = self.model.AddBuildItem(item, transform)
        placed.SetUUID(self._uuid("item", np.array([*turn.ravel(), *shift_mm], dtype=np.float32).tobytes()))

    def write(self, path: Path) -> None:
        """Write the file."""
        self.model.SetBuildUUID(self._uuid("build"))
        write_bytes(path, _with_fixed_dates(bytes(self.model.QueryWriter("3mf").WriteToBuffer())))

    def _uuid(self, what: str, *content: bytes) -> str:
        """An id that follows from all content so far."""
        for piece in (what.encode(), *content):
            self.seed.update(piece)
        return str(uuid.uuid5(_NAMESPACE, self.seed.hexdigest()))


def file_date() -> datetime:
    """Date to write into files: SOURCE_DATE_EPOCH where it is set, else a constant.

    Raises:
        OutputError: If SOURCE_DATE_EPOCH is not a number of seconds.
    """
    seconds = os.environ.get("SOURCE_DATE_EPOCH")
    if not seconds:
        return _EPOCH
    try:
        return max(_EPOCH, datetime.fromtimestamp(int(seconds), UTC))
    except (ValueError, OverflowError, OSError) as error:
        raise OutputError(f"SOURCE_DATE_EPOCH must be a number of seconds, not {seconds!r}.") from error


def _with_fixed_dates(archive: bytes) -> bytes:
    """Pack a zip archive again with the same date on every member."""
    date = file_date().timetuple()[:6]
    result = io.BytesIO()
    with zipfile.ZipFile(io.BytesIO(archive)) as source, zipfile.ZipFile(result, "w") as target:
        for name in source.namelist():
            member = zipfile.ZipInfo(name, date)
            member.compress_type = zipfile.ZIP_DEFLATED
            target.writestr(member, source.read(name))
    return result.getvalue()

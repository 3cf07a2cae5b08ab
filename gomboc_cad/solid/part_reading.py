"""Mesh files of parts from anywhere: what they hold, what was repaired, and whether that bounds a solid."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from gomboc_cad.body.sphere import Array
from gomboc_cad.equilibria.records import Vector, as_vector
from gomboc_cad.errors import InspectionError
from gomboc_cad.progress import Progress, silent
from gomboc_cad.solid.formats.content import MAX_BYTES, FileMesh
from gomboc_cad.solid.formats.obj import OBJ, read_obj
from gomboc_cad.solid.formats.ply import PLY, read_ply
from gomboc_cad.solid.formats.stl import BINARY, TEXT, declared_size, read_binary_stl, read_text_stl
from gomboc_cad.solid.formats.threemf import THREE_MF, read_3mf
from gomboc_cad.solid.mesh import Mesh
from gomboc_cad.solid.mesh_topology import (
    EdgeFaults,
    Shells,
    edge_faults,
    join_equal_corners,
    join_rounded_corners,
    oriented_shells,
    shell_volumes,
    shells_around,
    without_repeated_facets,
)
from gomboc_cad.solid.self_intersection import TooEntangledError, is_star_shaped, self_intersection

UNITS_MM = {
    "mm": 1.0,
    "um": 1e-3,
    "cm": 10.0,
    "m": 1e3,
    "in": 25.4,
    "ft": 304.8,
}
"""Length of each unit that `--unit` takes."""

STEP = "a STEP file"

_UNIT_OF_3MF = {
    "micron": "um",
    "millimeter": "mm",
    "centimeter": "cm",
    "inch": "in",
    "foot": "ft",
    "meter": "m",
}
_SUFFIXES = {STEP: (".step", ".stp"), BINARY: (".stl",), TEXT: (".stl",), PLY: (".ply",), OBJ: (".obj",)}
_SUFFIXES[THREE_MF] = (".3mf",)
_READERS: dict[str, Callable[[Path, str], FileMesh]] = {
    BINARY: read_binary_stl,
    TEXT: read_text_stl,
    PLY: read_ply,
    OBJ: read_obj,
    THREE_MF: read_3mf,
}
_FOREIGN = {
    b"%PDF": "a PDF file",
    b"\x1f\x8b": "a gzip archive",
    b"glTF": "a glTF file",
    b"<!DOCTYPE html": "a web page",
    b"<html": "a web page",
    b"<?xml": "an XML file",
    b"DBRep_DrawableShape": "an OCCT BREP file",
    b"CASCADE Topology": "an OCCT BREP file",
    b"SQLite": "a database",
}
_HEAD_BYTES = 4096
_SIZES_MM = (1e-3, 1e6)
_USUAL_SIZES_MM = (2.0, 2000.0)
_LEAST_FILLING = 1e-9
"""A closed mesh that fills less of its bounding box than this encloses nothing but rounding."""


@dataclass(frozen=True, eq=False)
class PartMesh:
    """A part read from a mesh file, in millimetres.

    Attributes:
        kind: What the file is, for sentences: `a binary STL file`.
        mesh: Its facets, equal corners joined; where it bounds a solid they all face outwards.
        unit: Unit of the file's numbers, as in `UNITS_MM`.
        watertight: Whether every edge joins two facets.
        volume_mm3: Volume; None unless the mesh bounds one solid.
        com_mm: Centre of mass of that solid if it is homogeneous; likewise.
        faults: Why the mesh does not bound one solid, one clause each; none if it does.
        repairs: What was changed, one sentence each.
        notes: What a user should know, one sentence each.
    """

    kind: str
    mesh: Mesh
    unit: str
    watertight: bool
    volume_mm3: float | None
    com_mm: Vector | None
    faults: tuple[str, ...]
    repairs: tuple[str, ...]
    notes: tuple[str, ...]


def shown_name(path: Path) -> str:
    """Name of a file, printable whatever bytes it is made of."""
    return path.name.encode("utf-8", "backslashreplace").decode()


def identify(path: Path) -> str:
    """Tell what a file is by its content, and insist that its name says the same.

    Returns:
        `STEP`, or what a reader of this module calls it.

    Raises:
        InspectionError: If there is no such file, it is empty or too large, none of the known formats, or
            named as if it were another.
    """
    name = shown_name(path)
    try:
        size = path.stat().st_size
        if path.is_dir():
            raise InspectionError(f"{name} is a folder; name a file.")
        if not path.is_file():
            raise InspectionError(f"{name} is no ordinary file; name a file.")
        with path.open("rb") as stream:
            head = stream.read(_HEAD_BYTES)
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or "its name is no file name"
        raise InspectionError(f"{name} cannot be read: {reason}.") from error
    if not size:
        raise InspectionError(f"{name} is empty; save it again.")
    if size > MAX_BYTES:
        raise InspectionError(
            f"{name} has {size / 2**20:,.0f} MiB, more than the {MAX_BYTES / 2**20:,.0f} MiB that are read; "
            "make it coarser."
        )
    suffix = path.suffix.lower()
    kind = _kind(head, size, suffix)
    if kind is None:
        what = next((what for magic, what in _FOREIGN.items() if head.lstrip().startswith(magic)), None)
        raise InspectionError(
            f"{name} is {what or 'damaged or of an unknown format'}; STEP, STL, 3MF, OBJ and PLY files are "
            "read."
        )
    if suffix not in _SUFFIXES[kind]:
        raise InspectionError(
            f"{name} is {kind} by its content; rename it to end with {_SUFFIXES[kind][0]}, or export it "
            "again."
        )
    return kind


def _kind(head: bytes, size: int, suffix: str) -> str | None:
    """The format that the first bytes of a file tell; the suffix decides what only one of them could be."""
    text = head.removeprefix(b"\xef\xbb\xbf").lstrip()
    if head.startswith(b"PK"):
        return THREE_MF
    if text.startswith(b"ISO-10303-21"):
        return STEP
    if head.startswith((b"ply\n", b"ply\r")):
        return PLY
    # Many binary files begin with "solid" too, so the size decides first.
    if declared_size(head) == size:
        return BINARY
    printable = b"\0" not in head
    if text[:5].lower() == b"solid" and printable:
        return TEXT
    words = {line.split(maxsplit=1)[0] for line in head.split(b"\n") if line.strip()}
    if printable and words & {b"v", b"f", b"o", b"g", b"mtllib"} and (b"v" in words or suffix == ".obj"):
        return OBJ
    return BINARY if suffix == ".stl" and not printable and len(head) >= 84 else None


def read_part(path: Path, unit: str | None = None, progress: Progress = silent) -> PartMesh:
    """Read an STL, 3MF, OBJ or PLY file.

    Args:
        path: The file.
        unit: Unit of its numbers, as in `UNITS_MM`; None for millimetres, or for what a 3MF file states.
        progress: Told about each stage.

    Raises:
        InspectionError: If the file cannot be read, or holds no body; a mesh that merely does not bound a
            solid is read, and its record says why not.
    """
    name = shown_name(path)
    kind = identify(path)
    if kind not in _READERS:
        raise InspectionError(f"{name} is {kind}, which holds no mesh.")
    progress("reading the file")
    found = _READERS[kind](path, name)
    if not len(found.faces):
        raise InspectionError(f"{name} holds no facets.")
    used, notes = file_unit(name, found.unit, unit)
    mesh = Mesh(_scaled(name, found.vertices, used), found.faces)
    notes = found.notes + notes
    if found.unit is None and unit is None:
        notes += _size_notes(name, mesh)
    progress("checking the mesh")
    part = _as_solid(name, found, mesh, used, progress)
    return replace(part, notes=notes + part.notes)


def file_unit(name: str, stated: str | None, asked: str | None) -> tuple[str, tuple[str, ...]]:
    """Settle the unit of a file's numbers between what it states and what the user says.

    Args:
        name: Name of the file.
        stated: Unit that a 3MF file states, in its words; None where the format has none.
        asked: What the user says, as in `UNITS_MM`; None for nothing.

    Returns:
        The unit, and a sentence about it if it is not the millimetre.

    Raises:
        InspectionError: If either is unknown, or they contradict each other.
    """
    if asked is not None and asked not in UNITS_MM:
        raise InspectionError(f"The unit {asked!r} is none of {', '.join(UNITS_MM)}.")
    if stated is None:
        return asked or "mm", ()
    if stated not in _UNIT_OF_3MF:
        raise InspectionError(f"{name} states the unknown unit {stated!r}; save it in millimetres.")
    unit = _UNIT_OF_3MF[stated]
    if asked not in (None, unit):
        raise InspectionError(f"{name} states its unit, {unit}, which is not {asked}; leave --unit out.")
    return unit, () if unit == "mm" else (
        f"The file is in the unit {stated}; its numbers were multiplied by {UNITS_MM[unit]:g}.",
    )


def check_size_mm(name: str, low_mm: Array, high_mm: Array) -> None:
    """Refuse coordinates and sizes that no part has.

    Raises:
        InspectionError: If the size is not between a micrometre and a kilometre, or the place farther off.
    """
    with np.errstate(over="ignore"):
        size = float(np.linalg.norm(high_mm - low_mm))
    smallest, largest = _SIZES_MM
    reach = float(max(np.abs(low_mm).max(), np.abs(high_mm).max()))
    if not (smallest <= size <= largest and reach <= largest):
        raise InspectionError(
            f"{name} measures {size:.3g} mm across and reaches {reach:.3g} mm from the origin; sizes from "
            f"{smallest:g} mm to {largest:g} mm are read; state its unit with --unit, or scale it."
        )


def _scaled(name: str, vertices: Array, unit: str) -> Array:
    """Turn a file's numbers into millimetres."""
    if not np.all(np.isfinite(vertices)):
        raise InspectionError(f"{name} is damaged: it holds coordinates that are not numbers.")
    with np.errstate(over="ignore"):
        result = vertices * UNITS_MM[unit]
        single = unit != "mm" and np.array_equal(vertices.astype(np.float32), vertices)
        # Numbers of 32 bits stay such, because the census knows their rounding by that.
        result = result.astype(np.float32).astype(float) if single else result
    if not np.all(np.isfinite(result)):
        raise InspectionError(f"{name} is damaged: it holds coordinates beyond all sizes.")
    return result


def _size_notes(name: str, mesh: Mesh) -> tuple[str, ...]:
    """A warning about a part of unusual size in a format without a unit."""
    size = float(np.ptp(mesh.vertices_mm, axis=0).max())
    small, large = _USUAL_SIZES_MM
    if small <= size <= large:
        return ()
    return (
        f"{name} does not state its unit and measures {size:.4g} mm if that is the millimetre, "
        f"{25.4 * size:.4g} mm if it is the inch, {1e3 * size:.4g} mm if it is the metre: say --unit mm, in "
        "or m. The number of poses does not depend on it; every length, the barriers among them, does.",
    )


def _as_solid(name: str, found: FileMesh, raw: Mesh, unit: str, progress: Progress) -> PartMesh:
    """Repair what can be repaired without guessing, and find out whether the mesh bounds one solid."""
    mesh, repairs, edges = _joined(found, raw)
    if len(mesh.faces):
        check_size_mm(name, mesh.vertices_mm.min(axis=0), mesh.vertices_mm.max(axis=0))
    if len(mesh.faces) < 4 or _is_flat(mesh):
        raise InspectionError(
            f"{name} holds no body: all its {len(mesh.faces)} facets lie in one plane or line."
        )
    faults: tuple[str, ...] = ()
    if len(edges.open):
        faults += (f"it is not watertight: {len(edges.open)} edges belong to one facet only",)
    if edges.branched:
        faults += (f"it is no manifold: {edges.branched} edges join more than two facets",)
    watertight = not faults
    if len(found.parts) > 1:
        shown = ", ".join(found.parts[:5]) + (", …" if len(found.parts) > 5 else "")
        faults += (f"it holds {len(found.parts)} parts ({shown}), and nothing says that they are joined",)
    if watertight:
        shells = oriented_shells(mesh)
        mesh = shells.mesh
        if shells.turned:
            repairs += (
                f"{shells.turned} facets that faced the other way than their neighbours were turned.",
            )
        volumes = shell_volumes(shells)
        if volumes[np.argmax(np.abs(volumes))] < 0.0:
            mesh = Mesh(mesh.vertices_mm, mesh.faces[:, ::-1])
            shells, volumes = shells._replace(mesh=mesh), -volumes
            repairs += ("All facets faced inwards; they were turned.",)
        progress("looking for self-intersections")
        faults += _shell_faults(shells, volumes)
    mass = None if faults else mesh.mass()
    return PartMesh(
        kind=found.kind,
        mesh=mesh,
        unit=unit,
        watertight=watertight,
        volume_mm3=mass.volume_mm3 if mass else None,
        com_mm=mass.com_mm if mass else None,
        faults=faults,
        repairs=repairs,
        notes=(),
    )


def _joined(found: FileMesh, raw: Mesh) -> tuple[Mesh, tuple[str, ...], EdgeFaults]:
    """Join corners and drop facets that are collapsed or there twice; also gives what is left of faults."""
    repairs: tuple[str, ...] = ()
    loose = int(np.sum(np.bincount(raw.faces.ravel(), minlength=len(raw.vertices_mm)) == 0))
    mesh, collapsed = join_equal_corners(raw)
    joined = len(raw.vertices_mm) - loose - len(mesh.vertices_mm)
    if loose:
        repairs += (f"{loose} vertices that belong to no facet were left out.",)
    if joined and found.kind not in (BINARY, TEXT):  # STL has no shared corners
        repairs += (f"{joined} corners equal to others were joined with them.",)
    if collapsed:
        repairs += (f"{collapsed} facets with two equal corners were dropped.",)
    edges = edge_faults(mesh)
    if edges.branched:
        once = without_repeated_facets(mesh)
        if len(once.faces) < len(mesh.faces):
            repairs += (f"{len(mesh.faces) - len(once.faces)} facets that were there twice were dropped.",)
        mesh, edges = once, edge_faults(once)
    if len(edges.open):
        closed, moved = join_rounded_corners(mesh, edges)
        left = edge_faults(closed)
        if not len(left.open) and not left.branched:
            mesh, edges = closed, left
            repairs += (f"{moved} corners that differed from others by rounding only were joined with them.",)
    return mesh, repairs, edges


def _is_flat(mesh: Mesh) -> bool:
    centered = mesh.vertices_mm - mesh.vertices_mm.mean(axis=0)
    widths = np.linalg.svd(np.linalg.qr(centered, mode="r"), compute_uv=False)
    return bool(widths[2] <= 1e-9 * widths[0])


def _shell_faults(shells: Shells, volumes: Array) -> tuple[str, ...]:
    """Why closed shells are not the boundary of one solid; its cavities are shells that face inwards."""
    if not shells.orientable:
        return ("its surface has one side only, as a Klein bottle's has",)
    mesh = shells.mesh
    if abs(volumes.sum()) <= _LEAST_FILLING * np.prod(np.ptp(mesh.vertices_mm, axis=0)):
        return ("it encloses no volume",)
    star = len(volumes) == 1 and is_star_shaped(mesh, np.asarray(mesh.mass().com_mm))
    try:
        place = None if star else self_intersection(mesh)
    except TooEntangledError:
        return ("its facets lie so close together that self-intersections cannot be ruled out",)
    if place is not None:
        x, y, z = as_vector(place)
        return (f"it crosses itself, near ({x:.4g}, {y:.4g}, {z:.4g}) mm",)
    if len(volumes) == 1:
        return ()
    around = shells_around(shells)
    if around is None:
        return (f"it consists of {len(volumes)} shells, too many to tell solids from cavities",)
    if not np.array_equal(around, np.where(volumes > 0.0, 0.0, 1.0)):
        return ("it has shells that lie in one another and do not face as a solid and its cavities do",)
    solids = int(np.sum(volumes > 0.0))
    if solids > 1:
        return (f"it consists of {solids} separate bodies, and nothing says that they are joined",)
    return ()

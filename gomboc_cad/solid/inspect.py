"""Files read back from disk and checked against the model they were written from."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import NamedTuple

import numpy as np
import trimesh
from build123d import Shape
from manifold3d import Error, Manifold, Mesh64
from OCP.BRepCheck import BRepCheck_Analyzer

from gomboc_cad.body.mass import MassProperties
from gomboc_cad.equilibria.records import Vector
from gomboc_cad.errors import GeometryError, InspectionError
from gomboc_cad.solid.audit import audit_mesh
from gomboc_cad.solid.boundary import Boundary
from gomboc_cad.solid.content import Content, mesh_content, solid_content
from gomboc_cad.solid.facets import facet_normals
from gomboc_cad.solid.mass import solid_mass
from gomboc_cad.solid.mesh import Mesh
from gomboc_cad.solid.mesh_distance import MeshDistance, mesh_distance
from gomboc_cad.solid.mesh_reading import read_3mf, read_stl
from gomboc_cad.solid.patches import max_deviation_um
from gomboc_cad.solid.step import NamedSolid, read_step

MASS_TOLERANCE = 1e-6
"""Relative error allowed to a volume, and error allowed to a COM over the part's reach: 0.1 µm on 100 mm."""

CORRECTION_TOLERANCE = 0.02
"""How well the volume between facets and surface is known, relative to itself."""

KINDS = ("step", "stl", "3mf")

_INCH_MM = 25.4


@dataclass(frozen=True)
class Expected:
    """What a part of a file has to be.

    Attributes:
        name: Its name.
        volume_mm3: Volume of the model.
        com_mm: Centre of mass of the model.
        distance_um: Distance from the model's surfaces that the file promises: a mesh's sag, or the
            deviation of a B-rep.
        boundary: Those surfaces; None where they are not known, as with bought parts.
    """

    name: str
    volume_mm3: float
    com_mm: Vector
    distance_um: float
    boundary: Boundary | None = None


@dataclass(frozen=True)
class PartInspection:
    """What was found of one part of a file.

    Attributes:
        name: Its name.
        watertight: Whether a mesh is closed and consistently oriented, or a B-rep is one valid solid.
        volume_mm3: Volume; None where the part is too damaged to have one.
        com_mm: Centre of mass, likewise.
        distance_um: Largest distance from the model's surfaces, in both directions for a mesh; None where it
            could not be measured.
        facets: Number of triangles, None for a B-rep.
    """

    name: str
    watertight: bool
    volume_mm3: float | None = None
    com_mm: Vector | None = None
    distance_um: float | None = None
    facets: int | None = None


_Found = tuple[PartInspection, tuple[str, ...]]
"""What was found of a part, and a sentence for each fault."""


@dataclass(frozen=True)
class FileInspection:
    """What was found of one file.

    Attributes:
        name: Name of the file, without its folder.
        kind: `step`, `stl` or `3mf`.
        sha256: Digest of its bytes.
        size_bytes: Its size.
        parts: Its parts.
        problems: One sentence for each thing that is wrong.
    """

    name: str
    kind: str
    sha256: str
    size_bytes: int
    parts: tuple[PartInspection, ...]
    problems: tuple[str, ...]

    @property
    def ok(self) -> bool:
        """Whether nothing is wrong."""
        return not self.problems


def problems_of(files: Iterable[FileInspection]) -> tuple[str, ...]:
    """Every problem of several files, each behind the name of its file."""
    return tuple(f"{file.name}: {problem}" for file in files for problem in file.problems)


def inspect_file(
    path: Path,
    expected: Sequence[Expected],
    audit: bool = False,
    solids: Sequence[NamedSolid] | None = None,
) -> FileInspection:
    """Read a STEP, STL or 3MF file back and check it.

    Whatever is wrong with the content is a problem in the record and never an exception. A part that several
    files hold, the same to the last bit, is measured once.

    Args:
        path: The file.
        expected: Its parts, in any order; an STL file has one, whose name it does not carry.
        audit: Have meshes checked by PyMeshLab too, for self-intersections among other things.
        solids: The parts of a STEP file that was read already; they are not read again.

    Raises:
        InspectionError: If there is no such file, or its kind is not known.
        GombocError: If an audit is asked for and PyMeshLab is not installed.
    """
    kind = path.suffix.lower().lstrip(".")
    if kind not in KINDS:
        raise InspectionError(
            f"{path.name} is none of {', '.join(KINDS)}; there is nothing to inspect it with."
        )
    try:
        data = path.read_bytes()
    except OSError as error:
        raise InspectionError(f"{path} cannot be read: {error.strerror}.") from error
    by_name = {part.name: part for part in expected}
    try:
        if kind == "step":
            parts_read = read_step(path) if solids is None else solids
            found = [
                _inspect_brep(part.name, solid_content(part.solid), by_name.get(part.name))
                for part in parts_read
            ]
        else:
            stl_name = expected[0].name if expected else path.stem
            meshes = read_3mf(path) if kind == "3mf" else [(stl_name, read_stl(path))]
            found = [inspect_mesh(n, mesh, by_name.get(n), audit) for n, mesh in meshes]
        problems = [problem for _, clauses in found for problem in clauses]
    except InspectionError as error:
        found, problems = [], [str(error)]
    else:
        problems += _presence_problems(path.name, by_name, [part.name for part, _ in found])
    parts = tuple(part for part, _ in found)
    return FileInspection(
        path.name, kind, hashlib.sha256(data).hexdigest(), len(data), parts, tuple(problems)
    )


def _presence_problems(file: str, expected: Iterable[str], found: Sequence[str]) -> list[str]:
    """Sentences about parts that are missing, unknown or there more than once."""
    problems = [f"{file} lacks the part {name!r}." for name in expected if name not in found]
    problems += [f"{file} holds an unknown part {name!r}." for name in sorted(set(found) - set(expected))]
    problems += [
        f"{file} holds {name!r} more than once." for name in sorted(set(found)) if found.count(name) > 1
    ]
    return problems


@lru_cache(maxsize=32)
def _inspect_brep(name: str, solid: Content[Shape], expected: Expected | None) -> _Found:
    """Check one part of a STEP file."""
    shape = solid.of
    solids = shape.solids()
    if len(solids) != 1:
        return PartInspection(name, False), (f"{name} is {len(solids)} solids where it should be one.",)
    if not BRepCheck_Analyzer(shape.wrapped).IsValid():
        return PartInspection(name, False), (f"{name} is not a valid solid for OCCT.",)
    mass = solid_mass(shape)
    problems: list[str] = []
    distance_um = None
    if expected is not None:
        reach_mm = 0.5 * shape.bounding_box(optimal=False).diagonal
        if expected.boundary is None:
            problems += _loose_mass_problems(mass, expected, shape.area, reach_mm)
        else:
            problems += _mass_problems(
                mass, expected, MASS_TOLERANCE * mass.volume_mm3, MASS_TOLERANCE * reach_mm
            )
            try:
                distance_um = max_deviation_um(shape, expected.boundary.curved_surfaces)
            except GeometryError as error:
                problems.append(f"{name}: {error}")
            else:
                problems += _distance_problems(name, distance_um, expected.distance_um)
    return PartInspection(name, True, mass.volume_mm3, mass.com_mm, distance_um), tuple(problems)


def inspect_mesh(name: str, mesh: Mesh, expected: Expected | None, audit: bool = False) -> _Found:
    """Check one mesh of an STL or 3MF file; gives what was found and a sentence for each fault."""
    return _inspect_mesh(name, mesh_content(mesh), expected, audit)


@lru_cache(maxsize=16)
def _inspect_mesh(name: str, content: Content[Mesh], expected: Expected | None, audit: bool) -> _Found:
    mesh = content.of
    facets = len(mesh.faces)
    problems = [f"{name} {fault}." for fault in audit_mesh(mesh)] if audit else []
    closed = _closed(content)
    problems += [f"{name} {fault}." for fault in closed.faults]
    if problems:
        return PartInspection(name, False, facets=facets), tuple(problems)
    mass = mesh.mass()
    distance_um = None
    if expected is not None:
        reach_mm = 0.5 * float(np.linalg.norm(np.ptp(mesh.vertices_mm, axis=0)))
        if expected.boundary is None:
            problems += _loose_mass_problems(mass, expected, float(facet_normals(mesh)[1].sum()), reach_mm)
        else:
            gap = mesh_distance(mesh, closed.manifold, expected.boundary, expected.distance_um)
            distance_um = max(gap.from_mesh_um, gap.to_mesh_um)
            problems += _distance_problems(name, distance_um, expected.distance_um)
            if not 1e-3 * gap.corners_um <= MASS_TOLERANCE * reach_mm:
                problems.append(
                    f"{name} is displaced or of another size: its vertices lie {gap.corners_um:.2g} µm off "
                    "the model's surface, on which they should lie."
                )
            problems += _corrected_mass_problems(mass, gap, expected, reach_mm)
    return PartInspection(name, True, mass.volume_mm3, mass.com_mm, distance_um, facets), tuple(problems)


class _Closed(NamedTuple):
    """What is wrong with the boundary of a mesh, for two libraries, and the mesh as one of them has it."""

    faults: tuple[str, ...]
    manifold: Manifold


@lru_cache(maxsize=16)
def _closed(content: Content[Mesh]) -> _Closed:
    mesh, faults = content.of, []
    tri = trimesh.Trimesh(mesh.vertices_mm, mesh.faces, process=False)
    if not tri.is_watertight:
        faults.append(f"is not watertight: {_open_edges(mesh)} edges do not join two facets")
    elif not tri.is_winding_consistent:
        faults.append("has facets that are turned over")
    manifold = Manifold(Mesh64(mesh.vertices_mm, mesh.faces.astype(np.uint64)))
    if manifold.status() != Error.NoError:
        faults.append(f"is not a manifold for manifold3d ({manifold.status().name})")
    elif not faults and manifold.volume() <= 0.0:
        faults.append("is inside out")
    return _Closed(tuple(faults), manifold)


def _open_edges(mesh: Mesh) -> int:
    edges, edges_of_face = mesh.edges()
    return int(np.sum(np.bincount(edges_of_face.ravel(), minlength=len(edges)) != 2))


def _corrected_mass_problems(
    mass: MassProperties, gap: MeshDistance, expected: Expected, reach_mm: float
) -> list[str]:
    """Compare a mesh with the model after adding what lies between its facets and the analytic surfaces."""
    volume = mass.volume_mm3 + gap.missing_mm3
    com = (np.asarray(mass.com_mm) * mass.volume_mm3 + gap.missing_moment_mm4) / volume
    corrected = MassProperties.from_arrays(volume, com, np.asarray(mass.inertia_mm5))
    volume_mm3 = MASS_TOLERANCE * volume + CORRECTION_TOLERANCE * gap.moved_mm3
    com_mm = MASS_TOLERANCE * reach_mm + CORRECTION_TOLERANCE * gap.moved_moment_mm4 / volume
    return _mass_problems(corrected, expected, volume_mm3, com_mm)


def _loose_mass_problems(
    mass: MassProperties, expected: Expected, area_mm2: float, reach_mm: float
) -> list[str]:
    """Compare with a model of unknown surfaces, all of which may be off by what is promised, to one side."""
    moved_mm3 = 1e-3 * expected.distance_um * area_mm2
    return _mass_problems(mass, expected, moved_mm3, moved_mm3 * reach_mm / mass.volume_mm3)


def _mass_problems(mass: MassProperties, expected: Expected, volume_mm3: float, com_mm: float) -> list[str]:
    """Sentences about a volume or a COM that is further off than a tolerance."""
    problems = []
    if not abs(mass.volume_mm3 - expected.volume_mm3) <= volume_mm3:
        problems.append(
            f"{expected.name} has a volume of {mass.volume_mm3:.6g} mm³ where the model has "
            f"{expected.volume_mm3:.6g} mm³{_unit_hint(mass.volume_mm3 / expected.volume_mm3)}."
        )
    off_mm = np.subtract(mass.com_mm, expected.com_mm)
    if not np.linalg.norm(off_mm) <= com_mm:
        problems.append(
            f"{expected.name} has its centre of mass {1e3 * np.linalg.norm(off_mm):.4g} µm away from the "
            f"model's; {1e3 * com_mm:.3g} µm are allowed."
        )
    return problems


def _unit_hint(ratio: float) -> str:
    if abs(ratio / _INCH_MM**3 - 1.0) < 0.01 or abs(ratio * _INCH_MM**3 - 1.0) < 0.01:
        return ", as if inches and millimetres were mixed up"
    return ""


def _distance_problems(name: str, distance_um: float, promised_um: float) -> list[str]:
    if distance_um <= promised_um:
        return []
    return [
        f"{name} is {distance_um:.3g} µm away from the model's surface; {promised_um:.3g} µm are promised."
    ]

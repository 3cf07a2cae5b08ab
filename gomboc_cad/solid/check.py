"""Does any part from a file right itself? From the file to the verdict."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from gomboc_cad.equilibria.mesh import mesh_census
from gomboc_cad.equilibria.records import Census, Vector, as_vector
from gomboc_cad.errors import InspectionError
from gomboc_cad.progress import Progress, silent
from gomboc_cad.solid.part_reading import STEP, PartMesh, identify, read_part, shown_name
from gomboc_cad.solid.step_census import StepPart, read_step_part, step_census


@dataclass(frozen=True)
class PartCheck:
    """What was found of a part.

    Attributes:
        file: Name of the file.
        kind: What it is, for sentences: `a binary STL file`.
        unit: Unit of its numbers; None where a STEP file does not tell.
        watertight: Whether a mesh is closed, or a B-rep a valid solid.
        volume_mm3: Volume; None where the file does not hold exactly one solid.
        centroid_mm: Centre of mass of the homogeneous solid, likewise.
        com_mm: Centre of mass that the census is about.
        com_given: Whether that was given, and not the centroid.
        facets: Number of triangles of a mesh; None for a STEP file.
        size_mm: Extent along x, y and z.
        repairs: What was changed, one sentence each.
        notes: What a user should know, one sentence each; faults that a given centre of mass makes
            harmless among them.
        census: The census.
    """

    file: str
    kind: str
    unit: str | None
    watertight: bool
    volume_mm3: float | None
    centroid_mm: Vector | None
    com_mm: Vector
    com_given: bool
    facets: int | None
    size_mm: Vector
    repairs: tuple[str, ...]
    notes: tuple[str, ...]
    census: Census


def check_part(
    path: Path,
    *,
    com_mm: Sequence[float] | None = None,
    unit: str | None = None,
    barrier_um: float | None = None,
    faceted: bool = False,
    progress: Progress = silent,
) -> PartCheck:
    """Read a STEP, STL, 3MF, OBJ or PLY file and count the poses in which the part rests.

    Args:
        path: The file.
        com_mm: Centre of mass, shape (3,); that of the homogeneous solid if not given.
        unit: Unit of the file's numbers, as in `part_reading.UNITS_MM`; formats that state their own allow
            no other.
        barrier_um: Poses with a lower barrier do not count; by default what the resolution may falsify
            one by.
        faceted: The part really has the facets of its mesh; they do not stand for a smooth surface.
        progress: Told about each stage.

    Raises:
        InspectionError: If the file cannot be read, or does not hold exactly one solid and no centre of mass
            is given.
        CensusError: If the centre of mass is outside of the convex hull.
        GeometryError: If OCCT cannot mesh the part.
    """
    given = None if com_mm is None else _point(com_mm)
    barrier_mm = None if barrier_um is None else _length_mm(barrier_um)
    if identify(path) == STEP:
        return _check_step(path, given, unit, barrier_mm, progress)
    return _check_mesh(path, given, unit, barrier_mm, faceted, progress)


def _check_step(
    path: Path, given: Vector | None, unit: str | None, barrier_mm: float | None, progress: Progress
) -> PartCheck:
    progress("reading the file")
    part = read_step_part(path, unit)
    centroid = part.mass.com_mm if part.mass else None
    com, notes = _center(path, part, centroid, given)
    # The points of the surface bound the hull; the mass is that of the solid itself.
    census = replace(step_census(part, com, barrier_mm, progress), mass_properties=part.mass)
    return PartCheck(
        file=shown_name(path),
        kind=STEP,
        unit=part.unit,
        watertight=part.watertight,
        volume_mm3=part.mass.volume_mm3 if part.mass else None,
        centroid_mm=centroid,
        com_mm=com,
        com_given=given is not None,
        facets=None,
        size_mm=part.extent_mm,
        repairs=part.repairs,
        notes=notes,
        census=census,
    )


def _check_mesh(
    path: Path,
    given: Vector | None,
    unit: str | None,
    barrier_mm: float | None,
    faceted: bool,
    progress: Progress,
) -> PartCheck:
    part = read_part(path, unit, progress)
    com, notes = _center(path, part, part.com_mm, given)
    progress("census of the convex hull")
    # Without its own COM the mesh may be open; with one, the census knows how far facets move it.
    sag_mm = 0.0 if faceted else None
    census = mesh_census(part.mesh.vertices_mm, part.mesh.faces, given, barrier_mm=barrier_mm, sag_mm=sag_mm)
    if part.faults:
        census = replace(census, mass_properties=None)
    return PartCheck(
        file=shown_name(path),
        kind=part.kind,
        unit=part.unit,
        watertight=part.watertight,
        volume_mm3=part.volume_mm3,
        centroid_mm=part.com_mm,
        com_mm=com,
        com_given=given is not None,
        facets=len(part.mesh.faces),
        size_mm=as_vector(np.ptp(part.mesh.vertices_mm, axis=0)),
        repairs=part.repairs,
        notes=notes,
        census=census,
    )


def _center(
    path: Path, part: PartMesh | StepPart, centroid: Vector | None, given: Vector | None
) -> tuple[Vector, tuple[str, ...]]:
    """The COM to use, and the part's notes with its faults, which are harmless where a COM is given."""
    faults = "; ".join(part.faults)
    if given is not None:
        harmless = (
            f"As a solid it is unusable ({faults}); its convex hull and the given centre of mass were used."
        )
        return given, part.notes + ((harmless,) if faults else ())
    if centroid is None:
        raise InspectionError(
            f"{shown_name(path)} has no centre of mass of its own: {faults}. Repair it, or give --com-mm; "
            "the poses then depend on its convex hull only."
        )
    return centroid, part.notes


def _point(values: Sequence[float]) -> Vector:
    point = np.asarray(values, dtype=float)
    if point.shape != (3,) or not np.all(np.isfinite(point)):
        raise InspectionError(f"A centre of mass is three numbers in mm, not {values!r}.")
    return as_vector(point)


def _length_mm(barrier_um: float) -> float:
    if not 0.0 <= barrier_um < np.inf:
        raise InspectionError(f"The barrier must be a length of zero or more in µm, not {barrier_um!r}.")
    return 1e-3 * barrier_um

"""STEP files of parts from anywhere, and their census on points of the true surface, finer and finer."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from build123d import Shape
from OCP.BRepCheck import BRepCheck_Analyzer

from gomboc_cad.body.mass import MassProperties
from gomboc_cad.equilibria.mesh import mesh_census
from gomboc_cad.equilibria.records import Census, Vector, as_vector
from gomboc_cad.errors import InspectionError
from gomboc_cad.progress import Progress, silent
from gomboc_cad.solid.mass import solid_mass
from gomboc_cad.solid.part_reading import STEP, UNITS_MM, check_size_mm, identify, shown_name
from gomboc_cad.solid.step import NamedSolid, read_step
from gomboc_cad.solid.step_trial import try_step
from gomboc_cad.solid.surface_sampling import SurfaceSampler

FIRST_SAG = 4e-4
"""Sag of the coarsest points over the size of the part; each round halves it."""

MAX_ROUNDS = 6
_FADING = 0.75
"""Spurious basins have to shrink at least this much when the sag is halved; a real one would stay."""

_SAME_POSE_DEG = 15.0
_LENGTH_UNITS = re.compile(
    rb"CONVERSION_BASED_UNIT\s*\(\s*'(INCH|FOOT)'|SI_UNIT\s*\(\s*(\.[A-Z]+\.|\$)\s*,\s*\.METRE\.\s*\)",
    re.IGNORECASE,
)
_UNIT_OF_STEP = {
    b"INCH": "in",
    b"FOOT": "ft",
    b"$": "m",
    b".MILLI.": "mm",
    b".CENTI.": "cm",
    b".MICRO.": "um",
}


@dataclass(frozen=True, eq=False)
class StepPart:
    """A part read from a STEP file, in millimetres.

    Attributes:
        solids: Its solids, in place; one unless there is a fault.
        unit: Unit of the file; None where it could not be told. The kernel converted it.
        watertight: Whether OCCT finds every solid valid.
        mass: Of the homogeneous solid; None unless there is one valid solid.
        extent_mm: Extent along x, y and z.
        faults: Why there is not one valid solid, one clause each.
        repairs: What was changed, one sentence each.
        notes: What a user should know, one sentence each.
    """

    solids: tuple[Shape, ...]
    unit: str | None
    watertight: bool
    mass: MassProperties | None
    extent_mm: Vector
    faults: tuple[str, ...]
    repairs: tuple[str, ...]
    notes: tuple[str, ...]


def read_step_part(path: Path, unit: str | None = None) -> StepPart:
    """Read a STEP file, after a trial in another process.

    Args:
        path: The file.
        unit: What the user says its unit is; a STEP file states its own, so it can only agree.

    Raises:
        InspectionError: If the file cannot be read, holds no solid, or is in another unit.
    """
    if identify(path) == STEP:
        try_step(path, shown_name(path))
    return load_step_part(path, unit)


def load_step_part(path: Path, unit: str | None = None) -> StepPart:
    """Read a STEP file that OCCT is known not to crash on; see `read_step_part`."""
    name = shown_name(path)
    if identify(path) != STEP:
        raise InspectionError(f"{name} is no STEP file.")
    if name != path.name:
        raise InspectionError(f"{name} has a name that is not UTF-8; rename it.")
    stated = _stated_unit(path)
    if unit not in (None, stated):
        if unit not in UNITS_MM:
            raise InspectionError(f"The unit {unit!r} is none of {', '.join(UNITS_MM)}.")
        raise InspectionError(f"{name} states its unit, {stated or 'not ' + unit}; leave --unit out.")
    try:
        named = read_step(path)
    except RuntimeError as error:  # what OCCT's exceptions become
        raise InspectionError(f"{name} is damaged: OCCT cannot read it ({error}).") from error
    solids = [(part.name, solid) for part in named for solid in part.solid.solids()]
    if not solids:
        raise InspectionError(f"{name} holds no solid; join its surfaces to a solid and export it again.")
    return _assess(name, named, solids, stated)


def _assess(
    name: str, named: Sequence[NamedSolid], solids: Sequence[tuple[str, Shape]], unit: str | None
) -> StepPart:
    shapes = tuple(solid for _, solid in solids)
    box = [solid.bounding_box(optimal=True) for solid in shapes]
    low = np.min([tuple(b.min) for b in box], axis=0)
    high = np.max([tuple(b.max) for b in box], axis=0)
    check_size_mm(name, low, high)
    faults: tuple[str, ...] = ()
    repairs: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()
    if unit not in ("mm", None):
        notes += (f"The file is in the unit {unit}; it was converted to millimetres.",)
    loose = sum(len(part.solid.faces()) for part in named) - sum(len(solid.faces()) for solid in shapes)
    if loose > 0:
        notes += (f"{loose} faces that belong to no solid were left out.",)
    invalid = sum(not BRepCheck_Analyzer(solid.wrapped).IsValid() for solid in shapes)
    if invalid:
        faults += ("it is no valid solid for OCCT",)
    if len(shapes) > 1:
        shown = ", ".join(label or "unnamed" for label, _ in solids[:5]) + (", …" if len(solids) > 5 else "")
        faults += (f"it holds {len(shapes)} solids ({shown}), and nothing says that they are joined",)
    mass = None if faults else solid_mass(shapes[0])
    if mass is not None and mass.volume_mm3 < 0.0:
        repairs += ("The solid was inside out; it was turned.",)
        inertia = -np.array(mass.inertia_mm5)
        mass = MassProperties.from_arrays(-mass.volume_mm3, np.array(mass.com_mm), inertia)
    return StepPart(shapes, unit, not invalid, mass, as_vector(high - low), faults, repairs, notes)


def _stated_unit(path: Path) -> str | None:
    """The length unit of a STEP file, if it states one that is known, and no other."""
    found = {conversion or prefix for conversion, prefix in _LENGTH_UNITS.findall(path.read_bytes())}
    named = {_UNIT_OF_STEP.get(word.upper()) for word in found}
    # A unit like the inch is itself defined by a metric one.
    if named & {"in", "ft"}:
        named &= {"in", "ft"}
    return named.pop() if len(named) == 1 else None


def step_census(
    part: StepPart,
    com_mm: Vector,
    barrier_mm: float | None = None,
    progress: Progress = silent,
) -> Census:
    """Take the census on finer and finer points of the surface until two successive ones agree.

    They agree when they have the same verdict and the same poses with the same barriers, and when the basins
    that do not count have lower barriers on the finer points, as those have that only the points make.

    Args:
        part: The part.
        com_mm: Centre of mass.
        barrier_mm: Lowest barrier that counts; by default what the resolution may falsify one by.
        progress: Told about each round.

    Raises:
        CensusError: If the centre of mass is outside of the hull.
        GeometryError: If OCCT cannot mesh the part.
    """
    sampler = sampler_of(part)
    previous: Census | None = None
    sag_mm = FIRST_SAG * sampler.size_mm
    for _ in range(MAX_ROUNDS):
        progress(f"census at a sag of {1e3 * sag_mm:.3g} µm")
        points = sampler.sample(sag_mm)
        census = mesh_census(
            points.points_mm, points.faces, com_mm, barrier_mm=barrier_mm, sag_mm=points.sag_mm
        )
        if points.sag_mm == 0.0 or (
            previous is not None and agree(previous, census, fading=barrier_mm is None)
        ):
            return census
        if points.sag_mm > sag_mm or (previous is not None and _neutral(previous) and _neutral(census)):
            break
        previous, sag_mm = census, 0.5 * sag_mm
    if census.verdict == "undecided":
        return census
    return replace(
        census,
        verdict="undecided",
        reason=f"Points of the surface with a sag of {1e3 * points.sag_mm:.3g} µm and coarser ones do not "
        "agree on the poses or their barriers; give the barrier that counts, well above that.",
    )


def _neutral(census: Census) -> bool:
    """Whether the part rests all along a ring or a sphere, which no finer points will change."""
    return any(pose.kind == "stable" and pose.extent != "point" for pose in census.equilibria)


def sampler_of(part: StepPart) -> SurfaceSampler:
    """Mesh a part coarsely, ready for points as fine as wanted.

    Raises:
        GeometryError: If OCCT cannot mesh a face.
    """
    return SurfaceSampler(part.solids, float(np.linalg.norm(part.extent_mm)))


def agree(coarse: Census, fine: Census, fading: bool) -> bool:
    """Whether two censuses of one part with different sags say the same.

    Args:
        coarse: On the coarser points.
        fine: On the finer points.
        fading: Whether the basins that do not count are to be spurious ones, which vanish with the sag.
    """
    if fine.verdict == "undecided" or (fine.verdict, fine.stable) != (coarse.verdict, coarse.stable):
        return False
    assert coarse.mesh is not None  # both are censuses of meshes
    assert fine.mesh is not None
    sag_mm = coarse.mesh.sag_mm
    left = [pose for pose in coarse.equilibria if pose.kind == "stable"]
    for pose in (pose for pose in fine.equilibria if pose.kind == "stable"):
        same = max(left, key=lambda other: float(np.dot(other.direction, pose.direction)))
        left.remove(same)
        turned = np.dot(same.direction, pose.direction) < np.cos(np.radians(_SAME_POSE_DEG))
        barriers = [b if b is not None else 0.0 for b in (same.barrier_mm, pose.barrier_mm)]
        if turned or np.ptp(barriers) > 2.0 * sag_mm or abs(same.height_mm - pose.height_mm) > sag_mm:
            return False
    spurious = [mesh.highest_uncounted_mm or 0.0 for mesh in (coarse.mesh, fine.mesh)]
    return not fading or spurious[1] <= _FADING * spurious[0]

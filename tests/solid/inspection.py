"""A part written to every format by both kernels, read back and measured against its analytic boundary."""

from __future__ import annotations

from pathlib import Path

from build123d import Solid

from gomboc_cad.solid.boundary import Boundary
from gomboc_cad.solid.export import NamedMesh, NamedSolid, write_3mf, write_step, write_stl
from gomboc_cad.solid.inspect import Expected, inspect_file
from gomboc_cad.solid.mass import solid_mass
from gomboc_cad.solid.mesh import Mesh

STEP_DEVIATION_UM = 0.05


def problems_on_disk(
    folder: Path, solid: Solid, mesh: Mesh, boundary: Boundary, sag_um: float
) -> tuple[str, ...]:
    """Whatever an inspection finds; the mesh is held against the solid's mass, so the twins must agree."""
    mass = solid_mass(solid)
    write_step(folder / "part.step", [NamedSolid("part", solid, (0.5, 0.5, 0.5))], "part")
    write_stl(folder / "part.stl", mesh, "part")
    write_3mf(folder / "part.3mf", [NamedMesh("part", mesh)])
    problems: list[str] = []
    for kind, promised_um in (("step", STEP_DEVIATION_UM), ("stl", sag_um), ("3mf", sag_um)):
        expected = Expected("part", mass.volume_mm3, mass.com_mm, promised_um, boundary)
        problems += inspect_file(folder / f"part.{kind}", [expected]).problems
    return tuple(problems)

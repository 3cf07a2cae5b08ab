"""A hollow body with standoffs, seam bosses and holes, made once by both kernels and written to files."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest
from build123d import Solid

import gomboc_cad
from gomboc_cad import Body
from gomboc_cad.body import mass_properties
from gomboc_cad.solid.boundary import Boundary
from gomboc_cad.solid.export import NamedMesh, NamedSolid, write_3mf, write_step, write_stl
from gomboc_cad.solid.hollow import Cylinder, HollowBody, Mesh, Seam, brep, mesh, split_brep, split_mesh
from gomboc_cad.solid.inspect import Expected
from gomboc_cad.solid.mass import solid_mass
from gomboc_cad.solid.mesh import body_mesh
from gomboc_cad.solid.patches import body_solid, default_deviation_um

SAG_UM = 20.0
ORIGIN, ALONG_X = (0.0, 0.0, 0.0), (1.0, 0.0, 0.0)
SEAM = Seam(ORIGIN, ALONG_X)


def reference_hollow(body: Body) -> HollowBody:
    """A wall of 3 mm, four standoffs with blind holes, three seam bosses with dowel holes across x = 0."""
    sites = [(y, z) for y in (-10.0, 10.0) for z in (-8.0, 8.0)]
    pins = [(float(44 * np.cos(a)), float(44 * np.sin(a))) for a in 0.3 + np.arange(3) * 2 * np.pi / 3]
    return HollowBody(
        body,
        wall_mm=3.0,
        core_shift_mm=(0.15, -0.08, 0.05),
        bosses=(
            *(Cylinder((-49.0, *site), ALONG_X, 2.75, 9.0) for site in sites),
            *(Cylinder((-30.0, *pin), ALONG_X, 3.5, 60.0) for pin in pins),
        ),
        holes=(
            *(Cylinder((-45.0, *site), ALONG_X, 1.6, 5.0) for site in sites),
            *(Cylinder((-6.0, *pin), ALONG_X, 1.5, 12.0) for pin in pins),
        ),
    )


@dataclass(frozen=True)
class Halves:
    """The two halves of the hollow body in both kernels, and what they have to be."""

    solids: tuple[Solid, Solid]
    meshes: tuple[Mesh, Mesh]
    expected: tuple[Expected, Expected]

    def expected_meshes(self) -> tuple[Expected, Expected]:
        """The same for files with meshes."""
        lower, upper = (replace(part, distance_um=SAG_UM) for part in self.expected)
        return lower, upper


@pytest.fixture(scope="session")
def primary() -> Body:
    return gomboc_cad.catalog()["primary"]


@pytest.fixture(scope="session")
def hollow(primary: Body) -> HollowBody:
    return reference_hollow(primary)


@pytest.fixture(scope="session")
def hollow_brep(hollow: HollowBody) -> Solid:
    return brep(hollow)


@pytest.fixture(scope="session")
def hollow_mesh(hollow: HollowBody) -> Mesh:
    return mesh(hollow, SAG_UM)


@pytest.fixture(scope="session")
def halves(hollow: HollowBody, hollow_brep: Solid, hollow_mesh: Mesh) -> Halves:
    solids = split_brep(hollow_brep, SEAM)
    boundaries = Boundary.of_hollow(hollow).split(SEAM)
    lower, upper = (
        Expected(name, solid_mass(solid).volume_mm3, solid_mass(solid).com_mm, 0.1, boundary)
        for name, solid, boundary in zip(("lower half", "upper half"), solids, boundaries, strict=True)
    )
    return Halves(solids, split_mesh(hollow_mesh, SEAM, SAG_UM), (lower, upper))


@pytest.fixture(scope="session")
def expected_body(primary: Body) -> Expected:
    mass = mass_properties(primary)
    boundary = Boundary.of_body(primary)
    return Expected("primary", mass.volume_mm3, mass.com_mm, default_deviation_um(primary), boundary)


def write_all(folder: Path, body: Body, halves: Halves) -> None:
    """Write the body and the halves in every format."""
    write_step(folder / "body.step", [NamedSolid("primary", body_solid(body), (0.8, 0.2, 0.1))], "primary")
    write_stl(folder / "body.stl", body_mesh(body, SAG_UM), "primary")
    names = [part.name for part in halves.expected]
    colors = [(0.8, 0.2, 0.1), (0.2, 0.2, 0.8)]
    parts = [NamedSolid(*triple) for triple in zip(names, halves.solids, colors, strict=True)]
    write_step(folder / "assembly.step", parts, "hollow")
    write_step(folder / "lower.step", parts[:1], "lower half")
    write_stl(folder / "lower.stl", halves.meshes[0], "lower half")
    write_3mf(folder / "halves.3mf", [NamedMesh(*p) for p in zip(names, halves.meshes, strict=True)])


@pytest.fixture(scope="session")
def files(tmp_path_factory: pytest.TempPathFactory, primary: Body, halves: Halves) -> Path:
    """A folder with all files; tests that damage one copy it first."""
    folder = tmp_path_factory.mktemp("files")
    write_all(folder, primary, halves)
    return folder

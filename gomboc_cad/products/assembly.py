"""Parts and assemblies: every mass with its place, and the centre of mass of the whole."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from build123d import Location, Solid

from gomboc_cad.body.mass import MassProperties
from gomboc_cad.body.sphere import Array
from gomboc_cad.equilibria.records import Vector, as_vector
from gomboc_cad.products.materials import Material
from gomboc_cad.solid.boundary import Boundary
from gomboc_cad.solid.mass import solid_mass
from gomboc_cad.solid.mesh import Mesh
from gomboc_cad.solid.step import Color


@dataclass(frozen=True)
class Part:
    """One body of an assembly.

    Attributes:
        name: Unique name, the one in STEP and 3MF.
        material: Name of the material.
        mass_g: Mass.
        com_mm: Centre of mass in the body's frame.
        solid: The solid, in place.
        measured: Mass properties of the solid as a homogeneous one; a payload's own may differ.
        made: Whether it is made by the user (printed or machined) and not bought.
        standard: Standard or maker's number of a bought part.
        color: RGB in 0…1.
        mesh: Mesh of a made part, in place.
        boundary: The surfaces that bound a made part, in place.
        print_up: Direction of the body's frame that points up on a printer's bed; a made part without it is
            written, but not put on the plate.
    """

    name: str
    material: str
    mass_g: float
    com_mm: Vector
    solid: Solid
    measured: MassProperties
    made: bool
    standard: str
    color: Color
    mesh: Mesh | None = None
    boundary: Boundary | None = None
    print_up: Vector | None = None

    @classmethod
    def homogeneous(
        cls, name: str, solid: Solid, material: Material, color: Color, standard: str = ""
    ) -> Part:
        """A part of one material throughout; with a standard it is a bought one."""
        mass = solid_mass(solid)
        mass_g = material.mass_g(mass.volume_mm3)
        return cls(name, material.name, mass_g, mass.com_mm, solid, mass, not standard, standard, color)

    @property
    def volume_mm3(self) -> float:
        """Volume of the solid."""
        return self.measured.volume_mm3

    def moved(self, shift_mm: Array) -> Part:
        """The same part displaced rigidly by a vector of shape (3,)."""
        x, y, z = as_vector(shift_mm)
        return replace(
            self,
            com_mm=as_vector(np.add(self.com_mm, shift_mm)),
            solid=self.solid.moved(Location((x, y, z))),
            measured=replace(self.measured, com_mm=as_vector(np.add(self.measured.com_mm, shift_mm))),
            mesh=None
            if self.mesh is None
            else replace(self.mesh, vertices_mm=self.mesh.vertices_mm + shift_mm),
            boundary=None if self.boundary is None else self.boundary.moved((x, y, z)),
        )


@dataclass(frozen=True)
class Assembly:
    """Parts in place.

    Attributes:
        name: Name of the product.
        parts: The parts.
        com_target_mm: Where the centre of mass was wanted.
    """

    name: str
    parts: tuple[Part, ...]
    com_target_mm: Vector

    @property
    def mass_g(self) -> float:
        """Total mass."""
        return sum(part.mass_g for part in self.parts)

    @property
    def com_mm(self) -> Vector:
        """Centre of mass `Σ mᵢ pᵢ / Σ mᵢ`."""
        return as_vector(center_of_mass([(part.mass_g, part.com_mm) for part in self.parts]))

    def com_with(self, solids: Mapping[str, Solid]) -> Vector:
        """Centre of mass with some homogeneous parts replaced by other solids of the same material.

        Args:
            solids: The other solids by the name of the part.
        """
        masses = []
        for part in self.parts:
            if part.name in solids:
                other = solid_mass(solids[part.name])
                masses.append((part.mass_g * other.volume_mm3 / part.volume_mm3, other.com_mm))
            else:
                masses.append((part.mass_g, part.com_mm))
        return as_vector(center_of_mass(masses))

    @property
    def com_residual_um(self) -> float:
        """Distance of the centre of mass from its target."""
        return 1e3 * float(np.linalg.norm(np.subtract(self.com_mm, self.com_target_mm)))


def center_of_mass(masses: list[tuple[float, Vector]]) -> Array:
    """Weighted mean of positions: pairs (mass, position), shape (3,)."""
    weights = np.array([mass for mass, _ in masses])
    places = np.array([place for _, place in masses])
    result: Array = weights @ places / weights.sum()
    return result

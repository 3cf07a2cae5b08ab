"""Bought parts whose mass and centre of mass are not exactly known, and what that does to the assembly."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gomboc_cad.body.sphere import Array
from gomboc_cad.equilibria.records import Vector, as_vector
from gomboc_cad.products.assembly import Assembly, Part
from gomboc_cad.products.design import Uncertainty


@dataclass(frozen=True)
class UncertainLoad:
    """A part of an assembly that is known only with tolerances, as half-widths.

    Attributes:
        part: Name of the part.
        mass_tolerance_g: How far its mass may be off.
        com_tolerance_mm: How far its centre of mass may be off along each axis.
    """

    part: str
    mass_tolerance_g: float
    com_tolerance_mm: float

    def com_error_by_mass_mm(self, assembly: Assembly) -> Array:
        """Move of the assembly's centre of mass when the part is heavier by its tolerance, shape (3,)."""
        arm = np.subtract(self._within(assembly).com_mm, assembly.com_mm)
        return arm * self.mass_tolerance_g / assembly.mass_g

    def com_error_by_place_mm(self, assembly: Assembly) -> float:
        """Move along an axis when the part's centre of mass is off along it by its tolerance."""
        return self._within(assembly).mass_g / assembly.mass_g * self.com_tolerance_mm

    def _within(self, assembly: Assembly) -> Part:
        return next(part for part in assembly.parts if part.name == self.part)


def load_uncertainties(
    assembly: Assembly, loads: tuple[UncertainLoad, ...], worst_direction: Vector
) -> tuple[Uncertainty, ...]:
    """What the tolerances of the loads do to the centre of mass.

    Args:
        assembly: The finished assembly.
        loads: Its uncertain loads.
        worst_direction: Unit vector along which an error of the place is told: the rest's soft direction.
    """
    found = []
    for load in loads:
        found.append(
            Uncertainty(
                f"an error of {load.mass_tolerance_g:g} g in the mass of the {load.part}",
                as_vector(load.com_error_by_mass_mm(assembly)),
                "weigh it and give the mass with a smaller tolerance",
            )
        )
        found.append(
            Uncertainty(
                f"an error of {load.com_tolerance_mm:g} mm in the place of the {load.part}'s centre of mass",
                as_vector(load.com_error_by_place_mm(assembly) * np.array(worst_direction)),
                "balance the finished part, or find that centre of mass and give it with a smaller tolerance",
            )
        )
    return tuple(found)

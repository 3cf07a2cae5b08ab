"""The water that a part floats in."""

from __future__ import annotations

import math
from dataclasses import dataclass

from gomboc_cad.errors import GeometryError


@dataclass(frozen=True)
class Water:
    """A liquid at rest.

    Attributes:
        name: What it is called in reports.
        density_g_cm3: Its density.
    """

    name: str
    density_g_cm3: float

    def __post_init__(self) -> None:
        if not (math.isfinite(self.density_g_cm3) and self.density_g_cm3 > 0.0):
            raise GeometryError(
                f"The density of {self.name} must be a positive number of g/cm³, not {self.density_g_cm3!r}."
            )

    def displaced_volume_mm3(self, mass_g: float) -> float:
        """Volume that a floating mass displaces (Archimedes' principle)."""
        return 1e3 * mass_g / self.density_g_cm3


FRESH_WATER = Water("fresh water", 0.9982)
"""At 20 °C and 101.325 kPa, 998.2067 kg/m³: Tanaka et al., Metrologia 38 (2001) 301."""

SEA_WATER = Water("sea water", 1.025)
"""The usual figure of naval architecture; 1024.8 kg/m³ at 20 °C and 35.165 g/kg: ITTC 7.5-02-01-03 (2011)."""

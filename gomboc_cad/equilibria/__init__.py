"""Pure mathematics of rest: smooth census, strict convexity and the COM margin."""

from gomboc_cad.equilibria.convexity import convexity
from gomboc_cad.equilibria.margin import com_margin
from gomboc_cad.equilibria.records import (
    Census,
    CensusVerdict,
    Convexity,
    Equilibrium,
    Margin,
    MeshEvidence,
    Rest,
)
from gomboc_cad.equilibria.smooth import find_equilibria, smooth_census

__all__ = [
    "Census",
    "CensusVerdict",
    "Convexity",
    "Equilibrium",
    "Margin",
    "MeshEvidence",
    "Rest",
    "com_margin",
    "convexity",
    "find_equilibria",
    "smooth_census",
]

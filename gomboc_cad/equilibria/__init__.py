"""Pure mathematics of rest: censuses of smooth bodies and of meshes, strict convexity, the COM margin."""

from gomboc_cad.equilibria.convexity import convexity
from gomboc_cad.equilibria.margin import com_margin
from gomboc_cad.equilibria.mesh import mesh_census
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
    "mesh_census",
    "smooth_census",
]

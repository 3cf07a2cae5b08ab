"""Pure mathematics of rest: censuses of smooth bodies and of meshes, strict convexity, the COM margin."""

from importlib import import_module
from typing import TYPE_CHECKING, Any

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

if TYPE_CHECKING:
    from gomboc_cad.equilibria.dented import hull_census
    from gomboc_cad.equilibria.mesh import mesh_census

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
    "hull_census",
    "mesh_census",
    "smooth_census",
]

_MESH_CENSUSES = {"hull_census": "dented", "mesh_census": "mesh"}


def __getattr__(name: str) -> Any:
    """Load the censuses of meshes when they are asked for: scipy's graphs take longer than all the rest."""
    if name in _MESH_CENSUSES:
        return getattr(import_module(f"{__name__}.{_MESH_CENSUSES[name]}"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")

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
    from gomboc_cad.equilibria.drainage import DrainageOptions, drainage_count, rotated_counts
    from gomboc_cad.equilibria.mesh import mesh_census

__all__ = [
    "Census",
    "CensusVerdict",
    "Convexity",
    "DrainageOptions",
    "Equilibrium",
    "Margin",
    "MeshEvidence",
    "Rest",
    "com_margin",
    "convexity",
    "drainage_count",
    "find_equilibria",
    "hull_census",
    "mesh_census",
    "rotated_counts",
    "smooth_census",
]

_LATER = {
    "DrainageOptions": "drainage",
    "drainage_count": "drainage",
    "hull_census": "dented",
    "mesh_census": "mesh",
    "rotated_counts": "drainage",
}


def __getattr__(name: str) -> Any:
    """Load what works on meshes when it is asked for: scipy's graphs take longer than all the rest."""
    if name in _LATER:
        return getattr(import_module(f"{__name__}.{_LATER[name]}"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")

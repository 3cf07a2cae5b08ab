"""The tables by name, in the order of the paper."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from types import MappingProxyType

from gomboc_cad.errors import GombocError
from gomboc_cad.paper.applications import imu, seed_pod
from gomboc_cad.paper.ballast import ballast
from gomboc_cad.paper.cross_layer import cross_layer
from gomboc_cad.paper.dynamics import dynamics
from gomboc_cad.paper.instances import instances, resolution, thresholds
from gomboc_cad.paper.optimization import optimization
from gomboc_cad.paper.records import Table
from gomboc_cad.paper.sloan import beta_sweep
from gomboc_cad.paper.validation import rotations, validation
from gomboc_cad.progress import Progress, silent

TABLES: Mapping[str, Callable[[Progress], Table]] = MappingProxyType(
    {
        "validation": validation,
        "rotations": rotations,
        "beta-sweep": beta_sweep,
        "optimization": optimization,
        "instances": instances,
        "thresholds": thresholds,
        "resolution": resolution,
        "ballast": ballast,
        "dynamics": dynamics,
        "imu": imu,
        "seed-pod": seed_pod,
        "cross-layer": cross_layer,
    }
)


def reproduce(names: Iterable[str] | None = None, progress: Progress = silent) -> tuple[Table, ...]:
    """Reproduce the named tables, or all of them, in the order of the paper.

    Raises:
        GombocError: If there is no table of a name.
    """
    wanted = set(TABLES if names is None else names)
    if unknown := wanted - set(TABLES):
        raise GombocError(f"There is no table {', '.join(sorted(unknown))}; choose from {', '.join(TABLES)}.")
    return tuple(make(progress) for name, make in TABLES.items() if name in wanted)

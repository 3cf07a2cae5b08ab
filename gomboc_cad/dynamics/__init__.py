"""How a body moves on a table: quasi-static descent, and rolling in time."""

from gomboc_cad.dynamics.descent import basins, descent_path
from gomboc_cad.dynamics.records import (
    Basin,
    DescentPath,
    Resistance,
    Righting,
    RollingBody,
    Trajectory,
)
from gomboc_cad.dynamics.rolling import righting, rocking_periods_s, roll

__all__ = [
    "Basin",
    "DescentPath",
    "Resistance",
    "Righting",
    "RollingBody",
    "Trajectory",
    "basins",
    "descent_path",
    "righting",
    "rocking_periods_s",
    "roll",
]

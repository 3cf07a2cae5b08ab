"""Hydrostatics of a closed outer surface: how a part floats in one orientation, and in which it stays."""

from gomboc_cad.hydrostatics.census import floating_census
from gomboc_cad.hydrostatics.records import FloatingCensus, FloatingEvidence, FloatingPose, FloatingState
from gomboc_cad.hydrostatics.righting import RightingCurve, righting_curve
from gomboc_cad.hydrostatics.state import floating_state
from gomboc_cad.hydrostatics.water import FRESH_WATER, SEA_WATER, Water

__all__ = [
    "FRESH_WATER",
    "SEA_WATER",
    "FloatingCensus",
    "FloatingEvidence",
    "FloatingPose",
    "FloatingState",
    "RightingCurve",
    "Water",
    "floating_census",
    "floating_state",
    "righting_curve",
]

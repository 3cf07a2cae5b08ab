"""The calibration of a housing: what may be off in it, and what its sensor reads all the same."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from gomboc_cad.body.sphere import Array
from gomboc_cad.equilibria.records import Census, Rest, Vector
from gomboc_cad.products.assembly import Assembly
from gomboc_cad.products.imu_housing.boards import Board
from gomboc_cad.products.imu_housing.calibration import (
    HEADING_NOTE,
    Calibration,
    Contribution,
    calibrate,
    calibration_document,
    com_tilt_covariance,
    table_tilt_covariance,
)
from gomboc_cad.products.imu_housing.spec import ToleranceSpec
from gomboc_cad.products.loads import UncertainLoad
from gomboc_cad.products.placement import RestFrame
from gomboc_cad.products.verdict import Verdict

CALIBRATION_FILE = "calibration.json"

_SENSOR_NOTE = (
    "The sensor's own zero offset, scale and noise are not in the covariance: they are what the "
    "calibration is to find."
)
_LIMIT = 1.96
"""Half-width of a 95 % interval in standard deviations."""

_UNIFORM = 1.0 / math.sqrt(3.0)
"""Standard deviation of a uniform distribution of half-width 1 (JCGM 100:2008, 4.3.7)."""


@dataclass(frozen=True)
class MountedBoard:
    """A board in its housing.

    Attributes:
        board: The board with its sensor.
        frame: Directions of its length, width and component side in the body's frame.
        origin_mm: Its origin in the body's frame.
        loads: Parts of the assembly that are known only with tolerances.
    """

    board: Board
    frame: RestFrame
    origin_mm: Vector
    loads: tuple[UncertainLoad, ...]


def calibrate_housing(
    assembly: Assembly, mounted: MountedBoard, census: Census, tolerances: ToleranceSpec | None = None
) -> Calibration:
    """Say what the sensor in a housing reads when the housing rests.

    Args:
        assembly: The housing with all its parts.
        mounted: Its board.
        census: The census about the assembled centre of mass.
        tolerances: Those of the finished part and of its place of rest; those of a bare spec if not given.
    """
    tolerances = tolerances or ToleranceSpec()
    rest = census.rest
    com = _com_sources(assembly, mounted.loads, tolerances)
    contributions = [
        *(
            Contribution.of(source, tolerance, com_tilt_covariance(rest, covariance))
            for source, tolerance, covariance in com
        ),
        *_angle_contributions(rest, mounted.board, tolerances),
    ]
    com_covariance = sum((covariance for _, _, covariance in com), np.zeros((3, 3)))
    notes = [HEADING_NOTE, _SENSOR_NOTE, *_margin_notes(census, com_covariance)]
    if exact := [item.source for item in contributions if item.cone_95_deg == 0.0]:
        notes.append(f"Taken as exact, because no tolerance is given: {', '.join(exact)}.")
    return calibrate(
        rest, mounted.frame, mounted.board, np.array(mounted.origin_mm), contributions, tuple(notes)
    )


def calibration_documents(
    assembly: Assembly, mounted: MountedBoard, tolerances: ToleranceSpec, verdict: Verdict
) -> Mapping[str, dict[str, Any]]:
    """`calibration.json`; a housing with several rests has nothing to calibrate with, and gets none."""
    if verdict.census is None or verdict.census.stable != 1:
        return {}
    calibration = calibrate_housing(assembly, mounted, verdict.census, tolerances)
    return {CALIBRATION_FILE: calibration_document(calibration)}


def _com_sources(
    assembly: Assembly, loads: tuple[UncertainLoad, ...], tolerances: ToleranceSpec
) -> list[tuple[str, str, Array]]:
    """What moves the assembled centre of mass: source, tolerance, covariance in mm² of shape (3, 3)."""
    sources: list[tuple[str, str, Array]] = []
    for load in loads:
        by_mass = _UNIFORM * load.com_error_by_mass_mm(assembly)
        by_place = _UNIFORM * load.com_error_by_place_mm(assembly)
        sources += [
            (f"mass of the {load.part}", f"±{load.mass_tolerance_g:g} g", np.outer(by_mass, by_mass)),
            (
                f"centre of mass of the {load.part}",
                f"±{load.com_tolerance_mm:g} mm along each axis",
                by_place**2 * np.eye(3),
            ),
        ]
    by_assembly = _UNIFORM * 1e-3 * tolerances.com_error_um
    # The gradient at which the part stops is spread evenly over a disc of radius b: b²/4 along each axis.
    by_friction = 0.5e-3 * tolerances.rolling_resistance_um
    return [
        *sources,
        (
            "centre of mass of the assembly",
            f"±{tolerances.com_error_um:g} µm along each axis",
            by_assembly**2 * np.eye(3),
        ),
        ("rolling resistance", f"{tolerances.rolling_resistance_um:g} µm", by_friction**2 * np.eye(3)),
    ]


def _angle_contributions(rest: Rest, board: Board, tolerances: ToleranceSpec) -> list[Contribution]:
    """Errors that turn the sensor against the body, or the table against gravity."""
    level = table_tilt_covariance(rest, _UNIFORM * math.radians(tolerances.table_level_deg))
    turned = [
        ("seating of the board", tolerances.seating_deg),
        ("sensor's axes on the board", board.sensor.misalignment_deg or 0.0),
    ]
    return [
        *(
            Contribution.of(source, f"±{angle:g}°", (_UNIFORM * math.radians(angle)) ** 2 * np.eye(2))
            for source, angle in turned
        ),
        Contribution.of("table off level", f"±{tolerances.table_level_deg:g}°", level),
    ]


def _margin_notes(census: Census, com_covariance_mm2: Array) -> list[str]:
    """Warn where the first order, or the rest itself, cannot be relied on."""
    worst_mm = _LIMIT * math.sqrt(float(np.linalg.eigvalsh(com_covariance_mm2)[-1]))
    margin_mm = census.margin.s_margin_mm if census.margin else math.inf
    if worst_mm >= 0.5 * margin_mm:
        return [
            f"The centre of mass is known to ±{1e3 * worst_mm:.3g} µm (95 %), and a second rest can appear "
            f"from {1e3 * margin_mm:.3g} µm on: the cone, which is first order, is only a rough guide; weigh "
            "the board and balance the finished part."
        ]
    # A centre of mass raised by v lowers the stiffness by v.
    down = np.array(census.rest.direction)
    raised = _LIMIT * math.sqrt(float(down @ com_covariance_mm2 @ down)) / census.rest.stiffness_mm[0]
    if raised < 0.1:
        return []
    wider = 100.0 * raised / (1.0 - raised)
    return [
        f"The height of the centre of mass is uncertain too: where it is higher the rest is softer, and the "
        f"cone up to {wider:.0f} % wider."
    ]

"""What the accelerometer of a housing at rest should read, and how sure that is.

Frames: the sensor's own; the body's; and the resting frame, whose z points up and whose x is the
level direction nearest to the board's length. Every error is first a small tilt of the direction of
gravity in the body, with a 2 × 2 covariance along the rest's soft and stiff directions; the sum is
then carried into the sensor's frame. This is first order, as the rest's stiffness is.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.polynomial.legendre import leggauss
from scipy.optimize import brentq
from scipy.spatial.transform import Rotation
from scipy.special import erf

from gomboc_cad.body.sphere import Array, unit
from gomboc_cad.equilibria.records import Rest, Vector, as_vector
from gomboc_cad.products.imu_housing.boards import Board
from gomboc_cad.products.placement import RestFrame

Matrix2 = tuple[tuple[float, float], tuple[float, float]]
Matrix3 = tuple[Vector, Vector, Vector]
Quaternion = tuple[float, float, float, float]

CONFIDENCE = 0.95
HEADING_NOTE = (
    "The heading about the vertical is not fixed: gravity fixes two angles and leaves the third free, so x "
    "and y of the resting frame point where the part happens to lie, and the gyroscope or a magnetometer "
    "needs another reference for it."
)
_CONVENTIONS = (
    "v_rest = R v_sensor with R = rotation_sensor_to_rest, by rows; the same as a quaternion (w, x, y, z) "
    "in Hamilton's convention with w ≥ 0, v_rest = q v_sensor q*.",
    "Resting frame: z up, x level and nearest to the direction of the board's length.",
    "expected_specific_force_g is what an accelerometer at rest reads: +1 g upwards, the opposite of the "
    "direction of gravity.",
    "Tolerances are half-widths of a symmetric range and count as a standard deviation of half-width/√3 "
    "(JCGM 100:2008, 4.3.7); the cone holds 95 % if their sum is normally distributed.",
)
_QUADRATURE = leggauss(128)


@dataclass(frozen=True)
class Contribution:
    """What one source of error does to the direction of gravity in the sensor's frame.

    Attributes:
        source: What may be off.
        tolerance: By how much, with its unit.
        tilt_covariance_rad2: Covariance of the tilt along the soft and the stiff direction.
    """

    source: str
    tolerance: str
    tilt_covariance_rad2: Matrix2

    @classmethod
    def of(cls, source: str, tolerance: str, tilt_covariance_rad2: Array) -> Contribution:
        """A contribution from a covariance of shape (2, 2)."""
        return cls(source, tolerance, _rows2(tilt_covariance_rad2))

    @property
    def deviation_deg(self) -> tuple[float, float]:
        """Standard deviation along the soft and the stiff direction."""
        return _deviation_deg(self.tilt_covariance_rad2)

    @property
    def cone_95_deg(self) -> float:
        """Half-angle of the 95 % cone from this source alone."""
        return _cone_deg(self.tilt_covariance_rad2)


@dataclass(frozen=True)
class Calibration:
    """The reading to expect from a sensor at rest.

    Attributes:
        board: Name of the board.
        sensor: Part name of the sensor.
        sensor_position_mm: Centre of the sensor in the body's frame.
        rotation: Rows of the rotation R from the sensor's frame to the resting frame.
        quaternion: The same as (w, x, y, z), Hamilton's convention, w ≥ 0.
        specific_force_g: What the accelerometer reads, `Rᵀ (0, 0, 1)`: +1 g upwards.
        covariance_rad2: Covariance of that unit vector, in the sensor's frame.
        tilt_covariance_rad2: Covariance of the tilt along the soft and the stiff direction, all together.
        soft_direction: Direction in the sensor's frame towards which gravity tilts most easily.
        stiff_direction: Direction in which it tilts least easily.
        contributions: What each source adds.
        notes: What is and is not fixed, in sentences.
    """

    board: str
    sensor: str
    sensor_position_mm: Vector
    rotation: Matrix3
    quaternion: Quaternion
    specific_force_g: Vector
    covariance_rad2: Matrix3
    tilt_covariance_rad2: Matrix2
    soft_direction: Vector
    stiff_direction: Vector
    contributions: tuple[Contribution, ...]
    notes: tuple[str, ...]

    @property
    def gravity_direction(self) -> Vector:
        """Direction of gravity in the sensor's frame, as a unit vector."""
        x, y, z = self.specific_force_g
        return -x, -y, -z

    @property
    def cone_95_deg(self) -> float:
        """Half-angle of the cone about `specific_force_g` that holds the true direction with 95 %."""
        return _cone_deg(self.tilt_covariance_rad2)

    @property
    def deviation_deg(self) -> tuple[float, float]:
        """Standard deviation along the soft and the stiff direction."""
        return _deviation_deg(self.tilt_covariance_rad2)


def calibrate(
    rest: Rest,
    frame: RestFrame,
    board: Board,
    board_origin_mm: Array,
    contributions: Sequence[Contribution],
    notes: tuple[str, ...] = (HEADING_NOTE,),
) -> Calibration:
    """Carry a rest and its uncertainty into the frame of a board's sensor.

    Args:
        rest: The pose, whose direction points down; it need not be exactly that of the frame.
        frame: Directions of the board's length, width and component side in the body's frame.
        board: The board with its sensor.
        board_origin_mm: The board's origin in the body's frame, shape (3,).
        contributions: Independent sources of error.
        notes: Sentences for the record.
    """
    sensor_to_body = frame.matrix().T @ board.sensor.axes()
    rotation = _resting_axes(rest, frame) @ sensor_to_body
    tangent = np.array([rest.soft_direction, rest.stiff_direction]) @ sensor_to_body
    tilt = sum((np.array(item.tilt_covariance_rad2) for item in contributions), np.zeros((2, 2)))
    w, x, y, z = Rotation.from_matrix(rotation).as_quat(canonical=True, scalar_first=True).tolist()
    return Calibration(
        board=board.name,
        sensor=board.sensor.part,
        sensor_position_mm=as_vector(board_origin_mm + np.array(board.sensor.position_mm) @ frame.matrix()),
        rotation=_rows3(rotation),
        quaternion=(w, x, y, z),
        specific_force_g=as_vector(rotation[2]),
        covariance_rad2=_rows3(tangent.T @ tilt @ tangent),
        tilt_covariance_rad2=_rows2(tilt),
        soft_direction=as_vector(tangent[0]),
        stiff_direction=as_vector(tangent[1]),
        contributions=tuple(contributions),
        notes=notes,
    )


def com_tilt_covariance(rest: Rest, com_covariance_mm2: Array) -> Array:
    """Covariance of the rest's tilt for a covariance of the centre of mass in the body's frame.

    A centre of mass moved by v turns the direction that points down by `(∇²h)⁻¹ v_T`.

    Args:
        rest: The rest.
        com_covariance_mm2: Shape (3, 3).

    Returns:
        Along the soft and the stiff direction in rad², shape (2, 2).
    """
    axes = np.array([rest.soft_direction, rest.stiff_direction])
    turn = axes / np.array(rest.stiffness_mm)[:, None]
    result: Array = turn @ com_covariance_mm2 @ turn.T
    return result


def table_tilt_covariance(rest: Rest, deviation_rad: float) -> Array:
    """Covariance of the direction of gravity in the body for a table that is not level, shape (2, 2).

    On a table tilted by α the part rests where its centre of mass is over the contact point, that is
    where `|∇h| = h tan α`. The contact normal turns by `h α / k` for a stiffness k, and gravity leans
    from that normal by another α: `(1 + h/k) α` along each principal direction.
    """
    lever = 1.0 + rest.height_mm / np.array(rest.stiffness_mm)
    return np.diag((lever * deviation_rad) ** 2)


def tilt_cone_rad(covariance_rad2: Array, confidence: float = CONFIDENCE) -> float:
    """Radius that a tilt with a bivariate normal distribution about zero does not exceed.

    Solves `P(|t| ≤ r) = confidence` with `P = ∫ φ(x/σ₁)/σ₁ · erf(√(r² − x²) / (√2 σ₂)) dx` over
    `|x| ≤ r`, σ₁ ≥ σ₂ the principal deviations, by Gauss quadrature in the angle with `x = r sin θ`.

    Args:
        covariance_rad2: Shape (2, 2).
        confidence: A probability between 0 and 1.
    """
    minor, major = np.sqrt(np.maximum(np.linalg.eigvalsh(covariance_rad2), 0.0))
    if major == 0.0:
        return 0.0
    ratio = minor / major
    angle, weight = 0.5 * math.pi * _QUADRATURE[0], 0.5 * math.pi * _QUADRATURE[1]

    def missing(radius: float) -> float:
        across, along = radius * np.sin(angle), radius * np.cos(angle)
        inside = erf(along / (math.sqrt(2.0) * ratio)) if ratio > 0.0 else np.ones_like(along)
        density = np.exp(-0.5 * across**2) / math.sqrt(2.0 * math.pi)
        return float(weight @ (along * density * inside)) - confidence

    # The isotropic case has the largest radius, √(−2 ln (1 − P)) standard deviations.
    largest = math.sqrt(-2.0 * math.log1p(-confidence))
    return float(major) * float(brentq(missing, 0.0, 1.001 * largest, xtol=1e-12))


def calibration_document(calibration: Calibration) -> dict[str, Any]:
    """The JSON document of a calibration, written as `calibration.json`."""
    return {
        "board": calibration.board,
        "sensor": calibration.sensor,
        "sensor_position_mm": list(calibration.sensor_position_mm),
        "rotation_sensor_to_rest": [list(row) for row in calibration.rotation],
        "quaternion_sensor_to_rest_wxyz": list(calibration.quaternion),
        "expected_specific_force_g": list(calibration.specific_force_g),
        "gravity_direction": list(calibration.gravity_direction),
        "covariance_rad2": [list(row) for row in calibration.covariance_rad2],
        "cone_95_deg": calibration.cone_95_deg,
        "tilt": {
            "soft_direction": list(calibration.soft_direction),
            "stiff_direction": list(calibration.stiff_direction),
            "deviation_deg": list(calibration.deviation_deg),
            "covariance_rad2": [list(row) for row in calibration.tilt_covariance_rad2],
        },
        "contributions": [
            {
                "source": item.source,
                "tolerance": item.tolerance,
                "deviation_deg": list(item.deviation_deg),
                "cone_95_deg": item.cone_95_deg,
            }
            for item in calibration.contributions
        ],
        "conventions": list(_CONVENTIONS),
        "notes": list(calibration.notes),
    }


def _deviation_deg(tilt_covariance_rad2: Matrix2) -> tuple[float, float]:
    (soft, _), (_, stiff) = tilt_covariance_rad2
    return math.degrees(math.sqrt(soft)), math.degrees(math.sqrt(stiff))


def _cone_deg(tilt_covariance_rad2: Matrix2) -> float:
    return math.degrees(tilt_cone_rad(np.array(tilt_covariance_rad2)))


def _resting_axes(rest: Rest, frame: RestFrame) -> Array:
    """Rows x, y, z of the resting frame in the body's frame, shape (3, 3)."""
    up = -unit(np.array(rest.direction))
    along = np.array(frame.first)
    x = unit(along - (along @ up) * up)
    return np.array([x, np.cross(up, x), up])


def _rows2(matrix: Array) -> Matrix2:
    (a, b), (c, d) = matrix.tolist()
    return (a, b), (c, d)


def _rows3(matrix: Array) -> Matrix3:
    first, second, third = matrix
    return as_vector(first), as_vector(second), as_vector(third)

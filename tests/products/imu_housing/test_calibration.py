"""The calibration: frames are proper, the cone is the normal distribution's, the true census agrees."""

from __future__ import annotations

import json
import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad
from scipy.optimize import root
from scipy.spatial.transform import Rotation

import gomboc_cad
from gomboc_cad.body import mass_properties
from gomboc_cad.body.sphere import Array, unit
from gomboc_cad.body.support import support_jet
from gomboc_cad.equilibria import Census, Rest, find_equilibria, smooth_census
from gomboc_cad.products.imu_housing.boards import Board, board_names, load_board
from gomboc_cad.products.imu_housing.calibration import (
    Calibration,
    Contribution,
    calibrate,
    calibration_document,
    com_tilt_covariance,
    table_tilt_covariance,
    tilt_cone_rad,
)
from gomboc_cad.products.imu_housing.housing_calibration import (
    MountedBoard,
    calibrate_housing,
    calibration_documents,
)
from gomboc_cad.products.imu_housing.recipe import HousingDesign
from gomboc_cad.products.imu_housing.spec import ToleranceSpec
from gomboc_cad.products.loads import UncertainLoad
from gomboc_cad.products.placement import RestFrame
from gomboc_cad.products.verdict import judge

BODY = gomboc_cad.catalog()["primary"].with_diameter(100.0)
CENTROID = np.array(mass_properties(BODY).com_mm)
ORIGIN = np.zeros(3)

EXACT = ToleranceSpec(com_error_um=0.0, seating_deg=0.0, table_level_deg=0.0, rolling_resistance_um=0.0)

angles = st.floats(0.0, 2.0 * math.pi)


def known_to(mounted: MountedBoard, mass_g: float, com_mm: float) -> MountedBoard:
    """The same board, its mass and centre of mass known to some tolerances."""
    return replace(mounted, loads=(UncertainLoad("board", mass_g, com_mm),))


@pytest.fixture(scope="module")
def census() -> Census:
    """The primary about a centre of mass at which no direction of the rest is a coordinate axis."""
    return smooth_census(BODY, CENTROID + np.array([-0.1, 0.004, 0.03]))


@pytest.fixture(scope="module")
def housing_census(default_housing: HousingDesign) -> Census:
    """The default housing about its own centre of mass."""
    return smooth_census(default_housing.body, default_housing.assembly.com_mm)


def as_contribution(covariance: Array) -> Contribution:
    (a, b), (c, d) = covariance.tolist()
    return Contribution("test", "any", ((a, b), (c, d)))


def calibrated(rest: Rest, board: Board, covariance: Array | None = None) -> Calibration:
    contribution = as_contribution(np.zeros((2, 2)) if covariance is None else covariance)
    return calibrate(rest, RestFrame.from_rest((-1.0, 0.0, 0.0)), board, ORIGIN, [contribution])


def turned(board: Board, turn: Rotation) -> Board:
    """The same board with its sensor soldered on turned about z."""
    x, y, _ = turn.apply(board.sensor.axes().T)
    return board.model_copy(
        update={"sensor": board.sensor.model_copy(update={"x_axis": tuple(x), "y_axis": tuple(y)})}
    )


@pytest.mark.parametrize("name", board_names())
def test_the_rotation_is_proper_and_carries_the_reading_to_the_vertical(census: Census, name: str) -> None:
    result = calibrated(census.rest, load_board(name))
    rotation = np.array(result.rotation)
    assert np.allclose(rotation @ rotation.T, np.eye(3), atol=1e-14)
    assert np.linalg.det(rotation) == pytest.approx(1.0)
    assert np.allclose(rotation.T @ [0.0, 0.0, 1.0], result.specific_force_g, atol=1e-15)
    assert np.allclose(np.negative(result.gravity_direction), result.specific_force_g)
    # All these boards lie with the component side up, so the accelerometer reads almost +1 g on z.
    assert result.specific_force_g[2] > 0.99


@pytest.mark.parametrize("name", board_names())
def test_the_quaternion_is_the_same_rotation(census: Census, name: str) -> None:
    """v_rest = q v q*, multiplied out by hand."""
    result = calibrated(census.rest, load_board(name))
    w, *imaginary = result.quaternion
    q = np.array(imaginary)
    assert w >= 0.0
    assert w**2 + q @ q == pytest.approx(1.0)
    for vector in np.eye(3):
        by_quaternion = vector + 2.0 * w * np.cross(q, vector) + 2.0 * np.cross(q, np.cross(q, vector))
        assert np.allclose(by_quaternion, np.array(result.rotation) @ vector, atol=1e-14)


def test_the_vertical_is_that_of_the_census_and_not_of_the_frame(census: Census) -> None:
    """The board lies square to the nominal rest; the part rests about its true centre of mass."""
    board = load_board("adafruit-bno055")
    frame = RestFrame.from_rest((-1.0, 0.0, 0.0))
    result = calibrate(census.rest, frame, board, ORIGIN, [])
    in_body = frame.matrix().T @ board.sensor.axes() @ result.specific_force_g
    assert np.allclose(in_body, np.negative(census.rest.direction), atol=1e-14)
    lean = math.degrees(math.acos(result.specific_force_g[2]))
    assert lean == pytest.approx(math.degrees(math.acos(-census.rest.direction[0])))
    assert lean > 0.2


def test_a_sensor_turned_by_90_degrees_turns_the_result(census: Census) -> None:
    board = load_board("adafruit-lsm6ds3tr-c")
    quarter = Rotation.from_euler("z", 90.0, degrees=True)
    covariance = np.diag([4e-4, 1e-6])
    straight, across = (calibrated(census.rest, b, covariance) for b in (board, turned(board, quarter)))
    x, y, z = straight.specific_force_g
    assert across.specific_force_g == pytest.approx((y, -x, z))
    q = quarter.as_matrix()
    assert np.allclose(np.array(straight.rotation) @ q, across.rotation, atol=1e-15)
    assert np.allclose(q.T @ straight.covariance_rad2 @ q, across.covariance_rad2, atol=1e-18)
    assert across.cone_95_deg == pytest.approx(straight.cone_95_deg)


def test_the_covariance_lies_across_the_vertical(census: Census) -> None:
    covariance = np.array([[4e-4, 1e-5], [1e-5, 1e-6]])
    result = calibrated(census.rest, load_board("adafruit-mpu6050"), covariance)
    in_sensor = np.array(result.covariance_rad2)
    assert np.allclose(in_sensor @ result.specific_force_g, 0.0, atol=1e-18)
    assert np.trace(in_sensor) == pytest.approx(np.trace(covariance))
    assert np.linalg.eigvalsh(in_sensor)[1:] == pytest.approx(np.linalg.eigvalsh(covariance))


def test_the_true_census_agrees_with_the_covariance_and_the_cone(census: Census) -> None:
    """Monte Carlo: the centre of mass and the seating drawn at random, every rest found anew."""
    board, frame = load_board("adafruit-mpu6050"), RestFrame.from_rest((-1.0, 0.0, 0.0))
    com_deviation_mm, seating_rad = 1.5e-3, math.radians(0.15)
    covariance = com_tilt_covariance(census.rest, com_deviation_mm**2 * np.eye(3))
    result = calibrate(
        census.rest, frame, board, ORIGIN, [as_contribution(covariance + seating_rad**2 * np.eye(2))]
    )
    axes = frame.matrix().T @ board.sensor.axes()
    generator = np.random.default_rng(20)
    readings = []
    for _ in range(400):
        moved = census.com_mm + com_deviation_mm * generator.standard_normal(3)
        up = np.negative(find_equilibria(BODY, moved)[0].direction)
        seating = Rotation.from_rotvec(seating_rad * generator.standard_normal(3))
        readings.append(up @ seating.as_matrix() @ axes)
    off_deg = np.degrees(np.arccos(np.clip(readings @ np.array(result.specific_force_g), -1.0, 1.0)))
    # 95 % of 400 with three standard errors of the binomial distribution.
    assert np.mean(off_deg <= result.cone_95_deg) == pytest.approx(0.95, abs=3.0 * math.sqrt(0.0475 / 400))
    found = np.cov(np.array(readings).T)
    # A sample variance of 400 has a standard error of 7 %.
    assert np.abs(found - result.covariance_rad2).max() < 0.25 * np.abs(result.covariance_rad2).max()
    assert np.trace(found) == pytest.approx(np.trace(result.covariance_rad2), rel=0.2)


@pytest.mark.parametrize("axis", [0, 1])
def test_a_table_off_level_tilts_the_part_by_more_than_itself(axis: int) -> None:
    """Solve for the pose on an inclined plane: the centre of mass over the contact, |∇h| = h tan α."""
    rest = smooth_census(BODY, CENTROID, margins=False).rest
    slope = math.radians(0.002)
    tangents = np.array([rest.soft_direction, rest.stiff_direction])

    def unbalanced(lean: Array) -> Array:
        jet = support_jet(BODY, unit(np.array(rest.direction) + lean @ tangents)[None], CENTROID)
        wanted = jet.height_mm[0] * math.tan(slope) * tangents[axis]
        balance: Array = tangents @ (jet.gradient_mm[0] - wanted)
        return balance

    lean = root(unbalanced, np.zeros(2), tol=1e-12).x
    jet = support_jet(BODY, unit(np.array(rest.direction) + lean @ tangents)[None], CENTROID)
    normal = unit(np.array(rest.direction) + lean @ tangents)
    gravity = unit(jet.height_mm[0] * normal + jet.gradient_mm[0])
    predicted = math.sqrt(table_tilt_covariance(rest, slope)[axis, axis])
    assert gravity @ tangents[axis] == pytest.approx(predicted, rel=0.02)
    # The soft direction multiplies the error of the table by almost 300, the stiff one leaves it.
    assert predicted / slope == pytest.approx([288.0, 1.09][axis], rel=0.01)


def test_a_stiff_rest_only_feels_the_table() -> None:
    """On a facet nothing turns for a small error of the centre of mass; a sloping table still leans."""
    facet = Rest((0.0, 0.0, -1.0), 10.0, (math.inf, math.inf), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0))
    assert not com_tilt_covariance(facet, np.eye(3)).any()
    assert np.array_equal(table_tilt_covariance(facet, 0.1), np.diag([0.1**2, 0.1**2]))


@given(st.floats(1e-9, 1e3), angles)
def test_the_isotropic_cone_is_the_rayleigh_quantile(deviation: float, angle: float) -> None:
    """Closed form: P(|t| ≤ r) = 1 − exp(−r²/2σ²)."""
    c, s = math.cos(angle), math.sin(angle)
    turn = np.array([[c, -s], [s, c]])
    covariance = deviation**2 * turn @ turn.T
    assert tilt_cone_rad(covariance) == pytest.approx(deviation * math.sqrt(-2.0 * math.log(0.05)), rel=1e-6)


@given(st.floats(1e-9, 1e3), angles)
def test_a_degenerate_cone_is_the_two_sided_normal_quantile(deviation: float, angle: float) -> None:
    """Closed form: 1.959964 σ."""
    along = np.array([math.cos(angle), math.sin(angle)])
    cone = tilt_cone_rad(deviation**2 * np.outer(along, along))
    assert cone == pytest.approx(1.9599639845 * deviation, rel=1e-6)


@given(st.floats(0.01, 1.0), angles)
def test_the_cone_holds_its_probability(ratio: float, angle: float) -> None:
    """Against the integral in polar coordinates, which has no inner error function."""
    c, s = math.cos(angle), math.sin(angle)
    turn = np.array([[c, -s], [s, c]])
    radius = tilt_cone_rad(turn @ np.diag([1.0, ratio**2]) @ turn.T)

    def along(polar: float) -> float:
        inverse_square = math.cos(polar) ** 2 + (math.sin(polar) / ratio) ** 2
        return -math.expm1(-0.5 * radius**2 * inverse_square) / inverse_square

    inside = 4.0 * quad(along, 0.0, 0.5 * math.pi, points=[0.0, ratio], limit=200)[0]
    assert inside / (2.0 * math.pi * ratio) == pytest.approx(0.95, abs=1e-5)


def test_no_tolerances_give_no_covariance(default_housing: HousingDesign, housing_census: Census) -> None:
    exact = known_to(default_housing.mounted, mass_g=0.0, com_mm=0.0)
    result = calibrate_housing(default_housing.assembly, exact, housing_census, EXACT)
    assert not np.array(result.covariance_rad2).any()
    assert result.cone_95_deg == 0.0
    assert "Taken as exact" in result.notes[-1]


def test_the_housing_adds_its_sources_by_square(
    default_housing: HousingDesign, housing_census: Census
) -> None:
    setup = ToleranceSpec(com_error_um=2.0, seating_deg=0.2, table_level_deg=0.001, rolling_resistance_um=1.0)
    result = calibrate_housing(default_housing.assembly, default_housing.mounted, housing_census, setup)
    by_source = {item.source: item for item in result.contributions}
    soft = math.radians(housing_census.rest.tilt_deg_per_um[0])
    com, _ = by_source["centre of mass of the assembly"].deviation_deg
    assert math.radians(com) == pytest.approx(2.0 / math.sqrt(3.0) * soft)
    seating = by_source["seating of the board"]
    assert seating.deviation_deg == pytest.approx((0.2 / math.sqrt(3.0),) * 2)
    assert seating.cone_95_deg == pytest.approx(0.2 / math.sqrt(3.0) * math.sqrt(-2.0 * math.log(0.05)))
    rolling, _ = by_source["rolling resistance"].deviation_deg
    assert math.radians(rolling) == pytest.approx(0.5 * soft)
    share = default_housing.mounted.board.mass_g / default_housing.assembly.mass_g
    board, _ = by_source["centre of mass of the board"].deviation_deg
    assert math.radians(board) == pytest.approx(share * 500.0 / math.sqrt(3.0) * soft)
    squares = sum(item.deviation_deg[0] ** 2 for item in result.contributions)
    assert result.deviation_deg[0] ** 2 == pytest.approx(squares)
    # The board lies below the centre of mass, so its mass moves that up and down and tilts little.
    mass, _ = by_source["mass of the board"].deviation_deg
    assert mass < 0.05 * board


def test_the_document_is_json_with_units_and_an_honest_sentence(
    default_housing: HousingDesign, housing_census: Census
) -> None:
    setup = ToleranceSpec(com_error_um=1.0, seating_deg=0.1)
    document = json.loads(
        json.dumps(
            calibration_document(
                calibrate_housing(default_housing.assembly, default_housing.mounted, housing_census, setup)
            )
        )
    )
    assert document["sensor"] == "Bosch Sensortec BNO055"
    # The centre of mass is within 0.1 µm of its target, which tilts the soft direction by 0.013°.
    assert document["expected_specific_force_g"] == pytest.approx([0.0, 0.0, 1.0], abs=3e-4)
    assert np.allclose(document["rotation_sensor_to_rest"], np.eye(3), atol=3e-4)
    assert document["cone_95_deg"] >= max(item["cone_95_deg"] for item in document["contributions"])
    assert any("heading about the vertical is not fixed" in note for note in document["notes"])
    assert any("+1 g upwards" in sentence for sentence in document["conventions"])


def test_a_centre_of_mass_too_uncertain_for_its_margin_is_said(default_housing: HousingDesign) -> None:
    """About the centroid, where the rest is softest and the margin smallest."""
    census = smooth_census(BODY, CENTROID)

    def notes(mounted: MountedBoard) -> tuple[str, ...]:
        return calibrate_housing(default_housing.assembly, mounted, census, EXACT).notes

    careful = notes(known_to(default_housing.mounted, mass_g=0.02, com_mm=0.1))
    # As it comes, the board's mass is an estimate, and half a gram far below the middle is too much.
    careless = notes(default_housing.mounted)
    assert not any("second rest" in note or "wider" in note for note in careful)
    # At a fifth of a gram the rest is single, but softer or stiffer than the first order says.
    between = notes(known_to(default_housing.mounted, mass_g=0.2, com_mm=0.5))
    assert any("% wider" in note for note in between)
    assert any("second rest can appear" in note for note in careless)


def test_the_sensor_is_where_the_housing_has_it(
    default_housing: HousingDesign, housing_census: Census
) -> None:
    """Its place is over the board's laminate in the assembly, half a package above it."""
    result = calibrate_housing(default_housing.assembly, default_housing.mounted, housing_census)
    laminate = next(part for part in default_housing.assembly.parts if part.name == "board").solid
    frame, board = default_housing.frame, default_housing.mounted.board
    along, across, height = frame.matrix() @ result.sensor_position_mm
    corner = frame.matrix() @ np.array([*laminate.bounding_box().min])
    assert height - corner[2] == pytest.approx(board.sensor.position_mm[2], abs=1e-6)
    first, second, _ = frame.matrix() @ default_housing.mounted.origin_mm
    assert (along - first, across - second) == pytest.approx(board.sensor.position_mm[:2])


def test_only_a_single_rest_is_calibrated(default_housing: HousingDesign) -> None:
    """About a centre of mass raised by 0.6 mm the primary has more rests than one."""
    assembly, mounted = default_housing.assembly, default_housing.mounted
    verdict = judge(BODY, (CENTROID[0] + 0.6, 0.0, 0.0))
    assert verdict.census is not None
    assert verdict.census.stable > 1
    assert calibration_documents(assembly, mounted, ToleranceSpec(), verdict) == {}
    good = default_housing.documents(judge(BODY, assembly.com_mm))
    assert set(good) == {"calibration.json"}
    assert good["calibration.json"]["cone_95_deg"] > 0.0


def test_every_uncertain_part_is_a_source_of_its_own(
    default_housing: HousingDesign, housing_census: Census
) -> None:
    """A second load adds its square to the first; both are named."""
    one = UncertainLoad("board", 0.0, 0.3)
    other = UncertainLoad("screw-1", 0.0, 0.4)

    def deviation(*loads: UncertainLoad) -> float:
        mounted = replace(default_housing.mounted, loads=loads)
        return calibrate_housing(default_housing.assembly, mounted, housing_census, EXACT).deviation_deg[0]

    # The sensor's own misalignment is not given for this board, so nothing else counts.
    assert deviation() == 0.0
    assert deviation(one, other) == pytest.approx(math.hypot(deviation(one), deviation(other)))
    masses = {part.name: part.mass_g for part in default_housing.assembly.parts}
    assert deviation(other) / deviation(one) == pytest.approx(
        0.4 * masses["screw-1"] / (0.3 * masses["board"])
    )

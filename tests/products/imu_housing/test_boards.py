"""Boards: what their makers publish is in the files, and each fits the default housing."""

from __future__ import annotations

import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from gomboc_cad.errors import SpecError
from gomboc_cad.products.build_document import uncertainty_sentence
from gomboc_cad.products.imu_housing.boards import Board, board_names, load_board
from gomboc_cad.products.imu_housing.layout import HousingContents, lay_out
from gomboc_cad.products.imu_housing.spec import ImuHousingSpec
from gomboc_cad.products.placing.com_placement import com_target
from gomboc_cad.products.recipes import design_product
from gomboc_cad.products.spec import load_spec
from gomboc_cad.products.toml_model import parse_model
from gomboc_cad.products.verdict import judge
from gomboc_cad.resources import template_folder

Template = Callable[..., Path]
Change = Callable[[dict[str, Any]], None]

# Hole pitch along x and y in mm, from the dimension lines in the makers' board files (inches there).
HOLE_PITCH = {
    "adafruit-bno055": (0.8, 0.6),
    "adafruit-icm20948": (0.8, 0.5),
    "adafruit-lsm6ds3tr-c": (0.8, 0.5),
    "adafruit-mpu6050": (0.8, 0.5),
    "sparkfun-icm20948": (0.8, 0.8),
}


def board_data(name: str) -> dict[str, Any]:
    path = template_folder() / "boards" / f"{name}.toml"
    return tomllib.loads(path.read_text(encoding="utf-8"))


def spec_for(name: str) -> ImuHousingSpec:
    return ImuHousingSpec.model_validate(
        {"product": "imu-housing", "body": {"name": "primary"}, "board": {"type": name}, "mark": {"text": ""}}
    )


def test_every_board_has_a_published_hole_pitch_to_check_against() -> None:
    assert set(board_names()) == set(HOLE_PITCH)


@pytest.mark.parametrize("name", board_names())
def test_a_board_says_what_is_published_and_what_is_estimated(name: str) -> None:
    board = load_board(name)
    places = np.array([(hole.x_mm, hole.y_mm) for hole in board.holes])
    assert np.ptp(places, axis=0) / 25.4 == pytest.approx(HOLE_PITCH[name])
    # The pattern is centred on the outline, so no corner was taken for another.
    assert places.mean(axis=0) == pytest.approx((0.5 * board.length_mm, 0.5 * board.width_mm))
    assert "board file" in board.source
    assert board.mass_source.startswith("estimate")
    assert board.mass_tolerance_g >= 0.2 * board.mass_g
    # A laminate alone weighs less than the board, and parts do not weigh more than the laminate.
    laminate = 1.85e-3 * board.length_mm * board.width_mm * board.thickness_mm
    assert 0.9 * laminate < board.mass_g < 2.0 * laminate


@pytest.mark.parametrize("name", board_names())
def test_a_sensor_lies_on_the_component_side_with_z_out_of_it(name: str) -> None:
    board = load_board(name)
    axes = board.sensor.axes()
    assert np.allclose(axes.T @ axes, np.eye(3), atol=1e-15)
    assert np.linalg.det(axes) == pytest.approx(1.0)
    assert np.allclose(axes[:, 2], [0.0, 0.0, 1.0])
    x, y, z = board.sensor.position_mm
    assert (x, y) == pytest.approx((0.5 * board.length_mm, 0.5 * board.width_mm), abs=1.5)
    assert board.thickness_mm < z < board.thickness_mm + 1.0


def test_the_same_chip_at_the_same_turn_has_the_same_axes_on_two_boards() -> None:
    """Both makers turn the ICM-20948 by 180° in their board files."""
    adafruit, sparkfun = load_board("adafruit-icm20948"), load_board("sparkfun-icm20948")
    assert adafruit.sensor.part == sparkfun.sensor.part
    assert np.array_equal(adafruit.sensor.axes(), sparkfun.sensor.axes())


@pytest.mark.parametrize("name", board_names())
def test_a_board_fits_the_default_housing(name: str) -> None:
    spec = spec_for(name)
    body = spec.body.body()
    layout = lay_out(spec, body, com_target("best", body), HousingContents.of(spec), least_wall_mm=1.2)
    assert len(layout.hole_places_mm) == 4


def test_axes_may_have_any_length_and_are_made_right_handed() -> None:
    data = board_data("adafruit-bno055")
    data["sensor"] |= {"x_axis": [0.0, 0.0, 2.0], "y_axis": [3.0, 3.0, 0.0]}
    axes = parse_model(Board, data, "board").sensor.axes()
    half = np.sqrt(0.5)
    assert np.allclose(axes.T, [[0.0, 0.0, 1.0], [half, half, 0.0], [-half, half, 0.0]])


def test_files_of_earlier_versions_stay_valid() -> None:
    data = board_data("adafruit-mpu6050")
    del data["com_tolerance_mm"]
    del data["sensor"]["misalignment_deg"], data["sensor"]["misalignment_source"]
    board = parse_model(Board, data, "board")
    assert board.com_tolerance_mm == 0.0
    assert board.sensor.misalignment_deg is None


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda d: d["sensor"].update(y_axis=[1.0, 1.0, 0.0]), "not square to each other"),
        (lambda d: d["sensor"].update(x_axis=[0.0, 0.0, 0.0]), "must not be zero"),
        (lambda d: d["sensor"].update(position_mm=[30.0, 5.0, 2.0]), r"sensor.position_mm = \(30, 5, 2\)"),
        (lambda d: d["sensor"].update(position_mm=[5.0, 5.0, -9.0]), r"sensor.position_mm = \(5, 5, -9\)"),
        (lambda d: d["sensor"].update(misalignment_deg=1.0), "go together"),
        (lambda d: d.update(com_tolerance_mm=-1.0), "com_tolerance_mm = -1.0 is not allowed"),
        (lambda d: d.update(com_mm=[-1.0, 5.0, 1.0]), r"com_mm = \(-1, 5, 1\)"),
    ],
)
def test_impossible_sensors_are_refused(change: Change, said: str) -> None:
    data = board_data("adafruit-lsm6ds3tr-c")
    change(data)
    with pytest.raises(SpecError, match=said):
        parse_model(Board, data, "board")


@pytest.mark.slow
def test_a_mass_error_beyond_the_margin_is_said_in_the_reasons(template_with: Template) -> None:
    """The SparkFun board's estimated mass may move the COM by more than a light 60 mm housing allows."""
    path = template_with(
        ('type = "adafruit-bno055"', 'type = "sparkfun-icm20948"'),
        ("diameter_mm = 100.0", "diameter_mm = 60.0"),
        ("wall_mm = 3.0 ", "wall_mm = 2.0 "),
    )
    design = design_product(load_spec(str(path)))
    verdict = judge(design.body, design.assembly.com_mm)
    assert verdict.passed
    said = [uncertainty_sentence(item, verdict) for item in design.uncertainties]
    assert any("beyond the S-margin" in sentence and "weigh it" in sentence for sentence in said)
    notes = design.documents(verdict)["calibration.json"]["notes"]
    assert "heading" in " ".join(notes).lower()

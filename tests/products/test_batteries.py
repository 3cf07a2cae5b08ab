"""Batteries: what comes with the package is complete, and a wrong file is told in one sentence."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from gomboc_cad.errors import SpecError
from gomboc_cad.products.batteries import Battery, battery_names, load_battery
from gomboc_cad.products.placement import RestFrame
from gomboc_cad.resources import template_folder

FRAME = RestFrame.from_rest((-1.0, 0.0, 0.0))


@pytest.mark.parametrize("name", battery_names())
def test_a_battery_stands_on_its_seat(name: str) -> None:
    battery = load_battery(name)
    box = battery.solid(FRAME, np.array([3.0, 4.0, 5.0])).bounding_box()
    # `up` is x here: the underside is on the seat, and the middle is over it.
    assert pytest.approx(3.0, abs=1e-5) == box.min.X
    assert pytest.approx(3.0 + battery.height_mm, abs=1e-5) == box.max.X
    assert pytest.approx((4.0, 5.0), abs=1e-5) == (box.center().Y, box.center().Z)
    across = math.hypot(box.size.Y, box.size.Z) if battery.shape == "box" else box.size.Y
    assert 2.0 * battery.outline_radius_mm == pytest.approx(across, abs=1e-4)


@pytest.mark.parametrize("name", battery_names())
def test_a_battery_is_as_dense_as_its_chemistry(name: str) -> None:
    """Between a lithium pouch (1.7 g/cm³) and an alkaline or lead cell (below 3.2 g/cm³)."""
    battery = load_battery(name)
    density = battery.mass_g / battery.solid(FRAME, np.zeros(3)).volume * 1e3
    assert 1.7 < density < 3.2
    assert battery.mass_tolerance_g > 0.0


def test_an_18650_is_one() -> None:
    """18 mm in diameter and 65.0 mm long give the cell its name (IEC 61960-3)."""
    diameter, length = load_battery("18650").size_mm
    assert 18.0 <= diameter < 18.7
    assert 65.0 <= length < 65.5


def test_a_users_own_battery_is_found_beside_the_spec(tmp_path: Path) -> None:
    text = (template_folder() / "batteries" / "21700.toml").read_text(encoding="utf-8")
    (tmp_path / "mine.toml").write_text(text.replace("mass_g = 70.5", "mass_g = 69.0"), encoding="utf-8")
    assert load_battery("mine.toml", tmp_path).mass_g == 69.0


def test_an_unknown_battery_is_told_with_the_known_ones() -> None:
    with pytest.raises(SpecError, match=r"no battery 'aaa'.*18650.*sla-12v-7ah"):
        load_battery("aaa")


@pytest.mark.parametrize(
    ("shape", "size", "meaning"),
    [("cylinder", (1.0, 2.0, 3.0), "diameter and length"), ("box", (1.0, 2.0), "length, width and height")],
)
def test_the_number_of_sizes_belongs_to_the_shape(shape: str, size: tuple[float, ...], meaning: str) -> None:
    with pytest.raises(ValueError, match=meaning):
        Battery.model_validate(
            {
                "name": "x",
                "shape": shape,
                "size_mm": size,
                "mass_g": 1.0,
                "mass_tolerance_g": 0.1,
                "source": "x",
                "mass_source": "x",
            }
        )

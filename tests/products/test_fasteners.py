"""Bought fasteners have the sizes of their standards."""

from __future__ import annotations

import math

import pytest

from gomboc_cad.errors import SpecError
from gomboc_cad.products.fasteners import (
    dowel_pin,
    heat_set_insert,
    screw,
    screw_lengths_mm,
    thread_of,
)


def test_a_socket_head_screw_has_the_sizes_of_its_standards() -> None:
    """ISO 4762: M3 has a knurled head of 5.68 mm, 3 mm high; ISO 273 medium: 3.4 mm; core hole 2.5 mm."""
    m3 = screw("M3-0.5", 10.0, "iso4762")
    assert (m3.head_diameter_mm, m3.head_height_mm, m3.thread_mm) == (5.68, 3.0, 3.0)
    assert (m3.clearance_mm, m3.tap_drill_mm) == (3.4, 2.5)
    assert m3.counterbore_mm == pytest.approx(6.08)
    assert m3.standard == "ISO4762 M3-0.5 x 10"
    box = m3.solid.bounding_box()
    assert (pytest.approx(-10.0, abs=1e-6), pytest.approx(3.0, abs=1e-6)) == (box.min.Z, box.max.Z)


def test_an_insert_ends_at_its_top() -> None:
    insert = heat_set_insert("M3-0.5-4", "CNCKitchen")
    box = insert.solid.bounding_box()
    assert (pytest.approx(-4.0, abs=1e-6), pytest.approx(0.0, abs=1e-6)) == (box.min.Z, box.max.Z)
    assert insert.hole_depth_mm == 5.0
    assert 3.0 < insert.hole_diameter_mm < 5.0


def test_standard_lengths_rise() -> None:
    lengths = screw_lengths_mm("M3-0.5", "iso4762")
    assert lengths == tuple(sorted(lengths))
    assert {6.0, 8.0, 10.0, 12.0, 16.0} <= set(lengths)


def test_a_pin_is_a_cylinder_about_its_middle() -> None:
    pin = dowel_pin(3.0, 12.0)
    assert pin.volume == pytest.approx(math.pi * 1.5**2 * 12.0)
    assert pytest.approx(-6.0) == pin.bounding_box().min.Z


def test_the_thread_of_a_size() -> None:
    assert [thread_of(size) for size in ("M3-0.5", "M2.5-0.45-4", "M10-1.5-12.7")] == [3.0, 2.5, 10.0]
    with pytest.raises(SpecError, match="no metric thread"):
        thread_of("1/4-20")


@pytest.mark.parametrize(
    ("made", "said"),
    [
        (lambda: heat_set_insert("M3-0.5-4", "Nobody"), "no maker 'Nobody'.*choose one of.*CNCKitchen"),
        (lambda: heat_set_insert("M9", "CNCKitchen"), "'M9' is not made by CNCKitchen; choose one of"),
        (lambda: screw("M3-0.5", 10.0, "iso1"), "standard 'iso1'; choose one of.*iso4762"),
        (lambda: screw("M99", 10.0, "iso4762"), "no thread 'M99' in iso4762; choose one of"),
        (lambda: screw("M3-0.5", 10.5, "iso4762"), "no standard length 10.5 mm; choose one of.*10, 12"),
    ],
)
def test_what_is_not_in_the_tables_is_said(made: object, said: str) -> None:
    assert callable(made)
    with pytest.raises(SpecError, match=said):
        made()

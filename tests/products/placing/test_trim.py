"""Trim masses: standard sizes, masses, solids and holes."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from gomboc_cad.errors import SpecError
from gomboc_cad.products.common_spec import TrimSpec
from gomboc_cad.products.placing.com_placement import ComPlacement, place_com
from gomboc_cad.products.placing.trim import TrimSite, ball, set_screw, trim_items, trim_parts
from gomboc_cad.solid.mass import solid_mass

STEEL_G_MM3 = 7.85e-3
SLOPING = TrimSite("slope", (20.0, 3.0, 5.0), (0.6, 0.0, -0.8), 20.0, 8.0)


@pytest.mark.parametrize(
    ("diameter", "per_kg"), [(2.0, 30500), (3.0, 9030), (5.0, 1950), (10.0, 244), (12.0, 141), (25.0, 15.6)]
)
def test_balls_weigh_what_a_maker_says(diameter: float, per_kg: float) -> None:
    """Pieces per kilogram in the precision ball tables of Technoball (Italy)."""
    assert 1e3 / (STEEL_G_MM3 * ball(diameter).volume_mm3) == pytest.approx(per_kg, rel=0.01)


@pytest.mark.parametrize(
    ("size", "length", "kg_per_1000"),
    [
        ("M1.6-0.35", 3.0, 0.029),
        ("M2-0.4", 3.0, 0.044),
        ("M2.5-0.45", 4.0, 0.1),
        ("M3-0.5", 3.0, 0.1),
        ("M3-0.5", 4.0, 0.14),
        ("M4-0.7", 4.0, 0.22),
    ],
)
def test_set_screws_weigh_what_the_standard_says(size: str, length: float, kg_per_1000: float) -> None:
    """Approximate masses of DIN EN ISO 4026; with the nominal diameter M3 x 4 would be off by a third."""
    assert STEEL_G_MM3 * set_screw(size, length).volume_mm3 == pytest.approx(kg_per_1000, rel=0.12)


@pytest.mark.parametrize("item", [ball(6.0), set_screw("M5-0.8", 10.0)])
def test_the_solid_is_what_was_reckoned_with(item) -> None:
    mass = solid_mass(item.solid())
    assert mass.volume_mm3 == pytest.approx(item.volume_mm3, rel=1e-6)
    np.testing.assert_allclose(mass.com_mm, (0.0, 0.0, item.com_below_middle_mm), atol=1e-6)


def test_only_what_fits_a_site_is_offered() -> None:
    shallow = TrimSite("shallow", (0.0, 0.0, 0.0), (0.0, 0.0, -1.0), 6.0, 9.0)
    balls = trim_items(TrimSpec(kind="balls", max_diameter_mm=7.0), shallow)
    assert max(item.diameter_mm for item in balls) == 6.0
    screws = trim_items(TrimSpec(kind="set-screws", max_diameter_mm=4.0), shallow)
    assert screws[-1].standard == "ISO 4026 M4 x 6"
    assert max(item.length_mm for item in screws) == 6.0
    assert trim_items(TrimSpec(kind="pockets"), shallow) == ()


def test_set_screws_are_graded_by_volume() -> None:
    """Steps of about a fifth from the smallest to the largest that fits, of each the shortest screw."""
    screws = trim_items(
        TrimSpec(kind="set-screws", max_diameter_mm=10.0), replace(SLOPING, max_diameter_mm=10.0)
    )
    steps = np.diff(np.log([item.volume_mm3 for item in screws]))
    assert steps.min() > 0.0
    assert steps.max() < 3.0 * np.log(1.2)
    assert screws[-1].standard == "ISO 4026 M10 x 20"
    assert not any(item.standard == "ISO 4026 M3 x 20" for item in screws)


def test_a_screw_that_the_standard_does_not_have() -> None:
    with pytest.raises(SpecError, match=r"no set screw M5-0\.8 x 7"):
        set_screw("M5-0.8", 7.0)


def sloping(kind: str) -> ComPlacement:
    """A target that lies where a mass in the sloping hole takes the COM."""
    sign = -1.0 if kind == "pockets" else 1.0
    com = -sign * 0.004 * (np.array(SLOPING.base_mm) + 9.0 * SLOPING.direction)
    free = TrimSpec(kind=kind, max_diameter_mm=8.0)
    sites = [SLOPING, *(fan(i) for i in range(3))]
    return place_com((200.0, tuple(com)), (0.0, 0.0, 0.0), None, sites, free, 1.2)


def fan(index: int) -> TrimSite:
    """Sites along three axes, so that every direction can be had."""
    axis = np.eye(3)[index]
    return TrimSite(f"fan-{index}", tuple(-10.0 * axis), tuple(axis), 20.0, 8.0)


@pytest.mark.parametrize("kind", ["balls", "set-screws"])
def test_the_parts_are_where_the_placement_says(kind: str) -> None:
    placement = sloping(kind)
    parts = trim_parts(placement.trims)
    assert len(parts) == len(placement.trims) > 0
    for part, trim in zip(parts, placement.trims, strict=True):
        assert part.mass_g == pytest.approx(trim.mass_g, rel=1e-6)
        np.testing.assert_allclose(part.com_mm, trim.position_mm, atol=1e-6)
        assert not part.made
        assert part.standard == trim.standard


@pytest.mark.parametrize("kind", ["balls", "set-screws", "pockets"])
def test_holes_take_in_what_is_put_in_them(kind: str) -> None:
    placement = sloping(kind)
    for trim in (*placement.trims, *placement.pockets):
        hole = trim.hole
        assert hole.radius_mm <= 0.5 * trim.site.max_diameter_mm
        assert hole.length_mm <= trim.site.length_mm + 1e-9
        assert trim.depth_mm >= -1e-9
        assert trim.depth_mm + trim.length_mm <= hole.length_mm + 1e-9
        along = np.subtract(trim.middle_mm, hole.base_mm) @ trim.site.direction
        assert along == pytest.approx(trim.depth_mm + 0.5 * trim.length_mm)
        assert math.hypot(*np.subtract(trim.middle_mm, hole.base_mm)) == pytest.approx(along)

"""O-rings: published sizes, and grooves that squeeze and hold them."""

from __future__ import annotations

import math

import pytest

from gomboc_cad.errors import GeometryError, SpecError
from gomboc_cad.products.buoy.o_rings import face_seal, largest_face_seal, load_series

CROSS_SECTIONS = (1.78, 2.62, 3.53, 5.33, 6.99)

# Dash numbers and inside diameters in inches from AS 568, whose size codes ISO 3601-1 shares.
PUBLISHED = {
    (1.78, 50): 5.239,
    (2.62, 178): 9.737,
    (3.53, 259): 6.234,
    (3.53, 274): 9.984,
    (3.53, 284): 17.955,
    (5.33, 349): 4.475,
    (5.33, 377): 9.975,
    (5.33, 395): 25.940,
    (6.99, 441): 6.975,
    (6.99, 453): 11.975,
    (6.99, 475): 25.940,
}


@pytest.mark.parametrize(("ring", "inches"), PUBLISHED.items())
def test_size_codes_have_their_published_inside_diameters(ring: tuple[float, int], inches: float) -> None:
    series = load_series(ring[0])
    assert series.inside_diameters_mm[ring[1] - series.first_code] == pytest.approx(25.4 * inches, abs=0.0051)


@pytest.mark.parametrize("cross_section", CROSS_SECTIONS)
def test_a_groove_squeezes_its_ring_and_has_room_for_it(cross_section: float) -> None:
    """Static face seals: squeeze 15 to 30 %, groove filled to 60 to 90 % (Parker O-Ring Handbook, ch. 4)."""
    series = load_series(cross_section)
    assert list(series.inside_diameters_mm) == sorted(set(series.inside_diameters_mm))
    seal = face_seal(cross_section, series.inside_diameters_mm[0], 1000.0)
    assert 0.15 <= seal.squeeze <= 0.30
    fill = 0.25 * math.pi * cross_section**2 / (series.groove_depth_mm * series.groove_width_mm)
    assert 0.60 <= fill <= 0.90
    inside = seal.squeezed_solid().bounding_box()
    assert seal.outer_radius_mm > 0.5 * inside.size.X


@pytest.mark.parametrize("cross_section", CROSS_SECTIONS)
def test_the_squeezed_ring_keeps_its_volume(cross_section: float) -> None:
    """Volume of a torus, 2 π² R r²."""
    seal = face_seal(cross_section, 120.32, 1000.0)
    r = 0.5 * cross_section
    torus = 2.0 * math.pi**2 * (60.16 + r) * r**2
    assert seal.squeezed_solid().volume == pytest.approx(torus, rel=1e-9)


def test_the_largest_ring_is_taken_and_the_next_would_not_fit() -> None:
    seal = largest_face_seal(5.33, 135.0, 60.0)
    series = load_series(5.33)
    following = series.inside_diameters_mm[series.inside_diameters_mm.index(seal.inside_diameter_mm) + 1]
    assert seal.outer_radius_mm <= 135.0 < 0.5 * following + series.groove_width_mm
    assert seal.standard == "O-ring ISO 3601-1 377A 253.37 x 5.33"


def test_beyond_the_standard_a_ring_is_made_from_cord() -> None:
    seal = largest_face_seal(3.53, 470.0, 280.0)
    assert seal.standard == "O-ring from vulcanised cord 930 x 3.53"
    assert seal.outer_radius_mm <= 470.0


def test_a_ring_that_does_not_fit_is_refused() -> None:
    with pytest.raises(GeometryError, match=r"reaches 134.* mm .* room up to 130"):
        face_seal(5.33, 253.37, 130.0)


def test_a_thickness_that_is_none_of_the_standard_is_told_with_the_others() -> None:
    with pytest.raises(SpecError, match=r"flange.cross_section_mm = 4 .*1.78, 2.62, 3.53, 5.33, 6.99"):
        load_series(4.0)

"""Room inside a product: clearances against closed forms."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gomboc_cad.body import catalog, depth_mm
from gomboc_cad.products.envelope import Envelope, rectangle_mm
from gomboc_cad.products.placement import RestFrame
from gomboc_cad.solid.hollow import Cylinder

FRAME = RestFrame.from_rest((-1.0, 0.0, 0.0))
BLOCK = Envelope("a block", rectangle_mm((0.0, 0.0), 20.0, 10.0), -3.0, 4.0)

places = st.floats(-40.0, 40.0)


def upright(
    first: float, second: float, low: float, high: float, radius: float, bore: float = 0.0
) -> Cylinder:
    x, y, z = FRAME.point(first, second, low)
    return Cylinder((x, y, z), FRAME.up, radius, high - low, bore)


@given(places, places)
def test_the_gap_beside_is_that_of_a_rectangle_and_a_circle(first: float, second: float) -> None:
    beside = math.hypot(max(abs(first) - 10.0, 0.0), max(abs(second) - 5.0, 0.0))
    gap = BLOCK.gap_to_column_mm(FRAME, upright(first, second, -50.0, 50.0, 3.0))
    assert gap == pytest.approx(beside - 3.0, abs=1e-9)


@given(st.floats(4.0, 30.0))
def test_the_gap_to_a_column_above_is_the_vertical_one(low: float) -> None:
    assert BLOCK.gap_to_column_mm(FRAME, upright(0.0, 0.0, low, 60.0, 3.0)) == pytest.approx(low - 4.0)


def test_a_column_that_points_down_is_the_same_column() -> None:
    up = upright(0.0, 0.0, 6.0, 30.0, 3.0)
    x, y, z = FRAME.point(0.0, 0.0, 30.0)
    down = Cylinder((x, y, z), tuple(np.negative(FRAME.up)), 3.0, 24.0)
    assert BLOCK.gap_to_column_mm(FRAME, down) == pytest.approx(BLOCK.gap_to_column_mm(FRAME, up))


def test_a_block_may_pass_through_a_ring() -> None:
    """Its corners are √125 = 11.18 mm from the vertical."""
    assert BLOCK.gap_to_column_mm(FRAME, upright(0.0, 0.0, -9.0, 9.0, 20.0, 13.0)) == pytest.approx(
        13.0 - math.sqrt(125.0)
    )
    assert BLOCK.gap_to_column_mm(FRAME, upright(0.0, 0.0, -9.0, 9.0, 20.0, 11.0)) < 0.0


def test_two_blocks_are_apart_along_one_axis_or_meet() -> None:
    def other(first: float, low: float) -> Envelope:
        return Envelope("other", rectangle_mm((first, 0.0), 4.0, 4.0), low, low + 2.0)

    assert BLOCK.gap_mm(other(15.0, 0.0)) == pytest.approx(3.0)
    assert BLOCK.gap_mm(other(0.0, 5.5)) == pytest.approx(1.5)
    assert other(0.0, -8.0).gap_mm(BLOCK) == pytest.approx(3.0)
    assert BLOCK.gap_mm(other(11.0, 0.0)) < 0.0


def test_clearance_to_the_wall_is_the_depth_of_the_worst_corner() -> None:
    body = catalog()["primary"].with_diameter(60.0)
    low, high = BLOCK.wall_clearances_mm(body, FRAME, 2.0)
    corners = [FRAME.point(a, b, c) for a in (-10, 10) for b in (-5, 5) for c in (-3.0, 4.0)]
    depths = depth_mm(body, np.array(corners)) - 2.0
    assert min(low, high) == pytest.approx(depths.min())
    assert BLOCK.passes(0.0, body, FRAME, 2.0)
    assert not BLOCK.passes(27.0, body, FRAME, 2.0)


def test_the_column_around_a_block_holds_its_corners() -> None:
    column = BLOCK.column(FRAME)
    assert column.radius_mm == pytest.approx(math.sqrt(125.0))
    inner = np.array([FRAME.point(0.999 * a, 0.999 * b, c) for a, b in BLOCK.outline_mm for c in (-2.9, 3.9)])
    assert column.contains(inner).all()


@given(places, places, st.floats(2.0, 6.0))
def test_posts_let_no_column_pass_into_the_block(first: float, second: float, radius: float) -> None:
    """A column of 2 mm or more that is clear of all posts of 1 mm is clear of the block."""
    column = upright(first, second, -50.0, 50.0, radius)

    def gap(post: Cylinder) -> float:
        across = FRAME.matrix()[:2] @ np.subtract(post.base_mm, column.base_mm)
        return float(np.linalg.norm(across)) - post.radius_mm - radius

    if min(gap(post) for post in BLOCK.posts(FRAME, 1.0)) > 0.0:
        assert BLOCK.gap_to_column_mm(FRAME, column) > 0.0

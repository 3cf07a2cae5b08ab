"""Righting arms, held against closed forms and against the metacentric heights."""

from __future__ import annotations

import json

import numpy as np
import pytest

from gomboc_cad.body.sphere import geodesic_triangulation
from gomboc_cad.hydrostatics import FRESH_WATER, RightingCurve, floating_state, righting_curve
from gomboc_cad.report.floating_figures import Waterline, plot_waterline
from gomboc_cad.report.style import new_axes

VERTICES, FACES = geodesic_triangulation(4)
UP = (0.0, 0.0, 1.0)


def test_arms_of_a_ballasted_ball() -> None:
    """Buoyancy always acts through the centre of a ball, so the arm is s sin φ for a COM lowered by s."""
    curve = righting_curve(50.0 * VERTICES, FACES, 300.0, (0.0, 0.0, -4.0), UP, FRESH_WATER)
    expected = 4.0 * np.sin(np.radians(curve.heel_deg))
    np.testing.assert_allclose(curve.righting_arm_mm, [expected, expected], atol=0.02)


@pytest.fixture(scope="module")
def ellipsoid() -> RightingCurve:
    corners = VERTICES * (30.0, 50.0, 40.0)
    return righting_curve(corners, FACES, 100.0, (0.0, 0.0, -3.0), UP, FRESH_WATER, step_deg=2.0)


def test_the_curve_begins_with_the_slope_of_the_metacentric_height(ellipsoid: RightingCurve) -> None:
    state = floating_state(VERTICES * (30.0, 50.0, 40.0), FACES, 100.0, (0.0, 0.0, -3.0), UP, FRESH_WATER)
    slope = ellipsoid.righting_arm_mm[:, 1] / np.radians(2.0)
    np.testing.assert_allclose(slope, state.gm_mm, rtol=0.02)
    assert ellipsoid.axes == state.heel_axes
    assert slope[0] < slope[1]


def test_the_work_is_the_difference_of_energy(ellipsoid: RightingCurve) -> None:
    """The integral of the arm over half a turn is how much higher the COM is over the centre of buoyancy."""
    low, high = (
        floating_state(VERTICES * (30.0, 50.0, 40.0), FACES, 100.0, (0.0, 0.0, -3.0), up, FRESH_WATER)
        for up in (UP, (0.0, 0.0, -1.0))
    )
    work = np.trapezoid(ellipsoid.righting_arm_mm, np.radians(ellipsoid.heel_deg))
    np.testing.assert_allclose(work, high.com_over_buoyancy_mm - low.com_over_buoyancy_mm, rtol=2e-3)


def test_the_direction_of_up_may_have_any_length(ellipsoid: RightingCurve) -> None:
    corners = VERTICES * (30.0, 50.0, 40.0)
    scaled = righting_curve(
        corners, FACES, 100.0, (0.0, 0.0, -3.0), (0.0, 0.0, 7.0), FRESH_WATER, step_deg=30.0
    )
    np.testing.assert_allclose(scaled.righting_arm_mm, ellipsoid.righting_arm_mm[:, ::15], atol=1e-9)


def test_json_gives_the_curve_back_and_it_draws_itself(ellipsoid: RightingCurve) -> None:
    back = RightingCurve.of_document(json.loads(json.dumps(ellipsoid.document())))
    np.testing.assert_array_equal(back.righting_arm_mm, ellipsoid.righting_arm_mm)
    assert (back.up, back.axes) == (ellipsoid.up, ellipsoid.axes)
    ax = new_axes(None, (4.0, 3.0))
    assert back.plot(ax) is ax
    drawn = [line.get_ydata() for line in ax.lines if len(line.get_xdata()) == len(back.heel_deg)]
    np.testing.assert_array_equal(drawn, back.righting_arm_mm)


def test_the_waterline_cuts_the_body_at_its_draught() -> None:
    corners = 50.0 * VERTICES
    state = floating_state(corners, FACES, 200.0, (0.0, 0.0, -5.0), UP, FRESH_WATER)
    curve = righting_curve(corners, FACES, 200.0, (0.0, 0.0, -5.0), UP, FRESH_WATER, step_deg=60.0)
    hydrostatics = {
        "water": {"name": "fresh water"},
        "com_mm": [0.0, 0.0, -5.0],
        "upright": {
            "up": UP,
            "draft_mm": state.draft_mm,
            "center_of_buoyancy_mm": state.center_of_buoyancy_mm,
            "bm_mm": state.bm_mm,
        },
        "righting": curve.document(),
    }
    seen = Waterline.of_document(hydrostatics, corners)
    assert -seen.outline_mm[:, 1].min() == pytest.approx(state.draft_mm)
    assert seen.outline_mm[:, 1].max() == pytest.approx(state.freeboard_mm)
    # The metacentre of a ball is its centre, 5 mm over this centre of mass.
    assert seen.metacentre_mm - seen.com_mm == pytest.approx(5.0, abs=0.1)
    assert seen.buoyancy_mm < seen.com_mm
    ax = new_axes(None, (4.0, 4.0))
    assert plot_waterline(seen, ax) is ax

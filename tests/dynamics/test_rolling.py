"""Rolling in time: conserved quantities, closed forms, friction at rest."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad

from gomboc_cad.body import Body, catalog, mass_properties, support_jet
from gomboc_cad.body.sphere import Array, fibonacci_directions
from gomboc_cad.dynamics import Resistance, RollingBody, righting, rocking_periods_s, roll
from gomboc_cad.errors import CensusError, NotConvexError

G = 9806.65
SKEW = (0.3, 0.5, 0.8)


def tilted(angle: float, toward: tuple[float, float] = (1.0, 0.0)) -> Array:
    """Straight down along −z, tilted by an angle."""
    return np.array([np.sin(angle) * toward[0], np.sin(angle) * toward[1], -np.cos(angle)])


def test_a_ball_rolls_straight_on(ball: Body) -> None:
    """Uniform motion with v = ω × r, whatever its spin about the vertical; it needs no friction for it."""
    motion = roll(
        RollingBody.homogeneous(ball), (0.0, 0.0, -1.0), spin_rad_s=(0.0, 4.0, 2.0), duration_s=1.0, samples=5
    )
    way = motion.com_mm - motion.com_mm[0]
    np.testing.assert_allclose(way, np.outer(motion.times_s, [200.0, 0.0, 0.0]), atol=1e-5)
    assert motion.load == pytest.approx(np.ones(5), abs=1e-9)
    assert motion.friction == pytest.approx(np.zeros(5), abs=1e-9)
    assert motion.stays_on_table


def test_energy_and_contact_are_kept_to_the_tolerance(rolling_primary: RollingBody) -> None:
    drifts = []
    for tolerance in (1e-6, 1e-9):
        motion = roll(
            rolling_primary,
            SKEW,
            spin_rad_s=(1.0, 2.0, -1.0),
            duration_s=1.0,
            samples=51,
            tolerance=tolerance,
        )
        drifts.append((np.ptp(motion.energy_mm), motion.drift_rad, motion.drift_mm))
        norms = np.linalg.norm(motion.turn, axis=1)
        assert norms == pytest.approx(np.ones(51), abs=100.0 * tolerance)
    assert np.all(np.array(drifts[0]) < (1e-2, 1e-3, 1e-2))
    assert np.all(np.array(drifts[1]) < (1e-6, 1e-7, 1e-5))


def test_jelletts_integral(loaded_ball: RollingBody) -> None:
    """A sphere loaded on its axis keeps the angular momentum about its COM along the arm to the contact.

    Source: Jellett, A Treatise on the Theory of Friction (1872), ch. VIII; energy does not see errors of the
    gyroscopic terms, this integral does.
    """
    motion = roll(loaded_ball, tilted(0.8), spin_rad_s=(3.0, -2.0, 9.0), duration_s=1.0, samples=41)
    arm = 50.0 * motion.down - np.array(loaded_ball.com_mm)
    momentum = motion.angular_velocity_rad_s @ np.array(loaded_ball.gyration_mm2)
    jellett = np.einsum("kx,kx->k", momentum, arm)
    assert np.ptp(motion.angular_velocity_rad_s[:, 2]) > 0.5
    assert jellett == pytest.approx(np.full(41, jellett[0]), rel=1e-7)


def test_small_rocking_of_the_loaded_ball(loaded_ball: RollingBody) -> None:
    """`T = 2π sqrt((G + (R − s)²) / (g s))`, s the distance of the COM from the centre."""
    inertia = loaded_ball.gyration_mm2[0][0] + 38.0**2
    expected = 2.0 * np.pi * np.sqrt(inertia / (G * 12.0))
    assert rocking_periods_s(loaded_ball, (0.0, 0.0, -1.0)) == pytest.approx((expected, expected), rel=1e-12)


@pytest.mark.parametrize("amplitude", [0.5, 2.5])
def test_large_rocking_of_the_loaded_ball(loaded_ball: RollingBody, amplitude: float) -> None:
    """The period by quadrature of the energy: after it the ball is back where it was, at rest."""
    inertia, s = loaded_ball.gyration_mm2[1][1], 12.0

    def slowness(x: float) -> float:
        angle = amplitude * np.sin(x)
        about_contact = inertia + 2500.0 + s * s - 100.0 * s * np.cos(angle)
        fall = 2.0 * G * s * (np.cos(angle) - np.cos(amplitude))
        return float(np.sqrt(about_contact / fall) * amplitude * np.cos(x))

    period = 4.0 * quad(slowness, 0.0, 0.5 * np.pi - 1e-9, epsabs=1e-12)[0]
    motion = roll(loaded_ball, tilted(amplitude), duration_s=period, samples=3)
    np.testing.assert_allclose(motion.down[1], tilted(-amplitude), atol=2e-7)
    np.testing.assert_allclose(motion.down[2], tilted(amplitude), atol=2e-7)
    np.testing.assert_allclose(motion.com_mm[2], motion.com_mm[0], atol=1e-4)


def test_rocking_of_an_ellipsoid_about_its_two_axes(loaded_ellipsoid: RollingBody) -> None:
    """Stiffness a²/c − h about the COM, inertia about the contact: two periods, met by the simulation."""
    inertia, height = np.array(loaded_ellipsoid.gyration_mm2), 31.0
    slow, fast = (
        2.0 * np.pi * np.sqrt((inertia[turn, turn] + height**2) / (G * (axis**2 / 40.0 - height)))
        for turn, axis in ((0, 50.0), (1, 65.0))
    )
    periods = rocking_periods_s(loaded_ellipsoid, (0.0, 0.0, -1.0))
    assert periods == pytest.approx((slow, fast), rel=1e-9)
    for period, toward in ((slow, (0.0, 1.0)), (fast, (1.0, 0.0))):
        motion = roll(loaded_ellipsoid, tilted(1e-3, toward), duration_s=period, samples=3)
        np.testing.assert_allclose(motion.down[1], tilted(-1e-3, toward), atol=1e-8)
        np.testing.assert_allclose(motion.down[2], tilted(1e-3, toward), atol=1e-8)


def test_periods_are_refused_away_from_a_rest(loaded_ball: RollingBody) -> None:
    for direction in ((1.0, 0.0, 0.0), (0.0, 0.0, 1.0)):
        with pytest.raises(CensusError, match="stable rest"):
            rocking_periods_s(loaded_ball, direction)


def test_damping_takes_the_amplitude_as_in_a_linear_oscillator(loaded_ball: RollingBody) -> None:
    gamma, start = 2.0, 1e-3
    frequency = 2.0 * np.pi / rocking_periods_s(loaded_ball, (0.0, 0.0, -1.0))[0]
    damped = np.sqrt(frequency**2 - gamma**2 / 4.0)
    motion = roll(
        loaded_ball, tilted(start), resistance=Resistance(damping_per_s=gamma), duration_s=1.0, samples=21
    )
    phase = damped * motion.times_s
    expected = np.exp(-0.5 * gamma * motion.times_s) * (
        np.cos(phase) + gamma / (2.0 * damped) * np.sin(phase)
    )
    np.testing.assert_allclose(motion.down[:, 0], start * expected, atol=1e-4 * start)


def test_rolling_resistance_takes_as_much_from_each_swing(loaded_ball: RollingBody) -> None:
    """A Coulomb-damped oscillator loses 2 b/s of amplitude in each half swing, and stops in the dead zone."""
    b, s, start = 0.02, 12.0, 0.02
    motion = roll(loaded_ball, tilted(start), resistance=Resistance(rolling_mm=b), samples=4001)
    angle = np.arctan2(motion.down[:, 0], -motion.down[:, 2])
    turns = angle[1:-1][(angle[1:-1] - angle[:-2]) * (angle[2:] - angle[1:-1]) < 0.0]
    left = np.abs(turns)
    assert len(left) >= 5
    np.testing.assert_allclose(start - left, 2.0 * b / s * np.arange(1, len(left) + 1), rtol=0.01)
    assert motion.stopped
    assert motion.slope_mm[-1] <= b * (1.0 + 1e-6)
    assert np.all(np.diff(motion.energy_mm) < 1e-9)


def test_rolling_resistance_does_the_work_of_its_moment(loaded_ellipsoid: RollingBody) -> None:
    """Energy lost over the weight is `∫ b N |ω| dt / (m g)`, with the load as it varies."""
    b = 0.5
    motion = roll(
        loaded_ellipsoid, tilted(1.0, (0.6, 0.8)), resistance=Resistance(b), duration_s=0.5, samples=2001
    )
    power = b * motion.load * np.linalg.norm(motion.angular_velocity_rad_s, axis=1)
    lost = np.trapezoid(power, motion.times_s)
    assert np.ptp(motion.load) > 0.1
    assert motion.energy_mm[0] - motion.energy_mm[-1] == pytest.approx(lost, rel=1e-5)


@given(share=st.floats(0.05, 3.0), azimuth=st.floats(0.0, 6.28))
@settings(max_examples=10, deadline=None)
def test_a_body_at_rest_stays_in_the_dead_zone_and_leaves_it_from_outside(
    share: float, azimuth: float, loaded_ball: RollingBody
) -> None:
    """On the loaded ball `|∇h| = s sinθ`."""
    b = 0.3
    start = tilted(np.arcsin(share * b / 12.0), (np.cos(azimuth), np.sin(azimuth)))
    motion = roll(
        loaded_ball, start, resistance=Resistance(rolling_mm=b), duration_s=0.2, samples=11, tolerance=1e-7
    )
    if share < 0.999:
        assert motion.stopped
        assert len(motion.times_s) == 1
    elif share > 1.001:
        assert len(motion.times_s) > 1
        assert motion.down[-1, 2] < start[2]


def test_larger_bodies_are_slower_by_the_root_of_their_size(rolling_primary: RollingBody) -> None:
    large = RollingBody.homogeneous(rolling_primary.body.with_diameter(400.0))
    one = roll(rolling_primary, SKEW, duration_s=0.4, samples=5, tolerance=1e-9)
    other = roll(large, SKEW, duration_s=0.8, samples=5, tolerance=1e-9)
    np.testing.assert_allclose(other.down, one.down, atol=1e-6)
    np.testing.assert_allclose(other.com_mm, 4.0 * one.com_mm, atol=1e-3)


def test_ballast_is_a_point_mass(ball: Body) -> None:
    """COM by the lever, inertia by Steiner."""
    loaded = RollingBody.ballasted(ball, 0.25, (0.0, 30.0, 0.0))
    assert loaded.com_mm == pytest.approx((0.0, 7.5, 0.0), abs=1e-12)
    across = 0.75 * (0.4 * 2500.0 + 7.5**2) + 0.25 * 22.5**2
    np.testing.assert_allclose(loaded.gyration_mm2, np.diag([across, 750.0, across]), atol=1e-9)
    with pytest.raises(CensusError, match="fraction"):
        RollingBody.ballasted(ball, 1.0, (0.0, 0.0, 0.0))


def test_the_primary_rights_itself_from_everywhere_sampled(rolling_primary: RollingBody) -> None:
    """It stops where the slope is below the rolling-resistance length, as near to its rest as that allows."""
    b = 0.05
    start = fibonacci_directions(8)
    result = righting(
        rolling_primary, start, Resistance(b, 1.0), duration_s=40.0, samples=401, tolerance=1e-6
    )
    assert result.stopped.all()
    assert np.isfinite(result.rest_time_s).all()
    slopes = np.linalg.norm(
        support_jet(rolling_primary.body, result.end, np.array(rolling_primary.com_mm)).gradient_mm, axis=1
    )
    assert slopes.max() <= b * (1.0 + 1e-3)
    # The soft stiffness is 0.1696 mm: b over it is 17°.
    assert result.tilt_deg.max() < 17.5
    righted = result.tilt_deg <= result.upright_deg
    assert np.all(np.isfinite(result.righting_time_s) == righted)
    assert np.all(result.righting_time_s[righted] <= result.rest_time_s[righted])
    assert result.friction.max() < 0.2
    assert result.load.min() > 0.9


def test_both_ways_of_following_agree(loaded_ellipsoid: RollingBody) -> None:
    """A body among others stops when and where it stops alone."""
    resistance = Resistance(0.3, 3.0)
    start = np.array([tilted(0.5, (0.6, 0.8)), tilted(1.2, (0.8, -0.6))])
    together = righting(loaded_ellipsoid, start, resistance, duration_s=5.0, samples=51)
    for k in range(2):
        alone = roll(
            loaded_ellipsoid, start[k], resistance=resistance, duration_s=5.0, samples=51, tolerance=1e-8
        )
        assert alone.stopped
        assert together.stopped[k]
        assert alone.times_s[-1] == pytest.approx(together.rest_time_s[k], abs=1e-3)
        np.testing.assert_allclose(alone.down[-1], together.end[k], atol=1e-4)


def test_with_damping_alone_a_body_settles_at_its_rest(loaded_ellipsoid: RollingBody) -> None:
    resistance = Resistance(damping_per_s=8.0)
    result = righting(loaded_ellipsoid, tilted(0.4)[None], resistance, duration_s=10.0, samples=101)
    assert result.stopped.all()
    assert result.tilt_deg[0] < 0.15


def test_what_cannot_be_followed_is_refused(ball: Body, loaded_ball: RollingBody) -> None:
    with pytest.raises(CensusError, match="Without rolling resistance"):
        righting(loaded_ball, fibonacci_directions(2), Resistance())
    with pytest.raises(CensusError, match="zero"):
        roll(loaded_ball, (0.0, 0.0, 0.0))
    with pytest.raises(CensusError, match="three finite"):
        roll(loaded_ball, (0.0, float("nan"), 1.0))
    with pytest.raises(CensusError, match="time above zero"):
        roll(loaded_ball, (0.0, 0.0, 1.0), duration_s=-1.0)
    with pytest.raises(CensusError, match="zero or more"):
        Resistance(rolling_mm=-1.0)
    with pytest.raises(NotConvexError):
        roll(RollingBody.homogeneous(catalog()["second"]), SKEW)


def test_homogeneous_inertia_is_that_of_the_mass_properties(rolling_primary: RollingBody) -> None:
    mass = mass_properties(rolling_primary.body)
    np.testing.assert_allclose(
        rolling_primary.gyration_mm2, np.array(mass.inertia_mm5) / mass.volume_mm3, rtol=1e-12
    )
    assert rolling_primary.com_mm == mass.com_mm

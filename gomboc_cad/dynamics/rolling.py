"""Rolling in time: how long a body takes to right itself, and how true it comes to rest."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
from scipy.integrate import solve_ivp

from gomboc_cad.body.sphere import Array, BoolArray, IntArray, unit
from gomboc_cad.body.support import support_jet
from gomboc_cad.dynamics.arguments import direction_rows, vector_rows
from gomboc_cad.dynamics.contact import Rolling, States, start_states, turned
from gomboc_cad.dynamics.records import GRAVITY_MM_S2, Resistance, Righting, RollingBody, Trajectory
from gomboc_cad.equilibria.convexity import require_strictly_convex
from gomboc_cad.equilibria.smooth import find_equilibria
from gomboc_cad.errors import CensusError

_REST_SPEED = 1e-4
"""Speed that counts as none, in units of sqrt(g/R₀)."""

_SMOOTHING = 0.1
"""Part of that speed below which the moment of rolling resistance falls to zero."""

_SETTLED_DEG = 0.1
"""Without rolling resistance nothing ever stops; the body counts as settled within this tilt of a rest."""


def rocking_periods_s(rolling: RollingBody, down: Sequence[float] | Array) -> tuple[float, float]:
    """Periods (slow, fast) of small undamped rocking about a stable rest.

    Linearised, `δ'' = −g (J⁻¹)_T ∇²h δ` for the tilt δ across the table, J the inertia about the contact.

    Args:
        rolling: The body.
        down: Body direction that points down at the rest, shape (3,).

    Raises:
        CensusError: If the direction is not that of a stable rest.
    """
    jet = support_jet(
        rolling.body, unit(np.atleast_2d(np.asarray(down, dtype=float))), np.array(rolling.com_mm)
    )
    stiffness, arm = jet.hessian_mm[0], jet.height_mm[0] * unit(np.asarray(down, dtype=float))
    if (
        np.linalg.norm(jet.gradient_mm) > 1e-6 * rolling.body.radius_mm
        or np.linalg.eigvalsh(stiffness)[0] <= 0.0
    ):
        raise CensusError("Rocking periods are those of a stable rest; give the direction of one.")
    inertia = np.array(rolling.gyration_mm2) + (arm @ arm) * np.eye(3) - np.outer(arm, arm)
    # A tilt along one tangent is a turn about the other.
    axes = np.stack([-jet.tangents[0, 1], jet.tangents[0, 0]])
    mobility = axes @ np.linalg.inv(inertia) @ axes.T
    slow, fast = np.sort(np.linalg.eigvals(GRAVITY_MM_S2 * mobility @ stiffness).real)
    return float(2.0 * np.pi / np.sqrt(slow)), float(2.0 * np.pi / np.sqrt(fast))


def roll(
    rolling: RollingBody,
    down: Sequence[float] | Array,
    *,
    spin_rad_s: Sequence[float] | Array = (0.0, 0.0, 0.0),
    resistance: Resistance | None = None,
    duration_s: float = 10.0,
    samples: int = 1001,
    tolerance: float = 1e-10,
) -> Trajectory:
    """Follow a body on a table from a pose and an angular velocity until it stops, or for a time.

    Args:
        rolling: The body.
        down: Body direction that points down at first, shape (3,).
        spin_rad_s: Angular velocity at first, in body coordinates, shape (3,).
        resistance: What takes energy out; nothing if not given.
        duration_s: Longest time.
        samples: Number of instants over that time at which the motion is given.
        tolerance: Relative error allowed in a step.

    Raises:
        NotConvexError: If the body is not strictly convex.
        CensusError: If the time, the samples or a vector is not usable, or the integration fails.
    """
    require_strictly_convex(rolling.body)
    rule = _StopRule.of(rolling, resistance or Resistance())
    start = start_states(rolling, direction_rows([down]), vector_rows([spin_rad_s]))
    stretches = list(_stretches(rule, start, _instants(duration_s, samples), tolerance))
    times = np.concatenate([stretch.times_s for stretch in stretches])
    states = States.of(np.concatenate([stretch.states[:, 0] for stretch in stretches]))
    motion = rule.rolling.motion(states)
    lowest = turned(states.turn / np.linalg.norm(states.turn, axis=1, keepdims=True), motion.down)
    return Trajectory(
        times_s=times,
        down=motion.down,
        turn=states.turn,
        angular_velocity_rad_s=states.spin,
        com_mm=states.com_mm,
        energy_mm=motion.energy_mm,
        load=motion.load,
        friction=motion.friction,
        slope_mm=motion.slope_mm,
        stopped=bool(stretches[-1].stopped.any()),
        drift_rad=float(np.hypot(lowest[:, 0], lowest[:, 1]).max()),
        drift_mm=float(np.abs(states.com_mm[:, 2] - motion.height_mm).max()),
    )


def righting(
    rolling: RollingBody,
    down: Array,
    resistance: Resistance,
    *,
    upright_deg: float = 10.0,
    duration_s: float = 60.0,
    samples: int = 2001,
    tolerance: float = 1e-7,
) -> Righting:
    """Release a body at rest from many orientations, and time how it rights itself.

    Args:
        rolling: The body.
        down: Body directions that point down at first, shape (n, 3).
        resistance: What takes energy out; without any nothing stops.
        upright_deg: Tilt from the lowest rest below which the body counts as righted.
        duration_s: Longest time.
        samples: Number of instants over that time, to which the righting time is rounded up.
        tolerance: Relative error allowed in a step.

    Raises:
        NotConvexError: If the body is not strictly convex.
        DegenerateEquilibriaError: If its rests are not isolated.
        CensusError: If there is no resistance, or an argument is not usable, or the integration fails.
    """
    if resistance == Resistance():
        raise CensusError("Without rolling resistance or damping nothing comes to rest; give one of them.")
    first = direction_rows(down)
    rule = _StopRule.of(rolling, resistance)
    lowest = np.array(find_equilibria(rolling.body, rolling.com_mm)[0].direction)
    end, count = first.copy(), len(first)
    rest_time = np.full(count, np.inf)
    righted_at, tilt = np.zeros(count), np.zeros(count)
    friction, load = np.zeros(count), np.ones(count)
    start = start_states(rolling, first, np.zeros_like(first))
    for stretch in _stretches(rule, start, _instants(duration_s, samples), tolerance):
        moving = stretch.bodies
        for time, states in zip(stretch.times_s, stretch.states, strict=True):
            motion = rule.rolling.motion(States.of(states))
            end[moving] = motion.down
            tilt[moving] = np.degrees(np.arccos(np.clip(motion.down @ lowest, -1.0, 1.0)))
            righted_at[moving[tilt[moving] > upright_deg]] = time
            friction[moving] = np.maximum(friction[moving], motion.friction)
            load[moving] = np.minimum(load[moving], motion.load)
        rest_time[moving[stretch.stopped]] = stretch.times_s[-1]
    return Righting(
        start=first,
        end=end,
        stopped=np.isfinite(rest_time),
        rest_time_s=rest_time,
        righting_time_s=np.where(tilt <= upright_deg, righted_at, np.inf),
        tilt_deg=tilt,
        upright_deg=upright_deg,
        friction=friction,
        load=load,
    )


class _StopRule(NamedTuple):
    """When a body is at rest: slow, and where the weight cannot set it in motion again."""

    rolling: Rolling
    speed_rad_s: float
    slope_mm: float
    size_mm: float

    @classmethod
    def of(cls, rolling: RollingBody, resistance: Resistance) -> _StopRule:
        size = rolling.body.radius_mm
        speed = _REST_SPEED * float(np.sqrt(GRAVITY_MM_S2 / size))
        slope = resistance.rolling_mm
        moving = Rolling(rolling, resistance, _SMOOTHING * speed)
        if slope == 0.0 and resistance.damping_per_s > 0.0:
            lowest = find_equilibria(rolling.body, rolling.com_mm)[0]
            settled = np.radians(_SETTLED_DEG)
            slope = settled * min(lowest.stiffness_mm or (0.0,))
            speed = settled * 2.0 * np.pi / rocking_periods_s(rolling, lowest.direction)[0]
        return cls(moving, speed, slope, size)

    def signals(self, states: Array) -> Array:
        """Below zero for bodies at rest, shape (n,)."""
        one = States.of(states)
        speed = np.linalg.norm(one.spin, axis=1) / self.speed_rad_s - 1.0
        slope = (self.rolling.motion(one).slope_mm - self.slope_mm) / self.size_mm
        result: Array = np.maximum(speed, slope)
        return result


class _Stretch(NamedTuple):
    """Motion until the next body stops.

    Attributes:
        times_s: Instants, shape (k,).
        bodies: Indices of the bodies that move, shape (n,).
        states: Their states, shape (k, n, WIDTH).
        stopped: Which of them stop at the last instant, shape (n,).
    """

    times_s: Array
    bodies: IntArray
    states: Array
    stopped: BoolArray


def _stretches(rule: _StopRule, states: Array, instants: Array, tolerance: float) -> Iterator[_Stretch]:
    """Follow bodies side by side, each until it stops."""

    def rates(_: float, numbers: Array) -> Array:
        return rule.rolling.motion(States.of(numbers)).rates.ravel()

    def first_stop(_: float, numbers: Array) -> float:
        return float(rule.signals(numbers).min())

    first_stop.terminal, first_stop.direction = True, -1.0  # type: ignore[attr-defined]  # as scipy wants it
    typical = np.repeat([1.0, 1.0, np.sqrt(GRAVITY_MM_S2 / rule.size_mm), rule.size_mm], (4, 3, 3, 3))
    bodies, time = np.arange(len(states)), float(instants[0])
    stopped = rule.signals(states) <= 0.0
    yield _Stretch(instants[:1], bodies, states[None], stopped)
    while time < instants[-1] and not stopped.all():
        bodies, states = bodies[~stopped], states[~stopped]
        done = solve_ivp(
            rates,
            (time, instants[-1]),
            states.ravel(),
            method="DOP853",
            t_eval=instants[instants > time],
            events=first_stop,
            rtol=tolerance,
            atol=tolerance * np.tile(typical, len(bodies)),
        )
        if not done.success:
            raise CensusError(f"The rolling motion cannot be followed: {done.message}")
        # Where a body stops before the next instant, scipy gives empty lists.
        times = np.asarray(done.t, dtype=float)
        rows = np.asarray(done.y, dtype=float).reshape(states.size, -1).T.reshape(-1, *states.shape)
        if done.t_events and done.y_events and len(done.t_events[0]):
            times = np.append(times, done.t_events[0])
            rows = np.concatenate([rows, done.y_events[0].reshape(-1, *states.shape)])
        time, states = float(times[-1]), rows[-1]
        # An event is located to rounding.
        stopped = rule.signals(states) <= 1e-9
        yield _Stretch(times, bodies, rows, stopped)


def _instants(duration_s: float, samples: int) -> Array:
    if not 0.0 < duration_s < np.inf or samples < 2:
        raise CensusError(
            f"A motion needs a time above zero and at least two instants, not {duration_s!r} s and {samples}."
        )
    return np.linspace(0.0, duration_s, samples)

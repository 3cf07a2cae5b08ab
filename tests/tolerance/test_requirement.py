"""Which variants are good: one rest, held nowhere else, within the angle."""

from __future__ import annotations

import numpy as np

from gomboc_cad.tolerance.requirement import RIGHTS_ITSELF, Requirement
from gomboc_cad.tolerance.variants import MONOSTABLE, MULTISTABLE, UNDECIDED, Outcomes

NAN = float("nan")


def outcomes(*rows: tuple[int, float, float, float]) -> Outcomes:
    """Of verdicts, tilts, S-margins and soft stiffnesses."""
    verdict, tilt, margin, soft = np.array(rows, dtype=float).T
    return Outcomes(
        verdict=verdict.astype(np.int8),
        stable=np.where(verdict == MONOSTABLE, 1, 2),
        rest_direction=np.tile([0.0, 0.0, -1.0], (len(rows), 1)),
        tilt_deg=tilt,
        s_margin_mm=margin,
        stiffness_mm=np.stack([soft, 10.0 * soft], axis=1),
    )


def test_one_rest_is_enough_without_more_demands() -> None:
    made = outcomes(
        (MONOSTABLE, 170.0, 1e-9, 1e-9),
        (MULTISTABLE, 0.0, 0.0, 1.0),
        (UNDECIDED, 0.0, 1.0, 1.0),
        (UNDECIDED, NAN, NAN, NAN),
    )
    assert RIGHTS_ITSELF.met(made).tolist() == [True, False, False, False]


def test_the_angle_includes_its_limit_and_the_dead_zone() -> None:
    """A soft stiffness of 1 mm and b = 0.01 mm give 0.573 degrees."""
    made = outcomes(*((MONOSTABLE, tilt, 0.5, 1.0) for tilt in (4.4, 4.5, 5.0, 5.1, NAN)))
    assert Requirement(5.0).met(made).tolist() == [True, True, True, False, False]
    assert Requirement(5.0, rolling_mm=0.01).met(made).tolist() == [True, False, False, False, False]


def test_rolling_resistance_at_the_margin_may_hold_it_elsewhere() -> None:
    made = outcomes(*((MONOSTABLE, 0.0, margin, 1e3) for margin in (0.011, 0.01, 0.009, NAN)))
    assert Requirement(rolling_mm=0.01).met(made).tolist() == [True, False, False, False]
    assert Requirement(rolling_mm=0.01).may_stall(made.s_margin_mm).tolist() == [False, True, True, True]


def test_a_rest_without_stiffness_is_within_no_angle_but_half_a_turn() -> None:
    made = outcomes((MONOSTABLE, 0.0, 1.0, 0.0), (MONOSTABLE, 0.0, 1.0, np.inf))
    assert Requirement(10.0, rolling_mm=0.01).met(made).tolist() == [False, True]
    assert Requirement(180.0, rolling_mm=0.01).met(made).tolist() == [True, True]

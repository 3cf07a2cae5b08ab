"""When a product is good: it rights itself, and it rests within an angle, rolling resistance included.

With a rolling-resistance length b a body may stop wherever `|∇f| ≤ b`, f being the height of its COM: a slope
of that size is held just as a COM shift of that size would be balanced. So below the S-margin, the smallest
COM shift that makes another stable rest, rolling resistance makes no new rest either: wherever the height is
curved upwards all around, it holds the body near the one rest only. Elsewhere it holds it on a ridge of the
height, as around an unstable pose, which the body leaves when it is put askew by more than the dead zone
there.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gomboc_cad.body.sphere import Array, BoolArray
from gomboc_cad.errors import StudyError
from gomboc_cad.tolerance.dead_zone import half_width_deg
from gomboc_cad.tolerance.variants import MONOSTABLE, Outcomes


@dataclass(frozen=True)
class Requirement:
    """What a product has to do on the table.

    Attributes:
        max_tilt_deg: Largest angle from the nominal rest at which it may stop; None if any will do.
        rolling_mm: Rolling-resistance length b of the product on its table.
    """

    max_tilt_deg: float | None = None
    rolling_mm: float = 0.0

    def __post_init__(self) -> None:
        """Raise StudyError if a figure is no length or no angle."""
        if self.max_tilt_deg is not None and not 0.0 < self.max_tilt_deg <= 180.0:
            raise StudyError(
                f"The largest tilt must be above 0 and at most 180 degrees, not {self.max_tilt_deg!r}."
            )
        if not 0.0 <= self.rolling_mm < math.inf:
            raise StudyError(
                f"The rolling-resistance length must be zero or more millimetres, not {self.rolling_mm!r}."
            )

    def dead_zone_deg(self, outcomes: Outcomes) -> Array:
        """Half-width of the dead zone along the soft direction of each rest, NaN without one, shape (n,)."""
        return half_width_deg(self.rolling_mm, outcomes.stiffness_mm[:, 0])

    def met(self, outcomes: Outcomes) -> BoolArray:
        """Which variants right themselves and stop within the angle; undecided ones do not, shape (n,)."""
        return self.accepts(
            outcomes.verdict, outcomes.tilt_deg, outcomes.s_margin_mm, self.dead_zone_deg(outcomes)
        )

    def accepts(
        self, verdict: NDArray[np.int8], tilt_deg: Array, s_margin_mm: Array, dead_zone_deg: Array
    ) -> BoolArray:
        """The same of columns (n,) of which the last was found by `dead_zone_deg`."""
        good: BoolArray = (verdict == MONOSTABLE) & ~self.may_stall(s_margin_mm)
        if self.max_tilt_deg is not None:
            good &= tilt_deg + dead_zone_deg <= self.max_tilt_deg
        return good

    def may_stall(self, s_margin_mm: Array) -> BoolArray:
        """Which variants rolling resistance may hold elsewhere than near a stable rest, shape (n,)."""
        if self.rolling_mm == 0.0:
            return np.zeros(len(s_margin_mm), dtype=bool)
        # An unknown margin is no margin.
        return ~(s_margin_mm > self.rolling_mm)


RIGHTS_ITSELF = Requirement()
"""One rest is enough, whatever its tilt, on a table without rolling resistance."""

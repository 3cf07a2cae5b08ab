"""What a search wants of a body, and what it must keep."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gomboc_cad.body.sphere import Array, BoolArray
from gomboc_cad.errors import BodyError
from gomboc_cad.search.landscape import Landscape

OBJECTIVES = ("s-margin", "height-range", "stiffness")

DEFAULT_MIN_CURVATURE = 0.05
DEFAULT_MIN_MARGIN = 0.003

_MENDED_CURVATURE = 1e-3
"""So much is gained by an amplitude that is smaller by as little, which hardly costs any margin."""

SLACK = np.array([2e-5, 1e-5])
"""So much more curvature and margin than asked a search aims at, for it rounds and linearises."""


@dataclass(frozen=True)
class Goal:
    """An objective and its constraints, in units of the nominal radius R₀.

    Attributes:
        objective: `s-margin`: how far the COM may move before a second stable rest appears, the U-margin
            being kept at least as large; `height-range`: unstable less stable height of the COM; `stiffness`:
            soft stiffness of the rest.
        min_curvature: Smallest principal curvature allowed, times R₀.
        min_margin: Smallest COM margin allowed. It keeps a search for range or stiffness off the edge of the
            region with one stable and one unstable equilibrium, where nothing can be proven.

    Raises:
        BodyError: If the objective is unknown, or a constraint is outside the range where bodies exist.
    """

    objective: str = "s-margin"
    min_curvature: float = DEFAULT_MIN_CURVATURE
    min_margin: float = DEFAULT_MIN_MARGIN

    def __post_init__(self) -> None:
        """Check the values."""
        if self.objective not in OBJECTIVES:
            raise BodyError(
                f"There is no objective {self.objective!r}; choose one of {', '.join(OBJECTIVES)}."
            )
        if not 0.001 <= self.min_curvature <= 0.95:
            raise BodyError(
                f"The smallest curvature must be from 0.001 to 0.95 (times R0), not {self.min_curvature!r}."
            )
        if not 0.0 < self.min_margin <= 0.02:
            raise BodyError(
                f"The smallest margin must be between 0 and 0.02 (in units of R0), not {self.min_margin!r}."
            )

    @property
    def curvature_floor(self) -> float:
        """The smallest curvature that a search aims at."""
        return self.min_curvature + float(SLACK[0])

    @property
    def margin_floor(self) -> float:
        """The smallest margin that a search aims at."""
        return self.min_margin + float(SLACK[1])

    def value(self, landscape: Landscape) -> float:
        """The objective of a body of radius 1."""
        if self.objective == "s-margin":
            return landscape.margin_mm
        return landscape.height_range_mm if self.objective == "height-range" else landscape.stiffness_mm

    def shortfall(self, landscape: Landscape) -> Array:
        """By how much a body of radius 1 misses the floors of curvature and of margin, zero or more, (2,)."""
        floors = np.array([self.curvature_floor, self.margin_floor])
        reached = np.array([landscape.min_curvature_per_mm, landscape.margin_mm])
        result: Array = np.maximum(0.0, floors - reached)
        return result

    def is_out_of_reach(self, landscape: Landscape) -> BoolArray:
        """Whether curvature and margin lack more than the last step of a search can mend, shape (2,)."""
        result: BoolArray = self.shortfall(landscape) > SLACK + np.array([_MENDED_CURVATURE, 0.0])
        return result

    def missed(self, min_curvature: float, margin: float) -> tuple[str, ...]:
        """The constraints that a body with this curvature and margin does not meet."""
        return (
            *(("smallest curvature",) if min_curvature < self.min_curvature else ()),
            *(("smallest margin",) if margin < self.min_margin else ()),
        )

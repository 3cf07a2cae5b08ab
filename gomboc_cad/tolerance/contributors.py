"""Sources that act: how draws of random numbers become deviations from the design.

Each source draws numbers from its columns of the quantiles, standard normal where a scatter is given and
uniform within ±1 where a half-width is, and acts linearly on one of the `Deviations`. What follows from those
together is not linear; that is the business of the mass model and of the judge.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from scipy.special import ndtri

from gomboc_cad.body.sphere import Array, IntArray
from gomboc_cad.tolerance.model import Source

Law = Literal["normal", "uniform"]
Target = Literal["form_mm", "shrinkage", "upper_shift_mm", "mass_g", "place_mm", "com_mm"]
"""What a source acts on: a field of `Deviations`, flat, or the shrinkage along the machine's axes."""


@dataclass(frozen=True, eq=False)
class Contributor:
    """A source and what it does.

    Attributes:
        source: What it is.
        law: `normal`: of standard deviation 1; `uniform`: within ±1.
        target: What it acts on.
        entries: The components of the target that it acts on, shape (w,), each once.
        effect: What a draw of 1 does: shape (w,) with one draw for each component, or (d, w).
        mean: What it does on the average, shape (w,) or one number.
    """

    source: Source
    law: Law
    target: Target
    entries: IntArray
    effect: Array
    mean: Array | float = 0.0

    def scaled(self, factor: float) -> Contributor:
        """The same with all that it does times a factor."""
        source = replace(self.source, size=factor * self.source.size)
        return replace(self, source=source, effect=factor * self.effect, mean=factor * self.mean)

    def values(self, quantiles: Array) -> Array:
        """What it does to n products.

        Args:
            quantiles: Its own columns, in (0, 1), shape (n, d).

        Returns:
            Shape (n, w), each row computed by itself.
        """
        draws = ndtri(quantiles) if self.law == "normal" else 2.0 * quantiles - 1.0
        if self.effect.ndim == 1:
            result: Array = self.mean + draws * self.effect
            return result
        result = np.zeros((len(draws), len(self.entries))) + self.mean
        for draw, effect in zip(draws.T, self.effect, strict=True):
            result += draw[:, None] * effect
        return result

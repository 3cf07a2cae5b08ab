"""Rows of quantiles: scrambled Sobol points, the same for each batch whatever was drawn before.

A study takes the points in their order. A sensitivity analysis takes them twice as wide, as the matrices A
and B of the pick-freeze scheme (Saltelli et al., Computer Physics Communications 181 (2010) 259) and as `A`
with the columns of one source from `B`, for each source.

Source of the scrambling: Matoušek, Journal of Complexity 14 (1998) 527, as in `scipy.stats.qmc`.
"""

from __future__ import annotations

import threading
from dataclasses import dataclass
from itertools import accumulate
from typing import Protocol

import numpy as np
from scipy.stats import qmc

from gomboc_cad.body.sphere import Array, IntArray
from gomboc_cad.errors import StudyError

BATCH_ROWS = 512
"""Rows that are drawn and judged together: a power of two."""

MAX_VARIANTS = 2**30
"""As many points does a sequence have."""

_BITS = 30
_MOST_DIMENSIONS = 21201


class Sample(Protocol):
    """Rows of quantiles in batches of one size."""

    @property
    def batches(self) -> int:
        """Number of batches."""

    def batch(self, index: int) -> Array:
        """The quantiles of one batch, inside (0, 1), shape (rows, dimensions)."""


class _Engines(threading.local):
    """The last sequence of this thread: going on is cheap, starting anew takes as long as all rows before."""

    def __init__(self) -> None:
        self._key: tuple[int, int] | None = None
        self._engine: qmc.Sobol

    def at(self, dimensions: int, seed: int, row: int) -> qmc.Sobol:
        """The sequence, just before the row."""
        if self._key != (dimensions, seed):
            self._engine = qmc.Sobol(dimensions, scramble=True, bits=_BITS, rng=np.random.default_rng(seed))
            self._key = dimensions, seed
        if self._engine.num_generated > row:
            self._engine.reset()
        # The engine takes a jump by zero for one to the row before the first.
        if row > self._engine.num_generated:
            self._engine.fast_forward(row - self._engine.num_generated)
        return self._engine


_ENGINES = _Engines()


def quantiles(dimensions: int, seed: int, batch: int, rows: int = BATCH_ROWS) -> Array:
    """Rows `batch · rows` and following of a scrambled Sobol sequence.

    Args:
        dimensions: Columns.
        seed: Which scrambling; sequences with different seeds are independent of each other.
        batch: Index of the batch.
        rows: Rows of each batch, a power of two.

    Returns:
        Centres of cells of width 2⁻³⁰, so that no quantile is 0 or 1, shape (rows, dimensions).

    Raises:
        StudyError: If the seed is negative, or there are too many dimensions.
    """
    if seed < 0:
        raise StudyError(f"The seed must be zero or more, not {seed}.")
    if dimensions > _MOST_DIMENSIONS:
        raise StudyError(
            f"{dimensions} uncertain numbers are too many; at most {_MOST_DIMENSIONS} are possible."
        )
    if dimensions == 0:
        return np.empty((rows, 0))
    points: Array = _ENGINES.at(dimensions, seed, batch * rows).random(rows)
    return points + 0.5 ** (_BITS + 1)


@dataclass(frozen=True)
class SobolSample:
    """The first rows of a sequence, in whole batches.

    Attributes:
        dimensions: Columns.
        seed: Which scrambling.
        variants: How many rows are wanted; the last batch has more of them.
    """

    dimensions: int
    seed: int
    variants: int

    def __post_init__(self) -> None:
        """Raise StudyError if there are no rows, or more than the sequence has."""
        if not 1 <= self.variants <= MAX_VARIANTS:
            raise StudyError(f"A study takes 1 to {MAX_VARIANTS} variants, not {self.variants}.")

    @property
    def batches(self) -> int:
        """Number of batches."""
        return -(-self.variants // BATCH_ROWS)

    def batch(self, index: int) -> Array:
        """The quantiles of one batch, shape (BATCH_ROWS, dimensions)."""
        return quantiles(self.dimensions, self.seed, index)

    def rows(self, numbers: IntArray) -> Array:
        """The quantiles of single rows by their numbers (n,), shape (n, dimensions)."""
        places = (divmod(number, BATCH_ROWS) for number in numbers.tolist())
        return np.stack([self.batch(batch)[row] for batch, row in places])


@dataclass(frozen=True)
class PickFreeze:
    """The matrices A, B, A with group 1 from B, A with group 2 from B, ..., one after the other.

    Attributes:
        groups: Columns of each group.
        seed: Which scrambling.
        samples: Rows of each matrix: a power of two.
    """

    groups: tuple[int, ...]
    seed: int
    samples: int

    def __post_init__(self) -> None:
        """Raise StudyError if the number of rows is no power of two."""
        if not 2 <= self.samples <= MAX_VARIANTS or self.samples & (self.samples - 1):
            raise StudyError(f"A sensitivity analysis takes a power of two of samples, not {self.samples}.")

    @property
    def batches(self) -> int:
        """Number of batches of all matrices."""
        return (2 + len(self.groups)) * (self.samples // self._rows)

    def batch(self, index: int) -> Array:
        """The quantiles of one batch, which lies within one matrix, shape (rows, sum of the groups)."""
        width = sum(self.groups)
        matrix, part = divmod(index, self.samples // self._rows)
        both = quantiles(2 * width, self.seed, part, self._rows)
        first, second = both[:, :width], both[:, width:]
        if matrix < 2:
            return (first, second)[matrix].copy()
        ends = list(accumulate(self.groups, initial=0))
        columns = slice(ends[matrix - 2], ends[matrix - 1])
        mixed = first.copy()
        mixed[:, columns] = second[:, columns]
        return mixed

    @property
    def _rows(self) -> int:
        return min(self.samples, BATCH_ROWS)

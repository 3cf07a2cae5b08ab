"""What a sample says: proportions with exact intervals, percentiles, Sobol indices of groups of columns."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from scipy.special import betaincinv
from scipy.stats import bootstrap, sobol_indices

from gomboc_cad.body.sphere import Array


@dataclass(frozen=True)
class Interval:
    """An estimate and the interval that covers the truth with a stated confidence.

    Attributes:
        estimate: The estimate; NaN if nothing was observed.
        low: Lower end.
        high: Upper end.
        confidence: Least probability with which such an interval covers the truth.
    """

    estimate: float
    low: float
    high: float
    confidence: float = 0.95


def clopper_pearson(passed: int, trials: int, confidence: float = 0.95) -> Interval:
    """Give the exact interval of a proportion: each end fails with at most half of 1 − confidence.

    Args:
        passed: How many of the trials are good.
        trials: How many independent trials there were; with none the interval is (0, 1).
        confidence: As 0.95.

    Source: Clopper and Pearson, Biometrika 26 (1934) 404, by quantiles of the beta distribution.
    """
    if not 0 <= passed <= trials:
        raise ValueError(f"{passed} of {trials} is no proportion")
    tail = 0.5 * (1.0 - confidence)
    low = float(betaincinv(passed, trials - passed + 1, tail)) if passed > 0 else 0.0
    high = float(betaincinv(passed + 1, trials - passed, 1.0 - tail)) if passed < trials else 1.0
    return Interval(passed / trials if trials else float("nan"), low, high, confidence)


@dataclass(frozen=True)
class Yield:
    """The share of good parts.

    The interval is exact for independent rows. Sobol points spread more evenly than these, so with them it
    covers the truth more often than it promises.

    Attributes:
        passed: Variants that are good.
        undecided: Variants on which there is no verdict.
        variants: All variants.
        confidence: Of the intervals.
    """

    passed: int
    undecided: int
    variants: int
    confidence: float = 0.95

    @property
    def interval(self) -> Interval:
        """The yield if no undecided variant is good."""
        return clopper_pearson(self.passed, self.variants, self.confidence)

    @property
    def possible(self) -> Interval:
        """The yield if every undecided variant is good."""
        return clopper_pearson(self.passed + self.undecided, self.variants, self.confidence)


@dataclass(frozen=True)
class Distribution:
    """How a quantity is distributed over a sample.

    Attributes:
        count: Values in the sample.
        mean: Their mean.
        p05: 5 % of them are below.
        p50: Their median.
        p95: 95 % of them are below.
        smallest: The smallest of them.
        largest: The largest of them.
    """

    count: int
    mean: float
    p05: float
    p50: float
    p95: float
    smallest: float
    largest: float


def distribution(values: Array) -> Distribution | None:
    """Summarise numbers (n,); None if there are none."""
    if not len(values):
        return None
    smallest, p05, p50, p95, largest = (
        float(v) for v in np.percentile(values, (0.0, 5.0, 50.0, 95.0, 100.0))
    )
    return Distribution(len(values), float(np.mean(values)), p05, p50, p95, smallest, largest)


@dataclass(frozen=True)
class SobolIndex:
    """How much of the variance of an output a source explains.

    Attributes:
        source: Name of the source.
        first: Share that vanishes on the average if the source alone is fixed.
        total: Share that remains on the average if all other sources are fixed; more than the first where the
            source acts together with others.
    """

    source: str
    first: Interval
    total: Interval


def group_indices(
    names: Sequence[str],
    f_a: Array,
    f_b: Array,
    f_ab: Array,
    *,
    seed: int,
    confidence: float = 0.95,
    resamples: int = 500,
) -> tuple[SobolIndex, ...]:
    """First and total Sobol indices of groups of columns from a pick-freeze sample.

    The intervals are those of the percentiles of a bootstrap over the rows.

    Args:
        names: Of the g groups.
        f_a: Output on the matrix A, shape (n,), n a power of two.
        f_b: Output on the matrix B, shape (n,).
        f_ab: Output on A with the columns of each group from B, shape (g, n).
        seed: Of the bootstrap.
        confidence: Of the intervals.
        resamples: Of the bootstrap.

    Source: Saltelli et al., Computer Physics Communications 181 (2010) 259, in `scipy.stats.sobol_indices`.
    """
    acts = np.any(f_ab != f_a, axis=1)
    acting = [name for name, acting in zip(names, acts, strict=True) if acting]
    none = Interval(0.0, 0.0, 0.0, confidence)
    found = {name: SobolIndex(name, none, none) for name in names}
    if len(acting) == 1:
        # All there is to explain is its own.
        whole = Interval(1.0, 1.0, 1.0, confidence)
        found[acting[0]] = SobolIndex(acting[0], whole, whole)
    elif acting:
        estimate = _indices(f_a, f_b, f_ab[acts])
        spread = bootstrap(
            (np.arange(len(f_a)),),
            lambda rows: _indices(f_a[rows], f_b[rows], f_ab[acts][:, rows]),
            n_resamples=resamples,
            confidence_level=confidence,
            method="percentile",
            vectorized=False,
            rng=np.random.default_rng(seed),
        ).confidence_interval
        ends = np.stack([estimate, spread.low, spread.high], axis=-1)
        for name, first, total in zip(acting, *ends, strict=True):
            found[name] = SobolIndex(name, _interval(first, confidence), _interval(total, confidence))
    return tuple(found[name] for name in names)


def _interval(ends: Array, confidence: float) -> Interval:
    estimate, low, high = (float(end) for end in ends)
    return Interval(estimate, low, high, confidence)


def _indices(f_a: Array, f_b: Array, f_ab: Array) -> Array:
    """First and total indices as rows, shape (2, g)."""
    output: dict[Literal["f_A", "f_B", "f_AB"], Array] = {
        "f_A": f_a[None],
        "f_B": f_b[None],
        "f_AB": f_ab[:, None],
    }
    found = sobol_indices(func=output, n=len(f_a))
    result: Array = np.stack([found.first_order, found.total_order])
    return result

"""Is the share of good parts high enough? Acceptance sampling with exact binomial bounds.

A search compares many sizes of the same sources, so it judges the same rows at each of them (common random
numbers): what differs is then the size alone. What it finds was chosen by those rows, which therefore cannot
vouch for it: a fresh sample does, with rows that nothing was chosen by.

All rows here are independent, not Sobol points as in a study, because only of independent rows is the number
of good ones binomial and the interval of Clopper and Pearson exact.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Generator, Sequence
from concurrent.futures import Executor
from contextlib import closing
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np
from scipy.special import bdtr

from gomboc_cad.body.sphere import Array, BoolArray
from gomboc_cad.errors import StudyError
from gomboc_cad.tolerance.judging import RowArray, judged
from gomboc_cad.tolerance.model import StudyModel
from gomboc_cad.tolerance.requirement import Requirement
from gomboc_cad.tolerance.running import Job, run_batches
from gomboc_cad.tolerance.sampling import BATCH_ROWS
from gomboc_cad.tolerance.statistics import Interval, clopper_pearson
from gomboc_cad.tolerance.variants import Outcomes


@dataclass(frozen=True)
class Target:
    """What share of the parts has to be good.

    Attributes:
        requirement: When a part is good.
        good_share: That share, as 0.95.
        confidence: Of the interval whose lower end has to reach it.

    Raises:
        StudyError: If the share or the confidence is not between 0 and 1.
    """

    requirement: Requirement
    good_share: float = 0.95
    confidence: float = 0.95

    def __post_init__(self) -> None:
        """Check the figures."""
        for what, value in (("yield target", self.good_share), ("confidence", self.confidence)):
            if not 0.0 < value < 1.0:
                raise StudyError(f"The {what} must be above 0 and below 1, not {value!r}.")

    @property
    def least_rows(self) -> int:
        """As many rows without a failure does it take to show the target."""
        return math.ceil(math.log(0.5 * (1.0 - self.confidence)) / math.log(self.good_share))

    def allowed_failures(self, rows: int) -> int:
        """Acceptance number: so many of the rows may fail, and the lower bound still reaches the target.

        The bound of Clopper and Pearson does so when that many failures or fewer would have at most half of
        1 − confidence as their probability if the share of good parts were just the target.

        Raises:
            StudyError: If even without a failure the rows are too few.
        """
        if rows < self.least_rows:
            raise StudyError(
                f"{rows} variants cannot show that {100.0 * self.good_share:g} % are good; judge at least "
                f"{self.least_rows}."
            )
        tail = bdtr(np.arange(rows), rows, 1.0 - self.good_share)
        return int(np.searchsorted(tail, 0.5 * (1.0 - self.confidence), side="right")) - 1


@dataclass(frozen=True)
class Rows:
    """Independent random rows, the same whenever they are asked for.

    Attributes:
        count: How many.
        seed: Seed of all rows of one question.
        stream: Which of them; rows of different streams have nothing in common.
    """

    count: int
    seed: int = 0
    stream: int = 0

    def of(self, model: StudyModel) -> IndependentSample:
        """The rows, as wide as the model takes them."""
        return IndependentSample(self, dimensions(model))


@dataclass(frozen=True)
class IndependentSample:
    """Rows in batches; the last batch is whole too, and has rows that do not count.

    Attributes:
        rows: The rows.
        dimensions: Columns.
    """

    rows: Rows
    dimensions: int

    @property
    def batches(self) -> int:
        """Number of batches."""
        return -(-self.rows.count // BATCH_ROWS)

    def batch(self, index: int) -> Array:
        """The quantiles of one batch, shape (BATCH_ROWS, dimensions)."""
        generator = np.random.default_rng((self.rows.seed, self.rows.stream, index))
        # The generator may give 0, which is no quantile.
        return np.maximum(generator.random((BATCH_ROWS, self.dimensions)), 2.0**-54)


@dataclass(frozen=True)
class Effort:
    """How many variants an answer may cost.

    Attributes:
        search: Rows that every candidate is judged on.
        check: Rows that confirm what was found; more of them than of the others, or good answers fail.
        seed: Seed of all.
    """

    search: int = 4 * BATCH_ROWS
    check: int = 16 * BATCH_ROWS
    seed: int = 0

    @property
    def search_rows(self) -> Rows:
        """The rows of the search."""
        return Rows(self.search, self.seed)

    @property
    def check_rows(self) -> Rows:
        """Rows that no search has seen, the first of several streams."""
        return Rows(self.check, self.seed, stream=1)


def as_designed(model: StudyModel) -> StudyModel:
    """The same with every source switched off."""
    return model.scaled({source.name: 0.0 for source in model.sources})


def design_outcome(model: StudyModel) -> Outcomes:
    """Judge the design as drawn, in one row."""
    _, outcome = judged(as_designed(model), np.full((1, dimensions(model)), 0.5))
    return outcome


def require_good_design(model: StudyModel, requirement: Requirement) -> Outcomes:
    """Judge the design as drawn, in one row.

    Raises:
        StudyError: If it is not good, so that no tolerance can make it so.
    """
    outcome = design_outcome(model)
    if not requirement.met(outcome)[0]:
        raise StudyError(
            "The design does not meet the requirement even when it is made perfectly (S-margin "
            f"{1e3 * float(outcome.s_margin_mm[0]):.4g} µm, dead zone "
            f"{float(requirement.dead_zone_deg(outcome)[0]):.3g} degrees); change one of the two."
        )
    return outcome


def dimensions(model: StudyModel) -> int:
    """Number of quantiles that a variant of the model takes."""
    return sum(source.dimensions for source in model.sources)


def accepted(model: StudyModel, target: Target, rows: Rows, executor: Executor | None = None) -> bool:
    """Whether the lower bound of the yield reaches the target on these rows; stops as soon as it cannot."""
    allowed = target.allowed_failures(rows.count)
    failed = 0
    with closing(_good_flags(model, target.requirement, rows, executor)) as batches:
        for good in batches:
            failed += int(np.count_nonzero(~good))
            if failed > allowed:
                return False
    return True


def good_parts(
    model: StudyModel, requirement: Requirement, rows: Rows, executor: Executor | None = None
) -> int:
    """How many of the rows are good."""
    return sum(int(np.count_nonzero(good)) for good in _good_flags(model, requirement, rows, executor))


def _good_flags(
    model: StudyModel, requirement: Requirement, rows: Rows, executor: Executor | None
) -> Generator[BoolArray]:
    """Which rows are good, batch by batch."""
    left = rows.count
    with closing(run_batches(Job(model, rows.of(model), requirement), executor)) as batches:
        for batch in batches:
            yield good_rows(batch[:left], requirement)
            left -= len(batch)


def good_rows(rows: RowArray, requirement: Requirement) -> BoolArray:
    """Which of the rows that were kept of variants are good, shape (n,)."""
    columns = (rows[name] for name in ("verdict", "tilt_deg", "s_margin_mm", "dead_zone_deg"))
    return requirement.accepts(*columns)


@dataclass(frozen=True)
class Checked:
    """A proposed value, checked by fresh rows.

    Attributes:
        value: The value, such as a factor or a length.
        met: Whether the lower end of the interval reaches the target.
        good: Share of good parts among the fresh rows, with its interval.
        rows: The rows.
    """

    value: float
    met: bool
    good: Interval
    rows: Rows

    @property
    def text(self) -> str:
        """The share and its interval in words."""
        good = self.good
        estimate, low, high, sure = (100.0 * v for v in (good.estimate, good.low, good.high, good.confidence))
        return (
            f"{estimate:.4g} % of {self.rows.count} variants are good, {low:.4g} to {high:.4g} % with "
            f"{sure:.4g} % confidence"
        )

    def document(self) -> dict[str, Any]:
        """The check as the study gives it."""
        return {"met": self.met, "variants": self.rows.count, "seed": self.rows.seed, **asdict(self.good)}


def first_confirmed(
    values: Sequence[float],
    made: Callable[[float], StudyModel],
    target: Target,
    rows: Rows,
    executor: Executor | None = None,
) -> Checked:
    """The first of several values that meets the target on fresh rows, or else the last, which does not.

    Each value has rows of its own. So that several tries do not make a false answer more likely, the chance
    of error, 1 − confidence, is divided among them.

    Args:
        values: What to try, the most wanted first.
        made: The model with such a value.
        target: What has to be met.
        rows: The first rows; the others are those of the streams that follow.
        executor: Where to run; here if not given.
    """
    confidence = 1.0 - (1.0 - target.confidence) / len(values)
    for attempt, value in enumerate(values):
        fresh = replace(rows, stream=rows.stream + attempt)
        good = good_parts(made(value), target.requirement, fresh, executor)
        interval = clopper_pearson(good, fresh.count, confidence)
        checked = Checked(value, interval.low >= target.good_share, interval, fresh)
        if checked.met:
            break
    return checked


def largest_accepted(
    accepts: Callable[[float], bool], start: float, least: float, most: float, accuracy: float
) -> float | None:
    """Find the largest value that is accepted, if all below one that is accepted are accepted too.

    From the start by doubling or halving to a bracket, then by bisection in the logarithm.

    Args:
        accepts: Whether a value is.
        start: First value, above 0.
        least: None is returned if not even this is accepted.
        most: Returned if it is accepted.
        accuracy: Relative accuracy of the value.
    """
    low = high = start
    if accepts(start):
        while accepts(high := min(2.0 * low, most)):
            if high == most:
                return most
            low = high
    else:
        while not accepts(low := max(0.5 * high, least)):
            if low == least:
                return None
            high = low
    return refined(accepts, low, high, accuracy)


def refined(accepts: Callable[[float], bool], good: float, bad: float, accuracy: float) -> float:
    """Bisect the logarithm between a value that is accepted and one that is not, and give one that is.

    Args:
        accepts: Whether a value is.
        good: A positive value that is accepted.
        bad: A positive value that is not, on either side.
        accuracy: Relative accuracy.
    """
    while abs(math.log(good / bad)) > accuracy:
        middle = math.sqrt(good * bad)
        good, bad = (middle, bad) if accepts(middle) else (good, middle)
    return good

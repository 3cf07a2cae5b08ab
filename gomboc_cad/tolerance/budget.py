"""The budget: how much each source of error may have so that enough parts are good.

Sources differ in kind, so they are made comparable by what each of them may have when it is alone: its lone
limit, the size at which it meets the target by itself, all others being zero. The share of its lone limit
that a source uses says how much of the tolerance it takes up, whatever its unit.

The budget gives every source the same share where it can. If the target is missed, those that use more than
the common share are tightened to it and the others stay as they are; if it is met with room to spare, those
that use less may grow up to it and the others stay. So nothing is tightened that does not matter, and what
dominates is tightened first. The share is found by bisection on the same rows throughout, and what is found
is then confirmed by fresh ones.
"""

from __future__ import annotations

import math
from concurrent.futures import Executor
from dataclasses import dataclass, replace
from typing import Any

from gomboc_cad.progress import Progress, silent
from gomboc_cad.tolerance.acceptance import (
    Checked,
    Effort,
    Target,
    accepted,
    first_confirmed,
    largest_accepted,
    require_good_design,
)
from gomboc_cad.tolerance.model import Source, StudyModel
from gomboc_cad.tolerance.sampling import BATCH_ROWS

MOST_FACTOR = 8.0
"""No source is allowed more than so many times its size: what holds for small errors ends somewhere."""

_LEAST_FACTOR = 2.0**-20
_MOST_SHARE = 2.0
"""More than 1, because the lone limits are found on few rows and lie on the safe side."""

_EFFORT = Effort()
_LONE_ACCURACY, _ACCURACY = 0.1, 0.02
_BACKED_OFF = (1.0, 0.95, 0.9, 0.85)


@dataclass(frozen=True)
class Allowance:
    """What one source may have.

    Attributes:
        source: The source, with its size as made now.
        allowed: Size that it may have together with what the others are allowed.
        alone: Largest size that meets the target with all others at zero, to about ten percent; the limit of
            the search, 8 times the size, where that still meets it.
    """

    source: Source
    allowed: float
    alone: float

    @property
    def factor(self) -> float:
        """What is allowed over what is."""
        return self.allowed / self.source.size if self.source.size > 0.0 else 1.0

    @property
    def use(self) -> float:
        """Share of its lone limit that the source takes up; above 1 it is too large even alone."""
        if self.source.size == 0.0:
            return 0.0
        return self.source.size / self.alone if self.alone > 0.0 else math.inf

    @property
    def attainable(self) -> bool | None:
        """Whether the best shops reach what is allowed; None where nothing is known of them."""
        return None if self.source.best is None else self.allowed >= self.source.best

    def document(self) -> dict[str, Any]:
        """The allowance as the study gives it."""
        return {
            "source": self.source.name,
            "text": self.source.text,
            "unit": self.source.unit,
            "size": self.source.size,
            "allowed": self.allowed,
            "alone": self.alone,
            "attainable": self.attainable,
        }


@dataclass(frozen=True)
class Budget:
    """How much every source may have.

    Attributes:
        target: What has to be met.
        allowances: One for each source, those that use most of their lone limit first.
        as_made: What fresh rows say of the sources as they are; its value is the factor 1.
        checked: What fresh rows say of the budget; its value is the common share of the lone limits, or the
            factor 1 if all is left as it is.
    """

    target: Target
    allowances: tuple[Allowance, ...]
    as_made: Checked
    checked: Checked

    @property
    def met(self) -> bool:
        """Whether fresh rows meet the target with every source at what it is allowed."""
        return self.checked.met

    @property
    def sentence(self) -> str:
        """What the user is told."""
        if not self.met:
            return f"No budget was found that surely meets the target: {self.checked.text}."
        tightened = [a for a in self.allowances if a.factor < 1.0]
        if not tightened:
            return f"Every source may stay as it is, or grow to what is allowed: {self.checked.text}."
        limits = ", ".join(f"{a.source.name} {a.allowed:.3g} {a.source.unit}" for a in tightened)
        beyond = [a.source.name for a in tightened if a.attainable is False]
        warning = f" Beyond what the process reaches at best: {', '.join(beyond)}." if beyond else ""
        return f"Tightened to {limits}, all else as it is: {self.checked.text}.{warning}"

    def document(self) -> dict[str, Any]:
        """The budget as the study gives it."""
        return {
            "met": self.met,
            "sentence": self.sentence,
            "as_made": self.as_made.document(),
            "checked": self.checked.document(),
            "sources": [allowance.document() for allowance in self.allowances],
        }


def lone_factors(
    model: StudyModel, target: Target, effort: Effort, executor: Executor | None = None
) -> dict[str, float]:
    """For each source the largest factor on its size that meets the target with all others at zero.

    To about ten percent, and at most MOST_FACTOR, which sources without a size get too.

    Raises:
        StudyError: If the design itself is not good.
    """
    require_good_design(model, target.requirement)
    rows = replace(effort.search_rows, count=max(BATCH_ROWS, target.least_rows))
    off = {source.name: 0.0 for source in model.sources}

    def lone_factor(source: Source) -> float:
        if source.size == 0.0:
            return MOST_FACTOR

        def accepts(factor: float) -> bool:
            return accepted(model.scaled({**off, source.name: factor}), target, rows, executor)

        return largest_accepted(accepts, 1.0, _LEAST_FACTOR, MOST_FACTOR, _LONE_ACCURACY) or 0.0

    return {source.name: lone_factor(source) for source in model.sources}


def solve_budget(
    model: StudyModel,
    target: Target,
    effort: Effort = _EFFORT,
    *,
    executor: Executor | None = None,
    progress: Progress = silent,
) -> Budget:
    """Find what every source may have, and confirm it with fresh rows.

    Args:
        model: The study.
        target: What has to be met.
        effort: How many variants it may cost.
        executor: Where to run; here if not given.
        progress: Called with the name of each stage as it begins.

    Raises:
        StudyError: If the design itself is not good, or the rows are too few to show the target.
    """
    progress("finding what each source may have alone")
    lone = lone_factors(model, target, effort, executor)
    fresh = effort.check_rows
    as_made = first_confirmed([1.0], lambda _: model, target, fresh, executor)
    # Sources above the common share are tightened to it, or those below it may grow to it.
    bound = max if as_made.met else min

    def factors(share: float) -> dict[str, float]:
        return {name: bound(1.0, min(share * limit, MOST_FACTOR)) for name, limit in lone.items()}

    def at(share: float) -> StudyModel:
        return model.scaled(factors(share))

    def accepts(share: float) -> bool:
        return accepted(at(share), target, effort.search_rows, executor)

    progress("sharing the tolerance among the sources")
    share = largest_accepted(accepts, 0.5, _LEAST_FACTOR, _MOST_SHARE, _ACCURACY)
    checked, allowed = as_made, dict.fromkeys(lone, 1.0)
    if share is not None:
        found = first_confirmed(
            [share * part for part in _BACKED_OFF], at, target, replace(fresh, stream=2), executor
        )
        if found.met or not as_made.met:
            checked, allowed = found, factors(found.value)
    allowances = sorted(
        (
            Allowance(source, source.size * allowed[source.name], source.size * lone[source.name])
            for source in model.sources
        ),
        key=lambda allowance: -allowance.use,
    )
    return Budget(target, tuple(allowances), as_made, checked)

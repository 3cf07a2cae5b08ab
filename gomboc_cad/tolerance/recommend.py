"""What to change so that enough parts are good: one thing at a time, each proposal confirmed by fresh rows.

Three kinds of change are tried. The COM may be lowered towards the rest, which makes the rest stiffer; on the
way the S-margin may fall before it grows, so the distances are scanned and the first that meets the target is
refined. One source may be tightened while all others stay as they are. Or another process makes the same
design.

They are ordered by what they touch: first the design alone, then one tolerance, the one that has to be
tightened least coming first, then the whole process, the one with the highest sure yield coming first.
A tolerance that even the best shops do not reach is said to be so.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace
from typing import Any, Literal

from gomboc_cad.equilibria.records import as_vector
from gomboc_cad.progress import Progress, silent
from gomboc_cad.tolerance.acceptance import (
    Checked,
    Effort,
    Target,
    accepted,
    design_outcome,
    first_confirmed,
    largest_accepted,
    refined,
)
from gomboc_cad.tolerance.model import Source, StudyModel

Change = Literal["lower_com", "tighten", "process"]

_EFFORT = Effort()
_FIRST_LOWERING, _MOST_LOWERING = 1e-3, 0.2
"""Of the scan, in units of the nominal radius."""

_SCAN_RATIO = 1.4
"""A window of lowerings that is narrower may be missed."""

_LEAST_FACTOR = 2.0**-20
_ACCURACY = 0.02
_FARTHER = (1.0, 1.05, 1.1, 1.2)
_TIGHTER = (1.0, 0.95, 0.9, 0.8)


@dataclass(frozen=True)
class Proposal:
    """One change and what becomes of the yield.

    Attributes:
        change: `lower_com`, `tighten` a source, or another `process`.
        subject: The source or the process; `com` for the centre of mass.
        now: Size of what is changed as it is; 0 where that means nothing.
        proposed: Its proposed size.
        unit: Unit of both; empty for a process.
        checked: What fresh rows say.
        best: Size of the source that the best shops reach; None where nothing is known of them.
    """

    change: Change
    subject: str
    now: float
    proposed: float
    unit: str
    checked: Checked
    best: float | None = None

    @property
    def met(self) -> bool:
        """Whether the target is met."""
        return self.checked.met

    @property
    def attainable(self) -> bool | None:
        """Whether the best shops reach the proposed size; None where nothing is known of them."""
        return None if self.best is None else self.proposed >= self.best

    @property
    def sentence(self) -> str:
        """What the user is told."""
        if self.change == "lower_com":
            what = f"Lowering the centre of mass by {self.proposed:.3g} mm towards the rest"
        elif self.change == "tighten":
            what = f"Tightening {self.subject} from {self.now:.3g} to {self.proposed:.3g} {self.unit}"
            if self.met and self.attainable is False:
                what += f" (the process reaches {self.best:.3g} at best)"
        else:
            what = f"Making it by {self.subject}"
        return f"{what}: {self.checked.text}."

    def document(self) -> dict[str, Any]:
        """The proposal as the study gives it."""
        return {
            "change": self.change,
            "subject": self.subject,
            "now": self.now,
            "proposed": self.proposed,
            "unit": self.unit,
            "attainable": self.attainable,
            "sentence": self.sentence,
            "checked": self.checked.document(),
        }


@dataclass(frozen=True)
class Recommendation:
    """What meets the target.

    Attributes:
        target: The target.
        as_made: What fresh rows say of the study as it is.
        proposals: Changes that meet the target, each alone, in the order of preference; empty if nothing has
            to be changed, or nothing helps.
        fell_short: Changes that were tried and do not meet it, taken as far as they go, the best first.
    """

    target: Target
    as_made: Checked
    proposals: tuple[Proposal, ...]
    fell_short: tuple[Proposal, ...]

    @property
    def sentence(self) -> str:
        """What the user is told first."""
        if self.as_made.met:
            return f"Nothing has to be changed: {self.as_made.text}."
        if self.proposals:
            return self.proposals[0].sentence
        best = f" the best is this. {self.fell_short[0].sentence}" if self.fell_short else ""
        return f"No single change that was tried meets the target;{best}"

    def document(self) -> dict[str, Any]:
        """The recommendation as the study gives it."""
        return {
            "sentence": self.sentence,
            "as_made": self.as_made.document(),
            "proposals": [proposal.document() for proposal in self.proposals],
            "fell_short": [proposal.document() for proposal in self.fell_short],
        }


def recommend(
    model: StudyModel,
    target: Target,
    effort: Effort = _EFFORT,
    *,
    as_made: Checked | None = None,
    processes: Mapping[str, StudyModel] | None = None,
    most_lowering_mm: float | None = None,
    executor: Executor | None = None,
    progress: Progress = silent,
) -> Recommendation:
    """Find what to change so that the target is met, each change by itself and confirmed by fresh rows.

    Args:
        model: The study.
        target: What has to be met.
        effort: How many variants each candidate may cost.
        as_made: What `solve_budget` found with the same target and effort of the study as it is; judged here
            if not given.
        processes: The same design made by other processes, by name.
        most_lowering_mm: How far the COM may be lowered; a fifth of the nominal radius if not given.
        executor: Where to run; here if not given.
        progress: Called with the name of each stage as it begins.

    Raises:
        StudyError: If the rows are too few to show the target.
    """
    if as_made is None:
        as_made = first_confirmed([1.0], lambda _: model, target, effort.check_rows, executor)
    if as_made.met:
        return Recommendation(target, as_made, (), ())
    trial = _Trial(target, effort, executor)
    reach_mm = _MOST_LOWERING * model.nominal.body.radius_mm if most_lowering_mm is None else most_lowering_mm
    progress("lowering the centre of mass")
    tried = [trial.lowered_com(model, reach_mm)]
    for source in model.sources:
        if source.size > 0.0:
            progress(f"tightening {source.name}")
            tried.append(trial.tightened(model, source))
    for name, other in (processes or {}).items():
        progress(f"making it by {name}")
        tried.append(trial.made_by(name, other))
    met = sorted((p for p in tried if p.met), key=_preference)
    short = sorted((p for p in tried if not p.met), key=lambda p: -p.checked.good.estimate)
    return Recommendation(target, as_made, tuple(met), tuple(short))


def _preference(proposal: Proposal) -> tuple[int, float]:
    """What comes first is smaller."""
    if proposal.change == "lower_com":
        return 0, proposal.proposed
    if proposal.change == "tighten":
        return 1, -proposal.proposed / proposal.now
    return 2, -proposal.checked.good.low


@dataclass(frozen=True)
class _Trial:
    """How a change is tried.

    Attributes:
        target: What has to be met.
        effort: How many variants it may cost.
        executor: Where to run.
    """

    target: Target
    effort: Effort
    executor: Executor | None

    def lowered_com(self, model: StudyModel, reach_mm: float) -> Proposal:
        """The smallest lowering of the COM towards the rest that meets the target."""
        down = design_outcome(model).rest_direction[0]

        def at(distance_mm: float) -> StudyModel:
            return model.with_com_shift(as_vector(distance_mm * down))

        def accepts(distance_mm: float) -> bool:
            return accepted(at(distance_mm), self.target, self.effort.search_rows, self.executor)

        steps = _scan(_FIRST_LOWERING * model.nominal.body.radius_mm, reach_mm)
        found = next((step for step in steps if accepts(step)), None)
        if found is None:
            checked = self._as_far_as_it_goes(at(reach_mm), reach_mm)
        else:
            smallest = refined(accepts, found, found / _SCAN_RATIO, _ACCURACY)
            checked = self._confirmed([part * smallest for part in _FARTHER], at)
        return Proposal("lower_com", "com", 0.0, checked.value, "mm", checked)

    def tightened(self, model: StudyModel, source: Source) -> Proposal:
        """The largest size of one source that meets the target, all others staying as they are."""

        def at(factor: float) -> StudyModel:
            return model.scaled({source.name: factor})

        def accepts(factor: float) -> bool:
            return accepted(at(factor), self.target, self.effort.search_rows, self.executor)

        factor = None
        if accepts(0.0):
            factor = largest_accepted(accepts, 0.5, _LEAST_FACTOR, 1.0, _ACCURACY)
        if factor is None:
            checked = self._as_far_as_it_goes(at(0.0), 0.0)
        else:
            checked = self._confirmed([part * factor for part in _TIGHTER], at)
        size = source.size * checked.value
        return Proposal("tighten", source.name, source.size, size, source.unit, checked, source.best)

    def made_by(self, name: str, model: StudyModel) -> Proposal:
        """Another process; fresh rows are spent only on one that may do."""
        if accepted(model, self.target, self.effort.search_rows, self.executor):
            checked = self._confirmed([1.0], lambda _: model)
        else:
            checked = self._as_far_as_it_goes(model, 1.0)
        return Proposal("process", name, 0.0, 0.0, "", checked)

    def _confirmed(self, values: Sequence[float], made: Callable[[float], StudyModel]) -> Checked:
        # Stream 1 has shown that something must be changed.
        rows = replace(self.effort.check_rows, stream=2)
        return first_confirmed(values, made, self.target, rows, self.executor)

    def _as_far_as_it_goes(self, model: StudyModel, value: float) -> Checked:
        """What is reached where the search has found nothing, on its own rows."""
        rows = self.effort.search_rows
        return replace(first_confirmed([value], lambda _: model, self.target, rows, self.executor), met=False)


def _scan(first_mm: float, reach_mm: float) -> Iterator[float]:
    """Distances that grow by a fixed ratio up to the reach."""
    distance = first_mm
    while distance < reach_mm:
        yield distance
        distance *= _SCAN_RATIO
    yield reach_mm

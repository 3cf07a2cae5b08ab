"""One design, made by several processes, in one table."""

from __future__ import annotations

from collections.abc import Mapping
from concurrent.futures import Executor
from dataclasses import asdict, dataclass
from typing import Any

from gomboc_cad.progress import Progress, silent
from gomboc_cad.tolerance.acceptance import Effort, Target, design_outcome
from gomboc_cad.tolerance.budget import lone_factors
from gomboc_cad.tolerance.model import StudyModel
from gomboc_cad.tolerance.statistics import Yield
from gomboc_cad.tolerance.study import StudyResult, run_study

_VARIANTS = 4096


@dataclass(frozen=True, eq=False)
class ProcessRow:
    """What one process makes of the design.

    Attributes:
        process: Its name.
        result: The study.
        dominating: The source that uses most of what it may have alone; None if the design itself is not
            good, or it was not asked for.
        use: How much of that it uses; above 1 it makes too many bad parts even without the others. At least
            1/8, which is the limit of the search; None if no size of it will do.
    """

    process: str
    result: StudyResult
    dominating: str | None
    use: float | None

    def document(self) -> dict[str, Any]:
        """The row as the study gives it."""
        result = self.result
        return {
            "process": self.process,
            "variants": result.yield_tilt.variants,
            "yield_monostable": _yield(result.yield_monostable),
            "yield_tilt": _yield(result.yield_tilt),
            "undecided": result.yield_monostable.undecided,
            "tilt_deg": None if result.tilt_deg is None else asdict(result.tilt_deg),
            "dead_zone_deg": None if result.dead_zone_deg is None else asdict(result.dead_zone_deg),
            "s_margin_mm": None if result.s_margin_mm is None else asdict(result.s_margin_mm),
            "dominating": self.dominating,
            "use": self.use,
        }


def _yield(found: Yield) -> dict[str, Any]:
    """The interval if no undecided variant is good, and its upper end if all are."""
    return {**asdict(found.interval), "high_if_undecided_pass": found.possible.high}


def compare_processes(
    models: Mapping[str, StudyModel],
    target: Target,
    *,
    variants: int = _VARIANTS,
    seed: int = 0,
    executor: Executor | None = None,
    dominating: bool = True,
    progress: Progress = silent,
) -> tuple[ProcessRow, ...]:
    """Study the same design as several processes make it, the highest sure yield first.

    Args:
        models: The design with the errors of each process, by its name.
        target: What a good part does, and which share has to be good for a source to be within its limit.
        variants: How many of each.
        seed: Of the samples.
        executor: Where to run; here if not given.
        dominating: Whether to look for the source that decides, which takes far longer than the study.
        progress: Called with the name of each process as it begins.
    """
    rows = []
    for name, model in models.items():
        progress(f"making it by {name}")
        result = run_study(model, variants, seed, requirement=target.requirement, executor=executor)
        source, use = None, None
        if dominating:
            source, use = _dominating(model, target, Effort(seed=seed), executor)
        rows.append(ProcessRow(name, result, source, use))
    return tuple(sorted(rows, key=lambda row: -row.result.yield_tilt.interval.low))


def _dominating(
    model: StudyModel, target: Target, effort: Effort, executor: Executor | None
) -> tuple[str | None, float | None]:
    """The source that uses most of its lone limit, and how much."""
    if not model.sources or not target.requirement.met(design_outcome(model))[0]:
        return None, None
    lone = lone_factors(model, target, effort, executor)
    name = min(lone, key=lambda source: lone[source])
    return name, 1.0 / lone[name] if lone[name] > 0.0 else None

"""Some variants of a study judged a second time, as geometry: the two judges have to agree.

Rows are drawn by a seed of their own, so a cross-check can be repeated. Each is built and comes to rest on a
mesh, on finer points while that leaves anything open. What still differs is listed, with the reason.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, Literal, NamedTuple

import numpy as np

from gomboc_cad.body.sphere import Array, IntArray
from gomboc_cad.equilibria.records import CensusVerdict, Vector, as_vector
from gomboc_cad.reproducible import one_blas_thread
from gomboc_cad.tolerance.judging import judged
from gomboc_cad.tolerance.model import StudyModel
from gomboc_cad.tolerance.rebuilt import Rebuilt, nominal_rest, rebuild
from gomboc_cad.tolerance.variants import Nominal, Variants


class Resolution(NamedTuple):
    """How finely a part is built.

    Attributes:
        sag: Sag of its points over R₀, where it could balance.
        max_points: Where more would be needed, the sag is larger.
    """

    sag: float
    max_points: int


RESOLUTIONS = (Resolution(2e-5, 100_000), Resolution(2e-7, 300_000))
"""The coarser first: barriers of 1.5 and 0.015 µm on a body of 100 mm."""

Finding = Literal["agreed", "undecided", "disagreed"]
Spread = Callable[..., Iterable[Any]]
"""Like the built-in `map`, such as the `map` of an executor."""

_VERDICTS: tuple[CensusVerdict, ...] = ("monostable", "multistable", "undecided")

_SETTLED_DEG = 1e-3
"""Both judges find the bottom of a smooth rest to far better than this, unless it is all but neutral."""


@dataclass(frozen=True)
class FastOutcome:
    """What the fast judge says of a variant.

    Attributes:
        verdict: Whether it has one rest.
        rest_direction: The deepest one known.
        tilt_deg: Angle between it and the rest of the nominal.
        soft_stiffness_mm: The smaller stiffness there.
    """

    verdict: CensusVerdict
    rest_direction: Vector
    tilt_deg: float
    soft_stiffness_mm: float


@dataclass(frozen=True)
class ComparedRow:
    """A variant judged twice.

    Attributes:
        row: Its number in the study.
        finding: `agreed`, `undecided` where one of the judges does not know, or `disagreed`.
        reason: One sentence for it; empty where they agreed.
        fast: What the fast judge says.
        rebuilt: What the geometry says.
        difference_deg: Angle between the two rests; NaN where a judge knows none.
    """

    row: int
    finding: Finding
    reason: str
    fast: FastOutcome
    rebuilt: Rebuilt
    difference_deg: float


@dataclass(frozen=True)
class CrossCheck:
    """All variants that were judged twice.

    Attributes:
        rows: One record each.
    """

    rows: tuple[ComparedRow, ...]

    @property
    def agreed(self) -> tuple[ComparedRow, ...]:
        """Where both judges say the same."""
        return self._found("agreed")

    @property
    def undecided(self) -> tuple[ComparedRow, ...]:
        """Where one of them does not know."""
        return self._found("undecided")

    @property
    def disagreed(self) -> tuple[ComparedRow, ...]:
        """Where they contradict each other."""
        return self._found("disagreed")

    def _found(self, finding: Finding) -> tuple[ComparedRow, ...]:
        return tuple(row for row in self.rows if row.finding == finding)

    def document(self) -> dict[str, Any]:
        """For JSON."""
        settled = [row.difference_deg for row in self.agreed if row.rebuilt.settled]
        return {
            "rows": len(self.rows),
            "agreed": len(self.agreed),
            "largest_barrier_um": 1e3 * max((row.rebuilt.barrier_mm for row in self.agreed), default=0.0),
            "largest_difference_deg": max(settled, default=None),
            "undecided": [_entry(row) for row in self.undecided],
            "disagreed": [_entry(row) for row in self.disagreed],
        }


def checked_rows(variants: int, count: int, seed: int) -> IntArray:
    """Numbers of the variants of a study that are judged twice, rising, the same for the same seed."""
    generator = np.random.default_rng(seed)
    return np.sort(generator.choice(variants, size=min(count, variants), replace=False)).astype(np.int64)


def cross_check(
    model: StudyModel,
    quantiles: Array,
    rows: Sequence[int] | IntArray,
    *,
    resolutions: Sequence[Resolution] = RESOLUTIONS,
    spread: Spread = map,
) -> CrossCheck:
    """Judge variants by the model and as geometry.

    Args:
        model: The subject of the study.
        quantiles: Rows of quantiles inside (0, 1), shape (n, D).
        rows: Their numbers in the study, for the record.
        resolutions: How finely the parts are built; the next one is taken while the judges do not agree.
        spread: Where to build them: `map`, or the `map` of an executor.

    Raises:
        GeometryError: If the parting plane or a hole does not cut a part as it should.
    """
    variants, outcomes = judged(model, quantiles)
    fast = [
        FastOutcome(
            _VERDICTS[int(outcomes.verdict[k])],
            as_vector(outcomes.rest_direction[k]),
            float(outcomes.tilt_deg[k]),
            float(outcomes.stiffness_mm[k, 0]),
        )
        for k in range(len(variants))
    ]
    single = [variants.rows(slice(k, k + 1)) for k in range(len(variants))]
    numbers = [int(row) for row in rows]
    down = nominal_rest(model.nominal, resolutions[0].sag * model.nominal.body.radius_mm)
    compare = partial(_compared, model.nominal, down, tuple(resolutions))
    return CrossCheck(tuple(spread(compare, numbers, single, fast)))


def _compared(
    nominal: Nominal,
    down: Vector,
    resolutions: tuple[Resolution, ...],
    row: int,
    variant: Variants,
    fast: FastOutcome,
) -> ComparedRow:
    """Build a variant, more finely while that may settle a difference."""
    radius = nominal.body.radius_mm
    for sag, max_points in resolutions:
        with one_blas_thread():
            rebuilt = rebuild(nominal, variant, 0, sag * radius, down, max_points)
        compared = _judged_twice(row, fast, rebuilt, radius)
        known = fast.verdict == "undecided" and compared.rebuilt.verdict != "undecided"
        if compared.finding == "agreed" or known:
            break
    return compared


def _judged_twice(row: int, fast: FastOutcome, rebuilt: Rebuilt, radius_mm: float) -> ComparedRow:
    difference = _difference_deg(fast, rebuilt)
    finding: Finding = "agreed"
    reason = ""
    if "undecided" in (fast.verdict, rebuilt.verdict):
        finding = "undecided"
        reason = f"The fast judge says {fast.verdict}; rebuilt it is {rebuilt.verdict}: {rebuilt.reason}"
    elif fast.verdict != rebuilt.verdict:
        finding = "disagreed"
        reason = _contradiction(fast, rebuilt)
    elif fast.verdict == "monostable" and not difference <= _tolerance_deg(fast, rebuilt, radius_mm):
        finding = "disagreed"
        reason = f"Both find one rest, but {difference:.3g}° from each other."
    return ComparedRow(row, finding, reason, fast, rebuilt, difference)


def _contradiction(fast: FastOutcome, rebuilt: Rebuilt) -> str:
    if fast.verdict == "multistable":
        return (
            "The fast judge finds several rests; rebuilt there is one for every barrier above "
            f"{1e3 * rebuilt.barrier_mm:.3g} µm, so the others are shallower than that or not there."
        )
    return f"The fast judge finds one rest; rebuilt there are {rebuilt.stable}: {rebuilt.reason}"


def _difference_deg(fast: FastOutcome, rebuilt: Rebuilt) -> float:
    if rebuilt.rest_direction is None:
        return float("nan")
    one, other = np.array(fast.rest_direction), np.array(rebuilt.rest_direction)
    return float(np.degrees(2.0 * np.arctan2(np.linalg.norm(one - other), np.linalg.norm(one + other))))


def _tolerance_deg(fast: FastOutcome, rebuilt: Rebuilt, radius_mm: float) -> float:
    """How far apart the two rests may be.

    On a facet of the mesh its depth s under the surface leaves the normal open by sqrt(8 s / R), and a soft
    stiffness k leaves open on which of the facets the part rests, by sqrt(2 s / k).
    """
    if rebuilt.settled:
        return _SETTLED_DEG
    open_rad = np.sqrt(8.0 * rebuilt.barrier_mm / radius_mm)
    open_rad += np.sqrt(2.0 * rebuilt.barrier_mm / fast.soft_stiffness_mm)
    return float(np.degrees(open_rad)) + _SETTLED_DEG


def _entry(compared: ComparedRow) -> dict[str, Any]:
    fast, rebuilt = compared.fast, compared.rebuilt
    return {
        "row": compared.row,
        "fast": {"verdict": fast.verdict, "tilt_deg": _finite(fast.tilt_deg)},
        "rebuilt": {
            "verdict": rebuilt.verdict,
            "stable": rebuilt.stable,
            "tilt_deg": _finite(rebuilt.tilt_deg),
            "barrier_um": 1e3 * rebuilt.barrier_mm,
        },
        "reason": compared.reason,
    }


def _finite(value: float) -> float | None:
    """JSON has no NaN."""
    return value if np.isfinite(value) else None

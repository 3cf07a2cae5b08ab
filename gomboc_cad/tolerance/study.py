"""The study: how large a share of the products is good, and which sources decide it.

A study judges Sobol points in their order, so that what is there after any number of batches is a study of
its own, and an interrupted one goes on where it was. Every number depends on model, seed and row alone, not
on the executor.
"""

from __future__ import annotations

from concurrent.futures import Executor
from contextlib import nullcontext
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from gomboc_cad import __version__
from gomboc_cad.body.sphere import Array
from gomboc_cad.progress import Progress, silent
from gomboc_cad.tolerance.fingerprint import fingerprint
from gomboc_cad.tolerance.judging import COM_ERROR, ROW, RowArray, good_rows
from gomboc_cad.tolerance.requirement import RIGHTS_ITSELF, Requirement
from gomboc_cad.tolerance.running import Cancelled, Job, never, run_batches
from gomboc_cad.tolerance.sampling import BATCH_ROWS, PickFreeze, SobolSample
from gomboc_cad.tolerance.statistics import (
    Distribution,
    SobolIndex,
    Yield,
    distribution,
    group_indices,
)
from gomboc_cad.tolerance.storage import Store
from gomboc_cad.tolerance.variants import MONOSTABLE, UNDECIDED

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from gomboc_cad.tolerance.model import Source, StudyModel


@dataclass(frozen=True, eq=False)
class StudyResult:
    """What a study found.

    Attributes:
        sources: What varied.
        seed: Of the sample.
        requirement: What a good product does.
        yield_monostable: Share of the variants with one stable rest.
        yield_tilt: Share of the variants that meet the requirement.
        may_stall: Monostable variants that rolling resistance may hold elsewhere than near their rest.
        tilt_deg: Tilt of the monostable variants; None if there are none.
        dead_zone_deg: Dead zone of the monostable variants; None if there are none.
        s_margin_mm: S-margin of all variants on which there is a verdict, 0 where they have several rests.
        com_error_um: Distance of each COM from the nominal one.
        rows: What was kept of each variant, shape (n,) of ROW.
    """

    sources: tuple[Source, ...]
    seed: int
    requirement: Requirement
    yield_monostable: Yield
    yield_tilt: Yield
    may_stall: int
    tilt_deg: Distribution | None
    dead_zone_deg: Distribution | None
    s_margin_mm: Distribution | None
    com_error_um: Distribution
    rows: RowArray

    def plot_yield(self, ax: Axes | None = None) -> Axes:
        """Draw the yields with their intervals.

        Args:
            ax: Axes to draw on; new ones if not given.

        Returns:
            The axes.
        """
        from gomboc_cad.report.study_figures import plot_yields
        from gomboc_cad.report.study_records import ProcessYield

        return plot_yields([ProcessYield.of_study("this study", self)], ax)

    def plot_tilt(self, ax: Axes | None = None) -> Axes:
        """Draw how many parts tilt by how much.

        Args:
            ax: Axes to draw on; new ones if not given.

        Returns:
            The axes.
        """
        from gomboc_cad.report.tilt import TiltHistogram
        from gomboc_cad.report.tilt_figures import plot_tilt_histogram

        histogram = TiltHistogram.of_rows(self.rows)
        return plot_tilt_histogram(histogram, ax, limit_deg=self.requirement.max_tilt_deg)


def run_study(
    model: StudyModel,
    variants: int,
    seed: int,
    *,
    requirement: Requirement = RIGHTS_ITSELF,
    executor: Executor | None = None,
    store: Path | None = None,
    progress: Progress = silent,
    cancelled: Cancelled = never,
) -> StudyResult:
    """Make variants on paper, judge each, and count the good ones.

    Args:
        model: What varies.
        variants: How many.
        seed: Which of the samples; each is a study of its own.
        requirement: What a good product does.
        executor: Where batches are judged; in this process if there is none.
        store: File for the rows, .csv or .parquet. A study that was interrupted goes on from it.
        progress: Told of each batch.
        cancelled: Asked again and again whether to stop.

    Raises:
        StudyError: If there are no variants, or the store is that of another study.
        OutputError: If the store cannot be written.
        KeyboardInterrupt: If it is cancelled; what is in the store stays.
    """
    sample = SobolSample(_dimensions(model), seed, variants)
    job = Job(model, sample, requirement)
    rows = np.empty(variants, ROW)
    identity = _identity(model, sample, requirement)
    with nullcontext() if store is None else Store(store, variants, identity) as kept:
        first = 0 if kept is None else _recall(kept, rows)
        for index in range(first):
            progress(f"batch {index + 1} of {sample.batches}")
        fresh = run_batches(job, executor, first=first, progress=progress, cancelled=cancelled)
        for index, batch in enumerate(fresh, first):
            place = rows[index * BATCH_ROWS : (index + 1) * BATCH_ROWS]
            place[:] = batch[: len(place)]
            if kept is not None:
                kept.append(index, place)
        if kept is not None:
            kept.finish()
    return concluded(model.sources, seed, requirement, rows)


def _recall(store: Store, rows: RowArray) -> int:
    """Fill in the rows that are stored, and give the number of their batches."""
    done = 0
    for batch in store.stored():
        rows[done : done + len(batch)] = batch
        done += len(batch)
    return -(-done // BATCH_ROWS)


def concluded(
    sources: tuple[Source, ...], seed: int, requirement: Requirement, rows: RowArray
) -> StudyResult:
    """Sum up the rows of a study."""
    one_rest = rows["verdict"] == MONOSTABLE
    undecided = rows["verdict"] == UNDECIDED
    good = good_rows(rows, requirement)
    com_error = distribution(np.sqrt(sum(rows[name] ** 2 for name in COM_ERROR)))
    assert com_error is not None
    return StudyResult(
        sources=sources,
        seed=seed,
        requirement=requirement,
        yield_monostable=Yield(int(one_rest.sum()), int(undecided.sum()), len(rows)),
        yield_tilt=Yield(int(good.sum()), int(undecided.sum()), len(rows)),
        may_stall=int((one_rest & requirement.may_stall(rows["s_margin_mm"])).sum()),
        tilt_deg=distribution(rows["tilt_deg"][one_rest]),
        dead_zone_deg=distribution(rows["dead_zone_deg"][one_rest]),
        s_margin_mm=distribution(rows["s_margin_mm"][~undecided]),
        com_error_um=com_error,
        rows=rows,
    )


def _identity(
    model: StudyModel, sample: SobolSample, requirement: Requirement
) -> dict[str, str | int | float]:
    """What the rows depend on."""
    return {
        "gomboc_cad": __version__,
        "model": fingerprint(model),
        "seed": sample.seed,
        "batch_rows": BATCH_ROWS,
        "rolling_mm": requirement.rolling_mm,
    }


@dataclass(frozen=True)
class Sensitivity:
    """Which sources decide tilt and S-margin, by the shares of their variances.

    Attributes:
        samples: Rows of each matrix; (2 + sources) times as many variants were judged.
        seed: Of the sample.
        undecided: Variants without a verdict, which count with the means of the others.
        tilt_deg: Indices of the tilt: of the deepest rest where there are several.
        s_margin_mm: Indices of the S-margin, which is 0 where there are several rests.
    """

    samples: int
    seed: int
    undecided: int
    tilt_deg: tuple[SobolIndex, ...]
    s_margin_mm: tuple[SobolIndex, ...]

    def plot(self, ax: Axes | None = None) -> Axes:
        """Draw the shares of the variance of the tilt, the largest first.

        Args:
            ax: Axes to draw on; new ones if not given.

        Returns:
            The axes.
        """
        from gomboc_cad.report.study_figures import plot_sobol

        return plot_sobol(sorted(self.tilt_deg, key=lambda index: -index.total.estimate), ax)


def run_sensitivity(
    model: StudyModel,
    samples: int,
    seed: int,
    *,
    executor: Executor | None = None,
    progress: Progress = silent,
    cancelled: Cancelled = never,
) -> Sensitivity:
    """First and total Sobol indices of the sources.

    Args:
        model: What varies.
        samples: Rows of each matrix, a power of two.
        seed: Of the sample.
        executor: Where batches are judged; in this process if there is none.
        progress: Told of each batch.
        cancelled: Asked again and again whether to stop.

    Raises:
        StudyError: If the number of samples is no power of two.
        KeyboardInterrupt: If it is cancelled.
    """
    names = [source.name for source in model.sources]
    sample = PickFreeze(tuple(source.dimensions for source in model.sources), seed, samples)
    job = Job(model, sample, RIGHTS_ITSELF)
    rows = np.concatenate(list(run_batches(job, executor, progress=progress, cancelled=cancelled)))

    def indices(output: Array) -> tuple[SobolIndex, ...]:
        known = np.isfinite(output) & (rows["verdict"] != UNDECIDED)
        filled = np.where(known, output, np.mean(output[known]) if known.any() else 0.0)
        first, second, *mixed = filled.reshape(2 + len(names), samples)
        return group_indices(names, first, second, np.reshape(mixed, (len(names), samples)), seed=seed)

    return Sensitivity(
        samples=samples,
        seed=seed,
        undecided=int(np.count_nonzero(rows["verdict"] == UNDECIDED)),
        tilt_deg=indices(rows["tilt_deg"]),
        s_margin_mm=indices(rows["s_margin_mm"]),
    )


def _dimensions(model: StudyModel) -> int:
    return sum(source.dimensions for source in model.sources)

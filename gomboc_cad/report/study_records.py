"""Yields, sensitivities and allowable form errors: from a study in memory or from its document."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Self

import numpy as np

from gomboc_cad.body.sphere import Array, IntArray
from gomboc_cad.tolerance.allowable import FormErrorCurve
from gomboc_cad.tolerance.comparison import ProcessRow
from gomboc_cad.tolerance.statistics import Interval, SobolIndex, Yield
from gomboc_cad.tolerance.study import StudyResult


@dataclass(frozen=True)
class Share:
    """A yield as it is drawn.

    Attributes:
        estimate: Share of the variants that are good for sure.
        low: Lower end of its interval.
        high: Upper end.
        possible: Upper end if every undecided variant is good, too.
    """

    estimate: float
    low: float
    high: float
    possible: float

    @classmethod
    def of_yield(cls, found: Yield) -> Self:
        """Of a study in memory."""
        interval = found.interval
        return cls(interval.estimate, interval.low, interval.high, found.possible.high)

    @classmethod
    def of_document(cls, document: Mapping[str, Any]) -> Self:
        """Of a yield in `tolerance.json`."""
        high = float(document["high"])
        possible = float(document.get("high_if_undecided_pass", high))
        return cls(float(document["estimate"]), float(document["low"]), high, possible)


@dataclass(frozen=True)
class ProcessYield:
    """The yields of one process.

    Attributes:
        name: Its name.
        monostable: Share that has one rest.
        good: Share that meets the requirement.
    """

    name: str
    monostable: Share
    good: Share

    @classmethod
    def of_study(cls, name: str, result: StudyResult) -> Self:
        """Of a study in memory."""
        return cls(name, Share.of_yield(result.yield_monostable), Share.of_yield(result.yield_tilt))

    @classmethod
    def of_row(cls, row: ProcessRow) -> Self:
        """Of a row of a comparison."""
        return cls.of_study(row.process, row.result)

    @classmethod
    def of_document(cls, name: str, document: Mapping[str, Any]) -> Self:
        """Of `tolerance.json`, or of an entry of its key `processes`."""
        shares = (Share.of_document(document[key]) for key in ("yield_monostable", "yield_tilt"))
        return cls(name, *shares)


def yields_of_document(tolerance: Mapping[str, Any]) -> tuple[ProcessYield, ...]:
    """The yields of `tolerance.json`: of all processes if they were compared, else of the one asked about."""
    if rows := tolerance.get("processes"):
        return tuple(ProcessYield.of_document(row["process"], row) for row in rows)
    return (ProcessYield.of_document(tolerance["process"], tolerance),)


def sobol_of_document(entries: Sequence[Mapping[str, Any]]) -> tuple[SobolIndex, ...]:
    """The indices under a key such as `sobol` of `tolerance.json`."""
    return tuple(SobolIndex(e["source"], Interval(**e["first"]), Interval(**e["total"])) for e in entries)


@dataclass(frozen=True, eq=False)
class FormErrorLimits:
    """Allowable form error as it is drawn; amplitudes are rms over the sphere.

    Attributes:
        degrees: Undulations around a great circle, shape (n,).
        guaranteed_um: Amplitude up to which no field of that degree adds a rest, shape (n,).
        allowed_um: Amplitude of random fields at which the target is met; NaN where none was confirmed,
            shape (n,).
        process_um: What the process makes, shape (n,); None if unknown.
        good_share: Share of good parts that the target asks for.
    """

    degrees: IntArray
    guaranteed_um: Array
    allowed_um: Array
    process_um: Array | None
    good_share: float

    @classmethod
    def of_curve(cls, curve: FormErrorCurve) -> Self:
        """Of a curve in memory."""
        return cls(
            degrees=curve.degrees,
            guaranteed_um=1e3 * curve.guaranteed_mm,
            allowed_um=1e3 * curve.probable_mm,
            process_um=None if curve.process_mm is None else 1e3 * curve.process_mm,
            good_share=curve.target.good_share,
        )

    @classmethod
    def of_document(cls, document: Mapping[str, Any]) -> Self:
        """Of the key `form_error` of `tolerance.json`."""
        rows = document["degrees"]
        guaranteed, allowed, process = (
            np.array([np.nan if row[key] is None else row[key] for row in rows], dtype=float)
            for key in ("guaranteed_um", "allowed_um", "process_um")
        )
        return cls(
            degrees=np.array([row["degree"] for row in rows], dtype=np.int64),
            guaranteed_um=guaranteed,
            allowed_um=allowed,
            process_um=None if np.isnan(process).all() else process,
            good_share=float(document["good_share"]),
        )

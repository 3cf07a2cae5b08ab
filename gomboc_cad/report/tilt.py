"""How a rest answers to errors of the COM, and how the tilts of many parts are distributed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Self

import numpy as np

from gomboc_cad.body.sphere import Array, IntArray
from gomboc_cad.equilibria.records import Rest
from gomboc_cad.tolerance.judging import RowArray
from gomboc_cad.tolerance.variants import MONOSTABLE

GRADES = (("tactical", 0.05), ("industrial", 1.0), ("consumer", 3.0))
"""What orientation sensors of these grades are asked for, in degrees."""

_PER_DECADE = 12
_EDGES_DEG = np.append(np.geomspace(1e-4, 1e2, 6 * _PER_DECADE + 1), 180.0)


@dataclass(frozen=True)
class TiltSensitivity:
    """How the rest tilts for an error of the COM, to first order, with what it is compared with.

    Attributes:
        tilt_deg_per_um: Along the soft and the stiff direction.
        s_margin_um: COM error at which another rest may appear; None if unknown.
        cone_95_deg: Half-angle of the cone that holds the direction of gravity with 95 %, from a calibration.
        study_95_deg: Tilt that 95 % of the parts of a study stay below.
        limit_deg: The user's limit.
    """

    tilt_deg_per_um: tuple[float, float]
    s_margin_um: float | None = None
    cone_95_deg: float | None = None
    study_95_deg: float | None = None
    limit_deg: float | None = None

    @classmethod
    def of_rest(cls, rest: Rest, s_margin_mm: float | None = None, **known: float | None) -> Self:
        """Of a rest, with any of the other attributes."""
        margin_um = None if s_margin_mm is None else 1e3 * s_margin_mm
        return cls(rest.tilt_deg_per_um, margin_um, **known)

    @classmethod
    def of_documents(
        cls,
        stored: Mapping[str, Any] | None,
        verdict: Mapping[str, Any] | None = None,
        calibration: Mapping[str, Any] | None = None,
        tolerance: Mapping[str, Any] | None = None,
    ) -> Self | None:
        """Put together what the documents of a folder say; None if none of them knows of a rest.

        Args:
            stored: What `document` gave.
            verdict: `verdict.json`.
            calibration: `calibration.json`.
            tolerance: `tolerance.json`.
        """
        verdict, tolerance = verdict or {}, tolerance or {}
        if verdict.get("rest"):
            soft, stiff = (float(value) for value in verdict["rest"]["tilt_deg_per_um"])
            margin_mm = verdict.get("s_margin_mm")
            margin = None if margin_mm is None else 1e3 * float(margin_mm)
        elif stored:
            soft, stiff = (float(value) for value in stored["tilt_deg_per_um"])
            margin = stored["s_margin_um"]
        else:
            return None
        return cls(
            tilt_deg_per_um=(soft, stiff),
            s_margin_um=margin,
            cone_95_deg=calibration["cone_95_deg"] if calibration else None,
            study_95_deg=(tolerance.get("tilt_deg") or {}).get("p95"),
            limit_deg=tolerance.get("max_tilt_deg"),
        )

    def document(self) -> dict[str, Any]:
        """As it is stored: what no other document of a study says."""
        return {"tilt_deg_per_um": list(self.tilt_deg_per_um), "s_margin_um": self.s_margin_um}


@dataclass(frozen=True, eq=False)
class TiltHistogram:
    """How many variants of a study tilt by how much, in classes that are the same for all studies.

    Attributes:
        edges_deg: Edges of the classes, shape (k + 1,); what is below the first edge is in the first class.
        counts: Monostable variants in each class, shape (k,).
        others: Variants with another verdict.
    """

    edges_deg: Array
    counts: IntArray
    others: int

    @classmethod
    def of_rows(cls, rows: RowArray) -> Self:
        """Sort the rows of a study."""
        tilts = rows["tilt_deg"][rows["verdict"] == MONOSTABLE]
        counts = np.histogram(np.clip(tilts, _EDGES_DEG[0], None), _EDGES_DEG)[0]
        return cls(_EDGES_DEG, counts, len(rows) - len(tilts))

    @property
    def variants(self) -> int:
        """Number of variants."""
        return int(self.counts.sum()) + self.others

    def document(self) -> dict[str, Any]:
        """As it is stored."""
        return {
            "edges_deg": self.edges_deg.tolist(),
            "counts": self.counts.tolist(),
            "others": self.others,
        }

    @classmethod
    def of_document(cls, document: Mapping[str, Any]) -> Self:
        """Read what is stored."""
        edges, counts = np.array(document["edges_deg"], dtype=float), np.array(document["counts"], dtype=int)
        return cls(edges, counts, int(document["others"]))

"""One batch of a study: quantiles become variants, variants are judged, and what is kept of each is a row."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from gomboc_cad.body.sphere import Array, BoolArray
from gomboc_cad.reproducible import one_blas_thread
from gomboc_cad.tolerance.requirement import Requirement

if TYPE_CHECKING:
    from gomboc_cad.tolerance.model import StudyModel
    from gomboc_cad.tolerance.variants import Outcomes, Variants

ROW = np.dtype(
    [
        ("verdict", "i1"),
        ("stable", "<i4"),
        ("tilt_deg", "<f8"),
        ("s_margin_mm", "<f8"),
        ("dead_zone_deg", "<f8"),
        ("com_error_x_um", "<f8"),
        ("com_error_y_um", "<f8"),
        ("com_error_z_um", "<f8"),
    ]
)
"""What is kept of a variant. The COM error is that of the finished assembly, in the body's frame."""

COM_ERROR = ("com_error_x_um", "com_error_y_um", "com_error_z_um")

RowArray = NDArray[np.void]

_UM_PER_MM = 1e3


def judged(model: StudyModel, quantiles: Array) -> tuple[Variants, Outcomes]:
    """Make and judge the variants of rows of quantiles (n, D) inside (0, 1), in one thread.

    How matrix products are split among threads decides the last bits of a sum: with one thread the numbers
    are the same in every process.
    """
    with one_blas_thread():
        variants = model.variants(quantiles)
        return variants, model.judge(variants)


def judged_rows(model: StudyModel, quantiles: Array, requirement: Requirement) -> RowArray:
    """What is kept of the variants of rows of quantiles, shape (n,) of ROW."""
    variants, outcomes = judged(model, quantiles)
    rows = np.empty(len(quantiles), ROW)
    rows["dead_zone_deg"] = requirement.dead_zone_deg(outcomes)
    for name in ("verdict", "stable", "tilt_deg", "s_margin_mm"):
        rows[name] = getattr(outcomes, name)
    error_um = _UM_PER_MM * (variants.com_mm - np.array(model.nominal.com_mm))
    for name, column in zip(COM_ERROR, error_um.T, strict=True):
        rows[name] = column
    return rows


def good_rows(rows: RowArray, requirement: Requirement) -> BoolArray:
    """Which rows meet the requirement that they were judged with, shape (n,)."""
    return requirement.accepts(rows["verdict"], rows["tilt_deg"], rows["s_margin_mm"], rows["dead_zone_deg"])

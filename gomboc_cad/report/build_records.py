"""What the report shows and no other document says: computed once, where body and design are known."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from gomboc_cad.body.sphere import Array
from gomboc_cad.body.surface import Body
from gomboc_cad.equilibria import smooth_census
from gomboc_cad.equilibria.records import Census
from gomboc_cad.errors import CensusError
from gomboc_cad.report.landscape import height_landscape
from gomboc_cad.report.surface_fields import surface_fields
from gomboc_cad.report.tilt import TiltHistogram, TiltSensitivity
from gomboc_cad.report.zone_section import zone_mesh, zone_section
from gomboc_cad.tolerance.judging import COM_ERROR

if TYPE_CHECKING:
    from gomboc_cad.products.design import ProductDesign
    from gomboc_cad.products.verdict import Verdict
    from gomboc_cad.tolerance.model import StudyModel
    from gomboc_cad.tolerance.study import StudyResult

_UNIFORM = 1.0 / 3.0
"""Variance of a uniform distribution of half-width 1 (JCGM 100:2008, 4.3.7)."""


def product_records(design: ProductDesign, verdict: Verdict) -> dict[str, Any]:
    """The records of a product, as documents; none if it has no census.

    Args:
        design: The product.
        verdict: The verdict on it.
    """
    census = verdict.census
    if census is None:
        return {}
    return _pose_records(design.body, census, com_covariance_mm2(design), verdict.s_margin_mm)


def study_records(model: StudyModel, result: StudyResult) -> dict[str, Any]:
    """The records of a study, as documents.

    Args:
        model: What varied.
        result: What was found.
    """
    found: dict[str, Any] = {"tilt_histogram": TiltHistogram.of_rows(result.rows).document()}
    try:
        census = smooth_census(model.nominal.body, model.nominal.com_mm)
    except CensusError:
        return found
    errors_mm = 1e-3 * np.stack([result.rows[name] for name in COM_ERROR], axis=-1)
    spread = errors_mm.T @ errors_mm / len(errors_mm)
    return found | _pose_records(model.nominal.body, census, spread, None)


def com_covariance_mm2(design: ProductDesign) -> Array:
    """How uncertain the COM of a design is by the tolerances of its spec, shape (3, 3)."""
    # The parts of a design come with the kernel.
    from gomboc_cad.tolerance.product_parts import com_error_mm

    spread = com_error_mm(design) ** 2 * np.eye(3)
    for load in design.loads:
        by_mass = load.com_error_by_mass_mm(design.assembly)
        by_place = load.com_error_by_place_mm(design.assembly)
        spread += np.outer(by_mass, by_mass) + by_place**2 * np.eye(3)
    result: Array = _UNIFORM * spread
    return result


def _pose_records(
    body: Body, census: Census, spread_mm2: Array, product_margin_mm: float | None
) -> dict[str, Any]:
    """All that depends on the body and its COM; of a dented body, which has no margin, there is less."""
    margin = census.margin
    found = {
        "surface": surface_fields(body, census.com_mm, census.rest).document(),
        "landscape": height_landscape(census).document(),
        "tilt": TiltSensitivity.of_rest(census.rest, margin.s_margin_mm if margin else None).document(),
    }
    if margin is None:
        return found
    return found | {
        "zone_mesh": zone_mesh(body).document(),
        "zone_section": zone_section(body, census, spread_mm2, product_margin_mm).document(),
    }

"""The JSON document of a build; docs/user-guide.md lists its keys."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from gomboc_cad import __version__
from gomboc_cad.documents import file_document, rest_document
from gomboc_cad.products.assembly import Assembly
from gomboc_cad.products.design import ProductDesign, Uncertainty
from gomboc_cad.products.inheritance import inheritance_document, inheritance_reasons
from gomboc_cad.products.manufacture import Manufacture, manufacture_document
from gomboc_cad.products.openings.sites import openings_document
from gomboc_cad.products.placing.placement_report import placement_document
from gomboc_cad.products.recheck import Recheck, recheck_document
from gomboc_cad.products.verdict import Verdict, tilt_from_com_error_deg
from gomboc_cad.solid.inspect import FileInspection
from gomboc_cad.solid.transfer import Transfer


@dataclass(frozen=True)
class BuildRecord:
    """All that a build found.

    Attributes:
        design: The product.
        verdict: The verdict on it.
        files: Every file as read back.
        made: Walls and undercuts.
        again: The census of the exported parts' hull.
        transferred: Whether the exported surface has the census of the body; see `inheritance.inherited`.
    """

    design: ProductDesign
    verdict: Verdict
    files: Sequence[FileInspection]
    made: Manufacture
    again: Recheck
    transferred: Transfer | str | None


def build_document(found: BuildRecord) -> dict[str, Any]:
    """The JSON document of a build."""
    design, verdict = found.design, found.verdict
    assembly, census = design.assembly, verdict.census
    margin = census.margin if census else None
    watertight = _watertight(found.files)
    return {
        "product": assembly.name,
        "version": __version__,
        "body": design.body.name,
        "diameter_mm": design.body.diameter_mm,
        "spec": design.spec.model_dump(mode="json", exclude_none=True),
        "files": [file_document(file) for file in found.files],
        "parts": [
            {
                "name": part.name,
                "material": part.material,
                "mass_g": part.mass_g,
                "volume_mm3": part.volume_mm3,
                "com_mm": list(part.com_mm),
                "made": part.made,
                "standard": part.standard,
                "color": list(part.color),
                "watertight": watertight.get(part.name),
            }
            for part in assembly.parts
        ],
        "assembly": _assembly_document(assembly),
        "placement": placement_document(design.placement),
        "core_shift_mm": list(design.placement.core_shift_mm),
        "min_wall_left_mm": found.made.min_wall_mm,
        "manufacture": manufacture_document(found.made),
        "openings": openings_document(design.openings),
        "s_margin_mm": verdict.s_margin_mm,
        "u_margin_mm": margin.u_margin_mm if margin else None,
        "stable": census.stable if census else None,
        "unstable": census.unstable if census else None,
        "saddles": census.saddles if census else None,
        "rest": rest_document(census.rest) if census else None,
        "hull": recheck_document(found.again),
        "sensitivities": [
            {
                "source": item.source,
                "com_error_um": _com_error_um(item),
                "tilt_deg": tilt_from_com_error_deg(census.rest, item.com_error_mm),
            }
            for item in design.uncertainties
            if census
        ],
        "transfer": inheritance_document(found.transferred),
        **design.summary,
        "verdict": verdict.verdict,
        "reasons": _reasons(found),
    }


def _reasons(found: BuildRecord) -> list[str]:
    design, verdict = found.design, found.verdict
    return [
        *verdict.reasons,
        *inheritance_reasons(found.transferred),
        design.placement.sentence,
        # All of a group have the same sentence.
        *dict.fromkeys(opening.sentence for opening in design.openings),
        *(
            uncertainty_sentence(item, verdict)
            for item in design.uncertainties
            if verdict.s_margin_mm is not None
        ),
        *found.made.notes,
        *design.notes,
    ]


def _com_error_um(item: Uncertainty) -> float:
    return 1e3 * float(np.linalg.norm(item.com_error_mm))


def uncertainty_sentence(item: Uncertainty, verdict: Verdict) -> str:
    """What an uncertainty does to a product that has a rest, and what to do about it if that is too much."""
    assert verdict.census is not None
    assert verdict.s_margin_mm is not None
    error_um, margin_um = _com_error_um(item), 1e3 * verdict.s_margin_mm
    said = (
        f"{item.source[0].upper()}{item.source[1:]} moves the centre of mass by {error_um:.3g} µm and tilts "
        f"the rest by {tilt_from_com_error_deg(verdict.census.rest, item.com_error_mm):.2g}°"
    )
    if error_um < margin_um:
        return f"{said}."
    return (
        f"{said}; that is beyond the S-margin of {margin_um:.3g} µm, so a second rest cannot be ruled out: "
        f"{item.remedy}."
    )


def _assembly_document(assembly: Assembly) -> dict[str, Any]:
    return {
        "mass_g": assembly.mass_g,
        "com_mm": list(assembly.com_mm),
        "com_target_mm": list(assembly.com_target_mm),
        "com_residual_um": assembly.com_residual_um,
    }


def _watertight(files: Sequence[FileInspection]) -> dict[str, bool]:
    """A part is watertight when every file that holds it says so."""
    result: dict[str, bool] = {}
    for file in files:
        for part in file.parts:
            result[part.name] = result.get(part.name, True) and part.watertight
    return result

"""From a spec to a folder of files with a verdict: the main job."""

from __future__ import annotations

import hashlib
import json
from pathlib import Path
from typing import Any

import numpy as np

from gomboc_cad import __version__
from gomboc_cad.documents import file_document, rest_document
from gomboc_cad.equilibria.records import as_vector
from gomboc_cad.products.assembly import Assembly
from gomboc_cad.products.bill_of_materials import FILE_NAME as BILL_FILE
from gomboc_cad.products.bill_of_materials import bill_csv, bill_of_materials
from gomboc_cad.products.body_spec import require_verified
from gomboc_cad.products.calibration import calibrate_housing, calibration_document
from gomboc_cad.products.imu_housing import LOWER, UPPER, HousingDesign, design_imu_housing
from gomboc_cad.products.inheritance import inheritance_document, inheritance_reasons, inherited
from gomboc_cad.products.spec import load_spec, spec_path
from gomboc_cad.products.verdict import Sensitivity, Verdict, judge, tilt_from_com_error_deg
from gomboc_cad.progress import Progress, silent
from gomboc_cad.solid.audit import require_pymeshlab
from gomboc_cad.solid.boundary import Boundary
from gomboc_cad.solid.export import NamedMesh, write_3mf, write_step, write_stl
from gomboc_cad.solid.inspect import Expected, FileInspection, inspect_file, problems_of
from gomboc_cad.solid.output import open_output, write_bytes
from gomboc_cad.solid.patches import default_deviation_um
from gomboc_cad.solid.step import NamedSolid, read_step
from gomboc_cad.solid.transfer import Transfer

STAGES = 7
VERDICT_FILE = "verdict.json"
CALIBRATION_FILE = "calibration.json"

_BOUGHT_PART_DEVIATION_UM = 0.1
"""How far the knurled and threaded surfaces of bought parts may move on the way through a STEP file."""


def build_product(
    spec: str,
    folder: Path,
    *,
    force: bool = False,
    allow_unverified: bool = False,
    audit: bool = False,
    progress: Progress = silent,
) -> dict[str, Any]:
    """Build a product, write its files, read them back, and judge it.

    Args:
        spec: Name of a product, which stands for its template, or the path of a spec.
        folder: Where the files go.
        force: Allow a folder that holds something, and replace files of the same names.
        allow_unverified: Build of a body that is refuted or not convex too.
        audit: Have the meshes checked by PyMeshLab too.
        progress: Called with the name of each stage as it begins.

    Returns:
        The JSON document of `gomboc-cad build`, also written as `verdict.json`.

    Raises:
        SpecError: If the spec is wrong.
        UnverifiedBodyError: If its body is refuted or not convex.
        GeometryError: If something does not fit.
        OutputError: If the files cannot be written.
        GombocError: If an audit is asked for and PyMeshLab is not installed.
    """
    if audit:
        require_pymeshlab()
    wanted = load_spec(spec)
    body = wanted.body.body()
    if not allow_unverified:
        require_verified(body)
    with open_output(folder, force) as staging:
        design = design_imu_housing(wanted, spec_path(spec).parent, progress)
        progress("writing the files")
        expected = _write(design, staging)
        progress("reading the files back")
        found = [inspect_file(staging / name, parts, audit) for name, parts in expected.items()]
        found.append(_write_bill(design.assembly, staging))
        progress("judging")
        verdict = judge(body, design.assembly.com_mm, _problems(design, found))
        found += _write_calibration(design, verdict, staging)
        transferred = _transfer(design, verdict, staging)
        document = _document(design, verdict, found, transferred)
        write_bytes(staging / VERDICT_FILE, _json_bytes(document))
    # Not in the file, which is to be the same wherever it is written.
    return {"folder": str(folder), **document}


def _write(design: HousingDesign, staging: Path) -> dict[str, list[Expected]]:
    """Write all files; give what each of them must hold."""
    assembly = design.assembly
    layout = design.layout
    halves = Boundary.of_hollow(layout.hollow).split(layout.seam_point_mm, layout.frame.up)
    boundaries = dict(zip((LOWER, UPPER), halves, strict=True))
    deviation_um, sag_um = default_deviation_um(design.body), design.spec.mesh.sag_um

    as_solids = {
        part.name: Expected(
            part.name,
            part.volume_mm3,
            part.measured.com_mm,
            deviation_um if part.made else _BOUGHT_PART_DEVIATION_UM,
            boundaries.get(part.name),
        )
        for part in assembly.parts
    }
    as_meshes = {
        name: Expected(name, as_solids[name].volume_mm3, as_solids[name].com_mm, sag_um, boundaries[name])
        for name in (LOWER, UPPER)
    }

    expected: dict[str, list[Expected]] = {}
    solids = {part.name: NamedSolid(part.name, part.solid, part.color) for part in assembly.parts}
    write_step(staging / f"{assembly.name}.step", list(solids.values()), assembly.name)
    expected[f"{assembly.name}.step"] = list(as_solids.values())
    for name in (LOWER, UPPER):
        write_step(staging / f"{name}.step", [solids[name]], name)
        expected[f"{name}.step"] = [as_solids[name]]
        write_stl(staging / f"{name}.stl", design.meshes[name], name)
        expected[f"{name}.stl"] = [as_meshes[name]]
    write_3mf(
        staging / f"{assembly.name}.3mf", [NamedMesh(name, design.meshes[name]) for name in (LOWER, UPPER)]
    )
    expected[f"{assembly.name}.3mf"] = list(as_meshes.values())
    return expected


def _write_bill(assembly: Assembly, staging: Path) -> FileInspection:
    """Write the bill of materials."""
    return _write_text(staging / BILL_FILE, bill_csv(bill_of_materials(assembly.parts)))


def _write_calibration(design: HousingDesign, verdict: Verdict, staging: Path) -> list[FileInspection]:
    """Write what the sensor reads at rest; a housing with several rests has nothing to calibrate with."""
    if verdict.census is None or verdict.census.stable != 1:
        return []
    document = calibration_document(calibrate_housing(design, verdict.census))
    return [_write_text(staging / CALIBRATION_FILE, _json_bytes(document))]


def _write_text(path: Path, data: bytes) -> FileInspection:
    """Write a table or document, which has nothing to read back."""
    write_bytes(path, data)
    return FileInspection(path.name, path.suffix[1:], hashlib.sha256(data).hexdigest(), len(data), (), ())


def _json_bytes(document: dict[str, Any]) -> bytes:
    return (json.dumps(document, indent=2, ensure_ascii=False, allow_nan=False) + "\n").encode()


def _problems(design: HousingDesign, found: list[FileInspection]) -> tuple[str, ...]:
    problems = list(problems_of(found))
    residual, allowed = design.assembly.com_residual_um, design.spec.com.max_residual_um
    if residual > allowed:
        problems.append(
            f"The centre of mass is {residual:.3g} µm from its target, and com.max_residual_um allows "
            f"{allowed:g} µm."
        )
    return tuple(problems)


def _sensitivities(design: HousingDesign, verdict: Verdict) -> list[Sensitivity]:
    """What the uncertain masses of the spec do to the finished part."""
    if verdict.census is None:
        return []
    assembly, board = design.assembly, design.board
    place = next(part.com_mm for part in assembly.parts if part.name == "board")
    arm = np.subtract(place, assembly.com_mm) * board.mass_tolerance_g / assembly.mass_g
    com_error_um = 1e3 * float(np.linalg.norm(arm))
    tilt = tilt_from_com_error_deg(verdict.census.rest, as_vector(arm))
    return [
        Sensitivity(f"an error of {board.mass_tolerance_g:g} g in the mass of the board", com_error_um, tilt)
    ]


def _transfer(design: HousingDesign, verdict: Verdict, staging: Path) -> Transfer | str | None:
    """Whether the halves as read back have the census of the body; None if there is none to compare with."""
    if verdict.census is None:
        return None
    halves = {name: read_step(staging / f"{name}.step")[0].solid for name in (LOWER, UPPER)}
    exported = design.assembly.com_with(halves)
    return inherited(list(halves.values()), design.body, verdict.census, exported)


def _document(
    design: HousingDesign,
    verdict: Verdict,
    found: list[FileInspection],
    transferred: Transfer | str | None,
) -> dict[str, Any]:
    """The JSON document of a build."""
    assembly, census = design.assembly, verdict.census
    margin = census.margin if census else None
    watertight = _watertight(found)
    sensitivities = _sensitivities(design, verdict)
    return {
        "product": assembly.name,
        "version": __version__,
        "body": design.body.name,
        "diameter_mm": design.body.diameter_mm,
        "spec": design.spec.model_dump(mode="json", exclude_none=True),
        "files": [file_document(file) for file in found],
        "parts": [
            {
                "name": part.name,
                "material": part.material,
                "mass_g": part.mass_g,
                "volume_mm3": part.volume_mm3,
                "com_mm": list(part.com_mm),
                "made": part.made,
                "standard": part.standard,
                "watertight": watertight.get(part.name),
            }
            for part in assembly.parts
        ],
        "assembly": _assembly_document(assembly),
        "core_shift_mm": list(design.layout.hollow.core_shift_mm),
        "min_wall_left_mm": design.min_wall_left_mm,
        "s_margin_mm": margin.s_margin_mm if margin else None,
        "u_margin_mm": margin.u_margin_mm if margin else None,
        "stable": census.stable if census else None,
        "unstable": census.unstable if census else None,
        "saddles": census.saddles if census else None,
        "rest": rest_document(census.rest) if census else None,
        "sensitivities": [
            {"source": item.source, "com_error_um": item.com_error_um, "tilt_deg": item.tilt_deg}
            for item in sensitivities
        ],
        "transfer": inheritance_document(transferred),
        "verdict": verdict.verdict,
        "reasons": [
            *verdict.reasons,
            *inheritance_reasons(transferred),
            *(_sentence(item, margin.s_margin_mm) for item in sensitivities if margin),
        ],
    }


def _sentence(item: Sensitivity, s_margin_mm: float) -> str:
    said = (
        f"{item.source[0].upper()}{item.source[1:]} moves the centre of mass by {item.com_error_um:.3g} µm "
        f"and tilts the rest by {item.tilt_deg:.2g}°"
    )
    if item.com_error_um < 1e3 * s_margin_mm:
        return f"{said}."
    return (
        f"{said}; that is beyond the S-margin of {1e3 * s_margin_mm:.3g} µm, so a second rest cannot be "
        "ruled out: weigh it and give the mass with a smaller tolerance."
    )


def _assembly_document(assembly: Assembly) -> dict[str, Any]:
    return {
        "mass_g": assembly.mass_g,
        "com_mm": list(assembly.com_mm),
        "com_target_mm": list(assembly.com_target_mm),
        "com_residual_um": assembly.com_residual_um,
    }


def _watertight(found: list[FileInspection]) -> dict[str, bool]:
    """A part is watertight when every file that holds it says so."""
    result: dict[str, bool] = {}
    for file in found:
        for part in file.parts:
            result[part.name] = result.get(part.name, True) and part.watertight
    return result

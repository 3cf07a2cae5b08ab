"""From a spec to a folder of files with a verdict: the main job."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from build123d import Solid

from gomboc_cad.equilibria.records import Census
from gomboc_cad.products.assembly import Assembly, Part
from gomboc_cad.products.bill_of_materials import FILE_NAME as BILL_FILE
from gomboc_cad.products.bill_of_materials import bill_csv, bill_of_materials
from gomboc_cad.products.body_spec import require_verified
from gomboc_cad.products.build_document import BuildRecord, build_document
from gomboc_cad.products.design import ProductDesign
from gomboc_cad.products.inheritance import inherited
from gomboc_cad.products.manufacture import manufacture
from gomboc_cad.products.process import load_process
from gomboc_cad.products.recheck import recheck
from gomboc_cad.products.recipes import design_product
from gomboc_cad.products.spec import load_spec, spec_path
from gomboc_cad.products.subject import DESIGN_STAGES
from gomboc_cad.products.verdict import Verdict, judge
from gomboc_cad.progress import Progress, silent
from gomboc_cad.report.product_report import write_product_report
from gomboc_cad.reproducible import one_blas_thread
from gomboc_cad.solid.audit import require_pymeshlab
from gomboc_cad.solid.export import NamedMesh, write_3mf, write_plate, write_step, write_stl
from gomboc_cad.solid.inspect import Expected, FileInspection, inspect_file, problems_of
from gomboc_cad.solid.output import json_bytes, open_output, write_bytes
from gomboc_cad.solid.patches import default_deviation_um
from gomboc_cad.solid.plate import pack
from gomboc_cad.solid.plate_inspection import inspect_plate
from gomboc_cad.solid.step import NamedSolid, read_step
from gomboc_cad.solid.transfer import Transfer

STAGES = DESIGN_STAGES + 6
VERDICT_FILE = "verdict.json"

_BOUGHT_PART_DEVIATION_UM = 0.1
"""How far the knurled and threaded surfaces of bought parts may move on the way through a STEP file."""


@one_blas_thread()
def build_product(
    spec: str,
    folder: Path,
    *,
    changes: Sequence[str] = (),
    force: bool = False,
    allow_unverified: bool = False,
    audit: bool = False,
    report: bool = True,
    progress: Progress = silent,
) -> dict[str, Any]:
    """Build a product, write its files, read them back, and judge it.

    Args:
        spec: Name of a product, which stands for its template, or the path of a spec.
        folder: Where the files go.
        changes: `KEY=VALUE` each, for keys of the spec.
        force: Allow a folder that holds something, and replace files of the same names.
        allow_unverified: Build of a body that is refuted or not convex too.
        audit: Have the meshes checked by PyMeshLab too.
        report: Write the report too.
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
    wanted = load_spec(spec, changes)
    spec_folder = spec_path(spec).parent
    process = load_process(wanted.shell.process, spec_folder)
    if not allow_unverified:
        require_verified(wanted.body.body())
    with open_output(folder, force) as staging:
        design = design_product(wanted, spec_folder, progress)
        assembly = design.assembly
        progress("writing the files")
        expected = _write(design, staging)
        progress("reading the files back")
        solids = read_step(staging / _assembly_file(assembly))
        found = [
            inspect_file(staging / name, parts, audit, solids if name == _assembly_file(assembly) else None)
            for name, parts in expected.items()
        ]
        found.append(_write_plate(design, staging))
        found.append(_write_text(staging / BILL_FILE, bill_csv(bill_of_materials(assembly.parts))))
        progress("measuring walls and undercuts")
        made = manufacture(assembly, process, design.parting_direction)
        progress("rechecking the hull of the exported parts")
        exported = {part.name: part.solid for part in solids}
        again = recheck(exported, assembly.com_mm, design.openings, design.body, design.parting)
        progress("judging")
        problems = (*design.problems, *problems_of(found), *_com_problems(design), *made.problems)
        verdict = judge(design.body, assembly.com_mm, problems, again)
        found += _write_documents(design, verdict, staging)
        transferred = _transfer(design, verdict.census, exported)
        document = build_document(BuildRecord(design, verdict, found, made, again, transferred))
        write_bytes(staging / VERDICT_FILE, json_bytes(document))
        if report:
            progress("writing the report")
            write_product_report(design, verdict, staging, folder)
    # Not in the file, which is to be the same wherever it is written.
    return {"folder": str(folder), **document}


def _assembly_file(assembly: Assembly) -> str:
    """Name of the STEP file with all parts."""
    return f"{assembly.name}.step"


def _write(design: ProductDesign, staging: Path) -> dict[str, list[Expected]]:
    """Write all files with geometry; give what each of them must hold."""
    assembly = design.assembly
    made = [part for part in assembly.parts if part.made]
    deviation_um, sag_um = default_deviation_um(design.body), design.spec.mesh.sag_um
    meshes = {part.name: part.mesh for part in made if part.mesh is not None}
    as_solids = {part.name: _as_solid(part, deviation_um) for part in assembly.parts}
    as_meshes = {part.name: _expected(part, sag_um) for part in made}

    expected: dict[str, list[Expected]] = {}
    solids = {part.name: NamedSolid(part.name, part.solid, part.color) for part in assembly.parts}
    write_step(staging / _assembly_file(assembly), list(solids.values()), assembly.name)
    expected[_assembly_file(assembly)] = list(as_solids.values())
    for name, mesh in meshes.items():
        write_step(staging / f"{name}.step", [solids[name]], name)
        expected[f"{name}.step"] = [as_solids[name]]
        write_stl(staging / f"{name}.stl", mesh, name)
        write_3mf(staging / f"{name}.3mf", [NamedMesh(name, mesh)])
        expected[f"{name}.stl"] = expected[f"{name}.3mf"] = [as_meshes[name]]
    write_3mf(staging / f"{assembly.name}.3mf", [NamedMesh(name, mesh) for name, mesh in meshes.items()])
    expected[f"{assembly.name}.3mf"] = list(as_meshes.values())
    return expected


def _write_plate(design: ProductDesign, staging: Path) -> FileInspection:
    """Lay the made parts out on the printer's bed, write that and read it back."""
    assembly, plate = design.assembly, design.spec.plate
    path = staging / f"{assembly.name}-plate.3mf"
    items = pack(assembly.parts, plate)
    laid_out = {item.part for item in items}
    parts = [part for part in assembly.parts if part.name in laid_out]
    write_plate(path, [NamedMesh(part.name, part.mesh) for part in parts if part.mesh is not None], items)
    # The same meshes were measured against the model's surfaces already.
    expected = {part.name: replace(_expected(part, design.spec.mesh.sag_um), boundary=None) for part in parts}
    return inspect_plate(path, expected, items, plate.bed_mm)


def _as_solid(part: Part, deviation_um: float) -> Expected:
    return _expected(part, deviation_um if part.boundary is not None else _BOUGHT_PART_DEVIATION_UM)


def _expected(part: Part, distance_um: float) -> Expected:
    return Expected(part.name, part.volume_mm3, part.measured.com_mm, distance_um, part.boundary)


def _write_documents(design: ProductDesign, verdict: Verdict, staging: Path) -> list[FileInspection]:
    """Write what only this product has to say."""
    documents: Mapping[str, dict[str, Any]] = design.documents(verdict)
    return [_write_text(staging / name, json_bytes(document)) for name, document in documents.items()]


def _write_text(path: Path, data: bytes) -> FileInspection:
    """Write a table or document, which has nothing to read back."""
    write_bytes(path, data)
    return FileInspection(path.name, path.suffix[1:], hashlib.sha256(data).hexdigest(), len(data), (), ())


def _com_problems(design: ProductDesign) -> tuple[str, ...]:
    residual, allowed = design.assembly.com_residual_um, design.spec.com.max_residual_um
    if residual <= allowed:
        return ()
    return (
        f"The centre of mass is {residual:.3g} µm from its target, and com.max_residual_um allows "
        f"{allowed:g} µm.",
    )


def _transfer(
    design: ProductDesign, census: Census | None, exported: Mapping[str, Solid]
) -> Transfer | str | None:
    """Whether the made parts as read back have the census of the body; None without a census."""
    if census is None:
        return None
    made = {part.name: exported[part.name] for part in design.assembly.parts if part.made}
    return inherited(list(made.values()), design.body, census, design.assembly.com_with(made))

"""The bare body as files: no cavity, no parts, the same inspection and verdict as a product."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from gomboc_cad.body import Body, catalogue_entries, mass_properties
from gomboc_cad.documents import file_document, rest_document
from gomboc_cad.errors import SpecError
from gomboc_cad.products.inheritance import inheritance_document, inheritance_reasons, inherited
from gomboc_cad.products.verdict import Verdict, judge
from gomboc_cad.progress import Progress, silent
from gomboc_cad.reproducible import one_blas_thread
from gomboc_cad.solid.audit import require_pymeshlab
from gomboc_cad.solid.boundary import Boundary
from gomboc_cad.solid.export import NamedMesh, write_3mf, write_step, write_stl
from gomboc_cad.solid.inspect import Expected, inspect_file, problems_of
from gomboc_cad.solid.mass import solid_mass
from gomboc_cad.solid.mesh import body_mesh
from gomboc_cad.solid.offset import InsetSurface
from gomboc_cad.solid.output import open_output
from gomboc_cad.solid.patches import body_solid, default_deviation_um, max_deviation_um
from gomboc_cad.solid.step import NamedSolid, read_step
from gomboc_cad.solid.transfer import Transfer

FORMATS = ("step", "stl", "3mf")
STAGES = 5

_COLOR = (0.27, 0.51, 0.71)


@one_blas_thread()
def write_body(
    body: Body,
    folder: Path,
    formats: Sequence[str] = FORMATS,
    sag_um: float = 10.0,
    *,
    deviation_um: float | None = None,
    force: bool = False,
    audit: bool = False,
    progress: Progress = silent,
) -> dict[str, Any]:
    """Write a body's files, read them back and judge the body about its homogeneous centroid.

    Args:
        body: The body; a refuted one is written too, with the verdict FAIL.
        folder: Where the files go.
        formats: Any of `step`, `stl`, `3mf`.
        sag_um: Largest distance of a mesh's facets from the analytic surface.
        deviation_um: Largest distance of the STEP solid from the analytic surface; by default 0.1 µm on a
            diameter of 100 mm and in proportion.
        force: Allow a folder that holds something, and replace files of the same names.
        audit: Have the meshes checked by PyMeshLab too.
        progress: Called with the name of each stage as it begins.

    Returns:
        The JSON document of `gomboc-cad body`.

    Raises:
        SpecError: If a format is not known or the deviation is not a positive length.
        GeometryError: If the surface cannot be drawn, or the sag is out of range.
        OutputError: If the files cannot be written.
        GombocError: If an audit is asked for and PyMeshLab is not installed.
    """
    wanted = list(dict.fromkeys(name.strip().lower() for name in formats))
    if not wanted or not set(wanted) <= set(FORMATS):
        raise SpecError(f"--formats {','.join(formats)} is not allowed; choose any of {', '.join(FORMATS)}.")
    if audit:
        require_pymeshlab()
    name = file_stem(body)
    with open_output(folder, force) as staging:
        progress("making the solid")
        promised_um = _promised_deviation_um(body, deviation_um)
        solid = body_solid(body, promised_um)
        progress("making the mesh")
        mesh = body_mesh(body, sag_um)

        progress("writing the files")
        paths = [staging / f"{name}.{kind}" for kind in wanted]
        for path in paths:
            if path.suffix == ".step":
                write_step(path, [NamedSolid(name, solid, _COLOR)], name)
            elif path.suffix == ".stl":
                write_stl(path, mesh, name)
            else:
                write_3mf(path, [NamedMesh(name, mesh)])

        progress("reading the files back")
        model = mass_properties(body)
        boundary = Boundary.of_body(body)
        as_mesh = Expected(name, model.volume_mm3, model.com_mm, sag_um, boundary)
        as_solid = Expected(name, model.volume_mm3, model.com_mm, promised_um, boundary)
        found = [
            inspect_file(path, [as_solid if path.suffix == ".step" else as_mesh], audit) for path in paths
        ]

        progress("judging")
        entry = catalogue_entries().get(body.name)
        refuted = (entry.reason,) if entry is not None and entry.status == "refuted" else ()
        verdict = judge(body, model.com_mm, refuted + problems_of(found))
        transferred = _transfer(body, verdict, [path for path in paths if path.suffix == ".step"])
    measured = solid_mass(solid)
    census = verdict.census
    return {
        "folder": str(folder),
        "body": body.name,
        "diameter_mm": body.diameter_mm,
        "files": [file_document(file) for file in found],
        "max_deviation_um": max_deviation_um(solid, [InsetSurface(body)]),
        "sag_um": sag_um,
        "volume_mm3": measured.volume_mm3,
        "com_mm": list(measured.com_mm),
        "s_margin_mm": census.margin.s_margin_mm if census and census.margin else None,
        "rest": rest_document(census.rest) if census else None,
        "transfer": inheritance_document(transferred),
        "verdict": verdict.verdict,
        "reasons": [*verdict.reasons, *inheritance_reasons(transferred)],
    }


def _transfer(body: Body, verdict: Verdict, steps: list[Path]) -> Transfer | str | None:
    """Whether the STEP file as read back has the census of the body; None if there is nothing to compare."""
    if verdict.census is None or not steps:
        return None
    solids = [part.solid for part in read_step(steps[0])]
    return inherited(solids, body, verdict.census, solid_mass(solids[0]).com_mm)


def _promised_deviation_um(body: Body, asked_um: float | None) -> float:
    if asked_um is None:
        return default_deviation_um(body)
    if not (math.isfinite(asked_um) and asked_um > 0.0):
        raise SpecError(f"The deviation must be a positive length in µm, not {asked_um!r}.")
    return asked_um


def file_stem(body: Body) -> str:
    """Name of a body's files: its name with everything but letters, digits, dots and dashes replaced."""
    kept = "".join(c if c.isascii() and (c.isalnum() or c in ".-") else "-" for c in body.name)
    return kept.strip("-.") or "body"

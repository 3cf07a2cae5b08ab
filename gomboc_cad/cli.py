"""The command line: every command is a few lines over the library."""

from __future__ import annotations

import signal
import sys
from pathlib import Path
from typing import Annotated

import typer
from typer.exceptions import TyperException

from gomboc_cad.arguments import (
    BAD_INPUT,
    FAILED,
    INTERRUPTED,
    PASSED,
    PRODUCT_NAMES,
    AsJson,
    Audit,
    Beta,
    BodyName,
    Changes,
    Coefficients,
    ComOption,
    Diameter,
    FamilyName,
    Force,
    Output,
    Quiet,
    Subject,
    WithReport,
    chosen_body,
    chosen_body_and_com,
    decimals,
    design_stages,
    exact_decimals,
    numbers,
    require_absent,
    require_new_toml,
    with_figure,
)
from gomboc_cad.console import (
    Reporter,
    show_body,
    show_build,
    show_catalog,
    show_census,
    show_certificate,
    show_check,
    show_drill_map,
    show_templates,
    show_zone,
)
from gomboc_cad.errors import GombocError, NotConvexError
from gomboc_cad.long_commands import design, paper, tolerance
from gomboc_cad.report_command import report

app = typer.Typer(
    name="gomboc-cad",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)


def _version(wanted: bool) -> None:
    if wanted:
        from gomboc_cad import __version__

        print(f"gomboc-cad {__version__}")
        raise typer.Exit


@app.callback()
def options(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Show the version and exit.")
    ] = False,
) -> None:
    """Self-righting bodies and products: verified parameters in, rechecked CAD solids out."""


@app.command()
def catalog(json: AsJson = False, quiet: Quiet = False) -> int:
    """List the bodies with their status."""
    from gomboc_cad.documents import catalog_document

    Reporter(json, quiet).document(catalog_document(), show_catalog)
    return PASSED


@app.command()
def templates(
    name: Annotated[str | None, typer.Argument(metavar="[NAME]", help="One to copy.")] = None,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", metavar="FILE.toml", help="Where the copy goes.")
    ] = None,
    force: Force = False,
    json: AsJson = False,
    quiet: Quiet = False,
) -> int:
    """List what a spec may name, or copy a template to edit it."""
    from gomboc_cad.products.template_files import copy_template, template_names, template_values

    if (name is None) != (output is None):
        raise GombocError("Give the name of a template and -o FILE.toml to copy it, or neither to list all.")
    if name is not None and output is not None:
        require_new_toml(output, force)
        copy_template(name, output)
    file = None if output is None else str(output)
    document = {**template_names(), **template_values(), "file": file}
    Reporter(json, quiet).document(document, show_templates)
    return PASSED


@app.command()
def census(
    body: BodyName = None,
    family: FamilyName = None,
    beta: Beta = None,
    coef: Coefficients = None,
    diameter_mm: Diameter = None,
    com_mm: ComOption = None,
    json: AsJson = False,
    quiet: Quiet = False,
) -> int:
    """Count all resting positions of a body, about its centroid or about a given centre of mass.

    A body that is not convex rests on its hull, which is censused as a fine mesh. Exits with 1 when there
    is more than one stable rest, or that is undecided.
    """
    from gomboc_cad.documents import census_document, hull_census_document
    from gomboc_cad.equilibria import hull_census, smooth_census

    chosen = chosen_body(body, family, beta, coef, diameter_mm)
    com = None if com_mm is None else numbers("--com-mm", com_mm)
    try:
        found = smooth_census(chosen, com)
        document = census_document(chosen, found)
    except NotConvexError:
        found = hull_census(chosen, com)
        document = hull_census_document(chosen, found)
    Reporter(json, quiet).document(document, show_census)
    return PASSED if found.verdict == "monostable" else FAILED


@app.command(name="body")
def bare_body(
    output: Output,
    body: BodyName = None,
    family: FamilyName = None,
    beta: Beta = None,
    coef: Coefficients = None,
    diameter_mm: Diameter = None,
    formats: Annotated[str, typer.Option(help="Any of step, stl, 3mf.")] = "step,stl,3mf",
    sag_um: Annotated[float, typer.Option(help="Largest distance of a facet from the true surface.")] = 10.0,
    deviation_um: Annotated[
        float | None, typer.Option(help="Largest distance of the STEP solid from the true surface.")
    ] = None,
    force: Force = False,
    audit: Audit = False,
    json: AsJson = False,
    quiet: Quiet = False,
) -> int:
    """Write the bare body as STEP, STL and 3MF, read the files back and judge it."""
    from gomboc_cad.products.bare_body import STAGES, write_body

    reporter = Reporter(json, quiet)
    chosen = chosen_body(body, family, beta, coef, diameter_mm)
    with reporter.stages(STAGES) as progress:
        document = write_body(
            chosen,
            output,
            formats.split(","),
            sag_um,
            deviation_um=deviation_um,
            force=force,
            audit=audit,
            progress=progress,
        )
    reporter.document(document, show_body)
    return PASSED if document["verdict"] == "PASS" else FAILED


@app.command()
def check(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="A STEP, STL, 3MF, OBJ or PLY file.")],
    com_mm: ComOption = None,
    unit: Annotated[
        str | None, typer.Option("--unit", help="Unit of a file that states none: mm, um, cm, m, in or ft.")
    ] = None,
    barrier_um: Annotated[
        float | None,
        typer.Option(
            "--barrier-um",
            metavar="E",
            help="Poses with a lower barrier do not count; by default what the mesh resolves.",
        ),
    ] = None,
    faceted: Annotated[
        bool, typer.Option("--faceted", help="The part really has the facets of its mesh.")
    ] = False,
    json: AsJson = False,
    quiet: Quiet = False,
) -> int:
    """Count the poses in which any part rests, each with the barrier around it.

    Exits with 1 when there is more than one, or that is undecided.
    """
    from gomboc_cad.documents import check_document
    from gomboc_cad.solid.check import check_part

    reporter = Reporter(json, quiet)
    com = None if com_mm is None else numbers("--com-mm", com_mm)
    with reporter.stages(None) as progress:
        found = check_part(
            file, com_mm=com, unit=unit, barrier_um=barrier_um, faceted=faceted, progress=progress
        )
    reporter.document(check_document(found), show_check)
    return PASSED if found.census.verdict == "monostable" else FAILED


@app.command()
def certify(
    body: BodyName = None,
    family: FamilyName = None,
    beta: Beta = None,
    coef: Coefficients = None,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", metavar="FILE", help="Where the certificate goes.")
    ] = None,
    com_r0: Annotated[
        str | None,
        typer.Option("--com-r0", metavar="X,Y,Z", help="Centre of mass in units of R0, as exact decimals."),
    ] = None,
    verify: Annotated[
        Path | None, typer.Option("--verify", metavar="FILE", help="Check a certificate instead.")
    ] = None,
    force: Force = False,
    json: AsJson = False,
    quiet: Quiet = False,
) -> int:
    """Prove from its exact decimals that a body has one stable and one unstable pose, or refute it.

    With --verify every claim of a certificate is proven again. Exits with 1 when the body is not proven, or
    the certificate not accepted.
    """
    from time import perf_counter

    from gomboc_cad.documents import certificate_document, verification_document
    from gomboc_cad.equilibria import certificate
    from gomboc_cad.equilibria.certificate.checker import STAGES
    from gomboc_cad.solid.output import write_bytes

    reporter, begin = Reporter(json, quiet), perf_counter()
    if verify is not None:
        if any(other is not None for other in (body, family, output, com_r0)):
            raise GombocError("--verify takes a certificate and nothing else: no body, --com-r0 or --output.")
        read = certificate.load(verify)
        with reporter.stages(STAGES) as progress:
            checked = certificate.verify(read, progress)
        document = verification_document(read, checked, perf_counter() - begin)
        reporter.document(document, show_certificate)
        return PASSED if checked.accepted and read.status == "proven" else FAILED
    parameters = exact_decimals(body, family, beta, coef)
    com = None if com_r0 is None else decimals("--com-r0", com_r0)
    if output is not None:
        require_absent(output, force)
    with reporter.stages(STAGES) as progress:
        made = certificate.certify(parameters, progress, com=com)
    if output is not None:
        write_bytes(output, certificate.dumps(made).encode())
    reporter.document(certificate_document(made, output, perf_counter() - begin), show_certificate)
    return PASSED if made.status == "proven" else FAILED


@app.command()
def zone(
    body: Subject = None,
    family: FamilyName = None,
    beta: Beta = None,
    coef: Coefficients = None,
    diameter_mm: Diameter = None,
    com_mm: ComOption = None,
    changes: Changes = None,
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", metavar="FILE.stl", help="Write the zone, and a figure beside it."),
    ] = None,
    fineness: Annotated[
        float, typer.Option("--fineness", help="0.5 to 2; at 0.5 a quarter of the triangles, sooner.")
    ] = 1.0,
    force: Force = False,
    json: AsJson = False,
    quiet: Quiet = False,
) -> int:
    """Find where the centre of mass may be so that one stable rest stays, and where it is best."""
    from gomboc_cad.documents import zone_document
    from gomboc_cad.equilibria.zone import STAGES, loading_zone
    from gomboc_cad.report.zone_figures import write_zone

    reporter = Reporter(json, quiet)
    files = with_figure(output, ".stl", force)
    with reporter.stages(STAGES + design_stages(body)) as progress:
        chosen, com = chosen_body_and_com(body, family, beta, coef, diameter_mm, com_mm, changes, progress)
        found = loading_zone(chosen, com, fineness=fineness, progress=progress)
    if files:
        write_zone(found, *files)
    reporter.document(zone_document(found, files), show_zone)
    return PASSED


@app.command()
def drillmap(
    body: Subject = None,
    family: FamilyName = None,
    beta: Beta = None,
    coef: Coefficients = None,
    diameter_mm: Diameter = None,
    com_mm: ComOption = None,
    changes: Changes = None,
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", metavar="FILE.csv", help="Write the table, and a figure beside it."),
    ] = None,
    sites: Annotated[int, typer.Option("--sites", min=1, max=20_000, help="Number of directions.")] = 500,
    force: Force = False,
    json: AsJson = False,
    quiet: Quiet = False,
) -> int:
    """Find the largest hole or flat allowed at each place before the part can rest on it."""
    from gomboc_cad.documents import drill_document
    from gomboc_cad.equilibria.drill_map import drill_map
    from gomboc_cad.report.drill_figures import draw_drill_map, write_drill_table

    reporter = Reporter(json, quiet)
    files = with_figure(output, ".csv", force)
    with reporter.stages(1 + design_stages(body)) as progress:
        chosen, com = chosen_body_and_com(body, family, beta, coef, diameter_mm, com_mm, changes, progress)
        progress("mapping the surface")
        found = drill_map(chosen, com, sites=sites)
    if files:
        table, figure = files
        write_drill_table(found, table)
        draw_drill_map(found, figure)
    reporter.document(drill_document(found, files), show_drill_map)
    return PASSED


@app.command()
def build(
    spec: Annotated[str, typer.Argument(metavar="SPEC", help=f"A TOML file, or a product: {PRODUCT_NAMES}.")],
    output: Output,
    changes: Changes = None,
    force: Force = False,
    allow_unverified: Annotated[
        bool, typer.Option("--allow-unverified", help="Build of a refuted or non-convex body too.")
    ] = False,
    audit: Audit = False,
    with_report: WithReport = True,
    json: AsJson = False,
    quiet: Quiet = False,
) -> int:
    """Build a product: parts, assembly, read-back inspection and verdict."""
    from gomboc_cad.products.build import STAGES, build_product

    reporter = Reporter(json, quiet)
    with reporter.stages(STAGES) as progress:
        document = build_product(
            spec,
            output,
            changes=changes or (),
            force=force,
            allow_unverified=allow_unverified,
            audit=audit,
            report=with_report,
            progress=progress,
        )
    reporter.document(document, show_build)
    return PASSED if document["verdict"] == "PASS" else FAILED


for _command in (design, tolerance, report, paper):
    app.command()(_command)


def main() -> None:
    """Run the command line; errors that a user can cause become one sentence and exit code 2."""
    # A polite request to end is an interrupt like any other: temporary files are removed.
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        code = app(prog_name="gomboc-cad", standalone_mode=False)
    except (GombocError, TyperException) as error:
        message = error.format_message() if isinstance(error, TyperException) else str(error)
        print(f"gomboc-cad: {message}", file=sys.stderr)
        code = BAD_INPUT
    except (KeyboardInterrupt, typer.Abort):
        code = INTERRUPTED
    if code == INTERRUPTED:
        print("gomboc-cad: interrupted; nothing half-written was left.", file=sys.stderr)
    sys.exit(code)

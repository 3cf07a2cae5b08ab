"""The command line: every command is a few lines over the library."""

from __future__ import annotations

import signal
import sys
from pathlib import Path
from typing import Annotated, Any

import typer
from typer.exceptions import TyperException

from gomboc_cad.console import (
    Reporter,
    show_body,
    show_build,
    show_catalog,
    show_census,
    show_certificate,
    show_check,
    show_drill_map,
    show_zone,
)
from gomboc_cad.errors import GombocError, NotConvexError

PASSED, FAILED, BAD_INPUT, INTERRUPTED = 0, 1, 2, 130

app = typer.Typer(
    name="gomboc-cad",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)

BodyName = Annotated[
    str | None, typer.Argument(metavar="[BODY]", help="Catalogue name, for example primary.")
]
Subject = Annotated[
    str | None,
    typer.Argument(metavar="[BODY|SPEC]", help="Catalogue name, a TOML file, or a product: imu-housing."),
]
FamilyName = Annotated[
    str | None,
    typer.Option("--family", metavar="NAME", help="sloan1, sloan2, extended or harmonic, instead of BODY."),
]
Beta = Annotated[float | None, typer.Option("--beta", help="Amplitude of a Sloan family.")]
Coefficients = Annotated[
    list[str] | None,
    typer.Option("--coef", metavar="K=A", help="Coefficient k=a, or l,m=c for harmonic; repeatable."),
]
Diameter = Annotated[float, typer.Option("--diameter-mm", help="Nominal diameter 2 R0.")]
ComOption = Annotated[str | None, typer.Option("--com-mm", metavar="X,Y,Z", help="Centre of mass.")]
Output = Annotated[Path, typer.Option("--output", "-o", help="Folder to write to.")]
Force = Annotated[bool, typer.Option("--force", help="Overwrite files of the same names.")]
Audit = Annotated[bool, typer.Option("--audit", help="Inspect the meshes with PyMeshLab too (extra: audit).")]
AsJson = Annotated[bool, typer.Option("--json", help="One JSON object on stdout, nothing else there.")]
Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="No progress and no tables.")]


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
def census(
    body: BodyName = None,
    family: FamilyName = None,
    beta: Beta = None,
    coef: Coefficients = None,
    diameter_mm: Diameter = 100.0,
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

    chosen = _body(body, family, beta, coef, diameter_mm)
    com = None if com_mm is None else _numbers("--com-mm", com_mm)
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
    diameter_mm: Diameter = 100.0,
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
    chosen = _body(body, family, beta, coef, diameter_mm)
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
    com = None if com_mm is None else _numbers("--com-mm", com_mm)
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
        if body is not None or family is not None or output is not None:
            raise GombocError("--verify takes a certificate and nothing else: neither a body nor --output.")
        read = certificate.load(verify)
        with reporter.stages(STAGES) as progress:
            checked = certificate.verify(read, progress)
        document = verification_document(read, checked, perf_counter() - begin)
        reporter.document(document, show_certificate)
        return PASSED if checked.accepted and read.status == "proven" else FAILED
    parameters = _exact_parameters(body, family, beta, coef)
    if output is not None:
        _require_absent(output, force)
    with reporter.stages(STAGES) as progress:
        made = certificate.certify(parameters, progress)
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
    diameter_mm: Diameter = 100.0,
    com_mm: ComOption = None,
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", metavar="FILE.stl", help="Write the zone, and a figure beside it."),
    ] = None,
    force: Force = False,
    json: AsJson = False,
    quiet: Quiet = False,
) -> int:
    """Find where the centre of mass may be so that one stable rest stays, and where it is best."""
    from gomboc_cad.documents import zone_document
    from gomboc_cad.equilibria.zone import STAGES, loading_zone
    from gomboc_cad.report.zone_figures import write_zone

    reporter = Reporter(json, quiet)
    files = _with_figure(output, ".stl", force)
    chosen, com = _body_and_com(body, family, beta, coef, diameter_mm, com_mm)
    with reporter.stages(STAGES) as progress:
        found = loading_zone(chosen, com, progress=progress)
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
    diameter_mm: Diameter = 100.0,
    com_mm: ComOption = None,
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
    files = _with_figure(output, ".csv", force)
    chosen, com = _body_and_com(body, family, beta, coef, diameter_mm, com_mm)
    with reporter.stages(None) as progress:
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
    spec: Annotated[str, typer.Argument(metavar="SPEC", help="A TOML file, or a product: imu-housing.")],
    output: Output,
    force: Force = False,
    allow_unverified: Annotated[
        bool, typer.Option("--allow-unverified", help="Build of a refuted or non-convex body too.")
    ] = False,
    audit: Audit = False,
    json: AsJson = False,
    quiet: Quiet = False,
) -> int:
    """Build a product: parts, assembly, read-back inspection and verdict."""
    from gomboc_cad.products.build import STAGES, build_product

    reporter = Reporter(json, quiet)
    with reporter.stages(STAGES) as progress:
        document = build_product(
            spec, output, force=force, allow_unverified=allow_unverified, audit=audit, progress=progress
        )
    reporter.document(document, show_build)
    return PASSED if document["verdict"] == "PASS" else FAILED


def _body(
    name: str | None,
    family: str | None,
    beta: float | None,
    coefficients: list[str] | None,
    diameter_mm: float,
) -> Any:
    """Make the body that the options describe."""
    from gomboc_cad.body import make_body
    from gomboc_cad.body.catalogue import named_body

    if (name is None) == (family is None):
        raise GombocError("Give either the name of a body (gomboc-cad catalog lists them) or --family.")
    if not 1.0 <= diameter_mm <= 1e5:
        raise GombocError(f"--diameter-mm {diameter_mm:g} is not allowed; choose a size from 1 to 100000 mm.")
    if name is not None:
        if beta is not None or coefficients:
            raise GombocError("--beta and --coef go with --family, not with the name of a body.")
        return named_body(name, diameter_mm)
    terms = {}
    for text in coefficients or []:
        key, _, value = text.partition("=")
        terms[key.strip()] = _numbers("--coef", value, count=1)[0]
    return make_body(family or "", beta, terms, diameter_mm=diameter_mm)


def _body_and_com(
    name: str | None,
    family: str | None,
    beta: float | None,
    coefficients: list[str] | None,
    diameter_mm: float,
    com_mm: str | None,
) -> tuple[Any, Any]:
    """The body and the centre of mass of a product or of a bare body; another one if it is given."""
    from gomboc_cad.products.subject import body_and_com, is_spec

    subject: Any = name
    if name is None or not is_spec(name):
        subject = _body(name, family, beta, coefficients, diameter_mm)
    elif family is not None or beta is not None or coefficients:
        raise GombocError("--family, --beta and --coef go with a bare body, not with a product.")
    chosen, com = body_and_com(subject)
    return chosen, com if com_mm is None else _numbers("--com-mm", com_mm)


def _with_figure(path: Path | None, suffix: str, force: bool) -> tuple[Path, ...]:
    """A file to write and the figure beside it; nothing if no file is wanted."""
    if path is None:
        return ()
    if path.suffix.lower() != suffix:
        raise GombocError(f"{path} must end in {suffix}; a figure of the same name is written beside it.")
    files = (path, path.with_suffix(".png"))
    for file in files:
        _require_absent(file, force)
    return files


def _exact_parameters(
    name: str | None, family: str | None, beta: float | None, coefficients: list[str] | None
) -> Any:
    """The decimals of the body that the options describe, as they were written."""
    from gomboc_cad.body.catalogue import ExactParameters, exact_parameters

    body = _body(name, family, beta, coefficients, diameter_mm=100.0)
    return ExactParameters.of(body) if name is None else exact_parameters(name)


def _require_absent(path: Path, force: bool) -> None:
    if path.is_dir():
        raise GombocError(f"{path} is a folder; name a file to write to.")
    if path.exists() and not force:
        raise GombocError(f"{path} is there already; give another name, or --force to replace it.")


def _numbers(option: str, text: str, count: int = 3) -> list[float]:
    try:
        values = [float(part) for part in text.split(",")]
    except ValueError:
        values = []
    if len(values) != count:
        form = "three numbers X,Y,Z in mm" if count == 3 else "K=A with a number A"
        raise GombocError(f"{option} needs {form}, not {text!r}.")
    return values


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

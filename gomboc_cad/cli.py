"""The command line: every command is a few lines over the library."""

from __future__ import annotations

import signal
import sys
from pathlib import Path
from typing import Annotated, Any

import typer
from typer.exceptions import TyperException

from gomboc_cad.console import Reporter, show_body, show_build, show_catalog, show_census
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
    com_mm: Annotated[str | None, typer.Option("--com-mm", metavar="X,Y,Z", help="Centre of mass.")] = None,
    json: AsJson = False,
    quiet: Quiet = False,
) -> int:
    """Count all resting positions of a body, about its centroid or about a given centre of mass.

    Exits with 1 when the body has more than one stable rest or is not strictly convex.
    """
    from gomboc_cad.documents import census_document, not_convex_document
    from gomboc_cad.equilibria import convexity, smooth_census

    chosen = _body(body, family, beta, coef, diameter_mm)
    try:
        found = smooth_census(chosen, None if com_mm is None else _numbers("--com-mm", com_mm))
    except NotConvexError as error:
        Reporter(json, quiet).document(
            not_convex_document(chosen, convexity(chosen), str(error)), show_census
        )
        return FAILED
    Reporter(json, quiet).document(census_document(chosen, found), show_census)
    return PASSED if found.stable == 1 else FAILED


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

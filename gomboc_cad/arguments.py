"""What the arguments of the command line are called, and what they stand for."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from gomboc_cad.errors import GombocError
from gomboc_cad.progress import Progress

PASSED, FAILED, BAD_INPUT, INTERRUPTED = 0, 1, 2, 130
"""Exit codes."""

PRODUCT_NAMES = "imu-housing, seed-pod, buoy"
DEFAULT_DIAMETER_MM = 100.0
BodyName = Annotated[
    str | None,
    typer.Argument(metavar="[BODY]", help="Catalogue name, for example primary, or a TOML file with [body]."),
]
Subject = Annotated[
    str | None,
    typer.Argument(metavar="[BODY|SPEC]", help=f"Catalogue name, TOML file or product: {PRODUCT_NAMES}."),
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
Diameter = Annotated[
    float | None,
    typer.Option("--diameter-mm", help="Nominal diameter 2 R0; 100 unless a file says otherwise."),
]
ComOption = Annotated[str | None, typer.Option("--com-mm", metavar="X,Y,Z", help="Centre of mass.")]
Changes = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="KEY=VALUE", help="Change the spec: body.diameter_mm=60; repeatable."),
]
Output = Annotated[Path, typer.Option("--output", "-o", help="Folder to write to.")]
Force = Annotated[bool, typer.Option("--force", help="Overwrite files of the same names.")]
WithReport = Annotated[
    bool, typer.Option("--report/--no-report", help="Write report.html and its figures too.")
]
Audit = Annotated[bool, typer.Option("--audit", help="Inspect the meshes with PyMeshLab too (extra: audit).")]
AsJson = Annotated[bool, typer.Option("--json", help="One JSON object on stdout, nothing else there.")]
Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="No progress and no tables.")]


def chosen_body(
    name: str | None,
    family: str | None,
    beta: float | None,
    coefficients: list[str] | None,
    diameter_mm: float | None,
) -> Any:
    """Make the body that the options describe."""
    from gomboc_cad.body import make_body
    from gomboc_cad.body.catalogue import named_body
    from gomboc_cad.products.body_file import load_body

    if (name is None) == (family is None):
        raise GombocError("Give either the name of a body (gomboc-cad catalog lists them) or --family.")
    if diameter_mm is not None and not 1.0 <= diameter_mm <= 1e5:
        raise GombocError(f"--diameter-mm {diameter_mm:g} is not allowed; choose a size from 1 to 100000 mm.")
    if name is not None:
        if beta is not None or coefficients:
            raise GombocError("--beta and --coef go with --family, not with the name of a body.")
        if name.lower().endswith(".toml"):
            return load_body(Path(name), diameter_mm)
        return named_body(name, diameter_mm or DEFAULT_DIAMETER_MM)
    terms = {}
    for text in coefficients or []:
        key, _, value = text.partition("=")
        terms[key.strip()] = numbers("--coef", value, count=1)[0]
    return make_body(family or "", beta, terms, diameter_mm=diameter_mm or DEFAULT_DIAMETER_MM)


def chosen_body_and_com(
    name: str | None,
    family: str | None,
    beta: float | None,
    coefficients: list[str] | None,
    diameter_mm: float | None,
    com_mm: str | None,
    changes: list[str] | None,
    progress: Progress,
) -> tuple[Any, Any]:
    """The body and the centre of mass of a product or of a bare body; another one if it is given."""
    from gomboc_cad.products.subject import body_and_com, is_spec

    subject: Any = name
    if name is None or not is_spec(name):
        subject = chosen_body(name, family, beta, coefficients, diameter_mm)
    elif family is not None or beta is not None or coefficients:
        raise GombocError("--family, --beta and --coef go with a bare body, not with a product.")
    chosen, com = body_and_com(subject, progress, changes=changes or ())
    return chosen, com if com_mm is None else numbers("--com-mm", com_mm)


def design_stages(name: str | None) -> int:
    """How many stages `chosen_body_and_com` reports."""
    from gomboc_cad.products.subject import DESIGN_STAGES, is_spec

    return DESIGN_STAGES if name is not None and is_spec(name) else 0


def with_figure(path: Path | None, suffix: str, force: bool) -> tuple[Path, ...]:
    """A file to write and the figure beside it; nothing if no file is wanted."""
    if path is None:
        return ()
    if path.suffix.lower() != suffix:
        raise GombocError(f"{path} must end in {suffix}; a figure of the same name is written beside it.")
    files = (path, path.with_suffix(".png"))
    for file in files:
        require_absent(file, force)
    return files


def exact_decimals(
    name: str | None, family: str | None, beta: float | None, coefficients: list[str] | None
) -> Any:
    """The decimals of the body that the options describe, as they were written."""
    from gomboc_cad.body.catalogue import ExactParameters, catalogue_names, exact_parameters

    body = chosen_body(name, family, beta, coefficients, diameter_mm=None)
    return exact_parameters(body.name) if body.name in catalogue_names() else ExactParameters.of(body)


def decimals(option: str, text: str) -> tuple[str, str, str]:
    """Three decimals that are separated by commas, as they were written."""
    parts = [part.strip() for part in text.split(",")]
    if len(parts) != 3:
        raise GombocError(f"{option} needs three decimals X,Y,Z, not {text!r}.")
    x, y, z = parts
    return x, y, z


def require_new_toml(path: Path, force: bool) -> None:
    """Refuse, before a long search, a file that no command would read as a body or that cannot be written."""
    if path.suffix.lower() != ".toml":
        raise GombocError(f"{path} must end in .toml.")
    if not path.absolute().parent.is_dir():
        raise GombocError(f"The folder of {path} does not exist; make it first.")
    require_absent(path, force)


def require_absent(path: Path, force: bool) -> None:
    """Refuse a file to write that is a folder, or is there already and may not be replaced."""
    if path.is_dir():
        raise GombocError(f"{path} is a folder; name a file to write to.")
    if path.exists() and not force:
        raise GombocError(f"{path} is there already; give another name, or --force to replace it.")


def numbers(option: str, text: str, count: int = 3) -> list[float]:
    """Read numbers that are separated by commas."""
    try:
        values = [float(part) for part in text.split(",")]
    except ValueError:
        values = []
    if len(values) != count:
        form = "three numbers X,Y,Z in mm" if count == 3 else "K=A with a number A"
        raise GombocError(f"{option} needs {form}, not {text!r}.")
    return values

"""Manufacturing processes as data: what each can make."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import Field, model_validator

from gomboc_cad.body.sphere import Array, IntArray
from gomboc_cad.errors import SpecError
from gomboc_cad.products.common_spec import ShellSpec
from gomboc_cad.products.data_files import data_names, load_data
from gomboc_cad.products.process_tolerances import ProcessTolerances, Source
from gomboc_cad.products.toml_model import Number, Text, TomlModel, parse_model, read_toml
from gomboc_cad.resources import template_folder

Kind = Literal["printed", "machined", "moulded"]
Length = Annotated[Number, Field(gt=0.0, le=10_000.0)]

_FOLDER = "processes"
_LIKE = "like"


class Process(TomlModel):
    """A way of making parts.

    Attributes:
        name: Full name.
        kind: `printed`, `machined` or `moulded`.
        min_wall_mm: The thinnest wall that it makes reliably, where the wall hangs together with others on
            two sides or more, as that of a shell does.
        min_wall_source: Where that comes from.
        undercuts_matter: Whether a surface that two opposite sides do not reach costs slides, another
            clamping, or cannot be made at all.
        typical_size_mm: Largest part on a common machine, along three edges; None where machines differ too
            much to say.
        typical_size_source: Where that comes from.
        tolerances: What a study of tolerances needs to know; a file that is used for walls and undercuts only
            may leave it out.
    """

    name: Text
    kind: Kind
    min_wall_mm: Annotated[Number, Field(gt=0.0, le=50.0)]
    min_wall_source: Source
    undercuts_matter: bool
    typical_size_mm: tuple[Length, Length, Length] | None = None
    typical_size_source: Source | None = None
    tolerances: ProcessTolerances | None = None

    @model_validator(mode="after")
    def _sourced(self) -> Process:
        if (self.typical_size_mm is None) != (self.typical_size_source is None):
            raise ValueError("typical_size_mm and typical_size_source go together")
        if self.tolerances is not None and (self.tolerances.layers is None) == (self.kind == "printed"):
            raise ValueError("tolerances.layers goes with a printed process, and only with one")
        return self


def process_names() -> tuple[str, ...]:
    """Names of the processes that come with the package."""
    return data_names(_FOLDER)


def load_process(name: str, beside: Path | None = None) -> Process:
    """Read a process by the name of a template or by the path of a user's own file.

    A user's own file may say `like = "fdm"` and give only what differs: tables are taken over key by key, a
    figure is replaced as a whole, with its range and its source.

    Args:
        name: `fdm`, or a path that ends in `.toml`.
        beside: Folder that a relative path starts from, usually that of the spec.

    Raises:
        SpecError: If there is no such process or its file is wrong.
    """
    if not name.endswith(".toml"):
        return load_data(Process, _FOLDER, name, beside)
    path = (beside or Path()) / name
    own = read_toml(path)
    if _LIKE not in own:
        return parse_model(Process, own, path.name)
    pattern = own.pop(_LIKE)
    if pattern not in process_names():
        raise SpecError(
            f"{path.name}: like = {pattern!r} is not allowed (allowed: {', '.join(process_names())})."
        )
    base = read_toml(template_folder() / _FOLDER / f"{pattern}.toml")
    return parse_model(Process, _overridden(base, own), path.name)


def known_tolerances(process: Process) -> ProcessTolerances:
    """The tolerances of a process.

    Raises:
        SpecError: If its file says nothing of them.
    """
    if process.tolerances is None:
        raise SpecError(
            f"The file of the process {process.name} has no tables [tolerances.*]; write them, or begin the "
            'file with like = "fdm" (or another process) and give only what differs.'
        )
    return process.tolerances


def form_amplitudes_mm(process: Process, size_mm: float, degrees: IntArray) -> Array:
    """Root mean square over the sphere of the error of form, by spherical-harmonic degree.

    A harmonic of degree n has up to n undulations on a great circle, and over many degrees the spectrum of a
    great circle falls with the same exponent; so the degree stands for the undulations per revolution.

    Args:
        process: The process.
        size_mm: Largest dimension of the part, which is the diameter of a round one.
        degrees: Whole numbers, any shape.

    Returns:
        Amplitudes in mm, same shape; 0 outside of the orders of the process. The square root of the sum of
        their squares over all its orders is `process.tolerances.form.rms_mm(size_mm)`.

    Raises:
        SpecError: If the file of the process says nothing of its tolerances.
    """
    return known_tolerances(process).form.amplitudes_mm(size_mm, degrees)


def _overridden(base: dict[str, Any], own: dict[str, Any]) -> dict[str, Any]:
    """A table with some of its keys replaced; tables within it key by key, but figures as a whole."""
    return base | {key: _replacement(base.get(key), value) for key, value in own.items()}


def _replacement(old: Any, new: Any) -> Any:
    tables = isinstance(old, dict) and isinstance(new, dict)
    return _overridden(old, new) if tables and "source" not in old else new


def least_wall_mm(shell: ShellSpec, beside: Path | None = None) -> float:
    """The least wall that may be left of a shell: what its spec says, or else the minimum of its process.

    Args:
        shell: The shell.
        beside: Folder that the path of a user's own process starts from, usually that of the spec.

    Raises:
        SpecError: If the process is unknown, or makes no wall as thin as the spec asks for.
    """
    process = load_process(shell.process, beside)
    for key, wall_mm in (("wall_mm", shell.wall_mm), ("min_wall_mm", shell.min_wall_mm)):
        if wall_mm is not None and wall_mm < process.min_wall_mm:
            raise SpecError(
                f"shell.{key} = {wall_mm:g} is thinner than the {process.min_wall_mm:g} mm that the process "
                f"{process.name} makes reliably; make it thicker or choose another shell.process."
            )
    return process.min_wall_mm if shell.min_wall_mm is None else shell.min_wall_mm

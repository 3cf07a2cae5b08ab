"""Manufacturing processes as data: what each can make."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field, model_validator

from gomboc_cad.errors import SpecError
from gomboc_cad.products.common_spec import ShellSpec
from gomboc_cad.products.data_files import data_names, load_data
from gomboc_cad.products.toml_model import Number, Text, TomlModel

Kind = Literal["printed", "machined", "moulded"]
Length = Annotated[Number, Field(gt=0.0, le=10_000.0)]
Source = Annotated[str, Field(strict=True, min_length=1, max_length=800)]


_FOLDER = "processes"


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
    """

    name: Text
    kind: Kind
    min_wall_mm: Annotated[Number, Field(gt=0.0, le=50.0)]
    min_wall_source: Source
    undercuts_matter: bool
    typical_size_mm: tuple[Length, Length, Length] | None = None
    typical_size_source: Source | None = None

    @model_validator(mode="after")
    def _sourced(self) -> Process:
        if (self.typical_size_mm is None) != (self.typical_size_source is None):
            raise ValueError("typical_size_mm and typical_size_source go together")
        return self


def process_names() -> tuple[str, ...]:
    """Names of the processes that come with the package."""
    return data_names(_FOLDER)


def load_process(name: str, beside: Path | None = None) -> Process:
    """Read a process by the name of a template or by the path of a user's own file.

    Args:
        name: `fdm`, or a path that ends in `.toml`.
        beside: Folder that a relative path starts from, usually that of the spec.

    Raises:
        SpecError: If there is no such process or its file is wrong.
    """
    return load_data(Process, _FOLDER, name, beside)


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

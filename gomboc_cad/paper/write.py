"""The reproduced tables as files: JSON, a page in Markdown, and its figures."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Any

from gomboc_cad.paper.figures import FIGURES
from gomboc_cad.paper.page import page
from gomboc_cad.paper.registry import reproduce
from gomboc_cad.progress import Progress, silent
from gomboc_cad.reproducible import one_blas_thread
from gomboc_cad.solid.output import json_bytes, open_output, write_bytes

PAGE_NAME = "paper.md"
JSON_NAME = "paper.json"


@one_blas_thread()
def write_paper(
    folder: Path, names: Iterable[str] | None = None, *, force: bool = False, progress: Progress = silent
) -> dict[str, Any]:
    """Reproduce tables and write `paper.json`, `paper.md` and the figures of these tables.

    Args:
        folder: Where the files go.
        names: Names of tables; all of them if not given.
        force: Allow a folder that holds something already.
        progress: Told what is being computed.

    Returns:
        The document of `gomboc-cad paper`: keys `folder`, `tables`, `files`.

    Raises:
        GombocError: If there is no table of a name.
        OutputError: If the folder holds something and `force` is not set, or cannot be written.
    """
    with open_output(folder, force) as staging:
        tables = reproduce(names, progress)
        document = {"tables": [table.document() for table in tables]}
        write_bytes(staging / JSON_NAME, json_bytes(document))
        write_bytes(staging / PAGE_NAME, page(tables, ".").encode())
        drawn = write_figures(staging, {table.name for table in tables}, progress)
    return {"folder": str(folder), **document, "files": [JSON_NAME, PAGE_NAME, *drawn]}


def write_figures(folder: Path, tables: Iterable[str], progress: Progress = silent) -> list[str]:
    """Draw the figures that belong to the named tables; gives the names of the files."""
    wanted = set(tables)
    chosen = [figure for figure in FIGURES if figure.table in wanted]
    for figure in chosen:
        progress(f"drawing {figure.file}")
        figure.draw(folder / figure.file)
    return [figure.file for figure in chosen]

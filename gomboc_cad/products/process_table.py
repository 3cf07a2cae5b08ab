"""The tables of the page on processes, from the data.

`python -m gomboc_cad.products.process_table docs/processes.md` renews them.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from gomboc_cad.products.process import Process, known_tolerances, load_process, process_names
from gomboc_cad.products.process_tolerances import Figure
from gomboc_cad.solid.output import write_bytes

_SIZES_MM = (50.0, 100.0, 200.0)
_SHOWN_ORDERS = (2, 3, 5, 10, 15)


def figures(process: Process) -> dict[str, Figure]:
    """Every figure of a process by its key, such as `form.fixed_mm`."""
    tables = dict(known_tolerances(process))
    return {
        f"{table}.{key}": figure
        for table, model in tables.items()
        if model is not None
        for key, figure in dict(model).items()
        if isinstance(figure, Figure)
    }


def figure_table() -> str:
    """All figures of all processes, each with its range; and how many of them are estimates."""
    columns = {name: figures(load_process(name)) for name in process_names()}
    # Prints have a layer height besides.
    keys = max(columns.values(), key=len)
    rows = ([f"`{key}`", *(_shown(column.get(key)) for column in columns.values())] for key in keys)
    all_figures = [figure for column in columns.values() for figure in column.values()]
    estimates = sum(figure.source.startswith("estimate") for figure in all_figures)
    return "\n".join(
        [
            *_markdown(["key", *(f"`{name}`" for name in columns)], rows),
            "",
            f"Of {len(all_figures)} figures, {estimates} are estimates.",
        ]
    )


def form_table() -> str:
    """The error of form in µm: rms by size of the part, and by order for one size."""
    _, middle_mm, _ = _SIZES_MM
    header = [
        "process",
        *(f"rms, {size:g} mm" for size in _SIZES_MM),
        *(f"order {order}" for order in _SHOWN_ORDERS),
    ]
    forms = {name: known_tolerances(load_process(name)).form for name in process_names()}
    rows = (
        [
            f"`{name}`",
            *(_um(form.rms_mm(size)) for size in _SIZES_MM),
            *(_um(each) for each in form.amplitudes_mm(middle_mm, np.array(_SHOWN_ORDERS))),
        ]
        for name, form in forms.items()
    )
    return "\n".join(_markdown(header, rows))


TABLES = {"figures": figure_table, "form": form_table}


def with_tables(page: str) -> str:
    """A page with its tables renewed, each between `<!-- begin NAME -->` and `<!-- end NAME -->`."""
    for name, table in TABLES.items():
        begin, end = f"<!-- begin {name} -->", f"<!-- end {name} -->"
        page = re.sub(f"{begin}.*?{end}", f"{begin}\n{table()}\n{end}", page, flags=re.DOTALL)
    return page


def _shown(figure: Figure | None) -> str:
    if figure is None:
        return "–"
    low, high = figure.range
    return f"{figure.value:g} ({low:g} to {high:g})".replace("-", "−")


def _um(length_mm: float) -> str:
    return f"{1e3 * length_mm:.3g}"


def _markdown(header: Sequence[str], rows: Iterator[list[str]]) -> list[str]:
    return [f"| {' | '.join(cells)} |" for cells in (header, ["---"] * len(header), *rows)]


if __name__ == "__main__":
    path = Path(sys.argv[1])
    write_bytes(path, with_tables(path.read_text(encoding="utf-8")).encode())

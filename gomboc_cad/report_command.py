"""The command that writes the report of a folder again, from the JSON files in it alone."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from gomboc_cad.arguments import PASSED, AsJson, Quiet
from gomboc_cad.console import Reporter, show_report


def report(
    folder: Annotated[
        Path, typer.Argument(metavar="DIR", help="A folder that build or tolerance wrote, or both.")
    ],
    json: AsJson = False,
    quiet: Quiet = False,
) -> int:
    """Write the report of a folder again: one page that opens offline, and its figures."""
    from gomboc_cad.report.write import write_report

    reporter = Reporter(json, quiet)
    with reporter.stages(1) as progress:
        progress("writing the report")
        document = write_report(folder)
    reporter.document(document, show_report)
    return PASSED

"""The commands that take minutes: studies, searches, the source paper; each a few lines over the library."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from gomboc_cad.arguments import (
    FAILED,
    PASSED,
    PRODUCT_NAMES,
    AsJson,
    Changes,
    Force,
    Output,
    Quiet,
    WithReport,
    require_new_toml,
)
from gomboc_cad.console import Reporter, show_design, show_paper, show_tolerance


def tolerance(
    spec: Annotated[
        str, typer.Argument(metavar="SPEC", help=f"A TOML file, a product ({PRODUCT_NAMES}) or a body.")
    ],
    output: Output,
    changes: Changes = None,
    process: Annotated[
        str | None,
        typer.Option(
            "--process", metavar="NAME", help="How it is made; a name or a file. The spec's if left out."
        ),
    ] = None,
    variants: Annotated[int, typer.Option("--variants", metavar="N", min=1, help="How many.")] = 8192,
    seed: Annotated[int, typer.Option("--seed", min=0, help="Of all samples.")] = 0,
    max_tilt_deg: Annotated[float, typer.Option("--max-tilt-deg", help="Largest angle from the rest.")] = 1.0,
    rolling_um: Annotated[float, typer.Option("--rolling-um", help="Rolling-resistance length.")] = 1.0,
    target: Annotated[float, typer.Option("--target", help="Share of the parts that has to be good.")] = 0.95,
    cross_check: Annotated[
        int,
        typer.Option("--cross-check", min=0, max=10_000, help="Variants that are built and judged again."),
    ] = 12,
    rows: Annotated[
        str, typer.Option("--rows", help="Format of the file of variants: csv or parquet.")
    ] = "csv",
    answers: Annotated[
        bool, typer.Option("--answers/--no-answers", help="Look for what to change; takes most of the time.")
    ] = True,
    executor: Annotated[
        str, typer.Option("--executor", metavar="WHERE", help="local, local:4 or dask://HOST:PORT.")
    ] = "local",
    force: Force = False,
    with_report: WithReport = True,
    json: AsJson = False,
    quiet: Quiet = False,
) -> int:
    """Tell before machining how likely a made part rights itself, what limits that, and what to change.

    An interrupted study goes on when it is called again in the same way. Exits with 1 when the share of good
    parts is not surely as high as the target.
    """
    from gomboc_cad.tolerance.whole_study import Question, study_tolerances

    question = Question(
        process=process,
        variants=variants,
        seed=seed,
        max_tilt_deg=max_tilt_deg,
        rolling_mm=1e-3 * rolling_um,
        good_share=target,
        rebuilt=cross_check,
        rows_format=rows,
        answers=answers,
    )
    reporter = Reporter(json, quiet)
    with reporter.stages(None) as progress:
        document = study_tolerances(
            spec,
            output,
            question,
            changes=changes or (),
            executor=executor,
            force=force,
            report=with_report,
            progress=progress,
        )
    reporter.document(document, show_tolerance)
    return PASSED if document["verdict"] == "PASS" else FAILED


def design(
    output: Annotated[Path, typer.Option("--output", "-o", metavar="FILE.toml", help="Where the body goes.")],
    family: Annotated[str, typer.Option("--family", metavar="NAME", help="extended or harmonic.")],
    objective: Annotated[
        str, typer.Option("--objective", metavar="NAME", help="s-margin, height-range or stiffness.")
    ] = "s-margin",
    min_curvature: Annotated[
        float, typer.Option("--min-curvature", metavar="K", help="Smallest principal curvature, times R0.")
    ] = 0.05,
    min_margin: Annotated[
        float, typer.Option("--min-margin", metavar="M", help="Smallest margin of the COM, over R0.")
    ] = 0.003,
    seed: Annotated[
        int, typer.Option("--seed", min=0, help="Seed for extended; nothing is random for harmonic.")
    ] = 1,
    steps: Annotated[
        int | None,
        typer.Option("--steps", min=1, help="Most generations of extended, steps per stage of harmonic."),
    ] = None,
    force: Force = False,
    json: AsJson = False,
    quiet: Quiet = False,
) -> int:
    """Search for a new body with one stable and one unstable pose, and prove it.

    The file is a BODY for the other commands, and its table [body] goes into the spec of a product. Exits
    with 1 when the body is not proven or misses a constraint, which the file says too.
    """
    from time import perf_counter

    from gomboc_cad.documents import design_document
    from gomboc_cad.search import Goal, design_body, search_method, write_body_file

    reporter, begin = Reporter(json, quiet), perf_counter()
    require_new_toml(output, force)
    goal, method = Goal(objective, min_curvature, min_margin), search_method(family, seed, steps)
    with reporter.stages(None) as progress:
        made = design_body(goal, method, progress)
    write_body_file(made, output)
    reporter.document(design_document(made, output, perf_counter() - begin), show_design)
    return PASSED if made.accepted else FAILED


def paper(
    output: Output,
    only: Annotated[
        list[str] | None, typer.Option("--only", metavar="TABLE", help="One table; repeatable.")
    ] = None,
    force: Force = False,
    json: AsJson = False,
    quiet: Quiet = False,
) -> int:
    """Reproduce the source paper's tables and figures, and judge each figure by what is true."""
    from gomboc_cad.paper import write_paper

    reporter = Reporter(json, quiet)
    with reporter.stages(None) as progress:
        document = write_paper(output, only or None, force=force, progress=progress)
    reporter.document(document, show_paper)
    return PASSED

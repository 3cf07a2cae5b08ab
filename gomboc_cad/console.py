"""What a person sees in the terminal: tables on stdout, progress on stderr."""

from __future__ import annotations

import itertools
import json
import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from gomboc_cad.progress import Progress, silent

PROGRESS_VARIABLE = "GOMBOC_CAD_PROGRESS"
"""Environment variable by which a program asks for stages as lines on stderr: `lines`."""

_MOST_COEFFICIENTS = 4
_PERCENTILES = ("p05", "p50", "p95")


class Reporter:
    """Says results in the way that was asked for: JSON, tables, or nothing.

    Args:
        as_json: One JSON object on stdout and nothing else there.
        quiet: No progress and no tables.
    """

    def __init__(self, as_json: bool, quiet: bool) -> None:
        self.as_json = as_json
        self.quiet = quiet

    def document(self, document: dict[str, Any], show: Callable[[dict[str, Any]], None]) -> None:
        """Print a result, as JSON or by the function that shows it to a person."""
        if self.as_json:
            json.dump(document, sys.stdout, indent=2, ensure_ascii=False, allow_nan=False)
            sys.stdout.write("\n")
        elif not self.quiet:
            show(document)

    @contextmanager
    def stages(self, total: int | None) -> Iterator[Progress]:
        """Show on stderr which stage begins: a bar on a terminal, lines for a program that asks for them.

        The callback that it gives names the stage. Without a total, only that is shown.
        """
        if not self.quiet and os.environ.get(PROGRESS_VARIABLE) == "lines":
            yield _line_by_line(total)
            return
        if self.quiet or not sys.stderr.isatty():
            yield silent
            return
        from rich.console import Console
        from rich.progress import (
            BarColumn,
            MofNCompleteColumn,
            Progress,
            SpinnerColumn,
            TextColumn,
            TimeElapsedColumn,
        )

        text = TextColumn("{task.description}")
        counted = () if total is None else (BarColumn(), MofNCompleteColumn())
        columns = (SpinnerColumn(), text, *counted, TimeElapsedColumn())
        with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
            task = bar.add_task("starting", total=total)
            begun = False

            def begin(stage: str) -> None:
                nonlocal begun
                bar.update(task, description=stage, advance=1 if begun else 0)
                begun = True

            yield begin


def _line_by_line(total: int | None) -> Progress:
    """Stages as `[3/12] cutting the cavity`, or `[3] ...` where nobody knows how many there are."""
    numbers, of = itertools.count(1), "" if total is None else f"/{total}"

    def begin(stage: str) -> None:
        print(f"[{next(numbers)}{of}] {stage}", file=sys.stderr, flush=True)

    return begin


def _table(title: str, *columns: str) -> Any:
    from rich.table import Table

    table = Table(title=title, title_justify="left", title_style="bold", header_style="bold")
    for index, column in enumerate(columns):
        table.add_column(column, overflow="fold", no_wrap=index == 0)
    return table


def _named(document: dict[str, Any]) -> str:
    return f"{document['body']}, nominal diameter {document['diameter_mm']:g} mm"


def _print(*things: Any) -> None:
    from rich.console import Console

    # Names come from users; markup in them must stay text.
    console = Console(markup=False, highlight=False)
    for thing in things:
        console.print(thing)


def show_catalog(document: dict[str, Any]) -> None:
    """The catalogue as a table."""
    table = _table(
        "Bodies (lengths in units of the nominal radius)",
        "name",
        "family",
        "parameters",
        "status",
        "S-margin",
        "reason",
    )
    for body in document["bodies"]:
        terms = [] if body["beta"] is None else [f"β = {body['beta']:g}"]
        terms += _coefficients({key: f"{value:g}" for key, value in body["coefficients"].items()})
        margin = "–" if body["s_margin"] is None else f"{body['s_margin']:.5f}"
        table.add_row(body["name"], body["family"], ", ".join(terms), body["status"], margin, body["reason"])
    _print(table)


def show_report(document: dict[str, Any]) -> None:
    """Where the report is."""
    count = len(document["files"])
    _print(f"{document['folder']}/report.html is written, with {count - 1} other files.")


def show_templates(document: dict[str, Any]) -> None:
    """What a spec may name, or the file that was written."""
    if document["file"] is not None:
        _print(f"{document['file']} is yours to edit.")
        return
    table = _table("What a spec may name", "kind", "names")
    for kind, names in document.items():
        if isinstance(names, tuple):
            table.add_row(kind, ", ".join(names))
    _print(table)


def _coefficients(shown: dict[str, str]) -> list[str]:
    """Each coefficient; of many only their number."""
    if len(shown) > _MOST_COEFFICIENTS:
        return [f"{len(shown)} coefficients"]
    return [f"{key}: {value}" for key, value in shown.items()]


def show_census(document: dict[str, Any]) -> None:
    """A census as two tables."""
    facts = _table(
        f"{_named(document)}: {document['verdict']}",
        "quantity",
        "value",
    )
    facts.add_row("strictly convex", "yes" if document["strictly_convex"] else "no")
    facts.add_row("smallest principal curvature", f"{document['min_curvature_per_mm']:.6g} per mm")
    facts.add_row(
        "stable, saddle, unstable", f"{document['stable']}, {document['saddles']}, {document['unstable']}"
    )
    facts.add_row("volume", f"{document['volume_mm3']:.3f} mm³")
    facts.add_row("centre of mass", _vector(document["com_mm"], 6) + " mm")
    facts.add_row("height range", f"{document['height_range_mm']:.5g} mm")
    if document["margin_mm"] is None:
        _print(facts, *_reasons({"reasons": [document["reason"]]}), _barriers(document["equilibria"]))
        return
    facts.add_row(
        "COM margin (S, U)",
        f"{document['margin_mm']:.5g} mm ({document['s_margin_mm']:.5g}, {document['u_margin_mm']:.5g})",
    )
    _rest_rows(facts, document["rest"])
    poses = _table("Equilibria", "kind", "direction that points down", "height of the COM")
    for pose in document["equilibria"]:
        poses.add_row(pose["kind"], _vector(pose["direction"], 5), f"{pose['height_mm']:.6f} mm")
    _print(facts, poses)


def _barriers(poses: list[dict[str, Any]]) -> Any:
    """Poses of a mesh with the barrier around each."""
    table = _table(
        "Equilibria that count", "kind", "direction that points down", "height of the COM", "barrier", "share"
    )
    for pose in poses:
        barrier, share = pose["barrier_um"], pose["probability"]
        table.add_row(
            pose.get("kind", "stable"),
            _vector(pose["direction"], 5),
            f"{pose['height_mm']:.6f} mm",
            "–" if barrier is None else _length(barrier),
            "–" if share is None else f"{100 * share:.1f} %",
        )
    return table


def show_check(document: dict[str, Any]) -> None:
    """What `gomboc-cad check` found of a part."""
    facts = _table(f"{document['file']}, {document['kind']}: {document['verdict']}", "quantity", "value")
    size = " × ".join(f"{length:.5g}" for length in document["size_mm"])
    facts.add_row("size", f"{size} mm")
    facts.add_row("watertight", "yes" if document["watertight"] else "no")
    if document["volume_mm3"] is not None:
        facts.add_row("volume", f"{document['volume_mm3']:.6g} mm³")
    given = "given" if document["com_given"] else "homogeneous"
    facts.add_row(f"centre of mass, {given}", _vector(document["com_mm"], 5) + " mm")
    raw = document["raw"]
    facts.add_row(
        "faces of the hull that are stable, however low their barriers",
        f"{raw['stable']} of {document['hull_facets']}",
    )
    facts.add_row("barrier that counts", f"{document['barrier_um']:.4g} µm")
    facts.add_row("stable poses above it", str(document["stable"]))
    _print(facts, *_reasons(document), _barriers(document["poses"]))


def show_certificate(document: dict[str, Any]) -> None:
    """A certificate, or the check of one."""
    terms = [] if document["beta"] is None else [f"β = {document['beta']}"]
    terms += _coefficients(document["coefficients"])
    verdict = {True: "accepted", False: "REJECTED", None: document["status"]}[document.get("accepted")]
    facts = _table(f"{document['family']}, {', '.join(terms)}: {verdict}", "quantity", "value")
    rows = {
        "status": document["status"],
        "about": ", ".join(document["com"]) + " R₀" if document["com"] else None,
        "stable, unstable": f"{document['stable']}, {document['unstable']}" if document["stable"] else None,
        "principal curvatures above": document["curvature_above"],
        "margin of the centre of mass at least": document["com_margin"],
        "written to": document["file"],
    }
    for name, value in rows.items():
        if value is not None:
            facts.add_row(name, value)
    if document["com_enclosure"] is not None:
        for axis, (low, high) in zip("xyz", document["com_enclosure"], strict=True):
            facts.add_row(f"centroid, {axis}", low if low == high else f"{low} to {high}")
    facts.add_row("time", f"{document['seconds']:.2f} s")
    _print(facts, *_reasons({"reasons": [document["reason"]]}))


def show_design(document: dict[str, Any]) -> None:
    """What `gomboc-cad design` found."""
    goal = document["goal"]
    facts = _table(
        f"{document['family']}, {goal['objective']}: {document['status']}, {document['verdict']}",
        "quantity",
        "value",
    )
    proven = {
        key: document[key] and f", above {document[key]} proven" for key in ("com_margin", "curvature_above")
    }
    facts.add_row("stable, unstable", f"{document['stable']}, {document['unstable']}")
    facts.add_row(
        "COM margin (S, U)",
        f"{document['s_margin']:.5g}, {document['u_margin']:.5g} R₀{proven['com_margin'] or ''}",
    )
    facts.add_row(
        "smallest principal curvature",
        f"{document['min_curvature']:.5g} / R₀{proven['curvature_above'] or ''}",
    )
    facts.add_row("height range", f"{document['height_range']:.5g} R₀")
    facts.add_row("soft stiffness of the rest", f"{document['stiffness']:.5g} R₀")
    facts.add_row("written to", document["file"])
    facts.add_row("time", f"{document['seconds']:.0f} s")
    _print(facts, *_reasons(document))


def show_zone(document: dict[str, Any]) -> None:
    """The loading zone."""
    facts = _table(
        f"{document['body']}, nominal diameter {document['diameter_mm']:g} mm: loading zone", "", ""
    )
    facts.add_row("centre of mass", _vector(document["com_mm"], 5) + " mm")
    ballast = f"as a sphere whose COM is lowered by {document['equivalent_ballast_mm']:.4g} mm"
    facts.add_row("S-margin there", f"{document['s_margin_mm']:.4g} mm, {ballast}")
    facts.add_row("best place nearby", _vector(document["nearest_best_com_mm"], 5) + " mm")
    facts.add_row("S-margin there", f"{document['nearest_best_s_margin_mm']:.4g} mm")
    facts.add_row("best place of the whole zone", _vector(document["best_com_mm"], 3) + " mm")
    facts.add_row("S-margin there, inside the body", f"{document['best_s_margin_mm']:.4g} mm")
    facts.add_row("volume of the zone", f"{document['zone_volume_mm3']:.6g} mm³")
    for file in document["files"]:
        facts.add_row("written", file)
    _print(facts)


def show_drill_map(document: dict[str, Any]) -> None:
    """The best places of the drill map."""
    table = _table(
        f"{_named(document)}: best places for holes and flats",
        "outward normal",
        "radius of a hole or flat",
        "of a drilled hole alone",
        "depth of a plane flat",
    )
    for site in document["best"]:
        table.add_row(
            _vector(site["direction"], 3),
            f"{site['radius_mm']:.3f} mm",
            f"{site['refined_radius_mm']:.3f} mm",
            f"{site['flat_depth_mm']:.3f} mm",
        )
    said = [
        f"The centre of mass is {_vector(document['com_mm'], 4)} mm, that of the finished part: balance or "
        "fill what you remove.",
        f"At the rest itself, {_vector(document['rest_direction'], 3)}, a flat is the rest and adds none.",
    ]
    said += [f"Written: {file}" for file in document["files"]]
    _print(table, *_reasons({"reasons": said}))


def show_body(document: dict[str, Any]) -> None:
    """What `gomboc-cad body` wrote."""
    facts = _table(f"{document['body']}: {document['verdict']}", "quantity", "value")
    facts.add_row("largest deviation from the analytic surface", f"{document['max_deviation_um']:.3g} µm")
    facts.add_row("volume", f"{document['volume_mm3']:.3f} mm³")
    facts.add_row("centre of mass", _vector(document["com_mm"], 6) + " mm")
    _print(facts, *_reasons(document), _files(document))


def show_build(document: dict[str, Any]) -> None:
    """What `gomboc-cad build` made, and the verdict on it."""
    parts = _table(f"{document['product']}: parts", "part", "material", "mass", "volume", "watertight")
    for part in document["parts"]:
        watertight = {True: "yes", False: "NO", None: "–"}[part["watertight"]]
        parts.add_row(
            part["name"],
            part["material"],
            f"{part['mass_g']:.3f} g",
            f"{part['volume_mm3']:.1f} mm³",
            watertight,
        )
    assembly = document["assembly"]
    facts = _table(f"Verdict: {document['verdict']}", "quantity", "value")
    facts.add_row("mass", f"{assembly['mass_g']:.2f} g")
    facts.add_row("centre of mass", _vector(assembly["com_mm"], 5) + " mm")
    facts.add_row("distance from its target", f"{assembly['com_residual_um']:.3g} µm")
    if document["s_margin_mm"] is not None:
        facts.add_row("S-margin left", f"{document['s_margin_mm']:.4g} mm")
        _rest_rows(facts, document["rest"])
    _print(parts, facts, *_reasons(document), _files(document))


def show_paper(document: dict[str, Any]) -> None:
    """Each table of the paper, with its verdicts."""

    def text(figure: Any) -> str:
        if figure is None:
            return "–"
        return f"{figure:.4g}" if isinstance(figure, float) else str(figure)

    for made in document["tables"]:
        table = _table(made["title"], "figure", "paper", "reproduced", "truth", "verdict", "why")
        for row in made["rows"]:
            figures = (text(row[key]) for key in ("paper", "reproduced", "truth"))
            table.add_row(row["label"], *figures, row["verdict"], row["why"])
        _print(table)


def _length(length_um: float) -> str:
    return f"{length_um:.4g} µm" if length_um < 1e3 else f"{1e-3 * length_um:.4g} mm"


def _rest_rows(table: Any, rest: dict[str, Any]) -> None:
    soft, stiff = rest["tilt_deg_per_um"]
    table.add_row("points down at rest", _vector(rest["direction"], 5))
    table.add_row("tilt of the rest per µm of COM error", f"{soft:.3g}° soft, {stiff:.2g}° stiff")


def _reasons(document: dict[str, Any]) -> list[Any]:
    from rich.padding import Padding

    return [Padding(reason, (0, 0, 1, 2)) for reason in document["reasons"]]


def _files(document: dict[str, Any]) -> Any:
    table = _table(f"Files in {document['folder']}", "file", "size", "read back and checked")
    for file in document["files"]:
        table.add_row(
            file["path"],
            f"{file['size_bytes'] / 1000:.0f} kB",
            "in order" if file["ok"] else "; ".join(file["problems"]),
        )
    return table


def _vector(values: list[float], digits: int) -> str:
    # Adding zero turns a rounded −0.0 into 0.0.
    return "(" + ", ".join(f"{round(value, digits) + 0.0:.{digits}f}" for value in values) + ")"


def show_tolerance(document: dict[str, Any]) -> None:
    """A tolerance study: yields, sources, and what to change."""
    head = f"{document['subject']} by {document['process']}, {document['variants']} variants"
    facts = _table(f"{head}: {document['verdict']}", "quantity", "value")
    facts.add_row("one stable rest", _interval(document["yield_monostable"]))
    facts.add_row(f"good: stops within {document['max_tilt_deg']:g}°", _interval(document["yield_tilt"]))
    if undecided := document["yield_tilt"]["undecided"]:
        facts.add_row("undecided, counted as bad", f"{undecided}")
    for key, name, unit in (("tilt_deg", "tilt", "°"), ("s_margin_mm", "S-margin", " mm")):
        if (found := document[key]) is not None:
            facts.add_row(f"{name}: 5, 50, 95 %", ", ".join(f"{found[p]:.3g}" for p in _PERCENTILES) + unit)
    shares = {entry["source"]: entry["total"]["estimate"] for entry in document["sobol"]}
    sources = _table("What varies, and its total share of the tilt's variance", "share", "size", "source")
    for source in sorted(document["sources"], key=lambda source: -shares[source["name"]]):
        size = f"{source['size']:.3g} {source['unit']}"
        sources.add_row(f"{100.0 * shares[source['name']]:.0f} %", size, source["text"])
    said = [
        document[key]["sentence"] for key in ("budget_summary", "recommend", "baseline") if key in document
    ]
    if "no_answer" in document:
        said.append(document["no_answer"])
    checked = document["cross_check"]
    said.append(f"Built as geometry and judged again: {checked['agreed']} of {checked['rows']} agree.")
    _print(facts, sources, *_reasons({"reasons": said}))


def _interval(share: dict[str, Any]) -> str:
    estimate, low, high = (100.0 * share[key] for key in ("estimate", "low", "high"))
    return f"{estimate:.2f} % (surely {low:.2f} to {high:.2f} %)"

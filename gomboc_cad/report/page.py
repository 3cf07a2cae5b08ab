"""The report as one HTML page that needs no network: everything it shows is inside it."""

from __future__ import annotations

import json
from collections.abc import Mapping
from functools import cache
from importlib.resources import files
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from gomboc_cad.report import numerals
from gomboc_cad.report.document import cone_95_deg
from gomboc_cad.report.folder import CALIBRATION, HYDROSTATICS, REPORT, TOLERANCE, VERDICT, Results
from gomboc_cad.report.json_values import Value
from gomboc_cad.report.scene import gradients

_TEMPLATES = "templates"
_SECTIONS = {
    "verdict": "Verdict",
    "asked": "What was asked",
    "view": "The product in space",
    "landscape": "Height of the centre of mass",
    "zone": "Loading zone and COM budget",
    "tilt": "Tilt of the rest",
    "form-error": "Allowable form error",
    "yields": "Share of good parts by process",
    "sobol": "Which source decides",
    "answers": "What to change, and how far the study can be trusted",
    "hydrostatics": "Afloat",
    "method": "Method, limits and what is not modelled",
    "protocol": "How to accept the made part",
}
_IN_SCRIPT = {ord(character): f"\\u{ord(character):04x}" for character in "<>&\u2028\u2029"}
"""What could end a script element, or a line in it."""


def render_page(results: Results, figures: Mapping[str, str], scene: Mapping[str, Any] | None) -> str:
    """Write the page.

    Args:
        results: The folder's documents, with a completed `report.json`.
        figures: SVG elements by the name of the figure.
        scene: What the view in space shows; None if there is nothing.

    Raises:
        GombocError: If a file lacks a number or text that is needed, or holds something else there.
    """
    verdict, study = results.value(VERDICT), results.value(TOLERANCE)
    hydrostatics = results.value(HYDROSTATICS)
    left_out = () if hydrostatics else ("hydrostatics",)
    return (
        _environment()
        .get_template("page.html.j2")
        .render(
            stale_study=results.stale_study,
            unfinished_study=results.unfinished_study,
            subject=verdict["product"] if verdict else study["subject"],
            sections=[(name, title) for name, title in _SECTIONS.items() if name not in left_out],
            verdict=verdict,
            study=study,
            hydrostatics=hydrostatics,
            calibration=results.value(CALIBRATION),
            report=results.value(REPORT),
            cone=cone_95_deg(results),
            figures={name: Markup(svg) for name, svg in figures.items()},
            scene=None if scene is None else script_json(scene),
            gradients={} if scene is None else gradients(),
            style=Markup(_text("page.css")),
            viewer=Markup(_text("viewer.js")),
            form=Markup(_text("form.js")),
        )
    )


@cache
def _environment() -> Environment:
    environment = _Environment(
        loader=PackageLoader("gomboc_cad.report", _TEMPLATES),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters |= {
        "num": numerals.number,
        "fixed": numerals.fixed,
        "vector": numerals.vector,
        "words": numerals.words,
        "anything": numerals.anything,
        "keyword": numerals.keyword,
        "keys": Value.names,
        "plain": _plain,
        "said": _said,
        "address": _address,
    }
    environment.tests |= {"there": _is_there, "table": _is_table}
    return environment


class _Environment(Environment):
    """Jinja2 where a dot after a JSON value means a key, whatever methods the value has."""

    def getattr(self, obj: Any, attribute: str) -> Any:
        return obj[attribute] if isinstance(obj, Value) else super().getattr(obj, attribute)

    def getitem(self, obj: Any, argument: Any) -> Any:
        return obj[argument] if isinstance(obj, Value) else super().getitem(obj, argument)


def _is_there(value: Value) -> bool:
    return value.there


def _is_table(value: Value) -> bool:
    return isinstance(value.raw, dict)


def _plain(value: Value) -> float:
    return value.number


def _said(value: Value) -> str:
    return value.text


def _address(value: Value) -> str:
    return value.address


def script_json(document: Mapping[str, Any]) -> Markup:
    """JSON for a script element: it holds nothing that HTML could take for markup."""
    text = json.dumps(document, ensure_ascii=False, allow_nan=False, separators=(",", ":"))
    return Markup(text.translate(_IN_SCRIPT))


def _text(name: str) -> str:
    return files("gomboc_cad.report").joinpath(_TEMPLATES, name).read_text(encoding="utf-8")

"""An object of this workbench from outside: its mark in the tree, its heading, its main figures."""

from __future__ import annotations

from typing import Any

from freecad.gomboc import gui_texts, jobs
from freecad.gomboc.objects.computed import kind_of
from freecad.gomboc.texts import tr

from . import icons

PASS, FAIL, OUTDATED, RUNNING, NONE = "pass", "fail", "outdated", "running", ""

_NOTHING = 5e-5
"""Below this a length in mm, a share or an error in µm is of no interest to the eye."""

_WITHOUT = {("ComError", "body")}
"""Properties that say nothing about an object of that kind."""

_HEADINGS = {
    "PASS": gui_texts.HEADING_PASS,
    "FAIL": gui_texts.HEADING_FAIL,
    "monostable": gui_texts.HEADING_MONOSTABLE,
    "multistable": gui_texts.HEADING_MULTISTABLE,
    "undecided": gui_texts.HEADING_UNDECIDED,
    "": gui_texts.HEADING_DONE,
}
_STATES = {
    jobs.NEW: gui_texts.HEADING_NEW,
    jobs.WAITING: gui_texts.HEADING_RUNNING,
    jobs.RUNNING: gui_texts.HEADING_RUNNING,
    jobs.CANCELLED: gui_texts.HEADING_STOPPED,
    jobs.FAILED: gui_texts.HEADING_FAILED,
}


def kind(document_object: Any) -> str:
    """Which kind of object of this workbench it is, a product by its own name; "" for any other."""
    found = kind_of(document_object)
    return document_object.Product if found == "product" else found


def icon_name(document_object: Any) -> str:
    """The icon of its kind."""
    return icons.OF_KIND.get(kind(document_object), "gomboc-workbench")


def mark(document_object: Any) -> str:
    """The mark in the corner of its icon: green for the verdict that is wanted, red for the other."""
    if document_object.Status in (jobs.WAITING, jobs.RUNNING):
        return RUNNING
    if is_stale(document_object) or document_object.Verdict == "undecided":
        return OUTDATED
    if not document_object.Verdict:
        return NONE
    return PASS if document_object.Good else FAIL


def is_stale(document_object: Any) -> bool:
    """Whether its last computation failed or was stopped, so that it shows what was before, or nothing."""
    return document_object.Status in (jobs.FAILED, jobs.CANCELLED)


def heading(document_object: Any) -> str:
    """Its state, or its verdict, in a few words."""
    if document_object.Status in _STATES:
        return tr(_STATES[document_object.Status])
    verdict = document_object.Verdict
    return tr(_HEADINGS[verdict]) if verdict in _HEADINGS else verdict


def facts(document_object: Any) -> list[tuple[str, str]]:
    """Its main figures as (name, value with unit), those that it has."""
    if document_object.Status == jobs.NEW or not document_object.BuiltFrom:
        return []
    present, found = document_object.PropertiesList, kind(document_object)
    return [
        (tr(name), _shown(getattr(document_object, prop), unit))
        for prop, name, unit in gui_texts.FACTS
        if prop in present and (prop, found) not in _WITHOUT
    ]


def _shown(value: Any, unit: str) -> str:
    if hasattr(value, "Value"):
        value = value.Value
    if unit == "%":
        value = 100.0 * value
    text = f"({', '.join(map(_number, value))})" if hasattr(value, "x") else _number(value)
    return f"{text} {unit}".strip()


def _number(value: float) -> str:
    return "0" if abs(value) < _NOTHING else f"{value:.4g}"

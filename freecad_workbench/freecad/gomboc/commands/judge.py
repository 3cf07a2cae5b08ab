"""Buttons that judge what is there: equilibria of any part, loading zone, drill map, tolerance study."""

from __future__ import annotations

from freecad.gomboc import gui_texts, recorded
from freecad.gomboc.panels import result, study

from . import selected
from .command import Command


def _check() -> None:
    part, vertex = selected.part(), selected.vertex()
    com = "" if vertex is None else f", point=({recorded.name(vertex[0])}, {vertex[1]!r})"
    _begin(f"create_check({recorded.document(part)}, {recorded.name(part)}{com})")


def _zone() -> None:
    subject = selected.subject()
    _begin(f"create_zone({recorded.document(subject)}, {recorded.name(subject)})")


def _drill_map() -> None:
    subject = selected.subject()
    _begin(f"create_drill_map({recorded.document(subject)}, {recorded.name(subject)})")


def _study() -> None:
    study.show(selected.subject())


def _begin(call: str) -> None:
    made = recorded.call(call)
    if made is not None:
        result.show(made)


COMMANDS = (
    Command(
        "Gomboc_Check",
        "gomboc-check",
        gui_texts.CHECK,
        gui_texts.CHECK_TIP,
        _check,
        lambda: selected.part() is not None,
    ),
    Command(
        "Gomboc_LoadingZone",
        "gomboc-loading-zone",
        gui_texts.ZONE,
        gui_texts.ZONE_TIP,
        _zone,
        lambda: selected.subject() is not None,
    ),
    Command(
        "Gomboc_DrillMap",
        "gomboc-drill-map",
        gui_texts.DRILL_MAP,
        gui_texts.DRILL_MAP_TIP,
        _drill_map,
        lambda: selected.subject() is not None,
    ),
    Command(
        "Gomboc_ToleranceStudy",
        "gomboc-tolerance",
        gui_texts.STUDY,
        gui_texts.STUDY_TIP,
        _study,
        lambda: selected.subject() is not None,
    ),
)

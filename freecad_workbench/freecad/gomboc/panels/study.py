"""The panel of the tolerance study: how the parts are made, and how many are tried."""

from __future__ import annotations

from typing import Any

from freecad.gomboc import door, gui_texts, lists, recorded
from freecad.gomboc.texts import tr
from freecad.gomboc.views import icons

from . import task

_FEWEST, _USUAL, _MOST = 64, 2048, 1_000_000


def show(subject: Any) -> None:
    """Ask, then run the study of a body or product."""
    widgets = door.QtWidgets
    layout = widgets.QFormLayout()
    process = widgets.QComboBox()
    process.setObjectName("GombocProcess")
    process.addItem(tr(gui_texts.OWN_PROCESS), "")
    for name in lists.lists().choices["processes"]:
        process.addItem(name, name)
    variants, seed = widgets.QSpinBox(), widgets.QSpinBox()
    variants.setObjectName("GombocVariants")
    variants.setRange(_FEWEST, _MOST)
    variants.setValue(_USUAL)
    variants.setSingleStep(1024)
    seed.setObjectName("GombocSeed")
    seed.setRange(0, 2**31 - 1)
    for label, widget in (
        (gui_texts.PROCESS, process),
        (gui_texts.VARIANTS, variants),
        (gui_texts.SEED, seed),
    ):
        layout.addRow(tr(label), widget)

    def run() -> Any:
        return recorded.call(
            f"create_study({recorded.document(subject)}, {recorded.name(subject)}, "
            f"process={process.currentData()!r}, variants={variants.value()}, seed={seed.value()})"
        )

    title = tr(gui_texts.STUDY_OF, label=subject.Label)
    task.show(task.Task("GombocStudy", title, icons.OF_KIND["tolerance"], layout, run))

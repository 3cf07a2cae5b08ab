"""How far a job is, in words and as a bar."""

from __future__ import annotations

from typing import Any

from freecad.gomboc import gui_texts
from freecad.gomboc.texts import tr


def sentence(job: Any, waiting: int = 0) -> str:
    """What runs, in one line."""
    stage = job.progress.text if job.progress is not None else tr(gui_texts.STARTING)
    text = f"{job.title}: {stage}"
    return f"{text} ({tr(gui_texts.WAITING, count=waiting)})" if waiting else text


def show(bar: Any, progress: Any) -> None:
    """Set a progress bar to the stages that are done; where their number is not known, say the stage.

    A bar that moves by itself would have FreeCAD draw its whole window anew, all the time.
    """
    known = progress is not None and progress.total is not None
    bar.setRange(0, progress.total if known else 1)
    # The stage that is announced is not done yet.
    bar.setValue(progress.number - 1 if known else 0)
    number = 0 if progress is None else progress.number
    bar.setFormat("%p%" if known else tr(gui_texts.STAGE, number=number))

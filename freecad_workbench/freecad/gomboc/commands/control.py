"""Buttons about the program behind the buttons: stop it, set it up."""

from __future__ import annotations

from freecad.gomboc import gui_texts, jobs
from freecad.gomboc.panels import setup

from .command import Command

COMMANDS = (
    Command(
        "Gomboc_Stop",
        "gomboc-cancel",
        gui_texts.STOP_RUN,
        gui_texts.STOP_RUN_TIP,
        lambda: jobs.queue.cancel(),
        lambda: bool(jobs.queue.jobs()),
        needs_package=False,
    ),
    Command(
        "Gomboc_SetUp",
        "gomboc-setup",
        gui_texts.SETUP,
        gui_texts.SETUP_TIP,
        setup.show,
        lambda: True,
        needs_package=False,
    ),
)

"""The status bar while something is computed: what, how far, and a button that stops it."""

from __future__ import annotations

from typing import Any

from freecad.gomboc import door, gui_texts, jobs
from freecad.gomboc.texts import tr

from . import notices, progress, result

_watcher: Status | None = None


def watch() -> None:
    """Show the jobs of the queue from now on."""
    global _watcher
    if _watcher is None:
        _watcher = Status()
        jobs.queue.subscribe(_watcher.heard)


class Status:
    """A label, a bar and a button at the right of the status bar, seen only while a job runs."""

    def __init__(self) -> None:
        widgets = door.QtWidgets
        self._widget = widgets.QWidget()
        self._widget.setObjectName("GombocStatus")
        layout = widgets.QHBoxLayout(self._widget)
        layout.setContentsMargins(0, 0, 0, 0)
        self._label = widgets.QLabel()
        self._label.setObjectName("GombocStatusText")
        self._bar = widgets.QProgressBar()
        self._bar.setFixedWidth(120)
        self._bar.setTextVisible(False)
        stop = widgets.QPushButton(tr(gui_texts.STOP))
        stop.setObjectName("GombocStatusStop")
        stop.clicked.connect(lambda *_: jobs.queue.cancel())
        for widget in (self._label, self._bar, stop):
            layout.addWidget(widget)
        door.Gui.getMainWindow().statusBar().addPermanentWidget(self._widget)
        self._widget.hide()

    def heard(self, job: Any) -> None:
        """Follow a job; a failure that no panel shows gets a message of its own."""
        if job.state == jobs.FAILED and not result.shows(job):
            notices.tell(job.message)
        running = jobs.queue.running
        self._widget.setVisible(running is not None)
        if running is None:
            return
        self._label.setText(progress.sentence(running, len(jobs.queue.waiting)))
        progress.show(self._bar, running.progress)

"""The task panel of an object: how far its computation is, then its verdict with the reasons."""

from __future__ import annotations

from html import escape
from typing import Any

from freecad.gomboc import door, gui_texts, jobs
from freecad.gomboc.texts import tr
from freecad.gomboc.views import appearance, icons, marks

from . import progress

_COLORS = {"pass": "#2e9e3f", "fail": "#d5322e", "outdated": "#b07d00", "running": "#4178d4", "": "#6d7881"}

_REASONS_HEIGHT, _CELL = 280, 42

_shown: ResultPanel | None = None


def show(document_object: Any) -> None:
    """Open the task panel of an object; where another task is open, leave that alone."""
    global _shown
    close()
    if not door.Gui.Control.activeDialog():
        _shown = ResultPanel(document_object)
        door.Gui.Control.showDialog(_shown)


def close() -> None:
    """Close the panel, if one is open."""
    if _shown is not None:
        if _shown.is_there():
            _shown.reject()
        else:
            _shown.forget()


def shows(job: Any) -> bool:
    """Whether the panel that the user sees is about the object of a job."""
    return _shown is not None and _shown.is_about(job) and _shown.is_there() and _shown.form.isVisible()


class ResultPanel:
    """What FreeCAD asks of a task panel: `form`, the buttons, and what happens on closing."""

    def __init__(self, document_object: Any) -> None:
        self.document_name, self.object_name = document_object.Document.Name, document_object.Name
        widgets = door.QtWidgets
        self.form = widgets.QWidget()
        self.form.setObjectName("GombocResult")
        self.form.setWindowTitle(document_object.Label)
        self.form.setWindowIcon(door.QtGui.QIcon(icons.path(marks.icon_name(document_object))))
        layout = widgets.QVBoxLayout(self.form)
        self._verdict = _label("GombocVerdict")
        self._stage = _label("GombocStage")
        self._bar = widgets.QProgressBar()
        self._bar.setObjectName("GombocBar")
        self._stop = _button(gui_texts.STOP, "GombocStop", self._cancel)
        self._again = _button(gui_texts.AGAIN, "GombocAgain", self._rebuild)
        self._facts = _label("GombocFacts")
        self._reasons = _label("GombocReasons")
        row = widgets.QHBoxLayout()
        row.addWidget(self._bar, 1)
        row.addWidget(self._stop)
        for each in (self._verdict, self._stage, row, self._again, self._facts):
            (layout.addLayout if each is row else layout.addWidget)(each)
        layout.addWidget(_scrolled(self._reasons), 1)
        jobs.queue.subscribe(self._heard)
        self.update()

    def getStandardButtons(self) -> int:
        """Close."""
        return door.flag(door.QtWidgets.QDialogButtonBox.Close)

    def reject(self) -> bool:
        """Close the panel; what is being computed goes on."""
        self.forget()
        door.Gui.Control.closeDialog()
        return True

    def isAllowedAlterDocument(self) -> bool:
        """The rest of FreeCAD stays usable."""
        return True

    isAllowedAlterSelection = isAllowedAlterView = isAllowedAlterDocument

    def forget(self) -> None:
        """Hear no more of jobs."""
        global _shown
        jobs.queue.unsubscribe(self._heard)
        _shown = None

    def is_about(self, job: Any) -> bool:
        """Whether a job computes its object."""
        return (self.document_name, self.object_name) == (job.document_name, job.object_name)

    def is_there(self) -> bool:
        """Whether FreeCAD still has the panel: when it is closed, FreeCAD takes the form away from it."""
        return self.form is not None and self.form.parentWidget() is not None

    def target(self) -> Any:
        """The object, or None if it is gone."""
        document = door.App.listDocuments().get(self.document_name)
        return document.getObject(self.object_name) if document is not None else None

    def update(self) -> None:
        """Show what is so now."""
        target = self.target()
        if target is None:
            self._verdict.setText(tr(gui_texts.GONE))
            return
        job = next((job for job in jobs.queue.jobs() if job.is_about(target)), None)
        mark = marks.mark(target)
        heading = marks.heading(target)
        self._verdict.setText(f'<h3 style="color: {_COLORS[mark]}">{escape(heading)}</h3>')
        for widget in (self._bar, self._stop):
            widget.setVisible(job is not None)
        self._again.setVisible(job is None and marks.is_stale(target))
        if job is not None:
            self._stage.setText(progress.sentence(job) if job is jobs.queue.running else tr(gui_texts.QUEUED))
            progress.show(self._bar, job.progress)
        else:
            self._stage.setText(target.Message)
        self._stage.setVisible(bool(self._stage.text()))
        self._facts.setText(_table(marks.facts(target)) + _legend(appearance.scale(target)))
        self._reasons.setText(_paragraphs([*target.Reasons, *getattr(target, "Poses", [])]))

    def _heard(self, job: Any) -> None:
        if not self.is_there():
            self.forget()
        elif self.is_about(job):
            self.update()

    def _cancel(self) -> None:
        target = self.target()
        if target is not None:
            jobs.queue.cancel(target)

    def _rebuild(self) -> None:
        target = self.target()
        if target is not None:
            target.touch()
            target.Document.recompute()


def _label(name: str) -> Any:
    label = door.QtWidgets.QLabel()
    label.setObjectName(name)
    label.setWordWrap(True)
    label.setTextInteractionFlags(door.QtCore.Qt.TextSelectableByMouse)
    return label


def _button(text: str, name: str, action: Any) -> Any:
    button = door.QtWidgets.QPushButton(tr(text))
    button.setObjectName(name)
    button.clicked.connect(lambda *_: action())
    return button


def _scrolled(widget: Any) -> Any:
    area = door.QtWidgets.QScrollArea()
    area.setWidgetResizable(True)
    area.setFrameShape(door.QtWidgets.QFrame.NoFrame)
    area.setMinimumHeight(_REASONS_HEIGHT)
    widget.setAlignment(door.QtCore.Qt.AlignTop)
    area.setWidget(widget)
    return area


def _table(rows: list[Any]) -> str:
    cells = (
        f"<tr><td>{escape(name)}&nbsp;&nbsp;</td><td><b>{escape(value)}</b></td></tr>" for name, value in rows
    )
    return f"<table>{''.join(cells)}</table>" if rows else ""


def _legend(steps: list[tuple[str, str]]) -> str:
    cells = "".join(f'<td width="{_CELL}" bgcolor="{color}">&nbsp;</td>' for color, _ in steps)
    texts = "".join(f'<td width="{_CELL}" align="center">{escape(text)}</td>' for _, text in steps)
    return (
        f'<table cellspacing="0"><tr>{cells}</tr><tr>{texts}</tr></table>' + tr(gui_texts.SCALE)
        if steps
        else ""
    )


def _paragraphs(sentences: list[str]) -> str:
    return "".join(f"<p>{escape(sentence)}</p>" for sentence in sentences)

"""The dialog of the first use: install the package, or choose a Python that has it."""

from __future__ import annotations

from typing import Any

from freecad.gomboc import door, environment, gui_texts, settings
from freecad.gomboc.errors import GombocCadError
from freecad.gomboc.texts import tr

_FROM_INDEX, _FROM_WHEEL, _FROM_FOLDER = range(3)

_GOOD, _BAD = "#2e9e3f", "#d5322e"

_shown: SetUp | None = None


def is_ready() -> bool:
    """Whether the package can be run."""
    return isinstance(environment.state(), environment.Ready)


def show() -> SetUp:
    """Open the dialog, or bring it to the front; FreeCAD stays usable beside it."""
    global _shown
    if _shown is None:
        _shown = SetUp()
    _shown.open()
    return _shown


class SetUp:
    """The dialog. Both ways end in the same place: a Python that has the package, kept in the preferences."""

    def __init__(self) -> None:
        self._installation: environment.Installation | None = None
        widgets = door.QtWidgets
        self.dialog = widgets.QDialog(door.Gui.getMainWindow())
        self.dialog.setObjectName("GombocSetUp")
        self.dialog.setWindowTitle(tr(gui_texts.SETUP_TITLE))
        self.dialog.resize(640, 520)
        layout = widgets.QVBoxLayout(self.dialog)
        intro = widgets.QLabel(tr(gui_texts.SETUP_INTRO))
        intro.setWordWrap(True)
        layout.addWidget(intro)
        layout.addWidget(self._install_box())
        layout.addWidget(self._existing_box())
        self._state = widgets.QLabel()
        self._state.setObjectName("GombocSetUpState")
        self._state.setWordWrap(True)
        self._state.setTextInteractionFlags(door.QtCore.Qt.TextSelectableByMouse)
        layout.addWidget(self._state)
        self._output = widgets.QPlainTextEdit()
        self._output.setObjectName("GombocSetUpOutput")
        self._output.setReadOnly(True)
        self._output.setPlaceholderText(tr(gui_texts.SETUP_OUTPUT))
        layout.addWidget(self._output, 1)
        layout.addLayout(self._foot())
        self._choose_source(_FROM_INDEX)

    def open(self) -> None:
        """Show it with what is known now."""
        if self._installation is None:
            self._python.setText(settings.python())
            self._tell_state()
        self.dialog.show()
        self.dialog.raise_()

    def _install_box(self) -> Any:
        widgets = door.QtWidgets
        box = widgets.QGroupBox(tr(gui_texts.SETUP_INSTALL_BOX))
        layout = widgets.QGridLayout(box)
        where = widgets.QLabel(tr(gui_texts.SETUP_WHERE, folder=settings.private_environment()))
        where.setWordWrap(True)
        layout.addWidget(where, 0, 0, 1, 3)
        self._source_kind = widgets.QComboBox()
        self._source_kind.setObjectName("GombocSetUpSourceKind")
        for text in (gui_texts.SETUP_FROM_INDEX, gui_texts.SETUP_FROM_WHEEL, gui_texts.SETUP_FROM_FOLDER):
            self._source_kind.addItem(tr(text))
        self._source_kind.currentIndexChanged.connect(self._choose_source)
        self._source = widgets.QLineEdit()
        self._source.setObjectName("GombocSetUpSource")
        self._browse_source = _button(gui_texts.BROWSE, "GombocSetUpBrowseSource", self._ask_source)
        self._install = _button(gui_texts.SETUP_INSTALL, "GombocSetUpInstall", self._start)
        layout.addWidget(self._source_kind, 1, 0)
        layout.addWidget(self._source, 1, 1)
        layout.addWidget(self._browse_source, 1, 2)
        layout.addWidget(self._install, 2, 2)
        layout.setColumnStretch(1, 1)
        return box

    def _existing_box(self) -> Any:
        widgets = door.QtWidgets
        box = widgets.QGroupBox(tr(gui_texts.SETUP_EXISTING_BOX))
        layout = widgets.QGridLayout(box)
        self._python = widgets.QLineEdit()
        self._python.setObjectName("GombocSetUpPython")
        self._python.setPlaceholderText("/path/to/python3")
        self._use = _button(gui_texts.SETUP_USE, "GombocSetUpUse", self._use_existing)
        layout.addWidget(widgets.QLabel(tr(gui_texts.SETUP_PYTHON)), 0, 0)
        layout.addWidget(self._python, 0, 1)
        layout.addWidget(_button(gui_texts.BROWSE, "GombocSetUpBrowsePython", self._ask_python), 0, 2)
        layout.addWidget(self._use, 1, 2)
        layout.setColumnStretch(1, 1)
        return box

    def _foot(self) -> Any:
        widgets = door.QtWidgets
        foot = widgets.QHBoxLayout()
        self._bar = widgets.QProgressBar()
        self._bar.setRange(0, 0)
        self._stop = _button(gui_texts.STOP, "GombocSetUpStop", self._cancel)
        foot.addWidget(self._bar, 1)
        foot.addWidget(self._stop)
        foot.addStretch()
        foot.addWidget(_button(gui_texts.CLOSE, "GombocSetUpClose", self.dialog.close))
        self._bar.hide()
        self._stop.hide()
        return foot

    def _choose_source(self, kind: int) -> None:
        from_index = kind == _FROM_INDEX
        self._source.setEnabled(not from_index)
        self._browse_source.setEnabled(not from_index)
        self._source.setPlaceholderText(environment.DEFAULT_SOURCE if from_index else "")

    def _ask_source(self) -> None:
        dialog = door.QtWidgets.QFileDialog(self.dialog, tr(gui_texts.SETUP_INSTALL_BOX))
        if self._source_kind.currentIndex() == _FROM_WHEEL:
            dialog.setNameFilter("*.whl")
        else:
            dialog.setFileMode(_file_mode("Directory"))
        dialog.fileSelected.connect(self._source.setText)
        dialog.open()

    def _ask_python(self) -> None:
        dialog = door.QtWidgets.QFileDialog(self.dialog, tr(gui_texts.SETUP_EXISTING_BOX))
        dialog.setFileMode(_file_mode("ExistingFile"))
        dialog.fileSelected.connect(self._python.setText)
        dialog.open()

    def _start(self) -> None:
        from_index = self._source_kind.currentIndex() == _FROM_INDEX
        source = "" if from_index else self._source.text().strip()
        if not from_index and not source:
            self._tell(tr(gui_texts.SETUP_NO_SOURCE), _BAD)
            return
        self._output.clear()
        self._busy(True)
        self._tell(tr(gui_texts.SETUP_INSTALLING), "")
        try:
            self._installation = environment.install(source, self._output.appendPlainText, self._installed)
        except GombocCadError as error:
            self._busy(False)
            self._tell(str(error), _BAD)

    def _installed(self, error: str | None) -> None:
        self._installation = None
        if error is None:
            self._python.setText(settings.python())
            self._tell_state()
        else:
            self._tell(error, _BAD)
        self._busy(False)

    def _cancel(self) -> None:
        if self._installation is not None:
            self._installation.cancel()

    def _use_existing(self) -> None:
        self._busy(True)
        try:
            environment.use(self._python.text().strip())
        except GombocCadError as error:
            self._tell(str(error), _BAD)
        else:
            self._tell_state()
        finally:
            self._busy(False)

    def _busy(self, busy: bool) -> None:
        for widget in (self._install, self._use):
            widget.setEnabled(not busy)
        self._bar.setVisible(busy)
        self._stop.setVisible(busy)

    def _tell_state(self) -> None:
        found = environment.state()
        if isinstance(found, environment.Ready):
            self._tell(tr(gui_texts.SETUP_READY, version=found.version, python=found.python), _GOOD)
        else:
            self._tell(found.sentence, _BAD)

    def _tell(self, text: str, color: str) -> None:
        self._state.setText(text)
        self._state.setStyleSheet(f"font-weight: bold; color: {color};" if color else "font-weight: bold;")


def _button(text: str, name: str, action: Any) -> Any:
    button = door.QtWidgets.QPushButton(tr(text))
    button.setObjectName(name)
    button.setAutoDefault(False)
    button.clicked.connect(lambda *_: action())
    return button


def _file_mode(name: str) -> Any:
    return getattr(door.QtWidgets.QFileDialog, name)

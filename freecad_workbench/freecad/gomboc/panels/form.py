"""A form of settings: one row for each, with the value that the package's template has."""

from __future__ import annotations

from typing import Any, Iterable, Sequence

from freecad.gomboc import door, gui_texts
from freecad.gomboc.lists import Lists
from freecad.gomboc.objects.properties import Setting
from freecad.gomboc.texts import tr

_LARGEST_MM = 10_000.0


class Form:
    """Rows of a QFormLayout; only what the user changed counts, the template has the rest.

    Args:
        defaults: What can be set, and the value that it has if it is not.
        offered: What the package has to choose from.
    """

    def __init__(self, defaults: Iterable[tuple[Setting, Any]], offered: Lists) -> None:
        self.layout = door.QtWidgets.QFormLayout()
        self._rows: list[_Row] = []
        self._overrides: Any = None
        for setting, default in defaults:
            row = _ROWS[setting.kind](setting, default, offered.choices.get(setting.choices, ()))
            row.widget.setObjectName(f"Gomboc{setting.name}")
            row.widget.setToolTip(tr(setting.tip))
            self.layout.addRow(_words(setting.name), row.widget)
            self._rows.append(row)

    def add_overrides(self) -> None:
        """Add a field for any other key of the spec."""
        self._overrides = door.QtWidgets.QPlainTextEdit()
        self._overrides.setObjectName("GombocOverrides")
        self._overrides.setPlaceholderText("closure.kind=screws\nmesh.sag_um=20")
        self._overrides.setToolTip(tr(gui_texts.OVERRIDES_TIP))
        self._overrides.setFixedHeight(4 * self._overrides.fontMetrics().lineSpacing())
        self.layout.addRow(tr(gui_texts.OVERRIDES), self._overrides)

    def changed(self) -> dict[str, Any]:
        """What the user set, by the arguments of the API."""
        values = {row.setting.argument: row.value() for row in self._rows if row.value() != row.default}
        lines = self._overrides.toPlainText().splitlines() if self._overrides is not None else []
        overrides = [line for line in lines if line.strip()]
        return {**values, "overrides": overrides} if overrides else values


class _Row:
    def __init__(self, setting: Setting, default: Any, names: Sequence[str]) -> None:
        self.setting, self.default = setting, default


class _Length(_Row):
    def __init__(self, setting: Setting, default: Any, names: Sequence[str]) -> None:
        super().__init__(setting, float(default), names)
        self.widget = door.QtWidgets.QDoubleSpinBox()
        self.widget.setRange(0.0, _LARGEST_MM)
        self.widget.setDecimals(3)
        self.widget.setSuffix(" mm")
        self.widget.setValue(self.default)

    def value(self) -> float:
        return self.widget.value()


class _Choice(_Row):
    def __init__(self, setting: Setting, default: Any, names: Sequence[str]) -> None:
        super().__init__(setting, default, names)
        self.widget = door.QtWidgets.QComboBox()
        self.widget.addItems([*([] if default in names else [default]), *names])
        self.widget.setCurrentText(default)

    def value(self) -> str:
        return self.widget.currentText()


class _Text(_Row):
    def __init__(self, setting: Setting, default: Any, names: Sequence[str]) -> None:
        super().__init__(setting, default, names)
        self.widget = door.QtWidgets.QLineEdit(default)

    def value(self) -> str:
        return self.widget.text()


_ROWS = {"length": _Length, "choice": _Choice, "text": _Text}


def _words(name: str) -> str:
    """`CentreOfMass` as "Centre of mass"."""
    spaced = "".join(f" {letter.lower()}" if letter.isupper() else letter for letter in name).strip()
    return spaced[:1].upper() + spaced[1:]

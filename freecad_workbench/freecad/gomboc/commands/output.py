"""Buttons that hand results on: the report in a browser, the files into a folder."""

from __future__ import annotations

from typing import Any

from freecad.gomboc import api, door, gui_texts, recorded
from freecad.gomboc.panels import notices
from freecad.gomboc.texts import tr

from . import selected
from .command import Command


def _open_report() -> None:
    page = api.report_page(selected.own())
    door.QtGui.QDesktopServices.openUrl(door.QtCore.QUrl.fromLocalFile(str(page)))


def _export() -> None:
    target = selected.own()
    dialog = door.QtWidgets.QFileDialog(
        door.Gui.getMainWindow(), tr(gui_texts.EXPORT_TITLE, label=target.Label)
    )
    dialog.setObjectName("GombocExport")
    dialog.setFileMode(door.QtWidgets.QFileDialog.Directory)
    dialog.setOption(door.QtWidgets.QFileDialog.ShowDirsOnly, True)
    dialog.setAttribute(door.QtCore.Qt.WA_DeleteOnClose)
    dialog.fileSelected.connect(lambda folder: notices.guard(lambda: _export_to(target, folder)))
    dialog.open()


def _export_to(target: Any, folder: str) -> None:
    recorded.call(f"export({recorded.name(target)}, {folder!r})")
    door.Gui.getMainWindow().statusBar().showMessage(tr(gui_texts.EXPORTED, folder=folder), 10_000)


def _has_files() -> bool:
    target = selected.own()
    return target is not None and bool(getattr(target, "Files", None))


COMMANDS = (
    Command(
        "Gomboc_OpenReport",
        "gomboc-report",
        gui_texts.REPORT,
        gui_texts.REPORT_TIP,
        _open_report,
        _has_files,
        needs_package=False,
    ),
    Command(
        "Gomboc_Export",
        "gomboc-export",
        gui_texts.EXPORT,
        gui_texts.EXPORT_TIP,
        _export,
        _has_files,
        needs_package=False,
    ),
)

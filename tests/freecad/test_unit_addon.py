"""The addon as files: what FreeCAD's addon manager reads, and what its oldest Python can run; no FreeCAD."""

from __future__ import annotations

import ast
import re
import string
import sys
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import pytest
from freecad import gomboc
from freecad.gomboc import door, texts

from gomboc_cad import __version__

ADDON = Path(gomboc.__file__).resolve().parents[2]
MODULES = sorted(Path(gomboc.__file__).resolve().parent.rglob("*.py"))
OUTSIDE = {"FreeCAD", "FreeCADGui", "Part", "Mesh", "PySide", "PySide2", "PySide6", "pivy", "Import"}
# In the standard library, but not yet in that of Python 3.8.
TOO_NEW = {"tomllib", "zoneinfo", "graphlib"}


def imported(tree: ast.AST) -> set[str]:
    names = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            names |= {alias.name.partition(".")[0] for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and not node.level:
            names.add((node.module or "").partition(".")[0])
    return names


@pytest.mark.parametrize("module", MODULES, ids=lambda path: path.stem)
def test_a_module_runs_in_the_oldest_python_and_needs_nothing_else(module):
    text = module.read_text(encoding="utf-8")
    tree = ast.parse(text, feature_version=(3, 8))
    others = imported(tree) - {"freecad", "__future__"}
    assert others <= (set(sys.stdlib_module_names) - TOO_NEW) | OUTSIDE
    if module.stem != "door":
        assert not others & OUTSIDE, "only the door leads to FreeCAD"


def test_the_package_xml_names_what_is_there():
    space = {"p": "https://wiki.freecad.org/Package_Metadata"}
    package = ElementTree.parse(ADDON / "package.xml").getroot()
    assert package.findtext("p:version", None, space) == __version__ == gomboc.__version__
    for icon in package.iterfind(".//p:icon", space):
        ElementTree.parse(ADDON / icon.text)
    workbench = package.find("p:content/p:workbench", space)
    assert workbench.findtext("p:subdirectory", None, space) == "./"
    assert (ADDON / "freecad" / "gomboc" / "init_gui.py").is_file()
    assert not (ADDON / "freecad" / "__init__.py").exists(), "would hide FreeCAD's own freecad/__init__.py"


def table() -> dict[str, str]:
    found = {name: value for name, value in vars(texts).items() if name.isupper() and isinstance(value, str)}
    return {name: value for name, value in found.items() if name != "CONTEXT"}


def places(text: str) -> set[str]:
    return {name for _, name, _, _ in string.Formatter().parse(text) if name}


def test_each_sentence_gets_what_its_places_ask_for():
    told, used = table(), set()
    for module in MODULES:
        for node in ast.walk(ast.parse(module.read_text(encoding="utf-8"))):
            if not (
                isinstance(node, ast.Call) and ast.unparse(node.func) in ("texts.tr", "tr") and node.args
            ):
                continue
            match = re.fullmatch(r"texts\.([A-Z_]+)", ast.unparse(node.args[0]))
            if match:
                used.add(match[1])
                given = {keyword.arg for keyword in node.keywords}
                assert given == {None} or given == places(told[match[1]]), f"{module.name}:{node.lineno}"
    assert used == set(told), "a sentence that nobody says"


def test_without_freecad_texts_are_as_written():
    assert door.App is None
    assert not door.gui_up()
    assert texts.tr(texts.QUEUED, title="a {b}", running="ü") == "a {b} waits until ü is done."

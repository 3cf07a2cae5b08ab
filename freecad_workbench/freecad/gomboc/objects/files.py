"""The files of a build, kept inside the FreeCAD document as one archive."""

from __future__ import annotations

import re
import zipfile
from pathlib import Path
from typing import Any

from freecad.gomboc import texts
from freecad.gomboc.errors import GombocCadError

REPORT = "report.html"

_ARCHIVE = "gomboc-files.zip"


def pack(folder: Path) -> Path:
    """Make an archive of all files of a folder, beside them."""
    archive = folder.parent / _ARCHIVE
    with zipfile.ZipFile(archive, "w", zipfile.ZIP_DEFLATED, compresslevel=3) as packed:
        for path in sorted(path for path in folder.rglob("*") if path.is_file()):
            packed.write(path, path.relative_to(folder).as_posix())
    return archive


def unpack(document_object: Any, folder: Path, overwrite: bool) -> list[Path]:
    """Write the files of an object to a folder.

    Raises:
        GombocCadError: If it has none, one is there already, or the folder cannot be written to.
    """
    if not getattr(document_object, "Files", ""):
        raise GombocCadError(texts.tr(texts.NOT_BUILT, label=document_object.Label))
    try:
        with zipfile.ZipFile(document_object.Files) as packed:
            paths = [folder / name for name in packed.namelist()]
            there = [path for path in paths if path.exists()]
            if there and not overwrite:
                raise GombocCadError(texts.tr(texts.ALREADY_THERE, file=there[0]))
            folder.mkdir(parents=True, exist_ok=True)
            packed.extractall(folder)
    except OSError as error:
        reason = error.strerror or error
        raise GombocCadError(texts.tr(texts.FOLDER_NOT_WRITABLE, folder=folder, reason=reason)) from error
    return paths


def product_names(step: str) -> list[str]:
    """Names of the parts in the text of a STEP file, in its order; the first one is the assembly itself."""
    names = re.findall(r"= PRODUCT\s*\(\s*'((?:[^']|'')*)'", step)
    return [name.replace("\r", "").replace("\n", "").replace("''", "'") for name in names]

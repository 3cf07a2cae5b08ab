"""What a folder of results holds: the JSON files that a report is made of, read with suspicion."""

from __future__ import annotations

import hashlib
import json
import math
import re
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from gomboc_cad import __version__
from gomboc_cad.errors import InspectionError
from gomboc_cad.report.json_values import Value

VERDICT, TOLERANCE, REPORT = "verdict.json", "tolerance.json", "report.json"
CALIBRATION, HYDROSTATICS = "calibration.json", "hydrostatics.json"
SOURCES = (VERDICT, CALIBRATION, HYDROSTATICS, TOLERANCE)
"""The files that the page is made of besides its own `report.json`."""

FORMAT = 1
"""Of `report.json`; a higher one is of a newer version."""

_ROWS = ("variants.csv", "variants.parquet")
_SAME_PLACE_MM = 1e-6
_MOST_BYTES = 64_000_000
_NEEDED = {VERDICT: ("product", "verdict", "reasons"), TOLERANCE: ("subject", "yield_monostable")}


@dataclass(frozen=True)
class Results:
    """The JSON documents of a folder.

    Attributes:
        documents: Content by file name; a file that is not there is left out.
        hashes: SHA-256 of each of those files but the report's own, in the order of `SOURCES`, and of the
            study's rows.
        stale_study: Whether there is a study of another design than the build; it is left out.
        unfinished_study: Whether there is a study that was interrupted.
    """

    documents: Mapping[str, dict[str, Any]]
    hashes: Mapping[str, str]
    stale_study: bool = False
    unfinished_study: bool = False

    def value(self, name: str) -> Value:
        """The content of a file, absent if there is none."""
        return Value(self.documents[name], name) if name in self.documents else Value.absent(name)

    def plain(self, name: str) -> dict[str, Any] | None:
        """The content of a file as it is, or None."""
        return self.documents.get(name)


def read_results(folder: Path, beside: Path | None = None) -> Results:
    """Read the JSON files of a build, of a study, or of both.

    Args:
        folder: Where they are.
        beside: Where a study is looked for if there is none in the folder.

    Raises:
        InspectionError: If the folder is none or has no results, if a study in it is half-written, or if a
            file is damaged, of another program or of a newer version.
    """
    if not folder.exists():
        raise InspectionError(f"There is no folder {folder}; name one that `gomboc-cad build` wrote.")
    if not folder.is_dir():
        raise InspectionError(f"{folder} is a file; name the folder that it is in.")
    there = _files(folder, (*SOURCES, REPORT, *_ROWS))
    found = {name: _read(path) for name, path in there.items() if name not in _ROWS}
    if beside is not None and TOLERANCE not in found:
        # A damaged study there is no reason to refuse a build.
        with suppress(InspectionError):
            found[TOLERANCE] = _read(beside / TOLERANCE)
            there |= _files(beside, (TOLERANCE, *_ROWS))
    unfinished = TOLERANCE not in found and any(
        any(place.glob("variants.*.study.json")) for place in (folder, beside) if place is not None
    )
    if unfinished and VERDICT not in found:
        raise InspectionError(
            f"The study in {folder} is not finished; run the same `gomboc-cad tolerance` command again, and "
            "it goes on where it was."
        )
    if not found.keys() & _NEEDED.keys():
        raise InspectionError(
            f"{folder} holds neither {VERDICT} nor {TOLERANCE}; write one with `gomboc-cad build` or "
            "`gomboc-cad tolerance`."
        )
    of_study = _ROWS if TOLERANCE in found else ()
    listed = {file["path"].raw for file in Value(found.get(VERDICT), VERDICT)["files"]}
    for name in {CALIBRATION, HYDROSTATICS} - listed:
        # Of another product that was built into the same folder before.
        found.pop(name, None)
        there.pop(name, None)
    names = [name for name in (*SOURCES, *of_study) if name in there]
    hashes = {name: _sha256(there[name]) for name in names}
    return _of_one_design(Results(found, hashes, unfinished_study=unfinished))


def report_of(folder: Path) -> dict[str, Any]:
    """The `report.json` of a folder that is about to be replaced; empty if there is none that can be read."""
    with suppress(InspectionError):
        return _read(folder / REPORT)
    return {}


def _files(folder: Path, names: Sequence[str]) -> dict[str, Path]:
    """Those of the named files that a folder holds."""
    paths = {name: folder / name for name in names}
    return {name: path for name, path in paths.items() if path.is_file()}


def is_built(results: Results, com_mm: Sequence[float]) -> bool:
    """Whether the build of a folder, if there is one, is of the design with this centre of mass."""
    build = results.value(VERDICT)
    if not build:
        return True
    place = build["assembly"]["com_mm"].numbers
    return len(place) == len(com_mm) and math.dist(place, com_mm) <= _SAME_PLACE_MM


def _of_one_design(results: Results) -> Results:
    """Without a study that is of another design than the build: its numbers would not be of these parts."""
    study = results.value(TOLERANCE)
    if not study or is_built(results, study["com_mm"].numbers):
        return results
    kept = {name: document for name, document in results.documents.items() if name != TOLERANCE}
    hashes = {name: digest for name, digest in results.hashes.items() if name in kept}
    return Results(kept, hashes, stale_study=True)


def _read(path: Path) -> dict[str, Any]:
    name = path.name
    again = "write it again with `gomboc-cad tolerance`" if name == TOLERANCE else "build again"
    try:
        if path.stat().st_size > _MOST_BYTES:
            raise InspectionError(f"{name} is larger than any that gomboc-cad writes; {again}.")
        document = json.loads(path.read_bytes(), parse_constant=_refuse_constant)
    except OSError as error:
        raise InspectionError(f"{path} could not be read: {error.strerror or error}.") from None
    except (ValueError, RecursionError):
        raise InspectionError(f"{name} is damaged: it is no JSON of gomboc-cad; {again}.") from None
    if not isinstance(document, dict):
        raise InspectionError(f"{name} is not a document of gomboc-cad; {again}.")
    _require_known(name, document, again)
    return document


def _require_known(name: str, document: Mapping[str, Any], again: str) -> None:
    """Refuse a document of another program or of a version that is not known yet."""
    missing = [key for key in _NEEDED.get(name, ()) if key not in document]
    if missing or (name == REPORT and document.get("program") != "gomboc-cad"):
        lacks = f"it has no {missing[0]!r}" if missing else "it is of another program"
        raise InspectionError(f"{name} is not a document of gomboc-cad: {lacks}; {again}.")
    version, form = document.get("version", __version__), document.get("format", FORMAT)
    if not isinstance(version, str) or not isinstance(form, int) or isinstance(form, bool):
        raise InspectionError(f"{name}: version must be a text and format a whole number; {again}.")
    if form > FORMAT or _order(version) > _order(__version__):
        raise InspectionError(
            f"{name} was written by gomboc-cad {version[:40]}, and this is {__version__}; update gomboc-cad."
        )


def _order(version: str) -> tuple[int, ...]:
    """The release of a version, for comparison."""
    match = re.match(r"\d{1,6}(\.\d{1,6}){0,3}", version)
    return tuple(int(part) for part in match.group().split(".")) if match else (0,)


def _refuse_constant(text: str) -> float:
    raise ValueError(f"{text} is no JSON")


def _sha256(path: Path) -> str:
    with path.open("rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()

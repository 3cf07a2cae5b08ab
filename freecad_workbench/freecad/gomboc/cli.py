"""The package's command line: how it is called, what it prints, what its exit codes mean.

Nothing here runs anything or knows FreeCAD. Lengths are in mm.
"""

from __future__ import annotations

import json
import re
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Mapping, Sequence

from . import texts
from .errors import CancelledError, GombocCadError

LOWEST_VERSION, BELOW_VERSION = "0.1", "0.2"
"""Versions of the package that this workbench works with."""

PASSED, FAILED, BAD_INPUT, INTERRUPTED = 0, 1, 2, 130
"""Exit codes of the package."""

# -I: an outside Python must not see FreeCAD's PYTHONHOME or PYTHONPATH (an AppImage sets them), nor the
# current folder. UTF-8, whatever the code page of the system is.
ISOLATED = ("-I", "-X", "utf8")
ZONE_FINENESS = "0.5"
"""At 1 a zone has 700 000 triangles, too many to turn around in a window."""

_MODULE = (*ISOLATED, "-m", "gomboc_cad")

_STAGE = re.compile(r"\[(\d+)(?:/(\d+))?\] (.+)")
_SENTENCE = "gomboc-cad: "


@dataclass(frozen=True)
class Progress:
    """A stage of a run that begins.

    Attributes:
        number: The first is 1.
        total: How many there are, where that is known.
        text: What is done.
    """

    number: int
    total: int | None
    text: str


@dataclass(frozen=True)
class Subject:
    """What a command is about: a body of the catalogue, or a product with what was changed in its template.

    Attributes:
        name: Of the body or product.
        diameter_mm: Nominal diameter of a body; a product has it among its changes.
        changes: Values by the dotted key of the spec.
        overrides: Further changes as the user wrote them, `KEY=VALUE`; they come last and win.
    """

    name: str
    diameter_mm: float | None = None
    changes: Mapping[str, Any] = field(default_factory=dict)
    overrides: Sequence[str] = ()

    def arguments(self) -> list[str]:
        """The subject on a command line."""
        words = [self.name]
        if self.diameter_mm is not None:
            words += ["--diameter-mm", _number(self.diameter_mm)]
        for change in (*(f"{key}={toml(value)}" for key, value in self.changes.items()), *self.overrides):
            words += ["--set", change]
        return words


@dataclass(frozen=True)
class Study:
    """How a tolerance study is done.

    Attributes:
        process: Name of the process; that of the product if empty.
        variants: How many parts as made are looked at.
        seed: Of all random samples.
        answers: Look for what to change too, which takes most of the time.
    """

    process: str = ""
    variants: int = 2048
    seed: int = 0
    answers: bool = True

    def arguments(self) -> list[str]:
        """The study on a command line."""
        process = ["--process", self.process] if self.process else []
        answers = "--answers" if self.answers else "--no-answers"
        return [*process, "--variants", str(self.variants), "--seed", str(self.seed), answers]


def toml(value: Any) -> str:
    """A value as TOML: text, a truth, a number or a list of these.

    Raises:
        TypeError: If it is something else.
    """
    if isinstance(value, str):
        # A JSON string is a basic string of TOML, which wants one more character escaped.
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, (int, float)):
        return _number(value)
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(toml(entry) for entry in value) + "]"
    raise TypeError(f"{value!r} has no place in a spec")


def check_override(text: str) -> str:
    """A line of a user's own changes, without blanks around it.

    Raises:
        GombocCadError: If it is not KEY=VALUE.
    """
    if not re.fullmatch(r"\s*[A-Za-z0-9_][\w.\-]*\s*=.*\S.*", text):
        raise GombocCadError(texts.tr(texts.BAD_OVERRIDE, text=text))
    key, _, value = text.strip().partition("=")
    return f"{key.strip()}={value.strip()}"


def version() -> list[str]:
    """Arguments of Python that print the version of the package."""
    return [*_MODULE, "--version"]


def templates() -> list[str]:
    """Arguments of Python that list products, boards, materials and so on."""
    return [*_MODULE, "templates", "--json"]


def catalog() -> list[str]:
    """Arguments of Python that list the bodies."""
    return [*_MODULE, "catalog", "--json"]


def build(product: Subject, folder: Path) -> list[str]:
    """Arguments of Python that build a product into a folder."""
    return [*_MODULE, "build", *product.arguments(), "-o", str(folder), "--json"]


def body(subject: Subject, folder: Path) -> list[str]:
    """Arguments of Python that write a bare body into a folder."""
    return [*_MODULE, "body", *subject.arguments(), "-o", str(folder), "--formats", "step", "--json"]


def check(file: Path, com_mm: Sequence[float] | None = None) -> list[str]:
    """Arguments of Python that count the resting poses of a part."""
    return [*_MODULE, "check", str(file), "--unit", "mm", *_com(com_mm), "--json"]


def zone(subject: Subject, stl: Path, com_mm: Sequence[float] | None = None) -> list[str]:
    """Arguments of Python that write where the centre of mass may be."""
    how = ["--fineness", ZONE_FINENESS]
    return [*_MODULE, "zone", *subject.arguments(), *_com(com_mm), *how, "-o", str(stl), "--json"]


def drill_map(subject: Subject, sites: int, com_mm: Sequence[float] | None = None) -> list[str]:
    """Arguments of Python that tell the largest hole for each place."""
    return [*_MODULE, "drillmap", *subject.arguments(), *_com(com_mm), "--sites", str(sites), "--json"]


def tolerance(subject: Subject, folder: Path, study: Study) -> list[str]:
    """Arguments of Python that run a tolerance study; see `body_file` for that of a bare body."""
    return [*_MODULE, "tolerance", *subject.arguments(), *study.arguments(), "-o", str(folder), "--json"]


def body_file(subject: Subject) -> str:
    """The text of a file that describes a bare body, for commands that take its size from a file only."""
    return f"[body]\nname = {toml(subject.name)}\ndiameter_mm = {toml(subject.diameter_mm)}\n"


def progress_of(line: str) -> Progress | None:
    """The stage that a line on stderr announces, if it does."""
    match = _STAGE.fullmatch(line.strip())
    if match is None:
        return None
    number, total, text = match.groups()
    return Progress(int(number), int(total) if total else None, text)


def version_of(output: str) -> str | None:
    """The version in what `--version` prints."""
    match = re.search(r"^gomboc-cad (\d+(?:\.\w+)+)", output, re.MULTILINE)
    return match.group(1) if match else None


def supported(found: str) -> bool:
    """Whether the workbench works with this version of the package."""
    return _release(LOWEST_VERSION) <= _release(found) < _release(BELOW_VERSION)


class Transcript:
    """What a run has printed so far, as bytes that may end in the middle of a line or of a letter."""

    def __init__(self) -> None:
        self.lines: list[str] = []
        self.progress: Progress | None = None
        self._output = bytearray()
        self._partial = b""

    def add_output(self, data: bytes) -> None:
        """Take what came on stdout."""
        self._output += data

    def add_errors(self, data: bytes) -> list[str]:
        """Take what came on stderr, and return the lines that it completes."""
        *complete, self._partial = (self._partial + data).split(b"\n")
        lines = [_decoded(line).rstrip("\r") for line in complete]
        for line in lines:
            self.progress = progress_of(line) or self.progress
        self.lines += lines
        return lines

    @property
    def output(self) -> str:
        """All of stdout."""
        return _decoded(bytes(self._output))

    def document(self, exit_code: int, crashed: bool) -> dict[str, Any]:
        """The JSON object that a run ended with.

        Raises:
            GombocCadError: If it ended in another way; the text says what the program said.
        """
        self.add_errors(b"\n" if self._partial else b"")
        if crashed or exit_code not in (PASSED, FAILED, BAD_INPUT, INTERRUPTED):
            stage = self.progress.text if self.progress else ""
            after = texts.tr(texts.AFTER_STAGE, stage=stage) if stage else ""
            raise GombocCadError(texts.tr(texts.CRASHED, after=after))
        if exit_code == INTERRUPTED:
            raise CancelledError(self._sentence())
        if exit_code == BAD_INPUT:
            raise GombocCadError(self._sentence())
        try:
            document = json.loads(self.output)
        except ValueError as error:
            raise GombocCadError(texts.tr(texts.NO_ANSWER, reason=self.last_line() or error)) from None
        if not isinstance(document, dict):
            raise GombocCadError(texts.tr(texts.NO_ANSWER, reason=type(document).__name__))
        return document

    def last_line(self) -> str:
        """The last line on stderr that is not blank."""
        return next((line.strip() for line in reversed(self.lines) if line.strip()), "")

    def _sentence(self) -> str:
        said = "\n".join(self.lines)
        _, found, sentence = said.rpartition(_SENTENCE)
        return " ".join(sentence.split()) if found else self.last_line()


def environment(variables: Mapping[str, str]) -> dict[str, str]:
    """The environment for an outside program: without what FreeCAD's bundle sets for its own libraries.

    An AppImage or a snap puts its folders into LD_LIBRARY_PATH, where an outside Python would find wrong
    libraries.
    """
    kept = {key: value for key, value in variables.items() if not key.startswith(("PYTHON", "VIRTUAL_ENV"))}
    for name in ("LD_LIBRARY_PATH", "LD_PRELOAD"):
        if name in kept:
            entries = kept.pop(name).split(":")
            outside = [entry for entry in entries if not in_bundle(entry, variables)]
            if outside:
                kept[name] = ":".join(outside)
    return kept


def in_bundle(path: str, variables: Mapping[str, str]) -> bool:
    """Whether a path is inside FreeCAD's AppImage or snap, whose place changes from start to start."""
    bundles = [variables[name].rstrip("/") for name in ("APPDIR", "SNAP") if variables.get(name)]
    return any(path == bundle or path.startswith(bundle + "/") for bundle in bundles)


def _com(com_mm: Sequence[float] | None) -> list[str]:
    # With "=", as a number that begins with a minus sign would be taken for an option.
    return [] if com_mm is None else ["--com-mm=" + ",".join(map(_number, com_mm))]


def _number(value: float) -> str:
    return repr(value)


def _decoded(data: bytes) -> str:
    return data.decode("utf-8", errors="replace")


def _release(text: str) -> tuple[int, ...]:
    return tuple(int(part) for part in re.findall(r"\d+", text)[:3])

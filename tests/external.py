"""Programs and optional modules that tests use but the package does not need, and folders compared.

A missing one skips the test and is named; where the environment says CI=true it fails the test instead, so
that continuous integration cannot pass by leaving something out.
"""

from __future__ import annotations

import hashlib
import importlib
import importlib.util
import json
import os
import shutil
import subprocess
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from typing import Any, NoReturn

import pytest


def digests(folder: Path) -> dict[str, str]:
    """Digest of each file below a folder: two folders compare without a listing of megabytes that differ."""
    files = (path for path in folder.rglob("*") if path.is_file())
    return {str(path.relative_to(folder)): hashlib.sha256(path.read_bytes()).hexdigest() for path in files}


def missing(name: str, remedy: str) -> NoReturn:
    """Skip the test, or fail it under CI, because something it needs is not there."""
    sentence = f"{name} is missing: {remedy}"
    if os.environ.get("CI", "").lower() in {"true", "1"}:
        pytest.fail(sentence, pytrace=False)
    pytest.skip(sentence)


def require_module(name: str, extra: str) -> ModuleType:
    """Import an optional module, or skip (fail under CI) when it is not installed.

    A module that is installed but breaks on import raises as usual.
    """
    if importlib.util.find_spec(name) is None:
        missing(name, f"install gomboc-cad[{extra}]")
    return importlib.import_module(name)


def require_program(*names: str, package: str) -> str:
    """Path of the first of the named programs that exists, or skip (fail under CI)."""
    for name in names:
        found = shutil.which(name)
        if found:
            return found
    missing(names[0], f"install the system package {package}")


def clean_environment(**extra: str) -> dict[str, str]:
    """The environment without what would make another program's Python use this one's modules."""
    kept = {key: value for key, value in os.environ.items() if not key.startswith(("PYTHON", "VIRTUAL_ENV"))}
    return kept | extra


FREECAD_WRAPPER = """\
import json, os, traceback

with open({job!r}, encoding="utf-8") as stream:
    job = json.load(stream)
values = {{}}


def report(**named):
    values.update(named)


try:
    scope = {{"__name__": "__main__", "inputs": job["inputs"], "report": report}}
    exec(compile(job["script"], "<script in FreeCAD>", "exec"), scope)
    outcome = {{"values": values}}
except BaseException:
    outcome = {{"error": traceback.format_exc()}}
with open({outcome!r} + ".part", "w", encoding="utf-8") as stream:
    json.dump(outcome, stream)
os.replace({outcome!r} + ".part", {outcome!r})
"""


@dataclass(frozen=True)
class FreeCAD:
    """FreeCAD without a screen, with settings of its own in a scratch folder."""

    executable: str
    scratch: Path

    def run(self, script: str, *, timeout_s: float = 180.0, **inputs: Any) -> dict[str, Any]:
        """Run a script inside FreeCAD and return what it reported.

        The script finds `inputs`, a dict with the keyword arguments (JSON values; paths become text), and
        says what it found with `report(name=value, ...)`. On an uncaught exception freecadcmd runs the script
        a second time and exits 0, so its exit code says nothing: the outcome is a file written at the end.

        Raises:
            AssertionError: The script raised, FreeCAD ended without an outcome, or time ran out.
        """
        job, outcome, wrapper = (self.scratch / name for name in ("job.json", "outcome.json", "wrapper.py"))
        outcome.unlink(missing_ok=True)
        job.write_text(json.dumps({"script": script, "inputs": inputs}, default=os.fspath), encoding="utf-8")
        wrapper.write_text(FREECAD_WRAPPER.format(job=str(job), outcome=str(outcome)), encoding="utf-8")
        home = str(self.scratch)
        environment = clean_environment(
            FREECAD_USER_HOME=home, FREECAD_USER_DATA=home, FREECAD_USER_TEMP=home
        )
        done = run_program([self.executable, str(wrapper)], timeout_s=timeout_s, environment=environment)
        if not outcome.exists():
            raise AssertionError(f"FreeCAD ended with code {done.returncode} and no outcome:\n{done.stdout}")
        result = json.loads(outcome.read_text(encoding="utf-8"))
        if "error" in result:
            raise AssertionError(f"the script failed inside FreeCAD:\n{result['error']}")
        return result["values"]


@dataclass(frozen=True)
class PrusaSlicer:
    """PrusaSlicer from the command line, with settings of its own in a scratch folder."""

    executable: str
    scratch: Path

    def info(self, file: Path, *, timeout_s: float = 120.0) -> dict[str, bool | float | str]:
        """What `--info` says of a mesh, as `{"manifold": True, "number_of_facets": 12.0, ...}`."""
        done = self._run("--info", str(file), timeout_s=timeout_s)
        pairs = (line.split("=", 1) for line in done.stdout.splitlines() if "=" in line)
        found = {key.strip(): _value(text.strip()) for key, text in pairs}
        assert "manifold" in found, f"PrusaSlicer says nothing of {file}:\n{done.stdout}"
        return found

    def slice(self, file: Path, gcode: Path, *options: str, timeout_s: float = 600.0) -> str:
        """Slice a mesh with PrusaSlicer's built-in settings into a G-code file, and return its text."""
        self._run("--export-gcode", *options, "--output", str(gcode), str(file), timeout_s=timeout_s)
        assert gcode.exists(), f"PrusaSlicer wrote no {gcode}"
        return gcode.read_text(encoding="utf-8")

    def _run(self, *arguments: str, timeout_s: float) -> subprocess.CompletedProcess[str]:
        command = [self.executable, "--datadir", str(self.scratch), *arguments]
        done = run_program(command, timeout_s=timeout_s, environment=clean_environment())
        assert done.returncode == 0, f"PrusaSlicer ended with code {done.returncode}:\n{done.stdout}"
        return done


def run_program(
    command: list[str], *, timeout_s: float, environment: dict[str, str]
) -> subprocess.CompletedProcess[str]:
    """Run a program with no input, its output and errors in one text."""
    try:
        return subprocess.run(
            command,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            env=environment,
            timeout=timeout_s,
            encoding="utf-8",
            errors="replace",
            check=False,
        )
    except subprocess.TimeoutExpired as error:
        raise AssertionError(f"{command[0]} did not end within {timeout_s:g} s:\n{error.stdout}") from error


def _value(text: str) -> bool | float | str:
    if text in {"yes", "no"}:
        return text == "yes"
    try:
        return float(text)
    except ValueError:
        return text

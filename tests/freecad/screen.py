"""FreeCAD with its windows on a virtual screen, driven from inside by a script of steps."""

from __future__ import annotations

import json
import os
import signal
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tests.external import clean_environment, require_program

WORKBENCH = Path(__file__).parents[2] / "freecad_workbench"
DRIVER = Path(__file__).with_name("driver.py")

SETTINGS = """\
<?xml version="1.0" encoding="UTF-8" standalone="no" ?>
<FCParameters><FCParamGroup Name="Root"><FCParamGroup Name="BaseApp"><FCParamGroup Name="Preferences">
  <FCParamGroup Name="General">
    <FCText Name="AutoloadModule">PartWorkbench</FCText>
    <FCText Name="Language">English</FCText>
    <FCBool Name="ShowSplasher" Value="0"/>
  </FCParamGroup>
  <FCParamGroup Name="Document"><FCInt Name="CheckExtension" Value="0"/></FCParamGroup>
  <FCParamGroup Name="View"><FCBool Name="UseVBO" Value="0"/></FCParamGroup>
</FCParamGroup></FCParamGroup></FCParamGroup></FCParameters>
"""
"""FreeCAD's start page is a web browser, which is left alone here: it refuses to run for root."""


@contextmanager
def virtual_screen(size: str = "1280x960x24") -> Iterator[str]:
    """A virtual screen of its own, as the name of its display; Xvfb finds a free number itself."""
    server = require_program("Xvfb", package="xvfb")
    reading, writing = os.pipe()
    command = [server, "-displayfd", str(writing), "-screen", "0", size, "-nolisten", "tcp"]
    process = subprocess.Popen(
        command, pass_fds=[writing], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
    )
    os.close(writing)
    try:
        with os.fdopen(reading) as stream:
            number = stream.readline().strip()
        assert number, "Xvfb gave no display"
        yield f":{number}"
    finally:
        process.terminate()
        process.wait(timeout=10)


@dataclass(frozen=True)
class FreeCADWindows:
    """FreeCAD with windows: the workbench linked into Mod/, every setting in a scratch folder."""

    executable: str
    display: str
    scratch: Path
    python: str
    """The Python that has gomboc-cad; "" leaves FreeCAD without one."""
    linked: bool = True
    """Whether FreeCAD has the workbench."""

    def run(self, steps: str, *, timeout_s: float = 90.0, **inputs: Any) -> dict[str, Any]:
        """Run a script inside FreeCAD's windows and return what it reported.

        The script defines `steps()`, a generator: at each `yield condition` FreeCAD's event loop goes on
        until `condition()` is true. What else it may use is in driver.py.

        Raises:
            AssertionError: The script raised, a condition stayed false, or FreeCAD ended or hung.
        """
        home = self.scratch / "home"
        modules = home / "Mod"
        modules.mkdir(parents=True, exist_ok=True)
        if self.linked and not (modules / "gomboc").exists():
            (modules / "gomboc").symlink_to(WORKBENCH, target_is_directory=True)
        settings = home / "user.cfg"
        if not settings.exists():
            settings.write_text(SETTINGS, encoding="utf-8")
        job, outcome = self.scratch / "job.json", self.scratch / "outcome.json"
        outcome.unlink(missing_ok=True)
        job.write_text(
            json.dumps({"script": steps, "inputs": inputs, "timeout_s": timeout_s}, default=os.fspath),
            encoding="utf-8",
        )
        self._start(home, settings, job, outcome, timeout_s)
        result = json.loads(outcome.read_text(encoding="utf-8"))
        if "error" in result:
            raise AssertionError(f"the script failed inside FreeCAD:\n{result['error']}\n{self._said()}")
        return result["values"]

    def _start(self, home: Path, settings: Path, job: Path, outcome: Path, timeout_s: float) -> None:
        folders = {
            name: str(home)
            for name in (
                "HOME",
                "FREECAD_USER_HOME",
                "FREECAD_USER_DATA",
                "FREECAD_USER_TEMP",
                "XDG_RUNTIME_DIR",
            )
        }
        folders |= {name: str(home / name) for name in ("XDG_CONFIG_HOME", "XDG_DATA_HOME", "XDG_CACHE_HOME")}
        environment = clean_environment(
            **folders,
            DISPLAY=self.display,
            QT_QPA_PLATFORM="xcb",
            LIBGL_ALWAYS_SOFTWARE="1",
            OPENBLAS_NUM_THREADS="1",
            GOMBOC_CAD_PYTHON=self.python,
            GUI_JOB=str(job),
            GUI_OUTCOME=str(outcome),
        )
        with self._log.open("w", encoding="utf-8") as stream:
            process = subprocess.Popen(
                [self.executable, "-u", str(settings), str(DRIVER)],
                stdin=subprocess.DEVNULL,
                stdout=stream,
                stderr=subprocess.STDOUT,
                env=environment,
                start_new_session=True,
            )
            try:
                # The driver keeps the time limit and says which step hung; this is for a stuck FreeCAD.
                process.wait(timeout=timeout_s + 20.0)
            except subprocess.TimeoutExpired:
                pass
            finally:
                # With it goes what it started, if it left that running.
                with suppress(ProcessLookupError):
                    os.killpg(process.pid, signal.SIGKILL)
                process.wait()
        if not outcome.exists():
            raise AssertionError(
                f"FreeCAD ended with code {process.returncode} and no outcome:\n{self._said()}"
            )

    def _said(self) -> str:
        return self._log.read_text(encoding="utf-8", errors="replace")[-4000:]

    @property
    def _log(self) -> Path:
        return self.scratch / "freecad.log"

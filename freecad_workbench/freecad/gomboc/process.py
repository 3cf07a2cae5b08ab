"""One run of an outside program through QProcess, with or without an event loop."""

from __future__ import annotations

import os
import time
from dataclasses import dataclass
from typing import Any, Callable, Sequence

from . import cli, door, texts
from .errors import CancelledError, GombocCadError

_POLITE_S = 5.0
"""How long a program may take to end when it is asked to, before it is killed."""

_POLL_MS = 40


@dataclass(frozen=True)
class Ended:
    """How a run ended.

    Attributes:
        transcript: What it printed.
        exit_code: As the system says.
        crashed: It did not end by itself.
        cancelled: It was told to stop.
    """

    transcript: cli.Transcript
    exit_code: int
    crashed: bool
    cancelled: bool

    def document(self) -> dict[str, Any]:
        """The JSON object it ended with.

        Raises:
            CancelledError: It was told to stop.
            GombocCadError: It ended without one; the text is what the program said.
        """
        if self.cancelled:
            raise CancelledError(self.transcript.last_line())
        return self.transcript.document(self.exit_code, self.crashed)


class Run:
    """A program that runs beside FreeCAD.

    Args:
        program: Its path.
        arguments: As they are, without a shell.
        on_lines: Called with each batch of lines that it prints on stderr (and on stdout, if it is merged).
        on_end: Called once, when it has ended and everything it printed was read.
        merge: Show stdout among the lines instead of keeping it for a document.
    """

    def __init__(
        self,
        program: str,
        arguments: Sequence[str],
        on_lines: Callable[[list[str]], None] = lambda lines: None,
        on_end: Callable[[Ended], None] = lambda ended: None,
        merge: bool = False,
    ) -> None:
        if door.QtCore is None:
            raise GombocCadError(texts.tr(texts.NO_FREECAD))
        self.transcript = cli.Transcript()
        self.ended: Ended | None = None
        self._program, self._arguments = program, list(arguments)
        self._on_lines, self._on_end = on_lines, on_end
        self._cancelled_at: float | None = None
        self._process = door.QtCore.QProcess()
        if merge:
            self._process.setProcessChannelMode(door.QtCore.QProcess.MergedChannels)
        self._merge = merge
        variables = door.QtCore.QProcessEnvironment()
        for name, value in cli.environment(os.environ).items():
            variables.insert(name, value)
        variables.insert("GOMBOC_CAD_PROGRESS", "lines")
        self._process.setProcessEnvironment(variables)
        self._process.readyReadStandardOutput.connect(self._read)
        self._process.readyReadStandardError.connect(self._read)
        self._process.finished.connect(self._finished)

    def start(self) -> None:
        """Start it.

        Raises:
            GombocCadError: If there is no such program, or it may not be run.
        """
        self._process.start(self._program, self._arguments)
        if not self._process.waitForStarted():
            reason = self._process.errorString()
            raise GombocCadError(texts.tr(texts.NO_PROGRAM, program=self._program, reason=reason))
        self._process.closeWriteChannel()

    def cancel(self) -> None:
        """Ask it to end, and kill it if it does not; `on_end` is called all the same."""
        if self.ended is not None or self._cancelled_at is not None:
            return
        self._cancelled_at = time.monotonic()
        if os.name == "nt":
            # A console program on Windows does not hear a request to end.
            self._process.kill()
        else:
            self._process.terminate()
            if door.gui_up():
                door.QtCore.QTimer.singleShot(int(1e3 * _POLITE_S), self._kill_if_deaf)

    def wait(self, timeout_s: float | None = None) -> Ended:
        """Wait for the end; windows stay alive meanwhile, and no event loop is needed.

        Raises:
            GombocCadError: If time ran out; the program was stopped then.
        """
        begin, timed_out = time.monotonic(), False
        while self.ended is None:
            self.poll()
            if timeout_s is not None and time.monotonic() - begin > timeout_s:
                self.cancel()
                timed_out = True
        if timed_out:
            title = os.path.basename(self._program)
            raise GombocCadError(texts.tr(texts.OUT_OF_TIME, title=title, seconds=timeout_s))
        return self.ended

    def poll(self) -> None:
        """Wait a moment and take what came, so that neither the program nor the windows stand still."""
        self._process.waitForFinished(_POLL_MS)
        door.keep_screen_alive()
        self._kill_if_deaf()

    def _kill_if_deaf(self) -> None:
        if self.ended is not None or self._cancelled_at is None:
            return
        if time.monotonic() - self._cancelled_at >= _POLITE_S:
            self._process.kill()

    def _read(self) -> None:
        output = bytes(self._process.readAllStandardOutput())
        errors = bytes(self._process.readAllStandardError())
        if self._merge:
            output, errors = b"", output + errors
        self.transcript.add_output(output)
        lines = self.transcript.add_errors(errors)
        if lines:
            self._on_lines(lines)

    def _finished(self, exit_code: int, exit_status: Any = None) -> None:
        if self.ended is not None:
            return
        self._read()
        crashed = self._process.exitStatus() != door.QtCore.QProcess.NormalExit
        self.ended = Ended(self.transcript, exit_code, crashed, self._cancelled_at is not None)
        self._process.deleteLater()
        self._on_end(self.ended)


def run(program: str, arguments: Sequence[str], timeout_s: float | None = None) -> Ended:
    """Run a program and wait for its end.

    Raises:
        GombocCadError: If it cannot be started, or time ran out.
    """
    started = Run(program, arguments)
    started.start()
    return started.wait(timeout_s)

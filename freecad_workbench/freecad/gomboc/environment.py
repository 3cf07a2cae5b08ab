"""The Python that has the package: found, checked, or made by the workbench in an environment of its own."""

from __future__ import annotations

import os
import shutil
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Callable, Iterator, Union

from . import cli, settings, texts
from .errors import GombocCadError
from .process import Ended, Run, run

DEFAULT_SOURCE = f"gomboc-cad>={cli.LOWEST_VERSION},<{cli.BELOW_VERSION}"
"""What pip installs where neither a wheel nor a folder is given."""

BASE_PYTHON = (3, 11)
"""The oldest Python that the package runs in."""

_ASK_TIMEOUT_S = 60.0
_VERSION_AND_VENV = "import sys, venv, ensurepip; print('python', *sys.version_info[:2])"


@dataclass(frozen=True)
class Ready:
    """A Python with a version of the package that fits."""

    python: str
    version: str


@dataclass(frozen=True)
class WrongVersion:
    """A Python with another version of the package; `sentence` says what to do."""

    python: str
    version: str
    sentence: str


@dataclass(frozen=True)
class Missing:
    """No Python with the package; `sentence` says what to do."""

    sentence: str


State = Union[Ready, WrongVersion, Missing]

_known: dict[str, State] = {}


def state() -> State:
    """What the chosen Python has; asked once, until `forget`."""
    python = settings.python() or _private_python_if_there()
    if not python:
        return Missing(texts.tr(texts.NO_PACKAGE))
    if python not in _known:
        _known[python] = examine(python)
    return _known[python]


def forget() -> None:
    """Ask again next time."""
    _known.clear()


def ready_python() -> str:
    """The Python to run the package with.

    Raises:
        GombocCadError: If there is none; the text says what to do.
    """
    found = state()
    if isinstance(found, Ready):
        return found.python
    forget()
    raise GombocCadError(found.sentence)


def use(python: str) -> Ready:
    """Choose an existing Python, and remember it.

    Raises:
        GombocCadError: If it has no package of a version that fits; the choice stays as it was.
    """
    found = examine(python)
    if not isinstance(found, Ready):
        raise GombocCadError(found.sentence)
    settings.set_python(python)
    forget()
    return found


def examine(python: str) -> State:
    """What a Python executable has."""
    try:
        ended = run(python, cli.version(), _ASK_TIMEOUT_S)
    except GombocCadError as error:
        return Missing(str(error))
    version = cli.version_of(ended.transcript.output)
    if version is None:
        reason = ended.transcript.last_line() or f"exit code {ended.exit_code}"
        return Missing(texts.tr(texts.NOT_IN_PYTHON, python=python, reason=reason))
    if not cli.supported(version):
        low, high = cli.LOWEST_VERSION, cli.BELOW_VERSION
        sentence = texts.tr(texts.WRONG_VERSION, found=version, python=python, low=low, high=high)
        return WrongVersion(python, version, sentence)
    return Ready(python, version)


def python_of(folder: Path) -> Path:
    """The executable of a virtual environment."""
    return folder / ("Scripts/python.exe" if os.name == "nt" else "bin/python")


def base_python() -> str:
    """A Python that can make a virtual environment for the package.

    Raises:
        GombocCadError: If there is none.
    """
    for candidate in _base_candidates():
        try:
            ended = run(candidate, [*cli.ISOLATED, "-c", _VERSION_AND_VENV], _ASK_TIMEOUT_S)
        except GombocCadError:
            continue
        name, *numbers = ended.transcript.output.split() or [""]
        if ended.exit_code == 0 and name == "python" and tuple(map(int, numbers)) >= BASE_PYTHON:
            return candidate
    version = ".".join(map(str, BASE_PYTHON))
    raise GombocCadError(texts.tr(texts.NO_BASE_PYTHON, version=version))


def install_commands(base: str, folder: Path, source: str) -> list[tuple[str, list[str]]]:
    """Programs and arguments, one after the other, that make an environment and install the package.

    Args:
        base: A Python executable.
        folder: Of the virtual environment.
        source: "" for the package index, a wheel, or a folder with pyproject.toml.

    Raises:
        GombocCadError: If the source is none of these.
    """
    wanted = source or DEFAULT_SOURCE
    if source:
        path = Path(source)
        is_wheel = path.suffix == ".whl" and path.is_file()
        if not is_wheel and not (path / "pyproject.toml").is_file():
            raise GombocCadError(texts.tr(texts.NOT_A_SOURCE, source=source))
        wanted = str(path.resolve())
    pip = ["-m", "pip", "--disable-pip-version-check", "--no-input", "install", "--upgrade", wanted]
    return [
        (base, [*cli.ISOLATED, "-m", "venv", str(folder)]),
        (str(python_of(folder)), [*cli.ISOLATED, *pip]),
    ]


class Installation:
    """The package being installed into the workbench's own environment.

    Args:
        commands: Programs and arguments, one after the other.
        folder: Of the environment; one that was not there before is removed if the installation fails.
        on_line: Called with each line of output.
        on_end: Called once, with None, or with the sentence that says what failed.
    """

    def __init__(
        self,
        commands: list[tuple[str, list[str]]],
        folder: Path,
        on_line: Callable[[str], None],
        on_end: Callable[[str | None], None],
    ) -> None:
        self.error: str | None = None
        self.running = True
        self._commands, self._folder = list(commands), folder
        self._is_new = not folder.exists()
        self._on_line, self._on_end = on_line, on_end
        self._run: Run | None = None
        self._next()

    def cancel(self) -> None:
        """Stop it."""
        self._commands.clear()
        if self._run is not None:
            self._run.cancel()

    def wait(self) -> None:
        """Wait for the end; windows stay alive meanwhile.

        Raises:
            GombocCadError: If the installation failed.
        """
        while self.running and self._run is not None:
            self._run.wait()
        if self.error is not None:
            raise GombocCadError(self.error)

    def _next(self) -> None:
        if not self._commands:
            self._verify()
            return
        program, arguments = self._commands.pop(0)
        self._on_line(" ".join([program, *arguments]))
        self._run = Run(program, arguments, self._say, self._ended, merge=True)
        try:
            self._run.start()
        except GombocCadError as error:
            self._finish(str(error))

    def _say(self, lines: list[str]) -> None:
        for line in lines:
            self._on_line(line)

    def _ended(self, ended: Ended) -> None:
        if ended.cancelled:
            self._finish(texts.tr(texts.INSTALL_STOPPED))
        elif ended.crashed or ended.exit_code != 0:
            reason = ended.transcript.last_line() or f"exit code {ended.exit_code}"
            self._finish(texts.tr(texts.INSTALL_FAILED, reason=reason))
        else:
            self._next()

    def _verify(self) -> None:
        try:
            use(str(python_of(self._folder)))
        except GombocCadError as error:
            self._finish(texts.tr(texts.INSTALL_FAILED, reason=error))
        else:
            self._finish(None)

    def _finish(self, error: str | None) -> None:
        if error is not None and self._is_new:
            shutil.rmtree(self._folder, ignore_errors=True)
        self.error, self.running = error, False
        forget()
        self._on_end(error)


def install(
    source: str = "",
    on_line: Callable[[str], None] = lambda line: None,
    on_end: Callable[[str | None], None] = lambda error: None,
    base: str = "",
) -> Installation:
    """Install the package into the workbench's own environment, beside FreeCAD, and remember it.

    Args:
        source: "" for the package index, a wheel, or a folder with pyproject.toml.
        on_line: Called with each line of output.
        on_end: Called once, with None, or with the sentence that says what failed.
        base: Python that makes the environment; one is looked for if it is not given.

    Raises:
        GombocCadError: If the source cannot be installed from, or there is no Python to begin with.
    """
    folder = settings.private_environment()
    commands = install_commands(base or base_python(), folder, source)
    folder.parent.mkdir(parents=True, exist_ok=True)
    return Installation(commands, folder, on_line, on_end)


def _private_python_if_there() -> str:
    python = python_of(settings.private_environment())
    return str(python) if python.is_file() else ""


def _base_candidates() -> Iterator[str]:
    """Executables that may be a Python, the likely ones first; FreeCAD's own bundle has one too."""
    bundled = Path(sys.prefix)
    names = [f"python3.{minor}" for minor in (13, 12, 11)] + ["python3", "python", "py"]
    found = [shutil.which(name) for name in names]
    inside = [bundled / name for name in ("bin/python3", "bin/python", "bin/python.exe", "python.exe")]
    seen = set()
    for candidate in [*found, *(str(path) for path in inside if path.is_file())]:
        # An environment made from within an AppImage would point to where that was mounted once.
        if candidate and candidate not in seen and not cli.in_bundle(candidate, os.environ):
            seen.add(candidate)
            yield candidate

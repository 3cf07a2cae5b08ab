"""A trial of a STEP file in a process of its own, because OCCT crashes on some damaged ones."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

from gomboc_cad.errors import GombocError, InspectionError

TIME_LIMIT_S = 600.0

_REFUSED = 3
"""Exit code of a trial that ended with an error in words; reading the file here gives the same one."""


def try_step(path: Path, name: str) -> None:
    """Read and mesh a STEP file in another process.

    Args:
        path: The file.
        name: Its name, for sentences.

    Raises:
        InspectionError: If that process crashes or does not end within `TIME_LIMIT_S`.
    """
    command = [sys.executable, "-P", "-m", __name__, str(path.absolute())]
    quiet = subprocess.DEVNULL
    try:
        done = subprocess.run(
            command, stdin=quiet, stdout=quiet, stderr=quiet, timeout=TIME_LIMIT_S, check=False
        )
    except subprocess.TimeoutExpired as error:
        raise InspectionError(
            f"{name} takes OCCT more than {TIME_LIMIT_S:.0f} s to read; simplify it, or export a mesh."
        ) from error
    if done.returncode not in (0, _REFUSED):
        raise InspectionError(
            f"{name} is damaged: OCCT crashes on it (exit code {done.returncode}); export it again."
        )


def _main(path: Path) -> int:
    from gomboc_cad.solid.step_census import load_step_part, sampler_of

    try:
        sampler_of(load_step_part(path))
    except GombocError:
        return _REFUSED
    return 0


if __name__ == "__main__":
    sys.exit(_main(Path(sys.argv[1])))

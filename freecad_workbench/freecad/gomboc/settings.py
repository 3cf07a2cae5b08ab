"""What the user chose: which Python has the package."""

from __future__ import annotations

import os
from pathlib import Path

from . import door

PYTHON_VARIABLE = "GOMBOC_CAD_PYTHON"
"""Environment variable that names the Python executable where no preference is set."""

_PYTHON = "Python"


def python() -> str:
    """The Python executable of the preferences, else of the environment variable, else ""."""
    group = door.preferences()
    return (group.GetString(_PYTHON) if group is not None else "") or os.environ.get(PYTHON_VARIABLE, "")


def set_python(executable: str) -> None:
    """Remember the Python executable; "" forgets it."""
    group = door.preferences()
    if group is None:
        return
    if executable:
        group.SetString(_PYTHON, executable)
    else:
        group.RemString(_PYTHON)


def private_environment() -> Path:
    """The folder of the workbench's own virtual environment, which may not exist yet."""
    return door.user_data_folder() / "gomboc-cad" / "venv"

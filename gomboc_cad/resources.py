"""Where the templates are: beside the package in an installation, beside its folder in a checkout."""

from __future__ import annotations

from pathlib import Path


def template_folder() -> Path:
    """Folder of the spec templates, boards and materials that a user copies and edits."""
    package = Path(__file__).resolve().parent
    installed = package / "templates"
    return installed if installed.is_dir() else package.parent / "templates"

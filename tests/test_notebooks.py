"""Every notebook of the examples runs from top to bottom and draws its figures."""

from __future__ import annotations

from pathlib import Path

import nbformat
import pytest
from nbclient import NotebookClient

NOTEBOOKS = {"figures.ipynb": 6}
"""Number of pictures in each."""


def test_every_notebook_is_tested(root: Path) -> None:
    assert {path.name for path in (root / "examples").glob("*.ipynb")} == set(NOTEBOOKS)


@pytest.mark.parametrize("name", NOTEBOOKS)
def test_notebooks_are_stored_without_results(root: Path, name: str) -> None:
    notebook = nbformat.read(root / "examples" / name, as_version=4)
    nbformat.validate(notebook)
    for cell in notebook.cells:
        if cell.cell_type == "code":
            assert cell.outputs == []
            assert cell.execution_count is None


@pytest.mark.slow
@pytest.mark.parametrize("name", NOTEBOOKS)
# The kernel's own loop, not ours: it says that it listens to this machine without encryption.
@pytest.mark.filterwarnings("ignore::DeprecationWarning", "ignore::RuntimeWarning")
def test_notebooks_run(root: Path, tmp_path: Path, name: str) -> None:
    notebook = nbformat.read(root / "examples" / name, as_version=4)
    place = {"metadata": {"path": str(tmp_path)}}
    NotebookClient(notebook, timeout=240, kernel_name="python3", resources=place).execute()
    outputs = [output for cell in notebook.cells for output in cell.get("outputs", [])]
    pictures = [output for output in outputs if "image/png" in output.get("data", {})]
    assert len(pictures) == NOTEBOOKS[name]
    assert "1 stable, 1 unstable" in outputs[0]["text"]
    assert not [output for output in outputs if output.get("name") == "stderr"]
    assert (tmp_path / "landscape.svg").read_text(encoding="utf-8").startswith("<?xml")

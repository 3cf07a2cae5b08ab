"""Every example runs as its page says, from a folder of the reader's own."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from types import ModuleType

import pytest


def run_example(root: Path, name: str, *arguments: str, cwd: Path) -> str:
    command = [sys.executable, str(root / "examples" / name), *arguments]
    done = subprocess.run(command, capture_output=True, encoding="utf-8", cwd=cwd, timeout=240, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_every_example_is_tested(root: Path) -> None:
    text = Path(__file__).read_text(encoding="utf-8")
    for path in (root / "examples").glob("*.py"):
        assert f'"{path.name}"' in text, f"{path.name} is run by no test"


def test_build_body(root: Path, tmp_path: Path) -> None:
    shown = run_example(root, "build_body.py", "out", cwd=tmp_path)
    assert "1 stable, 1 unstable" in shown
    assert shown.count("in order") == 3
    assert (tmp_path / "out" / "primary.step").exists()


@pytest.mark.slow
def test_build_housing_and_read_its_verdict(root: Path, tmp_path: Path) -> None:
    shown = run_example(root, "build_housing.py", "out", cwd=tmp_path)
    assert "PASS" in shown
    told = run_example(root, "read_verdict.py", "out", cwd=tmp_path)
    assert told.startswith("imu-housing: PASS")
    assert "rights itself" in told
    assert "in the mass of the board" in told


def test_to_cadquery(root: Path, tmp_path: Path, cadquery: ModuleType) -> None:
    """The hole takes away a cylinder of 8 mm through about 100 mm."""
    shown = run_example(root, "to_cadquery.py", cwd=tmp_path)
    assert "1 solid with" in shown
    assert "Lost on the way there and back: 0 mm³" in shown
    removed = float(shown.rsplit("took away ", 1)[1].split()[0])
    assert 0.97 * 5026.5 < removed < 1.05 * 5026.5


def test_judge_parts(root: Path, tmp_path: Path) -> None:
    shown = run_example(root, "judge_parts.py", cwd=tmp_path)
    assert "primary: monostable" in shown
    assert "second: multistable" in shown
    assert shown.count("  a rest, left by raising") == 1 + 2
    assert "exactly one stable and one unstable equilibrium" in shown
    assert "Checked again: accepted" in shown

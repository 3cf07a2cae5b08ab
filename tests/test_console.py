"""What a program that calls the command line reads on stderr while it works."""

from __future__ import annotations

import pytest

from gomboc_cad.console import PROGRESS_VARIABLE, Reporter


@pytest.mark.parametrize(("total", "of"), [(3, "/3"), (None, "")])
def test_each_stage_is_a_numbered_line_for_a_program_that_asks_for_it(
    total: int | None, of: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv(PROGRESS_VARIABLE, "lines")
    with Reporter(as_json=True, quiet=False).stages(total) as progress:
        progress("cutting the cavity")
        progress("weighing")
    said = capsys.readouterr()
    assert said.err == f"[1{of}] cutting the cavity\n[2{of}] weighing\n"
    assert said.out == ""


@pytest.mark.parametrize(("asked", "quiet"), [("lines", True), ("", False)])
def test_nothing_is_said_to_those_who_did_not_ask(
    asked: str, quiet: bool, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """A log that only wants the sentence of an error gets nothing else."""
    monkeypatch.setenv(PROGRESS_VARIABLE, asked)
    with Reporter(as_json=False, quiet=quiet).stages(2) as progress:
        progress("weighing")
    assert capsys.readouterr() == ("", "")

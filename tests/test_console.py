"""What a program that calls the command line reads on stderr while it works."""

from __future__ import annotations

import pytest

from gomboc_cad.console import Reporter


@pytest.mark.parametrize(("total", "of"), [(3, "/3"), (None, "")])
def test_each_stage_is_a_numbered_line_where_nobody_looks(
    total: int | None, of: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with Reporter(as_json=True, quiet=False).stages(total) as progress:
        progress("cutting the cavity")
        progress("weighing")
    said = capsys.readouterr()
    assert said.err == f"[1{of}] cutting the cavity\n[2{of}] weighing\n"
    assert said.out == ""


def test_quiet_is_silent(capsys: pytest.CaptureFixture[str]) -> None:
    with Reporter(as_json=False, quiet=True).stages(2) as progress:
        progress("weighing")
    assert capsys.readouterr() == ("", "")

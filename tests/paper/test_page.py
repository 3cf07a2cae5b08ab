"""The page and the files: what is generated is what is in the repository."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from gomboc_cad.errors import GombocError, OutputError
from gomboc_cad.paper import TABLES, write_paper
from gomboc_cad.paper.figures import FIGURES
from gomboc_cad.paper.page import page, section
from gomboc_cad.paper.records import Table, judged
from tests.paper.test_tables import table


@pytest.fixture(scope="module")
def written(root: Path) -> str:
    return (root / "docs" / "paper.md").read_text(encoding="utf-8")


def test_the_page_has_its_sections_in_order_and_nothing_else(written: str) -> None:
    head = page([])
    assert written.startswith(head[: head.index("Of 0 figures")])
    titles = [line.removeprefix("`gomboc-cad paper --only ").rstrip("`") for line in written.splitlines()]
    assert [title for title in titles if title in TABLES] == list(TABLES)
    verdicts = [line.split(" | ")[-2] for line in written.splitlines() if line.startswith("| ")]
    counts = {verdict: verdicts.count(verdict) for verdict in ("agrees", "differs", "refuted")}
    assert (
        f"Of {sum(counts.values())} figures, {counts['agrees']} agree, {counts['differs']} differ and "
        f"{counts['refuted']} are refuted."
    ) in written


def test_every_figure_stands_beside_a_table_and_in_the_repository(root: Path) -> None:
    for figure in FIGURES:
        assert figure.table in TABLES
        assert (root / "docs" / "images" / figure.file).is_file()


def test_a_bar_in_a_cell_does_not_end_it() -> None:
    row = judged("|∇h|", 1, 2, 3, "closed form", "Because of |x|.")
    text = section(Table("name", "Title", (), (row,)))
    assert text.splitlines()[-1] == r"| \|∇h\| | 1 | 2 | 3 (closed form) | differs | Because of \|x\|. |"


def test_files_of_one_table(tmp_path: Path) -> None:
    told: list[str] = []
    document = write_paper(tmp_path / "out", ["imu"], progress=told.append)
    assert document["files"] == ["paper.json", "paper.md"]
    assert {path.name for path in (tmp_path / "out").iterdir()} == set(document["files"])
    assert json.loads((tmp_path / "out" / "paper.json").read_text(encoding="utf-8")) == {
        "tables": document["tables"]
    }
    assert section(table("imu"), ".") in (tmp_path / "out" / "paper.md").read_text(encoding="utf-8")
    assert told == ["imu"]
    with pytest.raises(OutputError, match="not empty"):
        write_paper(tmp_path / "out", ["imu"])
    assert write_paper(tmp_path / "out", ["imu"], force=True) == document


def test_an_unknown_table_leaves_nothing_behind(tmp_path: Path) -> None:
    with pytest.raises(GombocError, match="no table tables"):
        write_paper(tmp_path / "out", ["tables"])
    assert list(tmp_path.iterdir()) == []


def test_a_figure_is_the_same_bytes_each_time(tmp_path: Path) -> None:
    (body,) = (figure for figure in FIGURES if figure.file == "paper-body.png")
    for name in ("one.png", "two.png"):
        body.draw(tmp_path / name)
    assert (tmp_path / "one.png").read_bytes() == (tmp_path / "two.png").read_bytes()

"""Processes: the shipped files are sourced and sensible, and a user's own works as well."""

from __future__ import annotations

from pathlib import Path

import pytest

from gomboc_cad.errors import SpecError
from gomboc_cad.products.common_spec import ShellSpec
from gomboc_cad.products.process import least_wall_mm, load_process, process_names

# Supported walls in mm, from the one-page table "3D printing design rules" of Protolabs Network.
PUBLISHED_WALL = {"fdm": 0.8, "sla": 0.5, "sls": 0.7, "mjf": 0.7, "polyjet": 1.0}

OWN = """
name = "my mill"
kind = "machined"
min_wall_mm = 0.9
min_wall_source = "tried"
undercuts_matter = true
"""


def test_the_processes_of_the_contract_are_there() -> None:
    names = {"fdm", "sla", "sls", "mjf", "polyjet", "cnc-3axis", "cnc-5axis", "injection"}
    assert set(process_names()) == names


@pytest.mark.parametrize("name", process_names())
def test_each_process_says_where_its_figures_come_from(name: str) -> None:
    process = load_process(name)
    assert 0.3 <= process.min_wall_mm <= 2.0
    assert len(process.min_wall_source) > 20
    assert (process.kind == "printed") == (name in PUBLISHED_WALL)
    # A printer builds any overhang with support or powder, and a tilted tool reaches most of them.
    assert process.undercuts_matter == (name in {"cnc-3axis", "injection"})


@pytest.mark.parametrize(("name", "wall_mm"), PUBLISHED_WALL.items())
def test_printed_walls_are_those_of_the_published_table(name: str, wall_mm: float) -> None:
    assert load_process(name).min_wall_mm == wall_mm


def test_a_process_of_ones_own_lies_beside_the_spec(tmp_path: Path) -> None:
    (tmp_path / "mine.toml").write_text(OWN, encoding="utf-8")
    assert load_process("mine.toml", tmp_path).min_wall_mm == 0.9
    assert least_wall_mm(ShellSpec(process="mine.toml"), tmp_path) == 0.9


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (("0.9", "-0.9"), r"mine.toml: min_wall_mm = -0.9 is not allowed"),
        (('"machined"', '"cast"'), r"mine.toml: kind = 'cast' is not allowed"),
        (
            ("min_wall_source", "min_wall_sauce"),
            r"unknown key min_wall_sauce, did you mean min_wall_source\?",
        ),
        (("undercuts_matter = true", "typical_size_mm = [1.0, 1.0, 1.0]"), "undercuts_matter is missing"),
    ],
)
def test_mistakes_in_a_process_of_ones_own_are_named(
    tmp_path: Path, change: tuple[str, str], message: str
) -> None:
    (tmp_path / "mine.toml").write_text(OWN.replace(*change), encoding="utf-8")
    with pytest.raises(SpecError, match=message):
        load_process("mine.toml", tmp_path)


def test_a_size_needs_its_source(tmp_path: Path) -> None:
    (tmp_path / "mine.toml").write_text(OWN + "typical_size_mm = [1.0, 1.0, 1.0]\n", encoding="utf-8")
    with pytest.raises(SpecError, match="typical_size_mm and typical_size_source go together"):
        load_process("mine.toml", tmp_path)


def test_an_unknown_process_is_refused_with_the_nearest_name() -> None:
    with pytest.raises(SpecError, match=r"no process 'cnc-4axis'; did you mean cnc-[35]axis\?"):
        load_process("cnc-4axis")
    with pytest.raises(SpecError, match=r"no process 'knitting'; choose one of cnc-3axis, .*, sls,"):
        load_process("knitting")


def test_a_name_does_not_leave_the_folder_of_the_templates() -> None:
    with pytest.raises(SpecError, match="no process"):
        load_process("../boards/adafruit-bno055")


def test_the_wall_left_is_the_processs_own_unless_the_spec_asks_for_more() -> None:
    assert least_wall_mm(ShellSpec(wall_mm=3.0, process="sls")) == 0.7
    assert least_wall_mm(ShellSpec(wall_mm=3.0, min_wall_mm=1.2, process="sls")) == 1.2


@pytest.mark.parametrize(
    ("shell", "message"),
    [
        (
            ShellSpec(wall_mm=0.7, process="fdm"),
            r"shell.wall_mm = 0.7 is thinner than the 0.8 mm .* FDM print",
        ),
        (ShellSpec(wall_mm=2.0, min_wall_mm=0.4, process="fdm"), r"shell.min_wall_mm = 0.4 is thinner"),
    ],
)
def test_a_wall_below_the_minimum_of_the_process_is_refused(shell: ShellSpec, message: str) -> None:
    with pytest.raises(SpecError, match=message):
        least_wall_mm(shell)

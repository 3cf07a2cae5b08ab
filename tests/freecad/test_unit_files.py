"""Files inside a document, and where an environment comes from; no FreeCAD."""

from __future__ import annotations

from types import SimpleNamespace

import pytest
from freecad.gomboc import cli, environment, settings
from freecad.gomboc.errors import GombocCadError
from freecad.gomboc.objects import files, properties


@pytest.fixture
def built(tmp_path):
    folder = tmp_path / "files"
    (folder / "figures").mkdir(parents=True)
    (folder / "größe é.step").write_bytes(b"ISO-10303-21;")
    (folder / "figures" / "zone.svg").write_text("<svg/>")
    return SimpleNamespace(Label="housing", Files=str(files.pack(folder)))


def test_files_come_out_as_they_went_in(built, tmp_path):
    paths = files.unpack(built, tmp_path / "Ausgabe 1 ß", overwrite=False)
    found = {path.relative_to(tmp_path / "Ausgabe 1 ß").as_posix(): path.read_bytes() for path in paths}
    assert found == {"größe é.step": b"ISO-10303-21;", "figures/zone.svg": b"<svg/>"}


def test_no_file_is_replaced_unasked(built, tmp_path):
    there = tmp_path / "out" / "größe é.step"
    there.parent.mkdir()
    there.write_text("mine")
    with pytest.raises(GombocCadError, match="is there already"):
        files.unpack(built, there.parent, overwrite=False)
    assert [path.name for path in there.parent.iterdir()] == [there.name]
    assert there.read_text() == "mine"
    files.unpack(built, there.parent, overwrite=True)
    assert there.read_bytes() == b"ISO-10303-21;"


def test_a_folder_that_cannot_be_made_is_said(built, tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(GombocCadError, match="cannot be written to"):
        files.unpack(built, tmp_path / "file" / "below", overwrite=False)


def test_nothing_built_is_nothing_to_export(tmp_path):
    with pytest.raises(GombocCadError, match="housing was not computed yet"):
        files.unpack(SimpleNamespace(Label="housing", Files=""), tmp_path, overwrite=False)


def test_names_of_parts_are_read_over_line_ends_and_quotes():
    step = (
        "#7 = PRODUCT('pod','pod','',(#8));\n#81 = PRODUCT('a very long name of a pa\nrt','x','',(#9));\n"
        "#82 = PRODUCT_CONTEXT('',#2,'mechanical');\n#90 = PRODUCT('Bob''s screw','Bob''s screw','',(#91));\n"
    )
    assert files.product_names(step) == ["pod", "a very long name of a part", "Bob's screw"]


@pytest.mark.parametrize("value", [None, "wide", [1], True, float("nan"), float("inf")])
def test_what_is_no_number_is_refused(value):
    with pytest.raises(GombocCadError, match=r"diameter_mm cannot be .*a number is needed"):
        properties.number("diameter_mm", value)


@pytest.mark.parametrize("value", ["1,2,3", [1.0, 2.0], 5, None, [1.0, 2.0, "far"]])
def test_what_is_no_point_is_refused(value):
    with pytest.raises(GombocCadError, match="com_mm cannot be"):
        properties.point("com_mm", value)


def test_lengths_lose_the_noise_of_unit_conversion():
    # 3 inches through FreeCAD's units come back as 76.19999999999999 mm.
    assert properties.exact_mm(76.19999999999999) == 76.2


@pytest.mark.parametrize("kind", ["index", "wheel", "folder"])
def test_what_pip_is_told(kind, tmp_path):
    source = ""
    if kind == "wheel":
        source = str(tmp_path / "gomboc cad-0.1.0-py3-none-any.whl")
        (tmp_path / "gomboc cad-0.1.0-py3-none-any.whl").touch()
    elif kind == "folder":
        source = str(tmp_path)
        (tmp_path / "pyproject.toml").touch()
    venv, pip = environment.install_commands("/usr/bin/python3", tmp_path / "venv é", source)
    assert venv == ("/usr/bin/python3", [*cli.ISOLATED, "-m", "venv", str(tmp_path / "venv é")])
    program, arguments = pip
    assert program == str(environment.python_of(tmp_path / "venv é"))
    assert arguments[-1] == (source or environment.DEFAULT_SOURCE)


@pytest.mark.parametrize("source", ["absent.whl", "."])
def test_what_cannot_be_installed_is_refused_before_anything_is_made(source, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(GombocCadError, match="neither a wheel"):
        environment.install_commands("python3", tmp_path / "venv", source)
    assert not (tmp_path / "venv").exists()


def test_the_environment_variable_counts_where_no_preference_is(monkeypatch):
    monkeypatch.setenv(settings.PYTHON_VARIABLE, "/opt/python")
    assert settings.python() == "/opt/python"

"""A file with a body: what reads it, and what is no such file."""

from __future__ import annotations

from pathlib import Path

import pytest

from gomboc_cad.body.catalogue import named_body
from gomboc_cad.body.mass import mass_properties
from gomboc_cad.errors import BodyError, SpecError
from gomboc_cad.products.body_file import is_body_file, load_body
from gomboc_cad.products.subject import body_and_com, is_spec

BODY = '[body]\nfamily = "sloan2"\nbeta = 0.03\ndiameter_mm = 60.0\n'


def written(folder: Path, text: str) -> Path:
    file = folder / "mine.toml"
    file.write_text(text, encoding="utf-8")
    return file


def test_a_body_is_named_after_its_file_and_has_its_diameter(tmp_path: Path) -> None:
    file = written(tmp_path, BODY)
    body = load_body(file)
    assert (body.name, body.diameter_mm) == ("mine.toml", 60.0)
    assert body.shape == named_body("sloan2-0.030").shape
    assert load_body(file, 80.0).diameter_mm == 80.0
    assert is_body_file(str(file))
    assert not is_spec(str(file))
    assert body_and_com(str(file)) == (body, mass_properties(body).com_mm)


def test_a_body_of_the_catalogue_keeps_its_name_and_so_its_status(tmp_path: Path) -> None:
    assert load_body(written(tmp_path, '[body]\nname = "second"\n')).name == "second"


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ('product = "imu-housing"\n' + BODY, "is the spec of a product, and a body is needed"),
        (BODY + "[shell]\nwall_mm = 3.0\n", "unknown key shell"),
        ("[body]\nbeta = 0.03\n", "give either name or family"),
        ("", "the key body is missing"),
    ],
)
def test_what_is_no_body_file_is_refused(tmp_path: Path, text: str, said: str) -> None:
    with pytest.raises(SpecError, match=said):
        load_body(written(tmp_path, text))


def test_wrong_parameters_are_refused(tmp_path: Path) -> None:
    with pytest.raises(BodyError, match="needs beta"):
        load_body(written(tmp_path, '[body]\nfamily = "sloan2"\n'))


def test_other_names_are_no_body_files(tmp_path: Path) -> None:
    assert not is_body_file("primary")
    assert not is_body_file(str(tmp_path / "none.toml"))
    assert not is_body_file(str(written(tmp_path, 'product = "imu-housing"\n' + BODY)))

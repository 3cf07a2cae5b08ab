"""Changes of a spec on the command line are what the same lines in the file would be; mistakes are told."""

from __future__ import annotations

from pathlib import Path

import pytest

from gomboc_cad.errors import SpecError
from gomboc_cad.products.spec import load_spec
from gomboc_cad.products.spec_changes import changed
from gomboc_cad.products.subject import body_and_com
from gomboc_cad.resources import template_folder


def test_changes_are_what_the_edited_file_says(tmp_path: Path) -> None:
    text = (template_folder() / "imu-housing.toml").read_text(encoding="utf-8")
    edited = tmp_path / "mine.toml"
    edited.write_text(
        text.replace("diameter_mm = 100.0 ", "diameter_mm = 60.0 ")
        .replace('text = "A1" ', 'text = "" ')
        .replace('"adafruit-bno055"', '"adafruit-mpu6050"', 1)
        .replace("offset_mm = [0.0, 0.0]    # shift", "offset_mm = [1.5, 0.0]    # shift", 1),
        encoding="utf-8",
    )
    changes = ("body.diameter_mm=60.0", "mark.text=", "board.type=adafruit-mpu6050", "board.offset_mm.0=1.5")
    assert load_spec("imu-housing", changes) == load_spec(str(edited))
    assert load_spec("imu-housing", changes) != load_spec("imu-housing")


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("1.5", 1.5),
        ("60", 60),
        ("true", True),
        ("PLA", "PLA"),
        ('"PLA"', "PLA"),
        ("", ""),
        ("a = b", "a = b"),
        ("[1, 2]", [1, 2]),
        ('{kind = "snap"}', {"kind": "snap"}),
        ("./my board.toml", "./my board.toml"),
    ],
)
def test_values_are_toml_and_names_need_no_quotes(text: str, value: object) -> None:
    assert changed({}, [f"table.key={text}"]) == {"table": {"key": value}}


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ("body.diameter_mm", "KEY=VALUE"),
        ("=5", "KEY=VALUE"),
        ("body..diameter_mm=5", "KEY=VALUE"),
        ("product.name=5", "no table"),
        ("ports.9=5", "no entry of a list of 1"),
        ("ports.x=5", "no entry of a list of 1"),
    ],
)
def test_mistakes_in_a_change_are_told(change: str, said: str) -> None:
    with pytest.raises(SpecError, match=said):
        changed({"product": "imu-housing", "ports": [{}]}, [change])


def test_the_model_tells_unknown_keys_and_wrong_values() -> None:
    with pytest.raises(SpecError, match="did you mean diameter_mm"):
        load_spec("imu-housing", ["body.diameter=60"])
    with pytest.raises(SpecError, match=r"body\.diameter_mm = 'big'"):
        load_spec("imu-housing", ["body.diameter_mm=big"])


def test_a_bare_body_has_no_spec_to_change() -> None:
    with pytest.raises(SpecError, match="bare body has none"):
        body_and_com("primary", changes=["body.diameter_mm=60"])

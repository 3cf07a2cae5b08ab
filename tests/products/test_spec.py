"""A spec is read, and every mistake in it becomes one sentence that names key, value and what is allowed."""

from __future__ import annotations

import shutil
import tomllib
from pathlib import Path
from typing import Any

import pytest

from gomboc_cad.errors import BodyError, SpecError, UnverifiedBodyError
from gomboc_cad.products.body_spec import BodySpec, require_verified
from gomboc_cad.products.imu_housing.boards import Board, load_board
from gomboc_cad.products.imu_housing.spec import ImuHousingSpec
from gomboc_cad.products.materials import load_material
from gomboc_cad.products.spec import load_spec
from gomboc_cad.products.toml_model import MAX_FILE_BYTES, parse_model
from gomboc_cad.resources import template_folder

TEMPLATE = (template_folder() / "imu-housing.toml").read_text(encoding="utf-8")


def spec_with(tmp_path: Path, old: str, new: str) -> str:
    """Write the template with one change and give its path."""
    assert old in TEMPLATE
    path = tmp_path / "mine.toml"
    path.write_text(TEMPLATE.replace(old, new), encoding="utf-8")
    return str(path)


def test_the_template_says_every_default_that_the_spec_has() -> None:
    """Leaving a key out gives the value the template shows, as its header promises."""
    # A default that depends on something else is shown as a comment.
    shown = tomllib.loads(TEMPLATE.replace("# min_wall_mm", "min_wall_mm"))
    bare = ImuHousingSpec.model_validate({"product": "imu-housing", "body": {"name": "primary"}})
    assert load_spec("imu-housing") == bare
    for section, model in bare:
        if section not in {"product", "body"}:
            assert set(shown[section]) == set(type(model).model_fields), section


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        (
            "wall_mm = 3.0 ",
            "wall_mm = -3.0 ",
            "shell.wall_mm = -3.0 is not allowed (allowed: more than 0 to 200)",
        ),
        ("wall_mm = 3.0 ", "wall_mm = nan ", "shell.wall_mm = nan is not allowed"),
        ("wall_mm = 3.0 ", "wall_mm = inf ", "shell.wall_mm = inf is not allowed"),
        ("wall_mm = 3.0 ", 'wall_mm = "3" ', "shell.wall_mm = '3' is not allowed"),
        ("wall_mm = 3.0 ", "wall_mm = true ", "shell.wall_mm = True is not allowed"),
        ("wall_mm = 3.0 ", "wal_mm = 3.0 ", "unknown key shell.wal_mm (did you mean wall_mm?)"),
        ("# min_wall_mm = 1.2", "min_wall_mm = 4.0", "min_wall_mm = 4 is more than wall_mm = 3"),
        (
            "diameter_mm = 100.0",
            "diameter_mm = 5.0",
            "body.diameter_mm = 5.0 is not allowed (allowed: from 10 to 2000)",
        ),
        ("diameter_mm = 100.0", "diameter_mm = 1e9", "body.diameter_mm = 1000000000.0 is not allowed"),
        ('name = "primary"', 'name = "primary"\nbeta = 0.02', "beta and coefficients go with family"),
        ('name = "primary"', "", "give either name or family"),
        ('kind = "dowels"', 'kind = "magic"', "closure.kind = 'magic' is not allowed (allowed: dowels"),
        ("count = 3", "count = 3.5", "closure.count = 3.5 is not allowed (allowed: from 2 to 8)"),
        ("count = 3", "count = 1", "closure.count = 1 is not allowed (allowed: from 2 to 8)"),
        ('target = "best"', 'target = "somewhere"', "com.target = 'somewhere' is not allowed"),
        ('target = "best"', "target = [1, 2]", "com.target"),
        ('product = "imu-housing"', 'product = "teapot"', "product = 'teapot' is not a product"),
        ('product = "imu-housing"', "", "product = None is not a product"),
        ("[mesh]", "[mash]", "unknown key mash (did you mean mesh?)"),
        ("[shell]", "[shell", "is not valid TOML"),
    ],
)
def test_a_mistake_is_named_with_key_value_and_range(tmp_path: Path, old: str, new: str, said: str) -> None:
    with pytest.raises(SpecError) as caught:
        load_spec(spec_with(tmp_path, old, new))
    sentence = str(caught.value)
    assert said in sentence
    assert "mine.toml" in sentence
    assert "\n" not in sentence or "TOML" in sentence


def test_several_mistakes_are_told_together(tmp_path: Path) -> None:
    path = tmp_path / "two.toml"
    path.write_text(
        TEMPLATE.replace("wall_mm = 3.0", "wall_mm = -1").replace("count = 3", "count = 99"), encoding="utf-8"
    )
    with pytest.raises(SpecError, match=r"shell\.wall_mm.*closure\.count"):
        load_spec(str(path))


def test_files_that_are_no_specs_are_refused(tmp_path: Path) -> None:
    with pytest.raises(SpecError, match="There is no file"):
        load_spec(str(tmp_path / "absent.toml"))
    with pytest.raises(SpecError, match="is a folder"):
        load_spec(str(tmp_path))
    binary = tmp_path / "binary.toml"
    binary.write_bytes(b"\xff\xfe\x00\x00")
    with pytest.raises(SpecError, match="UTF-8"):
        load_spec(str(binary))
    nested = tmp_path / "nested.toml"
    nested.write_text("a = " + "[" * 20000, encoding="utf-8")
    with pytest.raises(SpecError, match="not valid TOML"):
        load_spec(str(nested))
    huge = tmp_path / "huge.toml"
    huge.write_bytes(b"#" * (MAX_FILE_BYTES + 1))
    with pytest.raises(SpecError, match="larger than"):
        load_spec(str(huge))
    with pytest.raises(SpecError, match="There is no product 'imu-housin'"):
        load_spec("imu-housin")
    with pytest.raises(SpecError, match="cannot be read"):
        load_spec("nul\0byte.toml")


def test_a_board_of_ones_own_is_found_beside_the_spec(tmp_path: Path) -> None:
    shutil.copy(template_folder() / "boards" / "adafruit-bno055.toml", tmp_path / "mine.toml")
    assert load_board("mine.toml", tmp_path) == load_board("adafruit-bno055")
    with pytest.raises(SpecError, match="There is no file"):
        load_board("other.toml", tmp_path)
    with pytest.raises(SpecError, match=r"no board 'arduino'.*adafruit-bno055"):
        load_board("arduino")


def test_board_names_cannot_leave_the_folder_of_templates() -> None:
    with pytest.raises(SpecError, match="There is no board"):
        load_board("../materials")


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (
            {"holes": [{"x_mm": 1.0, "y_mm": 10.0, "diameter_mm": 2.5}] * 2},
            r"hole at \(1, 10\) is not inside",
        ),
        ({"holes": []}, "holes"),
        ({"com_mm": [0.0, 0.0, 99.0]}, "com_mm"),
        ({"height_mm": 1.0}, "height_mm = 1 is less than thickness_mm"),
        ({"corner_radius_mm": 12.0}, "corner_radius_mm = 12 does not fit"),
        ({"mass_g": 0.0}, "mass_g"),
    ],
)
def test_impossible_boards_are_refused(change: dict[str, Any], said: str) -> None:
    data = tomllib.loads((template_folder() / "boards" / "adafruit-bno055.toml").read_text(encoding="utf-8"))
    with pytest.raises(SpecError, match=said):
        parse_model(Board, data | change, "board")


def test_every_template_of_a_board_and_material_is_readable() -> None:
    for path in (template_folder() / "boards").glob("*.toml"):
        assert load_board(path.stem).source
    for name in tomllib.loads((template_folder() / "materials.toml").read_text(encoding="utf-8")):
        assert load_material(name).density_g_cm3 > 0.05
    with pytest.raises(SpecError, match="did you mean PLA"):
        load_material("PLAA")


@pytest.mark.parametrize("name", ["second", "third"])
def test_refuted_bodies_are_refused_with_their_reason(name: str) -> None:
    with pytest.raises(UnverifiedBodyError, match=r"refuted.*Gaussian curvature.*--allow-unverified"):
        require_verified(BodySpec(name=name).body())


def test_bodies_that_are_not_convex_are_refused_whatever_their_name() -> None:
    with pytest.raises(UnverifiedBodyError, match="not strictly convex"):
        require_verified(BodySpec(family="sloan2", beta=0.05).body())
    require_verified(BodySpec(family="sloan2", beta=0.03).body())


def test_an_unknown_body_is_a_clear_error() -> None:
    with pytest.raises(BodyError, match=r"no body named 'primray'.*primary"):
        BodySpec(name="primray").body()
    with pytest.raises(BodyError, match="no family"):
        BodySpec(family="gomboc", beta=0.02).body()

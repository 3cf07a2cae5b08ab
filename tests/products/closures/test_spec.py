"""What a spec says about a closure is read by its kind, and mistakes name the keys of the file."""

from __future__ import annotations

from typing import Any

import pytest

from gomboc_cad.errors import SpecError
from gomboc_cad.products.closures import ClosureSpec, DowelsSpec, ScrewsSpec, SnapSpec
from gomboc_cad.products.toml_model import TomlModel, parse_model


class Product(TomlModel):
    closure: ClosureSpec = DowelsSpec()


def read(closure: dict[str, Any]) -> ClosureSpec:
    return parse_model(Product, {"closure": closure}, "mine.toml").closure


def test_the_kind_decides_which_table_it_is() -> None:
    assert read({"kind": "dowels", "count": 4}) == DowelsSpec(count=4)
    assert read({"kind": "screws", "angle_deg": 30.0}) == ScrewsSpec(kind="screws", angle_deg=30.0)
    assert read({"kind": "snap", "undercut_mm": "auto"}) == SnapSpec(kind="snap")
    assert parse_model(Product, {}, "mine.toml").closure == DowelsSpec()


@pytest.mark.parametrize(
    ("closure", "said"),
    [
        ({"count": 3}, "the key closure.kind is missing (allowed: dowels, screws, thread-ring, snap, press)"),
        ({"kind": "glue"}, "closure.kind = 'glue' is not allowed (allowed: dowels, screws, thread-ring, "),
        ({"kind": "screws", "counts": 3}, "unknown key closure.counts (did you mean count?)"),
        ({"kind": "press", "undercut_mm": 1.0}, "unknown key closure.undercut_mm"),
        ({"kind": "screws", "count": 99}, "closure.count = 99 is not allowed (allowed: from 1 to 12)"),
        (
            {"kind": "screws", "head_in": "side"},
            "closure.head_in = 'side' is not allowed (allowed: upper, lower)",
        ),
        ({"kind": "snap", "clearance_mm": 0.0}, "closure.clearance_mm = 0.0 is not allowed"),
        ({"kind": "dowels", "diameter_mm": "3"}, "closure.diameter_mm = '3' is not allowed"),
    ],
)
def test_a_mistake_is_named_by_the_key_in_the_file(closure: dict[str, Any], said: str) -> None:
    with pytest.raises(SpecError) as caught:
        read(closure)
    assert str(caught.value).startswith("mine.toml: " + said)
    assert "\n" not in str(caught.value)

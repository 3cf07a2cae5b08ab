"""Numbers as the page writes them, and values that know where they stand."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from gomboc_cad.errors import InspectionError
from gomboc_cad.report.json_values import Value
from gomboc_cad.report.numerals import anything, decimal, fixed, number, significant, vector, words
from tests.report.walker import SUPERSCRIPTS


def read_back(written: str) -> float:
    mantissa, _, power = written.replace("−", "-").partition("·10")
    return float(mantissa) * 10.0 ** int(power.translate(SUPERSCRIPTS) if power else 0)


@given(st.floats(min_value=-1e29, max_value=1e29, allow_subnormal=False), st.integers(1, 8))
def test_so_many_digits_are_right(value: float, digits: int) -> None:
    shown = read_back(significant(value, digits))
    assert math.isclose(shown, value, rel_tol=0.5000001 * 10.0 ** (1 - digits))


@pytest.mark.parametrize(
    ("value", "digits", "written"),
    [
        (0.38206, 3, "0.382"),
        (0.9996, 3, "1.00"),
        (1024, 1, "1024"),
        (6629.44, 3, "6629"),
        (-0.5, 2, "−0.50"),
        (0.0, 3, "0"),
        (3.2e-16, 2, "3.2·10⁻¹⁶"),
        (-2.5e9, 2, "−2.5·10⁹"),
        (0.000102, 2, "0.00010"),
    ],
)
def test_numbers_are_written_as_one_writes_them(value: float, digits: int, written: str) -> None:
    assert significant(value, digits) == written


def test_zero_has_no_sign() -> None:
    assert decimal(-1e-9, 3) == "0.000"
    assert decimal(-0.0011, 3) == "−0.001"


DOCUMENT = Value(
    {"a/b~": {"x": [1.0, "two", True]}, "name": "<i>", "mass_g": 1.25, "sizes": [100.0, 0.5], "no": None},
    "f.json",
)


def test_a_value_says_where_it_stands() -> None:
    assert str(number(DOCUMENT["mass_g"], 2)) == '<data data-json="f.json#/mass_g" value="1.25">1.2</data>'
    assert 'data-scale="1000"' in fixed(DOCUMENT["mass_g"], 0, 1000)
    assert DOCUMENT["a/b~"]["x"][0].address == "f.json#/a~1b~0/x/0"
    assert str(words(DOCUMENT["name"])) == '<span data-json="f.json#/name">&lt;i&gt;</span>'
    assert vector(DOCUMENT["sizes"], 1).count("<data") == 2


def test_settings_are_shown_as_they_were_given() -> None:
    assert ">100</data>" in anything(DOCUMENT["sizes"][0])
    assert ">0.5</data>" in anything(DOCUMENT["sizes"][1])
    assert anything(DOCUMENT["a/b~"]["x"][2]) == "yes"


def test_what_is_not_there_is_false_until_it_is_read() -> None:
    absent = DOCUMENT["nothing"]["below"][3]
    assert not absent
    assert not absent.there
    assert not DOCUMENT["no"].there
    assert list(absent) == []
    assert Value(0.0, "f.json")
    with pytest.raises(InspectionError, match=r"^f\.json: nothing\.below\.3 is missing"):
        number(absent)
    with pytest.raises(InspectionError, match=r"name must be a number"):
        number(DOCUMENT["name"])
    with pytest.raises(InspectionError, match=r"mass_g must be an object"):
        DOCUMENT["mass_g"]["unit"]


@pytest.mark.parametrize("raw", [math.nan, math.inf, 10**400, True, "1"])
def test_only_finite_numbers_are_numbers(raw: object) -> None:
    with pytest.raises(InspectionError):
        number(Value(raw, "f.json", "/x"))

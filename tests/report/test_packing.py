"""Arrays inside JSON: what comes out is what went in, to the step; damage is told."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from gomboc_cad.errors import InspectionError
from gomboc_cad.report.packing import packed, packed_integers, unpacked, unpacked_integers

shapes = st.tuples(st.integers(1, 5), st.integers(1, 5))
values = arrays(float, shapes, elements=st.floats(-1e6, 1e6))


@given(values, st.sampled_from(["uint8", "uint16"]))
def test_values_come_back_to_half_a_step(array: np.ndarray, number: Any) -> None:
    document = json.loads(json.dumps(packed(array, number)))
    back = unpacked(document)
    assert back.shape == array.shape
    assert document["scale"] <= max(np.ptp(array) / (255 if number == "uint8" else 65535), 1.0)
    np.testing.assert_allclose(back, array, atol=0.501 * document["scale"], rtol=1e-12)


def test_equal_values_come_back_as_they_are() -> None:
    np.testing.assert_array_equal(unpacked(packed(np.full((2, 3), 7.25))), np.full((2, 3), 7.25))


@given(arrays(np.int64, shapes, elements=st.integers(0, 65535)))
def test_integers_come_back_exactly(array: np.ndarray) -> None:
    np.testing.assert_array_equal(unpacked_integers(packed_integers(array)), array)


def test_an_integer_that_does_not_fit_is_refused() -> None:
    with pytest.raises(OverflowError):
        packed_integers(np.array([256]), "uint8")


@pytest.mark.parametrize(
    "damage",
    [
        {"dtype": "float64"},
        {"dtype": ["uint16"]},
        {"shape": [3]},
        {"shape": [-2, -1]},
        {"shape": [2.0]},
        {"shape": [1 << 40]},
        {"shape": None},
        {"scale": float("nan")},
        {"offset": "much"},
        {"base64": "AA=="},
        {"base64": "not base64"},
        {"base64": 7},
    ],
)
def test_damage_is_told(damage: dict[str, Any]) -> None:
    document = packed(np.array([0.0, 1.0]))
    with pytest.raises(InspectionError, match="damaged"):
        unpacked(document | damage)


def test_numbers_are_little_endian() -> None:
    assert packed_integers(np.array([258]))["base64"] == "AgE="

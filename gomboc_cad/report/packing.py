"""Arrays inside JSON: base64 of little-endian numbers, rounded to steps of a stated size.

A packed array is an object with

* `dtype`: `uint8` or `uint16`;
* `shape`: lengths of the axes, the last one runs fastest;
* `offset`, `scale`: a value is `offset + scale · number`; 0 and 1 where the numbers are the values;
* `base64`: the numbers, each of `dtype`, the lowest byte first.
"""

from __future__ import annotations

import base64
import binascii
import math
from collections.abc import Mapping
from typing import Any, Literal, get_args

import numpy as np

from gomboc_cad.body.sphere import Array, IntArray
from gomboc_cad.errors import InspectionError

Number = Literal["uint8", "uint16"]
_LONGEST = 1 << 24


def packed(values: Array, number: Number = "uint16") -> dict[str, Any]:
    """Pack finite values in equal steps from the smallest to the largest of them.

    Args:
        values: Any shape, not empty.
        number: How fine the steps are: 1/255 or 1/65535 of the range.
    """
    low, high = float(values.min()), float(values.max())
    scale = (high - low) / np.iinfo(number).max or 1.0
    return _document(np.rint((values - low) / scale).astype(number), low, scale)


def packed_integers(values: IntArray, number: Number = "uint16") -> dict[str, Any]:
    """Pack integers as they are.

    Raises:
        OverflowError: If one does not fit.
    """
    info = np.iinfo(number)
    if values.size and (values.min() < info.min or values.max() > info.max):
        raise OverflowError(f"An index is too large for {number}.")
    return _document(values.astype(number), 0.0, 1.0)


def _document(numbers: Any, offset: float, scale: float) -> dict[str, Any]:
    little = numbers.astype(numbers.dtype.newbyteorder("<"))
    return {
        "dtype": numbers.dtype.name,
        "shape": list(numbers.shape),
        "offset": offset,
        "scale": scale,
        "base64": base64.b64encode(little.tobytes()).decode("ascii"),
    }


def unpacked(document: Mapping[str, Any]) -> Array:
    """Give back the values of a packed array.

    Raises:
        InspectionError: If the object is no packed array.
    """
    try:
        number, shape = document["dtype"], tuple(document["shape"])
        offset, scale = float(document["offset"]), float(document["scale"])
        content = base64.b64decode(document["base64"], validate=True)
        if number not in get_args(Number) or not (math.isfinite(offset) and math.isfinite(scale)):
            raise ValueError("number")
        if not all(isinstance(length, int) and 0 <= length <= _LONGEST for length in shape):
            raise ValueError("shape")
        if len(content) != math.prod(shape) * np.dtype(number).itemsize:
            raise ValueError("length")
        numbers = np.frombuffer(content, np.dtype(number).newbyteorder("<")).reshape(shape)
    except (KeyError, TypeError, ValueError, binascii.Error) as error:
        raise InspectionError("An array of the report's data is damaged; build or study again.") from error
    result: Array = offset + scale * numbers.astype(float)
    return result


def unpacked_integers(document: Mapping[str, Any]) -> IntArray:
    """Give back the integers of a packed array.

    Raises:
        InspectionError: If the object is no packed array.
    """
    result: IntArray = np.rint(unpacked(document)).astype(np.int64)
    return result

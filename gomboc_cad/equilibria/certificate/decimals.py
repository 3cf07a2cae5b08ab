"""Decimals and balls: a decimal is read exactly, a ball is written as decimals that enclose it."""

from __future__ import annotations

import math
import re
from fractions import Fraction
from typing import Final

from flint import arb, ctx

from gomboc_cad.errors import BodyError

_DECIMAL_BITS = 320
_DECIMAL_PLACES: Final = 20
_DECIMAL = re.compile(r"-?\d{1,20}(\.\d{1,60})?(e-?\d{1,2})?", re.ASCII)


def decimal_ball(text: object) -> arb:
    """The ball of a plain decimal such as "0.023149".

    Raises:
        BodyError: If it is not a decimal of sensible length.
    """
    if not isinstance(text, str) or not _DECIMAL.fullmatch(text.lower()):
        raise BodyError(f"{text!r:.60} is not a decimal number such as 0.023149, of at most 60 digits.")
    with ctx.workprec(_DECIMAL_BITS):
        return arb(text)


def decimal_interval(ball: arb) -> tuple[str, str]:
    """Decimals of 20 places that enclose a ball.

    Raises:
        BodyError: If the ball is not finite.
    """
    if not ball.is_finite():
        raise BodyError("A number of this body could not be enclosed; use smaller coefficients.")
    low, high = (_scaled(end) for end in (ball.lower(), ball.upper()))
    return _decimal(math.floor(low)), _decimal(math.ceil(high))


def _scaled(exact: arb) -> Fraction:
    mantissa, exponent = (int(part) for part in exact.man_exp())
    scale = Fraction(1 << exponent) if exponent >= 0 else Fraction(1, 1 << -exponent)
    return mantissa * scale * 10**_DECIMAL_PLACES


def _decimal(units: int) -> str:
    digits = f"{abs(units):0{_DECIMAL_PLACES + 1}d}"
    return f"{'-' * (units < 0)}{digits[:-_DECIMAL_PLACES]}.{digits[-_DECIMAL_PLACES:]}"

"""How the page writes what stands in the JSON: every number and text with the address it comes from."""

from __future__ import annotations

import math

from markupsafe import Markup, escape

from gomboc_cad.report.json_values import Value

_SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
_SMALLEST, _LARGEST = 1e-4, 1e7
"""Beyond these numbers are written with a power of ten."""


def number(value: Value, digits: int = 3, scale: float = 1.0) -> Markup:
    """A number of a JSON file to so many significant digits, times a factor that changes its unit."""
    return _data(value, significant(scale * value.number, digits), scale)


def fixed(value: Value, decimals: int = 3, scale: float = 1.0) -> Markup:
    """A number of a JSON file to so many decimals, times a factor that changes its unit."""
    return _data(value, decimal(scale * value.number, decimals), scale)


def vector(value: Value, decimals: int = 3) -> Markup:
    """The numbers of a list, in brackets."""
    return Markup("({})").format(Markup(", ").join(fixed(entry, decimals) for entry in value))


def words(value: Value) -> Markup:
    """A text of a JSON file, word by word."""
    return Markup('<span data-json="{}">{}</span>').format(value.address, value.text)


def keyword(value: Value) -> Markup:
    """The key at which a value stands."""
    return Markup('<span data-json-key="{}">{}</span>').format(value.address, value.key)


def anything(value: Value, digits: int = 6) -> Markup:
    """A number, text or truth value, or a list of them, as a table of settings shows it."""
    raw = value.raw
    if isinstance(raw, bool):
        return escape("yes" if raw else "no")
    if isinstance(raw, int | float):
        return _data(value, _without_zeros(significant(value.number, digits)), 1.0)
    if isinstance(raw, list):
        return Markup(", ").join(anything(entry, digits) for entry in value)
    return words(value)


def significant(number: float, digits: int) -> str:
    """Round to significant digits; digits before the point are never rounded away."""
    size = abs(number)
    if size == 0.0:
        return "0"
    if not _SMALLEST <= size < _LARGEST:
        mantissa, exponent = f"{number:.{digits - 1}e}".split("e")
        return f"{mantissa}·10{str(int(exponent)).translate(_SUPERSCRIPTS)}".replace("-", "−")
    rounded = float(f"{number:.{digits - 1}e}")
    return decimal(number, max(0, digits - 1 - math.floor(math.log10(abs(rounded)))))


def _without_zeros(written: str) -> str:
    """A setting as it was given: 100 and not 100.000."""
    plain = "." in written and "·" not in written
    return written.rstrip("0").rstrip(".") if plain else written


def decimal(number: float, decimals: int) -> str:
    """Round to decimals, with a true minus sign and none before zero."""
    written = f"{number:.{decimals}f}"
    return written.lstrip("-") if float(written) == 0.0 else written.replace("-", "−")


def _data(value: Value, written: str, scale: float) -> Markup:
    scaled = Markup(' data-scale="{}"').format(f"{scale:g}") if scale != 1.0 else ""
    return Markup('<data data-json="{}" value="{}"{}>{}</data>').format(
        value.address, repr(value.raw), scaled, written
    )
